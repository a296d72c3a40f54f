"""Draws a style by the rules of the paper: smooth colours, and lines over them."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

from vidstyle.blocks import all_blocks
from vidstyle.explore.paper.rules import (
    CUT_BLOCK,
    EVEN_SHARE,
    FILTER_COUNT_RANGE,
    FILTER_RULES,
    GRAY_RULE,
    GRAY_SHARE,
    LINE_BLOCK,
    MAX_GAIN,
    PAPER_HEIGHT,
    RANGE_BLOCK,
    SMOOTH_BLOCK,
    SURROUNDINGS_DEVIATION_PX,
    SURROUNDINGS_FACTOR,
    TONES_BLOCK,
    FilterRule,
)
from vidstyle.explore.random_steps import random_value, scale_factor
from vidstyle.style import Step, Style


def paper_style(random: Random, style: Style) -> Style:
    """Return the style with random layers by the rules of the paper."""
    count = random.randint(*FILTER_COUNT_RANGE)
    is_gray = random.random() < GRAY_SHARE
    rules = _filters(random, count - is_gray)
    while not _is_usable(rules):
        rules = _filters(random, count - is_gray)
    if is_gray:
        rules.insert(random.randint(0, len(rules)), GRAY_RULE)
    steps = [_step(random, rule) for rule in rules]
    smooth, lines, cuts = (_of(steps, block) for block in (SMOOTH_BLOCK, LINE_BLOCK, CUT_BLOCK))
    colors = [step for step in steps if step not in (*smooth, *lines, *cuts)]
    return replace(
        style,
        height=PAPER_HEIGHT,
        base=(Step(RANGE_BLOCK), *smooth),
        background=tuple(_enlarged(colors)),
        lines=(*_evened(), *_limited(lines), *cuts),
    )


def _filters(random: Random, count: int) -> list[FilterRule]:
    """Return random filters; only some repeat."""
    rules: list[FilterRule] = []
    while len(rules) < count:
        rules.append(random.choice([rule for rule in FILTER_RULES if rule.repeats or rule not in rules]))
    return rules


def _is_usable(rules: list[FilterRule]) -> bool:
    """Whether there are lines with a threshold on a smooth picture, and flat tones, if there is room."""
    blocks = {rule.block for rule in rules}
    needed = {SMOOTH_BLOCK, LINE_BLOCK, CUT_BLOCK}
    return needed <= blocks and (TONES_BLOCK in blocks or len(rules) == len(needed))


def _step(random: Random, rule: FilterRule) -> Step:
    parameters = all_blocks()[rule.block].parameters
    names = (*rule.parameters, *rule.ends)
    drawn = {name: random_value(random, parameters[name], rule.ends.get(name)) for name in names}
    return Step(rule.block, rule.fixed | drawn)


def _of(steps: list[Step], block: str) -> list[Step]:
    return [step for step in steps if step.block == block]


def _evened() -> list[Step]:
    """Return steps that remove most of the brightness around each pixel, for lines also in shadows."""
    mixing = {"other": "around", "mode": "grain_extract", "opacity": EVEN_SHARE}
    return [
        Step("to_gray", save="gray"),
        Step("scale", {"factor": scale_factor(SURROUNDINGS_FACTOR)}),
        Step("gaussian", {"sigma": SURROUNDINGS_DEVIATION_PX}, save="around"),
        Step("blend", mixing, source="gray"),
    ]


def _limited(lines: list[Step]) -> list[Step]:
    """Return lines with strengths that amplify by at most `MAX_GAIN` together."""
    gain = math.prod(1 + step.values["p"] for step in lines)
    if gain <= MAX_GAIN:
        return lines
    power = math.log(MAX_GAIN) / math.log(gain)
    return [
        replace(step, values=step.values | {"p": max(1.0, round((1 + step.values["p"]) ** power - 1, 1))})
        for step in lines
    ]


def _enlarged(steps: list[Step]) -> list[Step]:
    """Return the steps with the picture enlarged to its size before its tones become flat.

    Otherwise, everything after the working size would be shown enlarged, and therefore blurred. Without flat
    tones, it is enlarged last: lines over it are sharp.
    """
    rest = [step for step in steps if step.block != "scale"]
    if len(rest) == len(steps):
        return steps
    place = [step.block for step in steps].index("scale")
    full = next((at for at, step in enumerate(rest) if step.block == TONES_BLOCK), len(rest))
    enlarge = Step("scale", {"factor": scale_factor(1 / steps[place].values["factor"]), "method": "smooth"})
    place = min(place, full)
    return [*rest[:place], *_of(steps, "scale"), *rest[place:full], enlarge, *rest[full:]]
