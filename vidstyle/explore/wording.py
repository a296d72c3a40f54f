"""What a look is, and how it differs from another one, in plain words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from vidstyle.blocks import all_blocks
from vidstyle.explore.measure import gradient_of, luma_of_codes, oklab_thumbnail
from vidstyle.style import Style
from vidstyle.style.wiring import main_path

VISIBLE_CATEGORIES = ("print", "paint", "lines", "texture", "color", "tone", "smooth")
"""Categories of blocks by how much they say about a look, the most first."""
MAX_NAMED_BLOCKS, MAX_NAMED_CHANGES = 2, 2
CHANGE_WORDS = (
    ("lighter", "darker"),
    ("more contrast", "less contrast"),
    ("more colourful", "less colourful"),
    ("warmer", "cooler"),
    ("more detail", "less detail"),
)
"""Words for an increase and a decrease of each number of `_impression`."""
MIN_CHANGES = np.array([0.04, 0.03, 0.015, 0.015, 0.015])
"""Changes of these numbers that people notice between two small pictures, chosen by eye."""


def name_blocks(style: Style) -> str:
    """Return the blocks that shape a look most, such as "Halftone dots, ink lines"."""
    path = main_path(style.layers, style.masks)
    steps = [step for index, step in enumerate(style.steps) if index in path and step.block and not step.mute]
    known = [all_blocks()[name] for name in dict.fromkeys(step.block for step in steps)]
    seen = [block for block in known if block.category in VISIBLE_CATEGORIES]
    seen.sort(key=lambda block: VISIBLE_CATEGORIES.index(block.category))
    return _sentence([block.label for block in seen[:MAX_NAMED_BLOCKS]])


def name_step_changes(style: Style, before: Style) -> str:
    """Return which blocks a style has gained and lost, such as "With grain, without blur"."""
    now, then = ([step.block for step in each.steps if step.block] for each in (style, before))
    gained, lost = _missing(now, then), _missing(then, now)
    words = [f"with {_label(name)}" for name in gained] + [f"without {_label(name)}" for name in lost]
    return _sentence(words[:MAX_NAMED_CHANGES])


def name_visible_changes(picture: np.ndarray, before: np.ndarray) -> str:
    """Return how a picture differs from another of the same scene, both H x W x 3 uint8, or ""."""
    change = (_impression(picture) - _impression(before)) / MIN_CHANGES
    largest = [each for each in np.argsort(-np.abs(change), kind="stable") if abs(change[each]) >= 1]
    return _sentence([CHANGE_WORDS[each][int(change[each] < 0)] for each in largest[:MAX_NAMED_CHANGES]])


def _impression(picture: np.ndarray) -> np.ndarray:
    """Return brightness, contrast, colour strength, warmth and amount of detail."""
    light, green_red, blue_yellow = np.moveaxis(oklab_thumbnail(picture), -1, 0)
    warmth = green_red.mean() + blue_yellow.mean()
    detail = np.abs(gradient_of(luma_of_codes(picture))).mean()
    return np.array([light.mean(), light.std(), np.hypot(green_red, blue_yellow).mean(), warmth, detail])


def _missing(names: Sequence[str], among: Sequence[str]) -> list[str]:
    return list((Counter(names) - Counter(among)).elements())


def _label(name: str) -> str:
    return all_blocks()[name].label.lower()


def _sentence(words: Sequence[str]) -> str:
    text = ", ".join(dict.fromkeys(words)).lower()
    return text[:1].upper() + text[1:]
