"""Runs the passes of a plan again and again, and times each."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import product
from statistics import median
from typing import Literal

from vidstyle.core.picture import Picture
from vidstyle.gpu.jobs import Job
from vidstyle.gpu.passes import Pass
from vidstyle.gpu.plan import Plan
from vidstyle.gpu.runner import Equipment, Runner, Shares, _arrays_of

Clock = Literal["timer queries", "wall clock"]
"""What passes are timed with: the GPU's own clock, or this program's, waiting before and after each pass."""

Reading = Callable[[], float]
"""Tells a time in seconds; asked too early it waits for the GPU."""


class TimedRunner(Runner):
    """Runs passes again and again without transfers, and times them. Whoever calls it owns the context."""

    def __init__(self, equipment: Equipment, plan: Plan, largest: int, clock: Clock) -> None:
        super().__init__(equipment, plan, largest)
        self._clock = clock

    def run(self, picture: Picture, runs: int) -> tuple[float, ...]:
        """The seconds that each pass takes for a picture: the median of the runs."""
        shares = {each.sampled.step: 1.0 for each in self.plan.passes if each.sampled}
        total = dict.fromkeys(self.plan.passes, 0.0)
        for job in self._jobs:
            times = self._run_often(job, picture, shares, runs)
            for each in job.passes:
                # Read only here, when all is under way, so that the GPU never waits for this program.
                total[each] += median(read() for read in times[each])
        return tuple(total.values())

    def _run_often(self, job: Job, picture: Picture, shares: Shares, runs: int) -> dict[Pass, list[Reading]]:
        sent = self._equipment.upload.send(
            {
                name: plane[window.top : window.bottom, window.left : window.right]
                for node, window in job.planes.items()
                for name, plane in _arrays_of(node, picture).items()
            }
        )
        times: dict[Pass, list[Reading]] = {each: [] for each in job.passes}
        for _, each in product(range(runs), job.passes):
            with self._timed(times[each]):
                self._run_pass(job, each, sent)
                if each.sampled is not None and job.ends_measure:
                    self._measure(each.sampled, shares)
        return times

    @contextmanager
    def _timed(self, times: list[Reading]) -> Iterator[None]:
        """Append what tells how long the GPU takes for the block."""
        context = self._equipment.context
        if self._clock == "timer queries":
            query = context.query(time=True)
            with query:
                yield
            times.append(lambda: query.elapsed / 1e9)
            return
        context.finish()
        began = time.perf_counter()
        yield
        context.finish()
        elapsed = time.perf_counter() - began
        times.append(lambda: elapsed)
