"""The nodes of a lowered style: a directed acyclic graph of the values at every pixel.

Nodes hold neither samples nor code, and two equal ones are one. `lower` makes them; `cpu/` executes them in
bands of rows, `gpu/compile` turns them into GLSL.

Operations (`Node.op`), with the names of their inputs and values:

| op               | inputs                | values   | result                                               |
|------------------|-----------------------|----------|------------------------------------------------------|
| plane            |                       |          | a plane of the source, or its two chroma planes      |
| mask             |                       | name     | a mask of the source, or its backdrop                |
| luma_from_rgb    | color                 |          | luma, with `matrix` (ITU-T H.273, section 8.3)       |
| chroma_from_rgb  | color                 |          | blue and red difference, with `matrix`               |
| rgb_from_yuv     | luma, chroma          |          | RGB, with `matrix`                                   |
| rgb_from_gray    | luma                  |          | RGB with three equal channels                        |
| upsample         | chroma                |          | chroma of a subsampled grid at every pixel, linear   |
| resample         | image                 | method,  | the image at this node's shape, see `core.resample`  |
|                  |                       | border   |                                                      |
| block            | image, saved pictures | its own  | the function of `block`                              |
| filter_bank      | luma, chroma          | run      | all passes of a `BankRun`; without chroma, of luma   |
| network          | color                 | run      | the whole picture after a `NetworkRun`               |
| constant_luma    |                       | level    | the same luma everywhere                             |
| constant_chroma  |                       | tint     | the same chroma everywhere                           |
| color_matrix     | color                 | its rows | RGB after a 3 x 4 matrix, clipped to 0..1            |
| on_paper         | color                 | paper    | color * paper, clipped to 0..1                       |
| inked_luma       | under, lines          | ink      | lines * under + (1 - lines) * ink                    |
| inked_chroma     | under, lines          | ink      | the same for chroma                                  |
| inked_color      | under, lines          | ink      | the same for RGB                                     |
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache, cached_property, lru_cache
from operator import attrgetter
from typing import Any, Generic, Literal, NamedTuple, TypeVar

from vidstyle.block import Block
from vidstyle.core.picture import RANGES, WIDE_RANGE, Encoding, PictureLayout
from vidstyle.core.resample import OVERSHOOTING

T = TypeVar("T")
Kind = Literal["luma", "chroma", "color"]
Op = Literal[
    "plane",
    "mask",
    "luma_from_rgb",
    "chroma_from_rgb",
    "rgb_from_yuv",
    "rgb_from_gray",
    "upsample",
    "resample",
    "block",
    "filter_bank",
    "network",
    "constant_luma",
    "constant_chroma",
    "color_matrix",
    "on_paper",
    "inked_luma",
    "inked_chroma",
    "inked_color",
]
Shape = tuple[int, int]
"""Height and width."""

StepKey = tuple[str, int]
"""Layer and number of a step."""


@dataclass(frozen=True, eq=False)
class PercentileRequest(Generic[T]):
    """Percentiles of luma that a measured step takes, smoothed over time.

    Attributes:
        of: the node of luma that is measured.
        percentages: which percentiles.
        time_constant: in seconds.
        step: the step, by which an executor keeps the smoothed numbers from picture to picture.
    """

    of: T
    percentages: tuple[float, ...]
    time_constant: float
    step: StepKey


@dataclass(frozen=True, eq=False)
class Node:
    """One value at every pixel.

    Attributes:
        op: the operation, see the table above.
        kind: what the value is.
        shape: of the picture that it belongs to; for chroma with a grid, in samples of that grid.
        inputs: nodes by the operation's names; `image` is what a block works on.
        values: constants by the operation's names.
        block: the block of a "block" node.
        radius: how many pixels around its own a neighbourhood operation reads of its inputs.
        measure: what a measured block takes.
        matrix: the colour matrix of a conversion, or of the luma weights that a block takes.
        grid: step and siting of subsampled chroma; None for chroma at every pixel.
        page: shape of the luma that subsampled chroma belongs to.
        is_wide: whether it goes far beyond black and white, as a difference of Gaussians does.
        follows_overshoot: whether resampling may have put what it is made from beyond its range.
    """

    op: Op
    kind: Kind
    shape: Shape
    inputs: dict[str, Node] = field(default_factory=dict)
    values: dict[str, Any] = field(default_factory=dict)
    block: Block | None = None
    radius: int = 0
    measure: PercentileRequest[Node] | None = None
    matrix: str = ""
    grid: Encoding | None = None
    page: Shape | None = None
    is_wide: bool = False
    follows_overshoot: bool = False

    @cached_property
    def limits(self) -> tuple[float, float] | None:
        """What its values are clipped to, so that no chain of steps leaves all bounds; None: they are not.

        Resampling once is not: textures have room for what it adds. A bank clips each of its passes itself.
        """
        resampled_again = self.follows_overshoot and self._is_overshooting_resample
        if not (resampled_again or (self.block is not None and self.block.overshoots)):
            return None
        return WIDE_RANGE if self.is_wide else RANGES[self.kind]

    @property
    def may_overshoot(self) -> bool:
        """Whether resampling may have put it beyond its range, with nothing to clip it since."""
        is_clipped = self.op == "filter_bank" or self.limits is not None
        return not is_clipped and (self.follows_overshoot or self._is_overshooting_resample)

    @property
    def _is_overshooting_resample(self) -> bool:
        return self.op == "resample" and self.values["method"] in OVERSHOOTING

    @property
    def is_given(self) -> bool:
        """Whether it comes with the source, and is not computed."""
        return self.op in ("plane", "mask")

    @property
    def reads_neighbors(self) -> bool:
        """Whether it is a block or a bank that reads other pixels than its own."""
        return self.op == "filter_bank" or (self.block is not None and self.block.kind == "filter")


class ScaledSize(NamedTuple):
    """How a size follows from another one.

    Attributes:
        of: the other height and width.
        factor: by which it is scaled.
        border: pixels that are then added on every side.
    """

    of: Shape
    factor: float
    border: int = 0


@dataclass(frozen=True)
class LoweredStyle:
    """What a style computes for pictures of one layout.

    Attributes:
        source: the layout.
        target: how the planes of the result are encoded.
        color: the result as RGB where packed RGB is wanted; then there is neither luma nor chroma.
        luma: the result's luma.
        chroma: its chroma: at every pixel, then to be averaged to the target's grid; or on that grid
            already, at most in other codes; or None, which stands for neutral chroma.
        sizes: for each height and width at which it runs, how it follows from another size.
    """

    source: PictureLayout
    target: Encoding
    color: Node | None = None
    luma: Node | None = None
    chroma: Node | None = None
    sizes: Mapping[Shape, ScaledSize] = field(default_factory=dict)

    @property
    def luma_untouched(self) -> bool:
        """Whether luma is the source's own plane, codes included."""
        return self._is_source_plane(self.luma)

    @property
    def chroma_untouched(self) -> bool:
        """Whether chroma is the source's own planes, codes included."""
        return self._is_source_plane(self.chroma)

    @cached_property
    def reads_chroma(self) -> bool:
        """Whether any node reads chroma planes of the source."""
        return any(node.op == "plane" and node.kind == "chroma" for node in nodes_in_order(self.outputs))

    @property
    def outputs(self) -> tuple[Node, ...]:
        """The nodes of the result."""
        return tuple(node for node in (self.color, self.luma, self.chroma) if node is not None)

    def _is_source_plane(self, node: Node | None) -> bool:
        return node is not None and node.op == "plane" and self.source.encoding == self.target


@lru_cache
def encoding_of(matrix: str) -> Encoding:
    """Return the encoding of luma and chroma with the `matrix` of a node."""
    return Encoding(matrix)


def in_order(roots: Iterable[T], needs: Callable[[T], Iterable[T]]) -> list[T]:
    """Return all dependencies of the roots in topological order, without recursion: styles may be long."""
    found: dict[T, None] = {}
    entered: set[T] = set()
    stack = list(roots)[::-1]
    while stack:
        last = stack[-1]
        if last in entered:
            found[stack.pop()] = None
        else:
            entered.add(last)
            stack += [each for each in needs(last) if each not in found][::-1]
    return list(found)


def nodes_in_order(roots: Iterable[Node]) -> list[Node]:
    """Return all nodes that the roots need, each after those that it needs itself."""

    def needs(node: Node) -> Iterable[Node]:
        return [*node.inputs.values(), *([node.measure.of] if node.measure else [])]

    return in_order(roots, needs)


def identity_key(node: Any) -> tuple[object, ...]:
    """Return what two equal nodes have in common: their fields, nodes and arrays by identity.

    Arrays live as long as the style does, so their identity serves.
    """
    return tuple(map(_key, _all_fields(node.__class__)(node)))


@cache
def _all_fields(kind: Any) -> Callable[[Any], tuple[Any, ...]]:
    """Return the function that reads all fields of nodes of a kind."""
    return attrgetter(*(each.name for each in fields(kind)))


def _key(value: Any) -> object:
    if isinstance(value, dict):
        return tuple((name, _key(each)) for name, each in value.items())
    if isinstance(value, Encoding) or value is None or isinstance(value, int | float | str):
        return value
    if isinstance(value, tuple) and all(isinstance(part, int | float | str | tuple) for part in value):
        return value
    return id(value)
