"""Lowers a style to nodes: decides the computation at every pixel, once for all devices.

That is the channels of each step, when chroma is converted, upsampled, replaced or dropped, the size at which
a step runs, and how layers are combined.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vidstyle.blade.inference import RESAMPLING_METHOD, BankRun
from vidstyle.block import Block, rgb_from_text
from vidstyle.core.picture import Encoding, PictureLayout
from vidstyle.core.resample import fitting_method
from vidstyle.errors import StyleError
from vidstyle.network.network_run import NetworkRun
from vidstyle.style.limits import excess
from vidstyle.style.mask_declarations import BACKDROP, PEOPLE
from vidstyle.style.model import LAYERS, SOURCE, Step, Style
from vidstyle.style.nodes import (
    Kind,
    LoweredStyle,
    Node,
    Op,
    PercentileRequest,
    ScaledSize,
    Shape,
    StepKey,
    identity_key,
)
from vidstyle.style.resolve import ResolvedStep, layers_behind, masks_read
from vidstyle.style.wiring import START, wiring_of

UNDONE_TOLERANCE = 1e-3
"""Factors whose product is this close to 1 undo each other: 0.75 and 1.3333 do."""

_ABOVE_NAME, _MASK_NAME = " above", " mask"
"""Names of pictures that no step can save."""

Steps = Mapping[str, tuple[ResolvedStep, ...]]
"""The resolved steps of each layer."""


@dataclass(frozen=True)
class ImageValue:
    """A picture in the graph: RGB, or luma with or without chroma.

    Attributes:
        back: the resampling method that returns it to the page size.
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
        """Whether it has no chroma."""
        return self.chroma is None and self.color is None


def lower(style: Style, steps: Steps, source: PictureLayout, target: Encoding, rgb: bool) -> LoweredStyle:
    """Return the nodes of a style.

    Args:
        style: for its ink and paper.
        steps: its steps, resolved for pictures of the source's size.
        source: layout of the pictures.
        target: how the planes of the result are encoded.
        rgb: packed RGB of the target's depth is wanted instead.

    Raises:
        StyleError: it would take more time or memory than a style may (docs/rules.md, Style safety).
    """
    graph = GraphBuilder(source)
    image = graph.run_layers(style, steps)
    if rgb:
        lowered = LoweredStyle(source, target, color=graph.color(image), sizes=graph.sizes)
    else:
        image = graph.in_matrix(image, target.matrix)
        chroma = image.chroma if graph.is_on_grid(image.chroma, target) else graph.chroma(image)
        lowered = LoweredStyle(source, target, luma=graph.luma(image), chroma=chroma, sizes=graph.sizes)
    if problem := excess(lowered.outputs, source.shape):
        raise StyleError(style.name, [problem])
    return lowered


class GraphBuilder:
    """Follows the steps of a style and makes their nodes, equal ones only once.

    Attributes:
        source: layout of what comes in.
        encoding: its matrix is the one of luma and chroma.
        planes: the source itself.
        saved: the source, the masks, and the pictures that steps have saved, by name.
        sizes: as in `LoweredStyle`.
    """

    def __init__(self, source: PictureLayout) -> None:
        self.source = source
        self.encoding = source.encoding
        self.sizes: dict[Shape, ScaledSize] = {source.shape: ScaledSize(source.shape, 1.0)}
        self._nodes: dict[object, Node] = {}
        self.planes = self._source_planes()
        self.saved: dict[str, ImageValue] = {}

    def node(self, op: Op, kind: Kind, shape: Shape, inputs: dict[str, Node], **others: Any) -> Node:
        """Return a node, or the equal one made before."""
        follows = any(other.may_overshoot for other in inputs.values())
        node = Node(op, kind, shape, inputs, follows_overshoot=follows, **others)
        return self._nodes.setdefault(identity_key(node), node)

    def luma(self, image: ImageValue) -> Node:
        """Its luma."""
        if image.color is not None:
            return self._convert("luma_from_rgb", "luma", {"color": image.color})
        assert image.luma is not None
        return image.luma

    def chroma(self, image: ImageValue) -> Node | None:
        """Its chroma at every pixel; None for gray."""
        if image.color is not None:
            return self._convert("chroma_from_rgb", "chroma", {"color": image.color})
        if image.chroma is None or image.chroma.grid is None:
            return image.chroma
        return self.node("upsample", "chroma", image.shape, {"chroma": image.chroma})

    def stored_chroma(self, image: ImageValue) -> Node | None:
        """Return its chroma on any grid; converted only from RGB."""
        return self.chroma(image) if image.color is not None else image.chroma

    def color(self, image: ImageValue) -> Node:
        """Its RGB."""
        if image.color is not None:
            return image.color
        luma, chroma = self.luma(image), self.chroma(image)
        if chroma is None:
            return self.node("rgb_from_gray", "color", image.shape, {"luma": luma})
        return self._convert("rgb_from_yuv", "color", {"luma": luma, "chroma": chroma})

    def is_on_grid(self, chroma: Node | None, target: Encoding) -> bool:
        """Return whether chroma samples have the positions and matrix of the target's; codes may differ."""
        if chroma is None or chroma.grid is None or chroma.page != self.source.shape:
            return False
        return chroma.grid.has_grid_of(target)

    def in_matrix(self, image: ImageValue, matrix: str) -> ImageValue:
        """Return the picture, whose luma and chroma are taken with another colour matrix from now on."""
        if matrix == self.encoding.matrix or image.is_gray:
            return image
        image = ImageValue(color=self.color(image))
        self.encoding = replace(self.encoding, matrix=matrix)
        return image

    def at_size(self, image: ImageValue, shape: Shape, method: str) -> ImageValue:
        """Return the picture at another size; subsampled chroma stays subsampled."""
        if image.shape == shape:
            return image
        if image.color is not None:
            return ImageValue(color=self.resampled(image.color, shape, method))
        assert image.luma is not None
        chroma = image.chroma
        if chroma is not None and chroma.grid is not None:
            assert chroma.page is not None
            grid = chroma.grid.as_float_at(chroma.page, shape)
            small = grid.chroma_shape(*shape)
            chroma = self.resampled(chroma, small, method, grid=grid, page=shape)
        elif chroma is not None:
            chroma = self.resampled(chroma, shape, method)
        return ImageValue(self.resampled(image.luma, shape, method), chroma)

    def resampled(self, node: Node, shape: Shape, method: str, border: int = 0, **grid: Any) -> Node:
        """Return the node at another size; itself where it has that size and stays on its grid.

        `border` is as in `core.resample.Resampling`.
        """
        if node.shape == shape and not grid and not border:
            return node
        values: dict[str, Any] = {"method": fitting_method(method, node.shape, shape)}
        values |= {"border": border} if border else {}
        inputs = {"image": node}
        return self.node("resample", node.kind, shape, inputs, values=values, is_wide=node.is_wide, **grid)

    def _convert(self, op: Op, kind: Kind, inputs: dict[str, Node]) -> Node:
        shape = next(iter(inputs.values())).shape
        return self.node(op, kind, shape, inputs, matrix=self.encoding.matrix)

    def _source_planes(self) -> ImageValue:
        shape, encoding = self.source.shape, self.source.encoding
        if self.source.planes == "color":
            return ImageValue(color=self.node("plane", "color", shape, {}))
        luma = self.node("plane", "luma", shape, {})
        if self.source.planes == "gray":
            return ImageValue(luma)
        small = encoding.chroma_shape(*shape)
        return ImageValue(luma, self.node("plane", "chroma", small, {}, grid=encoding, page=shape))

    def run_layers(self, style: Style, steps: Steps) -> ImageValue:
        """Run the layers of a style, laid over the picture of the style behind people, if there is one."""
        behind = self._run_style(style.behind, steps, layers_behind(style)) if style.behind else None
        image = self._run_style(style, steps, dict(zip(LAYERS, LAYERS, strict=True)))
        return image if behind is None else self._mixed(behind, image, 1.0, PEOPLE)

    def _run_style(self, style: Style, steps: Steps, names: Mapping[str, str]) -> ImageValue:
        """base, then background and lines from where it ended, and the lines laid over the background.

        Args:
            names: the names of the layers in `steps`.
        """
        self.saved = {SOURCE: self.planes} | {name: self._mask(name) for name in masks_read(style)}
        base_steps, background_steps, lines_steps = (steps[names[layer]] for layer in LAYERS)
        base = self.run_layer(names["base"], base_steps, self.planes)
        background = lines = None
        if background_steps or not lines_steps:
            background = self._at_page_size(self.run_layer(names["background"], background_steps, base))
        if lines_steps:
            lines = self._at_page_size(self.run_layer(names["lines"], lines_steps, base))
        image = self._inked(self._on_paper(style, background), rgb_from_text(style.ink), lines)
        if style.strength != 1:
            image = self._mixed(image, self.planes, 1 - style.strength)
        if style.only:
            image = self._mixed(self.planes, image, 1.0, style.only)
        return self._mixed(image, self.planes, 1.0, style.keep) if style.keep else image

    def _mixed(self, under: ImageValue, above: ImageValue, opacity: float, mask: str = "") -> ImageValue:
        """Return a picture laid over another one, inside a mask if one is named."""
        values = {"other": _ABOVE_NAME} | ({"mask": _MASK_NAME} if mask else {})
        wiring = wiring_of(Step("blend", values, on="color"))
        assert wiring.block is not None
        self.saved |= {_ABOVE_NAME: above} | ({_MASK_NAME: self._mask(mask)} if mask else {})
        step = ResolvedStep(wiring, {"mode": "normal", "opacity": opacity})
        return self._run_step(step, wiring.block, under, ("strength", 0))

    def _mask(self, name: str) -> ImageValue:
        """Return a mask, or the backdrop."""
        values = {"name": name}
        if name == BACKDROP:
            return ImageValue(color=self.node("mask", "color", self.source.shape, {}, values=values))
        return ImageValue(self.node("mask", "luma", self.source.shape, {}, values=values))

    def run_layer(self, layer: str, steps: tuple[ResolvedStep, ...], image: ImageValue) -> ImageValue:
        """Return the picture after all steps of a layer."""
        for number, step in enumerate(steps):
            wiring = step.wiring
            given = self.saved[wiring.reads[START]] if START in wiring.reads else image
            image = self._run_step(step, wiring.block, given, (layer, number)) if wiring.block else given
            if wiring.saved_input:
                self.saved[wiring.saved_input] = given
            if wiring.saved_output:
                self.saved[wiring.saved_output] = image
        return image

    def _run_step(self, step: ResolvedStep, block: Block, image: ImageValue, key: StepKey) -> ImageValue:
        if block.kind == "resize":
            size = self._scaled(
                image.shape, block.function(image.shape, **step.values), step.values["factor"]
            )
            return replace(self.at_size(image, size, step.values["method"]), back=step.values["back"])
        if block.kind == "learned":
            return self._run_bank(image, block.function(**step.values), key)
        if block.kind == "network":
            return self._run_network(image, block.function(**step.values))
        measure = None
        if block.kind == "measured":
            percentages, time_constant = block.percentiles_for(step.values), step.values.get("settle", 0.0)
            measure = PercentileRequest(self.luma(image), percentages, time_constant, key)
        in_color = step.wiring.on == "color" or (step.wiring.on == "channels" and not image.is_gray)
        pictures = {
            name: self._saved_at_size(saved, image.shape, block.saved_refs[name].on, in_color)
            for name, saved in step.wiring.pictures.items()
        }
        if in_color:
            return ImageValue(
                color=self._call(step, block, self.color(image), pictures, measure), back=image.back
            )
        luma = self.luma(image)
        if not block.is_identity:
            luma = self._call(step, block, luma, pictures, measure)
        return self._with_luma(block, image, luma, pictures)

    def _scaled(self, shape: Shape, size: Shape, factor: float) -> Shape:
        """Return the requested size; if the step undoes an earlier scaling, exactly the size before it."""
        before, earlier, _ = self.sizes[shape]
        if abs(factor * earlier - 1) < UNDONE_TOLERANCE:
            return before
        self.sizes.setdefault(size, ScaledSize(shape, factor))
        return size

    def _saved_at_size(self, name: str, shape: Shape, wanted: str, in_color: bool) -> ImageValue:
        """Return a saved picture at another size; convert it first if only luma or chroma is read."""
        image = self.saved[name]
        if math.prod(image.shape) < math.prod(shape) and not (wanted == "same" and in_color):
            image = ImageValue(self.luma(image), self.stored_chroma(image) if wanted == "chroma" else None)
        return self.at_size(image, shape, "bilinear")

    def _run_bank(self, image: ImageValue, run: BankRun, key: StepKey) -> ImageValue:
        """Return the picture after a bank, which may run at a smaller size and may bypass chroma."""
        chroma = self.stored_chroma(image)
        if run.matrix is not None:
            image = self._after_matrix(image, run.matrix)
        small = luma = self._before_filters(self.luma(image), run, key)
        if run.scale != 1:
            small = self.resampled(luma, run.shape_at_scale(luma.shape), RESAMPLING_METHOD, run.border)
            self.sizes.setdefault(small.shape, ScaledSize(luma.shape, run.scale, run.border))
        filtered = self.node(
            "filter_bank", "luma", small.shape, {"luma": small}, values={"run": run}, radius=run.radius,
            is_wide=run.is_wide,
        )  # fmt: skip
        if run.bank.chroma is not None and self.chroma(image) is not None:
            chroma = self._run_bank_on_chroma(image, small, run)
        luma = self.resampled(filtered, luma.shape, RESAMPLING_METHOD, -run.border)
        return ImageValue(luma, chroma, back=image.back)

    def _before_filters(self, luma: Node, run: BankRun, key: StepKey) -> Node:
        """Return luma after the steps that a bank has before its filters."""
        for block, values in run.luma_steps:
            percentages = block.percentiles_for(values)
            request = PercentileRequest(luma, percentages, values["settle"], key) if percentages else None
            luma = self.node(
                "block", "luma", luma.shape, {"image": luma}, values=values, block=block,
                radius=block.radius_for(values), measure=request,
            )  # fmt: skip
        return luma

    def _after_matrix(self, image: ImageValue, matrix: np.ndarray) -> ImageValue:
        """Return the picture after a colour matrix, 3 x 4."""
        values = dict(zip(("red", "green", "blue"), map(tuple, matrix.tolist()), strict=True))
        inputs = {"color": self.color(image)}
        color = self.node("color_matrix", "color", image.shape, inputs, values=values)
        return ImageValue(color=color, back=image.back)

    def _run_network(self, image: ImageValue, run: NetworkRun | None) -> ImageValue:
        """Return the picture after a network; itself without one."""
        if run is None:
            return image
        inputs = {"color": self.color(image)}
        return ImageValue(
            color=self.node("network", "color", image.shape, inputs, values={"run": run}), back=image.back
        )

    def _run_bank_on_chroma(self, image: ImageValue, luma: Node, run: BankRun) -> Node:
        """Its chroma after a bank; luma, at the size at which the bank runs, chooses the filters."""
        chroma = self.chroma(image)
        assert chroma is not None
        small = self.resampled(chroma, luma.shape, RESAMPLING_METHOD, run.border)
        inputs = {"luma": luma, "chroma": small}
        filtered = self.node(
            "filter_bank", "chroma", luma.shape, inputs, values={"run": run}, radius=run.radius
        )
        return self.resampled(filtered, chroma.shape, RESAMPLING_METHOD, -run.border)

    def _call(
        self,
        step: ResolvedStep,
        block: Block,
        image: Node,
        pictures: dict[str, ImageValue],
        measure: PercentileRequest | None,
    ) -> Node:
        inputs = {"image": image}
        for name, picture in pictures.items():
            wanted = block.saved_refs[name].on
            if wanted != "chroma":
                takes_color = image.kind == "color" and wanted == "same"
                inputs[name] = self.color(picture) if takes_color else self.luma(picture)
        return self.node(
            "block",
            image.kind,
            image.shape,
            inputs,
            values=step.values,
            block=block,
            radius=block.radius_for(step.values),
            measure=measure,
            matrix=self.encoding.matrix,
            is_wide=block.overshoots and any(node.is_wide for node in inputs.values()),
        )

    def _with_luma(
        self, block: Block, image: ImageValue, luma: Node, pictures: dict[str, ImageValue]
    ) -> ImageValue:
        """Return the picture with other luma, and the chroma that the block leaves or takes."""
        chroma = None if block.chroma == "dropped" else self.stored_chroma(image)
        for name, picture in pictures.items():
            if block.saved_refs[name].on == "chroma":
                chroma = self.stored_chroma(picture)
        return ImageValue(luma, chroma, back=image.back)

    def _at_page_size(self, image: ImageValue) -> ImageValue:
        return self.at_size(image, self.source.shape, image.back)

    def _on_paper(self, style: Style, background: ImageValue | None) -> ImageValue:
        """Return the background printed on the paper, or the paper alone."""
        paper, shape = rgb_from_text(style.paper), self.source.shape
        if background is not None and paper == (1.0, 1.0, 1.0):
            return background
        if background is None or background.is_gray:
            level, *tint = self.encoding.yuv_from_color(paper)
            chroma = self._constant_chroma(tuple(tint)) if any(tint) else None
            blank = ImageValue(self.node("constant_luma", "luma", shape, {}, values={"level": level}), chroma)
            return self._inked(blank, (0.0, 0.0, 0.0), background)
        inputs = {"color": self.color(background)}
        return ImageValue(color=self.node("on_paper", "color", shape, inputs, values={"paper": paper}))

    def _inked(
        self, under: ImageValue, ink: tuple[float, float, float], lines: ImageValue | None
    ) -> ImageValue:
        """Ink where the lines are dark. Mixing is linear, so that it needs no conversion before it."""
        if lines is None:
            return under
        cover, shape = self.luma(lines), self.source.shape
        if under.color is not None:
            inputs = {"under": under.color, "lines": cover}
            return ImageValue(color=self.node("inked_color", "color", shape, inputs, values={"ink": ink}))
        level, *tint = self.encoding.yuv_from_color(ink)
        inputs = {"under": self.luma(under), "lines": cover}
        luma = self.node("inked_luma", "luma", shape, inputs, values={"ink": level})
        chroma = self.chroma(under)
        if chroma is None and any(tint):
            chroma = self._constant_chroma((0.0, 0.0))
        if chroma is not None:
            inputs = {"under": chroma, "lines": cover}
            chroma = self.node("inked_chroma", "chroma", shape, inputs, values={"ink": tuple(tint)})
        return ImageValue(luma, chroma)

    def _constant_chroma(self, tint: tuple[float, ...]) -> Node:
        return self.node("constant_chroma", "chroma", self.source.shape, {}, values={"tint": tint})
