"""Search for random styles that pass the quality gates."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import count
from threading import Event

import numpy as np

from vidstyle.core.machine.cores import available_cores
from vidstyle.errors import StyleError
from vidstyle.explore.crops.crop_measures import FullSizeMetrics
from vidstyle.explore.crops.full_size import FullSize
from vidstyle.explore.gates import (
    DUPLICATE_FAULT,
    MAX_UNSTEADY,
    NO_FAULT,
    UNSTEADY_FAULT,
    UNUSABLE_FAULT,
    doubt,
    fault,
    is_like_another,
    prune,
)
from vidstyle.explore.generate import random_style
from vidstyle.explore.measure import Original, PictureMetrics
from vidstyle.explore.paper.rules import Rules
from vidstyle.explore.score import score, spread_out
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.style import Style

MAX_ATTEMPTS_PER_STYLE = 50
"""Maximum number of styles tried for each one wanted; few styles work for some pictures."""


@dataclass(frozen=True)
class RandomStyle:
    """A style and its result on the original.

    Attributes:
        picture: H x W x 3 uint8.
        fault: why it is rejected, or "".
        steadiness: see `Original.steadiness`; 0 if not measured.
        score: 0..1, or the score of a judge.
        full_size: metrics of crops; None if it is rejected before they are measured.
    """

    style: Style
    picture: np.ndarray
    measures: PictureMetrics
    signature: np.ndarray
    fault: str
    steadiness: float
    score: float
    full_size: FullSizeMetrics | None = None


@dataclass
class Found:
    """The result of a search.

    Attributes:
        chosen: the selected styles without duplicates, best first.
        faults: number of rejected styles by reason; passed styles under "".
    """

    chosen: list[RandomStyle] = field(default_factory=list)
    faults: Counter[str] = field(default_factory=Counter)

    @property
    def tried(self) -> int:
        return self.faults.total()


def examine(original: Original, crops: FullSize, style: Style, rules: Rules = "open") -> RandomStyle:
    """Render the original in a style, and return it with metrics, fault and score.

    Args:
        rules: the rules of the style.
    """
    try:
        return _examine(original, crops, style, rules)
    except StyleError:  # it needs too large a working size for this picture
        plain = original.picture
        measures = original.measure(plain)
        signature = original.signature(plain, measures)
        return RandomStyle(style, plain, measures, signature, UNUSABLE_FAULT, 0.0, 0.0)


def _examine(original: Original, crops: FullSize, style: Style, rules: Rules) -> RandomStyle:
    picture = original.render(style)
    measures = original.measure(picture)
    signature = original.signature(picture, measures)
    result = RandomStyle(style, picture, measures, signature, fault(measures), 0.0, 0.0)
    if result.fault:
        return result
    large = crops.measure(style)
    worth = score(large, rules)
    reason = (fault(large, rules) or doubt(worth, rules)) if crops.is_large else NO_FAULT
    result = replace(result, full_size=large, score=worth, fault=reason)
    if result.fault:
        return result
    steadiness = original.steadiness(style, picture)
    return replace(result, steadiness=steadiness, fault=UNSTEADY_FAULT * (steadiness > MAX_UNSTEADY))


def search(
    original: Original,
    seed: int,
    wanted: int,
    rules: Rules = "open",
    tries: int | None = None,
    judge: Callable[[np.ndarray], float] | None = None,
    on_step: ProgressCallback = ignore_progress,
    stop: Event | None = None,
) -> Found:
    """Find random styles that pass the quality gates.

    Args:
        seed: styles are generated from the seeds "SEED-1", "SEED-2" and so on.
        wanted: number of styles to return.
        tries: number of candidates, of which the best are kept; None: until `wanted` styles pass.
        judge: scores pictures instead of `score`.
        on_step: receives progress.
        stop: ends the search early when set.

    Returns:
        The result, which does not depend on the number of cores.
    """
    found, passed, is_stopped = Found(), list[RandomStyle](), False
    on_step("drawing styles", 0, tries or wanted)
    for candidate in _examine_all(original, seed, rules, tries or MAX_ATTEMPTS_PER_STYLE * wanted):
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
        found.chosen = chosen if is_stopped else _prune_all(original, chosen, on_step)
    return found


def _examine_all(original: Original, seed: int, rules: Rules, tries: int) -> Iterator[RandomStyle]:
    """Yield candidates in the order of their seeds, using all cores."""
    numbers, crops = count(1), FullSize(original.large)
    with ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-explore") as pool:
        while tries > 0:
            batch = [next(numbers) for _ in range(min(2 * available_cores(), tries))]
            tries -= len(batch)
            yield from pool.map(
                lambda n: examine(original, crops, random_style(f"{seed}-{n}", rules), rules), batch
            )


def _ranks(scores: list[float]) -> np.ndarray:
    """Return evenly spaced ranks, 1 for the best, so that all kinds of scores weigh the same."""
    order = np.argsort(np.argsort(scores, kind="stable"), kind="stable")
    return (order + 1) / len(scores)


def _prune_all(original: Original, chosen: list[RandomStyle], on_step: ProgressCallback) -> list[RandomStyle]:
    """Remove ineffective steps from all candidates, using all cores."""
    done: list[RandomStyle] = []
    with ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-explore") as pool:
        shorter = pool.map(lambda each: prune(each.style, original, each.picture), chosen)
        for candidate, style in zip(chosen, shorter, strict=True):
            done.append(replace(candidate, style=style))
            on_step("pruning styles", len(done), len(chosen))
    return done
