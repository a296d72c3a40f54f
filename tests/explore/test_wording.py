"""What tiles are called: their blocks, and how they differ from the chosen one."""

from __future__ import annotations

import numpy as np
from media import photograph

from vidstyle.explore.wording import name_blocks, name_step_changes, name_visible_changes
from vidstyle.style import load_style
from vidstyle.style.wiring import main_path


def test_a_look_is_named_by_the_blocks_on_its_main_path() -> None:
    assert name_blocks(load_style("ink")) == "Sharpen along lines, grayscale"  # not by the edges of its masks
    assert name_blocks(load_style("plain")) == ""


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
