"""What a look is, and how it differs from another one, in plain words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from vidstyle.block import Block
from vidstyle.blocks import all_blocks
from vidstyle.explore.measure import gradient_of, luma_of_codes, oklab_thumbnail
from vidstyle.explore.naming.color_words import color_words, has_other_colors
from vidstyle.style import Style
from vidstyle.style.wiring import main_path

VISIBLE_CATEGORIES = ("print", "paint", "lines", "texture", "color", "tone", "smooth")
"""Categories of blocks by how much they say about a look, the most first."""
MAX_NAMED_BLOCKS, MAX_NAMED_CHANGES = 2, 2
MIN_NAMED_MARKS = 2
"""Number of marks in the shortest name of a look that has them: only one would hide what else one sees."""
CHANGE_WORDS = (
    ("lighter", "darker"),
    ("more contrast", "less contrast"),
    ("more colourful", "less colourful"),
    ("warmer", "cooler"),
    ("more detail", "less detail"),
)
"""Words for an increase and a decrease of each number of `_impression`."""
WARMTH_INDEX = 3
"""The place of warmth among them."""
MIN_CHANGES = np.array([0.04, 0.03, 0.015, 0.015, 0.015])
"""Changes of these numbers that people notice between two small pictures, chosen by eye."""


def names_of_look(picture: np.ndarray, marks: Sequence[str]) -> list[str]:
    """Return names for what one sees of a look, such as "Blue, dots", each more detailed than the one before.

    Args:
        picture: a picture in it, H x W x 3 uint8.
        marks: the visible marks; see `visible_marks`.
    """
    color = color_words(picture)
    fewest = min(MIN_NAMED_MARKS, len(marks))
    return [_sentence([color, *marks[:count]]) for count in range(fewest, len(marks) + 1)]


def name_blocks(style: Style) -> str:
    """Return the blocks that shape a look most, such as "Halftone dots, ink lines"."""
    return _sentence([block.label for block in _visible_blocks(style)[:MAX_NAMED_BLOCKS]])


def _visible_blocks(style: Style) -> list[Block]:
    """Return the blocks of a style that one sees, those that say most first."""
    path = main_path(style.layers, style.masks)
    steps = [step for index, step in enumerate(style.steps) if index in path and step.block and not step.mute]
    known = [all_blocks()[name] for name in dict.fromkeys(step.block for step in steps)]
    seen = [block for block in known if block.category in VISIBLE_CATEGORIES]
    seen.sort(key=lambda block: VISIBLE_CATEGORIES.index(block.category))
    return seen


def name_step_changes(style: Style, before: Style) -> str:
    """Return which blocks a style has gained and lost, such as "With grain, without blur"."""
    now, then = ([step.block for step in each.steps if step.block] for each in (style, before))
    gained, lost = _missing(now, then), _missing(then, now)
    words = [f"with {_label(name)}" for name in gained] + [f"without {_label(name)}" for name in lost]
    return _sentence(words[:MAX_NAMED_CHANGES])


def names_of_changes(picture: np.ndarray, before: np.ndarray) -> list[str]:
    """Return names for how a picture differs from another of its scene, both H x W x 3 uint8, best first.

    Other colours say more than any change. Changes that people hardly notice are called slight.
    """
    change = (_impression(picture) - _impression(before)) / MIN_CHANGES
    order = np.argsort(-np.abs(change), kind="stable")
    is_warm = _impression(picture)[WARMTH_INDEX] > 0
    words = [_change_word(each, change[each], is_warm) for each in order]
    sizes = np.abs(change[order])
    seen = [word for word, size in zip(words, sizes, strict=True) if size >= 1]
    slight = [word for word, size in zip(words, sizes, strict=True) if 0 < size < 1]
    pairs = [_sentence(pair) for pair in combinations(seen, MAX_NAMED_CHANGES)]
    other = [_sentence([color_words(picture)])] if has_other_colors(picture, before) else []
    return [
        *other,
        *pairs,
        *map(_sentence, ([word] for word in seen)),
        *(f"A little {word}" for word in slight),
    ]


def _change_word(which: int, change: float, is_warm: bool) -> str:
    """Return the word for a change; a warm picture is only "less warm" than another, never cooler."""
    if which == WARMTH_INDEX and is_warm == (change < 0):
        return "less warm" if is_warm else "less cool"
    return CHANGE_WORDS[which][int(change < 0)]


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
