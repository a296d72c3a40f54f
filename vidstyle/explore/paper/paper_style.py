"""Draws a style by the rules of the paper: smooth colours, and lines over them."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

from vidstyle.blocks import all_blocks
from vidstyle.explore.paper.light import evened, lit, moderated, thinned
from vidstyle.explore.paper.rules import (
    COLOR_BLOCK,
    CUT_BLOCK,
    DETAIL_BLOCK,
    FILTER_COUNT_RANGE,
    FILTER_RULES,
    GRAY_RULE,
    GRAY_SHARE,
    LINE_BLOCK,
    MAX_GAIN,
    PAPER_HEIGHT,
    SMOOTH_BLOCK,
    TONES_BLOCK,
    FilterRule,
)
from vidstyle.explore.random_steps import random_value, scale_factor
from vidstyle.style import Step, Style

SMOOTHED = "even"
"""Name of the picture after TVF."""


def paper_style(random: Random, style: Style) -> Style:
    """Return the style with random layers by the rules of the paper."""
    count = random.randint(*FILTER_COUNT_RANGE)
    is_gray = random.random() < GRAY_SHARE
    rules = _filters(random, count - is_gray)
    while not _is_usable(rules):
        rules = _filters(random, count - is_gray)
    if is_gray:
        rules.insert(random.randint(0, len(rules)), GRAY_RULE)
    base, background, lines = _layers([_step(random, rule) for rule in rules])
    return replace(style, height=PAPER_HEIGHT, base=base, background=background, lines=lines)


def _layers(steps: list[Step]) -> tuple[tuple[Step, ...], ...]:
    """Return base, background and lines; without flat tones, a style is black lines on white paper."""
    smooth, lines, cuts = (_of(steps, block) for block in (SMOOTH_BLOCK, LINE_BLOCK, CUT_BLOCK))
    detail, saturation = (_of(steps, block) for block in (DETAIL_BLOCK, COLOR_BLOCK))
    tones = [step for step in steps if step not in (*smooth, *lines, *cuts, *detail, *saturation)]
    base = *lit(), *detail, *_shared(smooth)
    if not _of(tones, TONES_BLOCK):
        return (*base, *tones), (), (*_limited(lines), *cuts)
    colors = [part for step in saturation for part in moderated(step, SMOOTHED)]
    return base, (*colors, *_enlarged(tones)), (*evened(), *_limited(lines), thinned(), *cuts)


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


def _shared(smooth: list[Step]) -> list[Step]:
    """Return smoothing steps that smooth as much together as one."""
    time = smooth[0].values["time"] / len(smooth)
    return [
        replace(step, values=step.values | {"time": time}, save=SMOOTHED if step is smooth[-1] else "")
        for step in smooth
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

    Otherwise, everything after the working size would be shown enlarged, and therefore blurred.
    """
    sizes, rest = _of(steps, "scale"), [step for step in steps if step.block != "scale"]
    if not sizes:
        return steps
    full = [step.block for step in rest].index(TONES_BLOCK)
    place = min(steps.index(sizes[0]), full)
    enlarge = Step("scale", {"factor": scale_factor(1 / sizes[0].values["factor"]), "method": "smooth"})
    return [*rest[:place], *sizes, *rest[place:full], enlarge, *rest[full:]]
