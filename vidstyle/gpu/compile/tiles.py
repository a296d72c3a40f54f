"""Tiling: how a page is divided, and which part of each picture a tile of the result depends on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, floor
from typing import NamedTuple

from vidstyle.core.codes import chroma_radius
from vidstyle.core.picture import Encoding
from vidstyle.core.sampling import Sampling
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader_nodes import ShaderNode
from vidstyle.style.nodes import Shape

RESAMPLING_RADIUS_PX = 5
"""Maximum number of pixels beyond its area that a resampling method reads: one more than Lanczos."""
MAX_SIDE = 8192
"""Pages with a longer side are processed in tiles, even if the device supports larger textures, as it may not
have enough memory for them."""
TILE_PITCH_PX = 64
"""Tiles begin at multiples of this, a multiple of chroma subsampling and of the sizes of work groups."""


class Window(NamedTuple):
    """Part of a page in pixels; the end row and column are exclusive."""

    top: int
    left: int
    bottom: int
    right: int

    @classmethod
    def whole(cls, shape: Shape) -> Window:
        """Return the window of a whole page."""
        return cls(0, 0, *shape)

    @property
    def shape(self) -> Shape:
        """Height and width."""
        return self.bottom - self.top, self.right - self.left

    def joined(self, other: Window | None) -> Window:
        """Return the smallest window that contains both."""
        if other is None:
            return self
        return Window(*map(min, self[:2], other[:2]), *map(max, self[2:], other[2:]))

    def within(self, shape: Shape) -> Window:
        """Return the part within a page, at least one pixel."""
        top, left = (min(max(start, 0), side - 1) for start, side in zip(self[:2], shape, strict=True))
        bottom, right = map(min, self[2:], shape)
        return Window(top, left, max(bottom, top + 1), max(right, left + 1))

    def grown(self, rows: tuple[int, int], columns: tuple[int, int]) -> Window:
        """Return the window enlarged by rows above and below and columns left and right."""
        return Window(
            self.top - rows[0], self.left - columns[0], self.bottom + rows[1], self.right + columns[1]
        )

    def on_grid(self, encoding: Encoding) -> Window:
        """Return the chroma samples whose areas begin in the window."""
        across, down = encoding.subsampling
        return Window(
            self.top // down, self.left // across, -(-self.bottom // down), -(-self.right // across)
        )


def windows_for(
    passes: Sequence[Pass], wanted: dict[Pass, Window], target: Encoding
) -> dict[ShaderNode | Pass, Window]:
    """Return the windows that each pass must compute, and that are needed of each plane of the source.

    Args:
        passes: the passes to run, in order.
        wanted: windows of the last passes.
        target: encoding of the result.

    Returns:
        Windows of passes and of the source's planes; passes that are not needed have none.
    """
    windows: dict[ShaderNode | Pass, Window] = dict(wanted.items())
    for each in reversed(passes):
        window = windows.get(each)
        if window is None:
            continue
        if each.result and each.result.role == "planes":
            window = window.grown(chroma_radius(target, 1), chroma_radius(target, 0)).within(each.shape)
        for image, part in _read(each, window):
            home = next((other for other in passes if image in other.stored), image)
            windows[home] = part.within(image.shape).joined(windows.get(home))
    return windows


def tiles(shape: Shape, side: int) -> list[Window]:
    """Return the tiles of a page, with sides of at most `side` pixels, a multiple of `TILE_PITCH_PX`."""
    return [
        Window(top, left, min(top + side, shape[0]), min(left + side, shape[1]))
        for top in range(0, shape[0], side)
        for left in range(0, shape[1], side)
    ]


def _read(each: Pass, window: Window) -> Iterator[tuple[ShaderNode, Window]]:
    for node in each.loads:
        if node.grid is None or node.shape == each.shape:
            yield node, window
    for node in each.nodes:
        if node.around is not None:
            yield node.around, _around(node, node.around, window)


def _around(node: ShaderNode, image: ShaderNode, window: Window) -> Window:
    """Return the window of its input that a node reads for a window of its result."""
    if node.is_enlarged and image.grid is not None:
        return _between(window, image.grid)
    if node.function is not None and node.function.name == "shrunk_chroma":
        (across, down), (x, y) = node.values["step"], node.values["siting"]
        top, left = floor(window.top * down + y - down), floor(window.left * across + x - across)
        return Window(top, left, ceil(window.bottom * down + y + 1), ceil(window.right * across + x + 1))
    border = node.values.get("border", 0)
    if node.shape != image.shape or border:
        added, removed = max(border, 0), max(-border, 0)
        sides = zip(image.shape, node.shape, strict=True)
        down, across = ((old - 2 * removed) / (new - 2 * added) for old, new in sides)
        on_page = window.grown((added, -added), (added, -added))
        top, left = floor(on_page.top * down), floor(on_page.left * across)
        bottom, right = ceil(on_page.bottom * down), ceil(on_page.right * across)
        mapped = Window(top, left, bottom, right).grown((-removed, removed), (-removed, removed))
        radius = max(RESAMPLING_RADIUS_PX, node.radius)
        return mapped.grown((radius, radius), (radius, radius))
    return window.grown((node.radius,) * 2, (node.radius,) * 2)


def _between(window: Window, grid: Encoding) -> Window:
    (across, down), (x, y) = grid.subsampling, grid.siting
    return Window(
        floor((window.top - y) / down) if down > 1 else window.top,
        floor((window.left - x) / across) if across > 1 else window.left,
        floor((window.bottom - 1 - y) / down) + 2 if down > 1 else window.bottom,
        floor((window.right - 1 - x) / across) + 2 if across > 1 else window.right,
    )


Pair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Job:
    """Passes that run one after another over windows of their pages.

    Attributes:
        plan: the plan of the passes.
        windows: windows of each pass, and of the planes of the source.
        ends_measure: whether it is the last job that samples for a measure.
    """

    plan: Plan
    windows: dict[ShaderNode | Pass, Window]
    ends_measure: bool = True

    @cached_property
    def passes(self) -> list[Pass]:
        """The passes, in order."""
        return [each for each in self.plan.passes if each in self.windows]

    @cached_property
    def planes(self) -> dict[ShaderNode, Window]:
        """The planes of the source and their windows."""
        return {node: window for node, window in self.windows.items() if isinstance(node, ShaderNode)}

    def window_of(self, node: ShaderNode) -> Window:
        """Return the part of a picture that its texture holds."""
        return self.windows.get(node) or self.windows[self._homes[node]]

    def area(self, each: Pass) -> tuple[Pair, Pair, Pair, int]:
        """Return the area that a pass computes, x before y.

        Returns:
            First texel in its targets, number of texels, pixel of the page at texel (0, 0), and pixels from
            one texel to the next.
        """
        window = self.windows[each]
        height, width = window.shape
        if each.sampled is None:
            return (0, 0), (width, height), (window.left, window.top), 1
        sampling = Sampling.of(*each.shape)
        row, column = sampling.first
        top, bottom = (max(-(-(edge - row) // sampling.stride), 0) for edge in (window.top, window.bottom))
        left, right = (max(-(-(edge - column) // sampling.stride), 0) for edge in (window.left, window.right))
        return (left, top), (right - left, bottom - top), (column, row), sampling.stride

    def result_window(self, name: str) -> Window:
        """Return the window of a plane of the result, in samples of the plane."""
        kind = "chroma" if name in ("blue", "red") else name
        window, role = next(
            (self.windows[each], each.result.role)
            for each in self.passes
            if each.result and any(node.kind == kind for node in each.result.nodes)
        )
        return window.on_grid(self.plan.target) if kind == "chroma" and role == "planes" else window

    @cached_property
    def _homes(self) -> dict[ShaderNode, Pass]:
        return {node: each for each in self.plan.passes for node in each.stored}


def jobs_of(plan: Plan, max_side: int) -> list[Job]:
    """Return the jobs for one picture.

    Args:
        max_side: maximum side of a texture in pixels; larger pages are processed in tiles.
    """
    ends = {each: Window.whole(each.shape) for each in plan.passes if each.sampled or each.result}
    whole = Job(plan, windows_for(plan.passes, ends, plan.target))
    if not plan.passes or _fits(whole, max_side):
        return [whole] if plan.passes else []
    return _tiled(plan, max_side)


def _tiled(plan: Plan, max_side: int) -> list[Job]:
    """Return jobs for measures, each over all tiles, then for the tiles of the result."""
    side = max_side // TILE_PITCH_PX * TILE_PITCH_PX
    while True:
        jobs = [job for each in plan.passes if each.sampled for job in _over_tiles(plan, each, side)]
        jobs += _result_tiles(plan, side)
        if side <= TILE_PITCH_PX or all(_fits(job, max_side) for job in jobs):
            return jobs
        side = side // 2 // TILE_PITCH_PX * TILE_PITCH_PX


def _over_tiles(plan: Plan, each: Pass, side: int) -> list[Job]:
    windows = tiles(each.shape, side)
    before = [other for other in plan.passes if each.needs(other) and other.sampled is None] + [each]
    return [
        Job(plan, windows_for(before, {each: window}, plan.target), ends_measure=window is windows[-1])
        for window in windows
    ]


def _result_tiles(plan: Plan, side: int) -> list[Job]:
    passes = [each for each in plan.passes if each.sampled is None]
    roles = {each: each.result.role for each in passes if each.result}
    jobs = []
    for window in tiles(plan.source.shape, side):
        of_chroma = window.on_grid(plan.target)
        wanted = {each: of_chroma if role == "chroma" else window for each, role in roles.items()}
        jobs.append(Job(plan, windows_for(passes, wanted, plan.target)))
    return jobs


def _fits(job: Job, max_side: int) -> bool:
    return all(max(window.shape) <= max_side for window in job.windows.values())
