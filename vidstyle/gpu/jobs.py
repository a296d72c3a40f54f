"""The order of work for a picture: all passes at once, or tile by tile where a side is too long."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from vidstyle.core.measured import Sampling
from vidstyle.gpu.nodes import Node
from vidstyle.gpu.passes import Pass
from vidstyle.gpu.plan import Plan
from vidstyle.gpu.windows import TILE_STEP, Window, tiles, windows_for

Pair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Job:
    """Passes that run one after another over windows of their pages.

    Attributes:
        plan: what they belong to.
        windows: of each pass, and of the planes of the source.
        ends_measure: whether it is the last that samples for a measure.
    """

    plan: Plan
    windows: dict[Node | Pass, Window]
    ends_measure: bool = True

    @cached_property
    def passes(self) -> list[Pass]:
        """The passes, in order."""
        return [each for each in self.plan.passes if each in self.windows]

    @cached_property
    def planes(self) -> dict[Node, Window]:
        """The planes of the source and what of them is needed."""
        return {node: window for node, window in self.windows.items() if isinstance(node, Node)}

    def window_of(self, node: Node) -> Window:
        """What of a picture lies in its texture."""
        return self.windows.get(node) or self.windows[self._homes[node]]

    def area(self, each: Pass) -> tuple[Pair, Pair, Pair, int]:
        """Where a pass writes and what it computes, x before y.

        Returns:
            the first place in its targets, how many places, the page's pixel at place (0, 0), and how many
            pixels lie between two places.
        """
        window = self.windows[each]
        height, width = window.shape
        if each.sampled is None:
            return (0, 0), (width, height), (window.left, window.top), 1
        sampling = Sampling.of(*each.shape)
        first = [
            -(-(start - begin) // sampling.stride)
            for start, begin in zip((window.top, window.left), sampling.first, strict=True)
        ]
        end = [
            -(-(stop - begin) // sampling.stride)
            for stop, begin in zip((window.bottom, window.right), sampling.first, strict=True)
        ]
        top, left = (max(number, 0) for number in first)
        size = max(end[1] - left, 0), max(end[0] - top, 0)
        return (left, top), size, (sampling.first[1], sampling.first[0]), sampling.stride

    def result_window(self, name: str) -> Window:
        """Where a plane of the result lies, in its own samples."""
        each = next(each for each in self.passes if each.result and _makes(each, name))
        assert each.result is not None
        window = self.windows[each]
        if name in ("blue", "red") and each.result.role == "planes":
            return window.on_grid(self.plan.target)
        return window

    @cached_property
    def _homes(self) -> dict[Node, Pass]:
        return {node: each for each in self.plan.passes for node in each.stored}


def jobs_of(plan: Plan, largest: int) -> list[Job]:
    """The jobs for one picture.

    Args:
        largest: pixels that a texture's side may have; longer pages are done in tiles.
    """
    ends = {each: Window.whole(each.shape) for each in plan.passes if each.sampled or each.result}
    whole = Job(plan, windows_for(plan.passes, ends, plan.target))
    if not plan.passes or _fits(whole, largest):
        return [whole] if plan.passes else []
    return _tiled(plan, largest)


def _tiled(plan: Plan, largest: int) -> list[Job]:
    """Measures first, each over all tiles, then the tiles of the result."""
    side = largest // TILE_STEP * TILE_STEP
    while True:
        jobs = [job for each in plan.passes if each.sampled for job in _over_tiles(plan, each, side)]
        jobs += _result_tiles(plan, side)
        if side <= TILE_STEP or all(_fits(job, largest) for job in jobs):
            return jobs
        side = side // 2 // TILE_STEP * TILE_STEP


def _over_tiles(plan: Plan, each: Pass, side: int) -> list[Job]:
    windows = tiles(each.shape, side)
    before = [other for other in plan.passes if each.needs(other) and other.sampled is None] + [each]
    return [
        Job(plan, windows_for(before, {each: window}, plan.target), ends_measure=window is windows[-1])
        for window in windows
    ]


def _result_tiles(plan: Plan, side: int) -> list[Job]:
    passes = [each for each in plan.passes if each.sampled is None]
    return [
        Job(
            plan,
            windows_for(
                passes, {each: _share(plan, each, window) for each in passes if each.result}, plan.target
            ),
        )
        for window in tiles(plan.source.shape, side)
    ]


def _share(plan: Plan, each: Pass, window: Window) -> Window:
    assert each.result is not None
    return window.on_grid(plan.target) if each.result.role == "chroma" else window


def _makes(each: Pass, name: str) -> bool:
    assert each.result is not None
    kind = "chroma" if name in ("blue", "red") else name
    return any(node.kind == kind for node in each.result.nodes)


def _fits(job: Job, largest: int) -> bool:
    return all(max(window.shape) <= largest for window in job.windows.values())
