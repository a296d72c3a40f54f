"""Draws a style by the rules of the paper."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

from vidstyle.blocks import all_blocks
from vidstyle.explore.paper.rules import (
    CUT_BLOCK,
    FILTER_COUNT_RANGE,
    FILTER_RULES,
    GRAY_RULE,
    GRAY_SHARE,
    LINE_BLOCK,
    MAX_GAIN,
    PAPER_HEIGHT,
    RANGE_BLOCK,
    SMOOTH_BLOCK,
    THRESHOLD_BLOCKS,
    FilterRule,
)
from vidstyle.explore.random_steps import random_value, scale_factor
from vidstyle.style import Step, Style


def paper_style(random: Random, style: Style) -> Style:
    """Return the style with a random background by the rules of the paper."""
    count = random.randint(*FILTER_COUNT_RANGE)
    is_gray = random.random() < GRAY_SHARE
    rules = _filters(random, count - is_gray)
    while not _is_usable(rules):
        rules = _filters(random, count - is_gray)
    if is_gray:
        rules.insert(random.randint(0, len(rules)), GRAY_RULE)
    steps = _limited(_smoothed(_ordered([_step(random, rule) for rule in rules])))
    steps = [Step(RANGE_BLOCK), *_on_luma(_enlarged(steps))]
    return replace(style, height=PAPER_HEIGHT, background=tuple(steps))


def _filters(random: Random, count: int) -> list[FilterRule]:
    """Return random filters; only some repeat."""
    rules: list[FilterRule] = []
    while len(rules) < count:
        rules.append(random.choice([rule for rule in FILTER_RULES if rule.repeats or rule not in rules]))
    return rules


def _is_usable(rules: list[FilterRule]) -> bool:
    """Whether there is a threshold, lines only with a filter that smooths, and Soft Threshold with lines."""
    blocks = {rule.block for rule in rules}
    with_lines = SMOOTH_BLOCK in blocks if LINE_BLOCK in blocks else CUT_BLOCK not in blocks
    return with_lines and bool(blocks & set(THRESHOLD_BLOCKS))


def _step(random: Random, rule: FilterRule) -> Step:
    parameters = all_blocks()[rule.block].parameters
    names = (*rule.parameters, *rule.ends)
    drawn = {name: random_value(random, parameters[name], rule.ends.get(name)) for name in names}
    return Step(rule.block, rule.fixed | drawn)


def _ordered(steps: list[Step]) -> list[Step]:
    """Return the steps with thresholds after the last lines."""
    last = _last([step.block for step in steps], (LINE_BLOCK,))
    if last is None:
        return steps
    before = [step for step in steps[:last] if step.block in THRESHOLD_BLOCKS]
    kept = [step for step in steps[:last] if step.block not in THRESHOLD_BLOCKS]
    return [*kept, steps[last], *before, *steps[last + 1 :]]


def _smoothed(steps: list[Step]) -> list[Step]:
    """Return the steps with one that smooths before the first lines."""
    blocks = [step.block for step in steps]
    if LINE_BLOCK not in blocks:
        return steps
    lines, smooth = blocks.index(LINE_BLOCK), blocks.index(SMOOTH_BLOCK)
    if smooth < lines:
        return steps
    return [*steps[:lines], steps[smooth], *steps[lines:smooth], *steps[smooth + 1 :]]


def _limited(steps: list[Step]) -> list[Step]:
    """Return the steps with strengths of lines that amplify by at most `MAX_GAIN` together."""
    gain = math.prod(1 + step.values["p"] for step in steps if step.block == LINE_BLOCK)
    if gain <= MAX_GAIN:
        return steps
    power = math.log(MAX_GAIN) / math.log(gain)
    return [
        replace(step, values=step.values | {"p": max(1.0, round((1 + step.values["p"]) ** power - 1, 1))})
        if step.block == LINE_BLOCK
        else step
        for step in steps
    ]


def _enlarged(steps: list[Step]) -> list[Step]:
    """Return the steps with the picture enlarged to its size before the last lines.

    Without lines after the working size, it is enlarged before the last threshold. Otherwise everything after
    the working size would be shown enlarged, and therefore blurred. A working size without a threshold after
    it comes before the last threshold instead.
    """
    blocks = [step.block for step in steps]
    if "scale" not in blocks:
        return steps
    size = blocks.index("scale")
    full = _last(blocks[size:], (LINE_BLOCK,)) or _last(blocks[size:], THRESHOLD_BLOCKS)
    if full is None:
        before = _last(blocks, THRESHOLD_BLOCKS)
        assert before is not None  # all styles have a threshold
        steps = [*steps[:before], steps[size], *steps[before:size], *steps[size + 1 :]]
        size, full = before, 1
    factor = scale_factor(1 / steps[size].values["factor"])
    enlarge = Step("scale", {"factor": factor, "method": "smooth"})
    return [*steps[: size + full], enlarge, *steps[size + full :]]


def _on_luma(steps: list[Step]) -> list[Step]:
    """Return the steps with the threshold on luma only, with the colours restored after it."""
    blocks = [step.block for step in steps]
    cut = _last(blocks, (CUT_BLOCK,))
    if cut is None or GRAY_RULE.block in blocks[:cut]:
        return steps
    return [*steps[:cut], Step(GRAY_RULE.block), steps[cut], Step("to_color"), *steps[cut + 1 :]]


def _last(blocks: list[str], wanted: tuple[str, ...]) -> int | None:
    return max((place for place, block in enumerate(blocks) if block in wanted), default=None)
