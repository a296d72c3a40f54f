"""Pictures in the graph of what is computed at every pixel, and how they become others of other form or size.

A picture is luma with or without chroma, or RGB, and is converted when something asks for another form, as
the CPU's `Work` does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from vidstyle.core.picture import Encoding
from vidstyle.core.resample import METHODS, fitting_method
from vidstyle.gpu.nodes import CHANNELS, Function, Kind, Layout, Node, Shape


@dataclass(frozen=True)
class Look:
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


class Looks:
    """Makes the nodes of pictures, each only once, and brings pictures to other forms.

    Attributes:
        source: what comes in.
        encoding: its matrix is the one that luma is taken with.
        planes: the source itself.
    """

    def __init__(self, source: Layout) -> None:
        self.source = source
        self.encoding = source.encoding
        self.planes = self._source_planes()
        self._nodes: dict[object, Node] = {}

    def luma(self, look: Look) -> Node:
        """Its luma."""
        if look.color is None:
            assert look.luma is not None
            return look.luma
        return self.call("luma", "luma_from_rgb", {"color": look.color}, from_rgb=self.encoding.from_rgb)

    def chroma(self, look: Look) -> Node | None:
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

    def chroma_on_grid(self, look: Look, target: Encoding) -> Node | None:
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

    def color(self, look: Look) -> Node:
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

    def in_matrix(self, look: Look, matrix: str) -> Look:
        """The picture, from which luma and chroma are to be taken with another colour matrix from now on."""
        if matrix == self.encoding.matrix or look.is_gray:
            return look
        look = Look(color=self.color(look))
        self.encoding = replace(self.encoding, matrix=matrix)
        return look

    def at_size(self, look: Look, shape: Shape, method: str) -> Look:
        """The picture at another size."""
        if look.shape == shape:
            return look
        if look.color is not None:
            return Look(color=self.resized(look.color, shape, method))
        assert look.luma is not None
        chroma = look.chroma
        if chroma is not None and chroma.grid is not None:
            assert chroma.page is not None
            grid = chroma.grid.as_float_at(chroma.page, shape)
            chroma = self.resized(chroma, grid.chroma_shape(*shape), method)
            chroma = self.node(replace(chroma, grid=grid, page=shape))
        elif chroma is not None:
            chroma = self.resized(chroma, shape, method)
        return Look(self.resized(look.luma, shape, method), chroma)

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

    def _source_planes(self) -> Look:
        shape, encoding = self.source.shape, self.source.encoding
        if self.source.planes == "color":
            return Look(color=Node("color", shape))
        if self.source.planes == "gray":
            return Look(Node("luma", shape))
        chroma = Node("chroma", encoding.chroma_shape(*shape), grid=encoding, page=shape)
        return Look(Node("luma", shape), chroma)


def _hashable(value: Any) -> object:
    """What stands for the value in a key. Arrays live as long as the style, so their identity does."""
    return value if isinstance(value, int | float | str | tuple) and not _holds_arrays(value) else id(value)


def _holds_arrays(value: Any) -> bool:
    return isinstance(value, tuple) and any(not isinstance(part, int | float) for part in value)
