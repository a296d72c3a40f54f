"""Pictures in the graph of what is computed at every pixel, and how they become others of other form or size.

A picture is luma with or without chroma, or RGB, and is converted when something asks for another form, as
the CPU's `Work` does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from vidstyle.blade.inference import BankRun
from vidstyle.blade.structure_tensor import window_radius, window_weights
from vidstyle.block import Block, Choice, LumaWeights, SavedRef
from vidstyle.core.picture import Encoding
from vidstyle.core.resample import METHODS, fitting_method
from vidstyle.gpu.compile.glsl import functions_of_block
from vidstyle.gpu.compile.nodes import CHANNELS, Function, Kind, Measure, Node, PictureLayout, Shape
from vidstyle.style import SOURCE
from vidstyle.style.resolve import ResolvedStep


@dataclass(frozen=True)
class ImageValue:
    """A picture in the graph: RGB, or luma with or without chroma.

    Attributes:
        back: the method by which it goes back to the page's size, if it has another one.
    """

    luma: Node | None = None
    chroma: Node | None = None
    color: Node | None = None
    back: str = "bicubic"

    @property
    def shape(self) -> Shape:
        """Height and width."""
        main = self.color or self.luma
        assert main is not None
        return main.shape

    @property
    def is_gray(self) -> bool:
        """Whether there is no chroma."""
        return self.chroma is None and self.color is None


class ImageBuilder:
    """Makes the nodes of pictures, each only once, and brings pictures to other forms.

    Attributes:
        source: what comes in.
        encoding: its matrix is the one that luma is taken with.
        planes: the source itself.
    """

    def __init__(self, source: PictureLayout) -> None:
        self.source = source
        self.encoding = source.encoding
        self.planes = self._source_planes()
        self._nodes: dict[object, Node] = {}

    def luma(self, look: ImageValue) -> Node:
        """Its luma."""
        if look.color is None:
            assert look.luma is not None
            return look.luma
        return self.call("luma", "luma_from_rgb", {"color": look.color}, from_rgb=self.encoding.from_rgb)

    def chroma(self, look: ImageValue) -> Node | None:
        """Its blue and red difference at every pixel; None for gray."""
        if look.color is not None:
            return self.call(
                "chroma", "chroma_from_rgb", {"color": look.color}, from_rgb=self.encoding.from_rgb
            )
        if look.chroma is None or look.chroma.grid is None:
            return look.chroma
        grid = look.chroma.grid
        return self.node(
            Node(
                "chroma",
                look.shape,
                Function("frame/between.glsl", "IMAGE_between"),
                around=look.chroma,
                values={"step": grid.step, "siting": grid.siting},
            )
        )

    def chroma_on_grid(self, look: ImageValue, target: Encoding) -> Node | None:
        """Its blue and red difference where they lie already where the target's do, else None."""
        chroma, shape = look.chroma, self.source.shape
        if (
            chroma is None
            or chroma.grid is None
            or chroma.page != shape
            or not chroma.grid.has_grid_of(target)
        ):
            return None
        if not chroma.is_plane or chroma.grid == target:
            return chroma
        same = self.call("chroma", "same_chroma", {"chroma": chroma})
        return self.node(replace(same, grid=chroma.grid, page=shape))

    def color(self, look: ImageValue) -> Node:
        """Its RGB."""
        if look.color is not None:
            return look.color
        chroma = self.chroma(look)
        if chroma is None:
            return self.call("color", "rgb_from_gray", {"luma": self.luma(look)})
        inputs = {"luma": self.luma(look), "chroma": chroma}
        return self.call("color", "rgb_from_yuv", inputs, to_rgb=self.encoding.to_rgb)

    def call(self, kind: Kind, name: str, inputs: dict[str, Node], **values: Any) -> Node:
        """A node made by one of the runner's own functions, of values of the same pixel."""
        shape = next(iter(inputs.values())).shape if inputs else self.source.shape
        return self.node(Node(kind, shape, Function(f"frame/{name}.glsl", name), inputs, values=values))

    def in_matrix(self, look: ImageValue, matrix: str) -> ImageValue:
        """The picture, from which luma and chroma are to be taken with another colour matrix from now on."""
        if matrix == self.encoding.matrix or look.is_gray:
            return look
        look = ImageValue(color=self.color(look))
        self.encoding = replace(self.encoding, matrix=matrix)
        return look

    def at_size(self, look: ImageValue, shape: Shape, method: str) -> ImageValue:
        """The picture at another size."""
        if look.shape == shape:
            return look
        if look.color is not None:
            return ImageValue(color=self.resized(look.color, shape, method))
        assert look.luma is not None
        chroma = look.chroma
        if chroma is not None and chroma.grid is not None:
            assert chroma.page is not None
            grid = chroma.grid.as_float_at(chroma.page, shape)
            chroma = self.resized(chroma, grid.chroma_shape(*shape), method)
            chroma = self.node(replace(chroma, grid=grid, page=shape))
        elif chroma is not None:
            chroma = self.resized(chroma, shape, method)
        return ImageValue(self.resized(look.luma, shape, method), chroma)

    def resized(self, node: Node, shape: Shape, method: str) -> Node:
        """The node at another size."""
        if node.shape == shape:
            return node
        function = Function("frame/resampled.glsl", "resampled", CHANNELS[node.kind])
        options = {"method": tuple(METHODS)}
        values = {
            "method": options["method"].index(fitting_method(method, node.shape, shape)),
            "old_size": node.shape[::-1],
            "new_size": shape[::-1],
        }
        return self.node(
            Node(
                node.kind, shape, function, around=node, values=values, options=options, is_wide=node.is_wide
            )
        )

    def node(self, node: Node) -> Node:
        """The node, or the same one made before."""
        inputs = tuple((name, id(each)) for name, each in node.inputs.items())
        values = tuple((name, _hashable(value)) for name, value in node.values.items())
        grid = None if node.grid is None else (node.grid.step, node.grid.siting, node.page)
        measured = id(node.measure) if node.measure else None
        key = (
            node.kind,
            node.shape,
            node.function,
            inputs,
            id(node.around),
            values,
            measured,
            grid,
            node.is_wide,
        )
        return self._nodes.setdefault(key, node)

    def _source_planes(self) -> ImageValue:
        shape, encoding = self.source.shape, self.source.encoding
        if self.source.planes == "color":
            return ImageValue(color=Node("color", shape))
        if self.source.planes == "gray":
            return ImageValue(Node("luma", shape))
        chroma = Node("chroma", encoding.chroma_shape(*shape), grid=encoding, page=shape)
        return ImageValue(Node("luma", shape), chroma)


def _hashable(value: Any) -> object:
    """What stands for the value in a key. Arrays live as long as the style, so their identity does."""
    return value if isinstance(value, int | float | str | tuple) and not _holds_arrays(value) else id(value)


def _holds_arrays(value: Any) -> bool:
    return isinstance(value, tuple) and any(not isinstance(part, int | float) for part in value)


class GraphBuilder(ImageBuilder):
    """Follows the steps of a style.

    Attributes:
        measures: all that the steps want to know of the whole picture, in the order of the steps.
    """

    def __init__(self, source: PictureLayout, form: str) -> None:
        super().__init__(source)
        self._form = form
        self.measures: list[Measure] = []
        self._saved = {SOURCE: self.planes}

    def run_layer(self, layer: str, steps: tuple[ResolvedStep, ...], look: ImageValue) -> ImageValue:
        """The picture after all steps of a layer."""
        for number, step in enumerate(steps):
            look = self._saved[step.source] if step.source else look
            if step.block is not None:
                look = self._run_step(step, step.block, look, (layer, number))
            if step.save:
                self._saved[step.save] = look
        return look

    def _run_step(
        self, step: ResolvedStep, block: Block, look: ImageValue, number: tuple[str, int]
    ) -> ImageValue:
        if block.saves:
            self._saved[block.saves] = look
        if block.kind == "resize":
            size = block.function(look.shape, **step.values)
            return replace(self.at_size(look, size, step.values["method"]), back=step.values["back"])
        if block.kind == "learned":
            return self._run_learned(block, block.function(**step.values), look)
        measure = None
        if block.kind == "measured":
            percentages = block.percentiles_for(step.values)
            measure = Measure(self.luma(look), percentages, step.values.get("settle", 0.0), number)
            self.measures.append(measure)
        pictures = {
            name: self.at_size(self._saved[saved], look.shape, "bilinear")
            for name, saved in step.pictures.items()
        }
        return self._run_block(step, block, look, pictures, measure)

    def _run_learned(self, block: Block, run: BankRun, look: ImageValue) -> ImageValue:
        chroma = self.chroma(look) if look.color is not None else look.chroma
        luma = self.luma(look)
        if run.scale != 1:
            luma = self.resized(luma, run.shape_at_scale(luma.shape), "area")
            # Exact: a filter chosen otherwise for one of few pixels would show in many.
            luma = self.node(replace(luma, is_wide=True))
        luma = self.resized(self._filtered(luma, run), look.shape, "bicubic")
        return ImageValue(luma, None if block.chroma == "dropped" else chroma, back=look.back)

    def _filtered(self, luma: Node, run: BankRun) -> Node:
        """Luma after all passes of a bank."""
        chosen: Node | None = None
        for _ in range(run.passes):
            if chosen is None or run.reselect:
                chosen = self._chosen(luma, run)
            filters = Function("blade/filtered.glsl", "filtered")
            luma = self.node(
                Node(
                    "luma",
                    luma.shape,
                    filters,
                    {"chosen": chosen},
                    around=luma,
                    radius=run.bank.size // 2,
                    values=filter_values(run),
                    is_wide=run.is_wide,
                )
            )
        return luma

    def _chosen(self, luma: Node, run: BankRun) -> Node:
        """The number of each pixel's filter.

        A compute group shares what it reads; fragments do not, so there one chooses for 2 x 2 pixels, in a
        pass of its own.
        """
        radius, values = window_radius(run.window), choice_values(run)
        if self._form == "compute":
            function = Function("blade/chosen_filter.glsl", "chosen_filter")
            return self.node(Node("luma", luma.shape, function, around=luma, radius=radius, values=values))
        height, width = luma.shape
        half = (height + 1) // 2, (width + 1) // 2
        function = Function("blade/chosen_filters.glsl", "chosen_filters")
        four = self.node(Node("choices", half, function, around=luma, radius=radius, values=values))
        return self.node(
            Node("luma", luma.shape, Function("blade/own_choice.glsl", "IMAGE_own_choice"), around=four)
        )

    def _run_block(
        self,
        step: ResolvedStep,
        block: Block,
        look: ImageValue,
        pictures: dict[str, ImageValue],
        measure: Measure | None,
    ) -> ImageValue:
        if step.on == "color" or (step.on == "channels" and not look.is_gray):
            inputs = self._inputs(block, pictures, color=True)
            color = self._call_block(step, block, self.color(look), inputs, measure)
            return ImageValue(color=color, back=look.back)
        inputs = self._inputs(block, pictures, color=False)
        luma = self._call_block(step, block, self.luma(look), inputs, measure)
        chroma = None if block.chroma == "dropped" else look.chroma
        if look.color is not None and block.chroma == "kept":
            chroma = self.chroma(look)
        for name, picture in pictures.items():
            if _wants(block, name) == "chroma":
                chroma = self.chroma(picture) if picture.color is not None else picture.chroma
        return ImageValue(luma, chroma, back=look.back)

    def _inputs(self, block: Block, pictures: dict[str, ImageValue], color: bool) -> dict[str, Node]:
        wanted = {name: look for name, look in pictures.items() if _wants(block, name) != "chroma"}
        return {
            name: self.color(look) if color and _wants(block, name) == "same" else self.luma(look)
            for name, look in wanted.items()
        }

    def _call_block(
        self,
        step: ResolvedStep,
        block: Block,
        picture: Node,
        inputs: dict[str, Node],
        measure: Measure | None,
    ) -> Node:
        values, options = _numbered(block, step.values)
        injected = block.injected.items()
        values |= {name: self.encoding.weights for name, kind in injected if kind is LumaWeights}
        for signature in functions_of_block(block.name):
            if signature.is_identity:  # to_gray and to_color do all they do by choosing the chroma
                continue
            function = Function(signature.file, signature.name, CHANNELS[picture.kind])
            node = Node(
                picture.kind, picture.shape, function, dict(inputs), None, 0, values, options, measure
            )
            if block.kind == "filter":
                picture = replace(node, around=picture, radius=block.radius_for(step.values))
            else:
                picture = replace(node, inputs={signature.parameters[0].name: picture, **inputs})
            picture = self.node(picture)
        return picture


def _numbered(block: Block, values: dict[str, Any]) -> tuple[dict[str, Any], dict[str, tuple[str, ...]]]:
    """The values with the number of each chosen word in its place, and the words."""
    controls = {name: block.parameters[name].control for name in values}
    options = {name: control.options for name, control in controls.items() if isinstance(control, Choice)}
    numbered = {
        name: options[name].index(value) if name in options else value for name, value in values.items()
    }
    return numbered, options


def _wants(block: Block, name: str) -> str:
    control = block.parameters[name].control
    assert isinstance(control, SavedRef)
    return control.on


MAX_TAPS = 16
"""Weights of one half of the window that the shader takes."""
MAX_PARTS = 8


def choice_values(run: BankRun) -> dict[str, Any]:
    """The values of `chosen_filter`."""
    radius = window_radius(run.window)
    half = [float(weight) for weight in window_weights(run.window)[:radius]]
    orientations, strengths, coherences, *ranges = (float(number) for number in run.bank.bins.as_array)
    return {
        "radius": radius,
        "window": half + [0.0] * (MAX_TAPS - len(half)),
        "bins": (orientations, strengths, coherences),
        "start": (ranges[0], ranges[2]),
        "density": (ranges[1], ranges[3]),
    }


def filter_values(run: BankRun) -> dict[str, Any]:
    """The values of `filtered`."""
    padding = [0.0] * (MAX_PARTS - len(run.weights))
    return {
        # Weights times twenty and more would show the rounding of half floats.
        "bank": run.bank.packed if run.is_wide else run.bank.packed_in_half,
        "size": run.bank.size,
        "part_weights": [float(weight) for weight in run.weights] + padding,
        "part_sums": [*run.bank.sums, *padding],
        "identity": float(run.identity),
    }
