"""What tiles are called: their blocks, and how they differ from the chosen one."""

from __future__ import annotations

import numpy as np
from media import photograph

from vidstyle.blocks import all_blocks
from vidstyle.explore.wording import (
    MARK_WORDS,
    name_blocks,
    name_look,
    name_step_changes,
    name_visible_changes,
)
from vidstyle.style import load_style
from vidstyle.style.wiring import main_path


def test_a_look_is_named_by_the_blocks_on_its_main_path() -> None:
    style = load_style(
        {"format": 1, "base": [{"block": "to_gray", "save": "gray"}, {"block": "sobel", "save": "edges"}],
         "lines": [{"from": "gray", "block": "gaussian", "save": "soft"},
                   {"from": "gray", "block": "blend", "other": "soft", "mask": "edges"},
                   {"block": "flow_dog"}]}
    )  # fmt: skip
    assert name_blocks(style) == "Sharpen along lines, grayscale"  # not by the edges of its mask
    assert name_blocks(load_style("plain")) == ""


def test_a_look_is_named_by_what_one_sees() -> None:
    dots = load_style(
        {"format": 1, "base": [{"block": "halftone"}, {"block": "noise"}, {"block": "posterize"}]}
    )
    blue = np.full((40, 60, 3), (40, 90, 200), np.uint8)
    assert name_look(dots, blue) == "Blue print, dotted"
    assert name_look(dots, blue // 4) == "Dark blue print, dotted"
    gray = np.full((40, 60, 3), 120, np.uint8)
    assert name_look(load_style("plain"), gray) == "Gray picture"
    both = np.concatenate([blue, np.full_like(blue, (220, 120, 20))])
    assert name_look(load_style("plain"), both) == "Vivid picture"
    assert name_look(load_style("plain"), np.full_like(blue, (180, 165, 140))) == "Sepia picture"
    assert MARK_WORDS.keys() <= all_blocks().keys()


def test_gained_and_lost_blocks_are_named() -> None:
    before = load_style({"format": 1, "base": [{"block": "gaussian"}, {"block": "posterize"}]})
    after = load_style({"format": 1, "base": [{"block": "posterize"}, {"block": "noise"}]})
    assert name_step_changes(after, before) == "With grain, without blur"
    assert name_step_changes(before, before) == ""


def test_visible_changes_are_named_the_largest_first() -> None:
    picture = photograph("coffee")[::4, ::4]
    gray = picture.mean(axis=2, keepdims=True).repeat(3, axis=2).astype(np.uint8)
    assert name_visible_changes(picture, picture) == ""
    assert "less colourful" in name_visible_changes(gray, picture).lower()
    assert name_visible_changes((picture * 0.5).astype(np.uint8), picture).startswith("Darker")
    assert name_visible_changes(picture // 2 + 127, picture).startswith("Lighter")


def test_the_main_path_leads_through_the_steps_that_become_the_result() -> None:
    style = load_style(
        {"format": 1, "base": [{"block": "to_gray", "save": "gray"}, {"block": "gaussian", "save": "soft"},
                               {"from": "gray", "block": "blend", "other": "soft"}],
         "lines": [{"block": "flow_xdog"}]}
    )  # fmt: skip
    assert main_path(style.layers) == {0, 2, 3}
    assert main_path(load_style("plain").layers) == frozenset()
