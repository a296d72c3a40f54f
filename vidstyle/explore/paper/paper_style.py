"""Draws a style by the rules of the paper."""

from __future__ import annotations

from dataclasses import replace
from random import Random

from vidstyle.blocks import all_blocks
from vidstyle.explore.paper.rules import (
    FILTER_COUNT_RANGE,
    FILTER_RULES,
    GRAY_RULE,
    GRAY_SHARE,
    LINE_BLOCK,
    THRESHOLD_BLOCKS,
    FilterRule,
)
from vidstyle.explore.random_steps import random_value, scale_factor
from vidstyle.style import Step, Style


def paper_style(random: Random, style: Style) -> Style:
    """Return the style with a random background by the rules of the paper."""
    count = random.randint(*FILTER_COUNT_RANGE)
    is_gray = random.random() < GRAY_SHARE
    rules: list[FilterRule] = []
    while len(rules) < count - is_gray:
        rules.append(random.choice([rule for rule in FILTER_RULES if rule.repeats or rule not in rules]))
    if is_gray:
        rules.insert(random.randint(0, len(rules)), GRAY_RULE)
    return replace(style, background=tuple(_enlarged([_step(random, rule) for rule in rules])))


def _step(random: Random, rule: FilterRule) -> Step:
    parameters = all_blocks()[rule.block].parameters
    names = (*rule.parameters, *rule.ends)
    return Step(
        rule.block, {name: random_value(random, parameters[name], rule.ends.get(name)) for name in names}
    )


def _enlarged(steps: list[Step]) -> list[Step]:
    """Return the steps with the picture enlarged to its size before the last threshold, else the last lines.

    Without it, everything after the working size would be shown enlarged, and therefore blurred. A working
    size with neither thresholds nor lines after it comes before the last of them instead.
    """
    blocks = [step.block for step in steps]
    if "scale" not in blocks:
        return steps
    size = blocks.index("scale")
    full = _last(blocks[size:], THRESHOLD_BLOCKS) or _last(blocks[size:], (LINE_BLOCK,))
    if full is None:
        before = _last(blocks, THRESHOLD_BLOCKS)
        before = _last(blocks, (LINE_BLOCK,)) if before is None else before
        if before is None:
            return steps
        steps = [*steps[:before], steps[size], *steps[before:size], *steps[size + 1 :]]
        size, full = before, 1
    factor = scale_factor(1 / steps[size].values["factor"])
    enlarge = Step("scale", {"factor": factor, "method": "smooth"})
    return [*steps[: size + full], enlarge, *steps[size + full :]]


def _last(blocks: list[str], wanted: tuple[str, ...]) -> int | None:
    return max((place for place, block in enumerate(blocks) if block in wanted), default=None)
