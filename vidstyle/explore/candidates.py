"""Random styles of which a picture holds together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import count
from threading import Event

import numpy as np

from vidstyle.core.cores import available_cores
from vidstyle.explore.gates import (
    DUPLICATE_FAULT,
    MAX_UNSTEADY,
    NO_FAULT,
    UNSTEADY_FAULT,
    fault,
    is_like_another,
    pruned,
)
from vidstyle.explore.generate import Rules, random_style
from vidstyle.explore.measure import Original, PictureMetrics
from vidstyle.explore.score import score, spread_out
from vidstyle.pipeline.progress import OnStep, unwatched
from vidstyle.style import Style

MAX_ATTEMPTS_PER_STYLE = 50
"""So many times as many styles as are wanted are tried, for pictures of which few styles make anything."""


@dataclass(frozen=True)
class RandomStyle:
    """A style and what it makes of the original.

    Attributes:
        picture: H x W x 3 uint8.
        fault: why it is thrown out; empty if it passes.
        steadiness: as of `Original.steadiness`; 0 where it was not measured.
        score: 0..1, or what a judge gives.
    """

    style: Style
    picture: np.ndarray
    measures: PictureMetrics
    signature: np.ndarray
    fault: str
    steadiness: float
    score: float


@dataclass
class Found:
    """The result of a search.

    Attributes:
        chosen: the best first, and none like another.
        faults: how many styles were thrown out, by reason; those that passed under "".
    """

    chosen: list[RandomStyle] = field(default_factory=list)
    faults: Counter[str] = field(default_factory=Counter)

    @property
    def tried(self) -> int:
        return self.faults.total()


def examined(original: Original, style: Style) -> RandomStyle:
    """A style with the measures, the fault and the score of what it makes of the original."""
    picture = original.render(style)
    measures = original.measure(picture)
    reason, steadiness = fault(measures), 0.0
    if not reason:
        steadiness = original.steadiness(style, picture)
        reason = UNSTEADY_FAULT if steadiness > MAX_UNSTEADY else NO_FAULT
    signature = original.signature(picture, measures)
    return RandomStyle(style, picture, measures, signature, reason, steadiness, score(measures))


def search(
    original: Original,
    seed: int,
    wanted: int,
    rules: Rules = "open",
    tries: int | None = None,
    judge: Callable[[np.ndarray], float] | None = None,
    on_step: OnStep = unwatched,
    stop: Event | None = None,
) -> Found:
    """Find random styles of which a picture holds together.

    Args:
        seed: the styles are those of the seeds "SEED-1", "SEED-2" and so on.
        wanted: how many.
        tries: how many styles to draw, of which the best are chosen; None: until as many as wanted pass.
        judge: scores pictures instead of the own score.
        on_step: is told how many have passed, or how many were tried.
        stop: once it is set, the search ends with what it has.

    Returns:
        The same for the same arguments, whatever the number of cores.
    """
    found, passed, is_stopped = Found(), list[RandomStyle](), False
    on_step("drawing styles", 0, tries or wanted)
    for candidate in _drawn(original, seed, rules, tries or MAX_ATTEMPTS_PER_STYLE * wanted):
        reason = candidate.fault
        if not reason and is_like_another(candidate.signature, [each.signature for each in passed]):
            reason = DUPLICATE_FAULT
        found.faults[reason] += 1
        if not reason:
            passed.append(replace(candidate, score=judge(candidate.picture)) if judge else candidate)
        on_step("drawing styles", found.tried if tries else len(passed), tries or wanted)
        if (is_stopped := stop is not None and stop.is_set()) or (tries is None and len(passed) >= wanted):
            break
    if passed:
        worth = _ranks([each.score for each in passed])
        order = spread_out(np.array([each.signature for each in passed]), worth, wanted)
        chosen = [passed[number] for number in order]
        found.chosen = chosen if is_stopped else _pruned(original, chosen, on_step)
    return found


def _drawn(original: Original, seed: int, rules: Rules, tries: int) -> Iterator[RandomStyle]:
    """The candidates in the order of their seeds, made on all cores."""
    numbers = count(1)
    with ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-explore") as pool:
        while tries > 0:
            batch = [next(numbers) for _ in range(min(2 * available_cores(), tries))]
            tries -= len(batch)
            yield from pool.map(lambda n: examined(original, random_style(f"{seed}-{n}", rules)), batch)


def _ranks(scores: list[float]) -> np.ndarray:
    """From 1 for the best to nearly 0, evenly: scores of any kind are then worth alike."""
    order = np.argsort(np.argsort(scores, kind="stable"), kind="stable")
    return (order + 1) / len(scores)


def _pruned(original: Original, chosen: list[RandomStyle], on_step: OnStep) -> list[RandomStyle]:
    """The candidates without steps that change nothing, on all cores."""
    done: list[RandomStyle] = []
    with ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-explore") as pool:
        shorter = pool.map(lambda each: pruned(each.style, original, each.picture), chosen)
        for candidate, style in zip(chosen, shorter, strict=True):
            done.append(replace(candidate, style=style))
            on_step("pruning styles", len(done), len(chosen))
    return done
