"""Which part of each picture is needed for a part of the result, and how a page is divided into tiles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, floor

from vidstyle.core.picture import Encoding
from vidstyle.core.planes import chroma_reach
from vidstyle.gpu.nodes import Node, Shape
from vidstyle.gpu.passes import Pass

RESAMPLING_REACH = 5
"""Pixels beyond its own area that any resampling method reads, one more than Lanczos does."""
TILE_STEP = 64
"""Tiles begin at multiples of so many pixels, which every chroma step and every compute group divides."""


@dataclass(frozen=True)
class Window:
    """Part of a page, in pixels: the last row and column are not in it."""

    top: int
    left: int
    bottom: int
    right: int

    @classmethod
    def whole(cls, shape: Shape) -> Window:
        """A whole page."""
        return cls(0, 0, *shape)

    @property
    def shape(self) -> Shape:
        """Height and width."""
        return self.bottom - self.top, self.right - self.left

    def joined(self, other: Window | None) -> Window:
        """The smallest window that holds both."""
        if other is None:
            return self
        return Window(
            min(self.top, other.top),
            min(self.left, other.left),
            max(self.bottom, other.bottom),
            max(self.right, other.right),
        )

    def within(self, shape: Shape) -> Window:
        """What of it lies on a page, at least one pixel."""
        top, left = (
            min(max(start, 0), side - 1) for start, side in zip((self.top, self.left), shape, strict=True)
        )
        bottom, right = min(self.bottom, shape[0]), min(self.right, shape[1])
        return Window(top, left, max(bottom, top + 1), max(right, left + 1))

    def grown(self, rows: tuple[int, int], columns: tuple[int, int]) -> Window:
        """It with so many more rows above and below and columns left and right."""
        return Window(
            self.top - rows[0], self.left - columns[0], self.bottom + rows[1], self.right + columns[1]
        )

    def on_grid(self, encoding: Encoding) -> Window:
        """The chroma samples whose areas begin in it."""
        across, down = encoding.step
        return Window(
            self.top // down, self.left // across, -(-self.bottom // down), -(-self.right // across)
        )


def windows_for(
    passes: Sequence[Pass], wanted: dict[Pass, Window], target: Encoding
) -> dict[Node | Pass, Window]:
    """The part that each pass has to compute, and that is needed of each plane of the source.

    Args:
        passes: those that have to run, in order.
        wanted: what is wanted of the last ones.
        target: how the result is encoded.

    Returns:
        the windows of passes and of the source's planes; none for passes that are not needed.
    """
    windows: dict[Node | Pass, Window] = dict(wanted.items())
    for each in reversed(passes):
        window = windows.get(each)
        if window is None:
            continue
        if each.result and each.result.role == "planes":
            window = window.grown(chroma_reach(target, 1), chroma_reach(target, 0)).within(each.shape)
        for image, part in _read(each, window):
            home = next((other for other in passes if image in other.stored), image)
            windows[home] = part.within(image.shape).joined(windows.get(home))
    return windows


def tiles(shape: Shape, side: int) -> list[Window]:
    """A page in tiles of at most `side` pixels, a multiple of TILE_STEP, across and down."""
    return [
        Window(top, left, min(top + side, shape[0]), min(left + side, shape[1]))
        for top in range(0, shape[0], side)
        for left in range(0, shape[1], side)
    ]


def _read(each: Pass, window: Window) -> Iterator[tuple[Node, Window]]:
    for node in each.loads:
        if node.grid is None or node.shape == each.shape:
            yield node, window
    for node in each.nodes:
        if node.around is not None:
            yield node.around, _around(node, node.around, window)


def _around(node: Node, image: Node, window: Window) -> Window:
    """What a node reads of the picture around it."""
    if node.is_enlarged and image.grid is not None:
        return _between(window, image.grid)
    if node.function is not None and node.function.name == "shrunk_chroma":
        (across, down), (x, y) = node.values["step"], node.values["siting"]
        top, left = floor(window.top * down + y - down), floor(window.left * across + x - across)
        return Window(top, left, ceil(window.bottom * down + y + 1), ceil(window.right * across + x + 1))
    if node.shape != image.shape:
        down, across = (old / new for old, new in zip(image.shape, node.shape, strict=True))
        mapped = Window(
            floor(window.top * down),
            floor(window.left * across),
            ceil(window.bottom * down),
            ceil(window.right * across),
        )
        reach = max(RESAMPLING_REACH, node.reach)
        return mapped.grown((reach, reach), (reach, reach))
    return window.grown((node.reach,) * 2, (node.reach,) * 2)


def _between(window: Window, grid: Encoding) -> Window:
    (across, down), (x, y) = grid.step, grid.siting
    return Window(
        floor((window.top - y) / down) if down > 1 else window.top,
        floor((window.left - x) / across) if across > 1 else window.left,
        floor((window.bottom - 1 - y) / down) + 2 if down > 1 else window.bottom,
        floor((window.right - 1 - x) / across) + 2 if across > 1 else window.right,
    )
