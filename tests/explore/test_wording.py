"""What tiles are called: their blocks, and how they differ from the chosen one."""

from __future__ import annotations

import numpy as np
from media import photograph

from vidstyle.blocks import all_blocks
from vidstyle.explore.naming.visible_marks import MARK_WORDS, visible_marks
from vidstyle.explore.naming.wording import name_blocks, name_step_changes, names_of_changes, names_of_look
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
    blue = np.full((40, 60, 3), (40, 90, 200), np.uint8)
    names = names_of_look(blue, ("dots", "grain", "soft"))
    assert names == ["Blue, dots, grain", "Blue, dots, grain, soft"]
    assert names_of_look(blue // 4, ()) == ["Dark blue"]
    gray = np.full((40, 60, 3), 120, np.uint8)
    assert names_of_look(gray, ("soft",)) == ["Gray, soft"]
    both = np.concatenate([blue, np.full_like(blue, (220, 120, 20))])
    assert names_of_look(both, ()) == ["Orange on blue"]
    lights = np.linspace(0.4, 1, 60)[None, :, None]
    assert names_of_look((both * lights).astype(np.uint8), ()) == ["Vivid colours"]
    black = gray * 0
    assert names_of_look(np.concatenate([black, *[blue + 50] * 5]), ()) == ["Black on blue"]
    red = np.full_like(blue, (200, 30, 30))
    assert names_of_look(np.concatenate([gray, gray + 100, gray, black, red[:10]]), ()) == ["Gray with red"]
    white = np.full((320, 60, 3), 255, np.uint8)
    white[100:120, :15], white[200:220, :15] = (200, 30, 30), (30, 90, 200)
    figures = np.concatenate([white, black])
    assert names_of_look(figures, ()) == ["Black and white with colours"]
    assert names_of_look(np.full_like(blue, (180, 165, 140)), ()) == ["Sepia"]
    assert names_of_look(np.concatenate([gray * 0, gray * 0 + 255]), ()) == ["Black and white"]


def test_a_mark_is_named_only_where_it_is_seen() -> None:
    source = np.ascontiguousarray(photograph("astronaut")[:240, :320])
    dots = {
        "format": 1,
        "background": [{"block": "halftone", "cell": 6}, {"block": "noise", "amount": 0.01}],
    }
    assert visible_marks(load_style(dots), source) == ("dots",)
    blurred = {"format": 1, "background": [*dots["background"], {"block": "gaussian", "sigma": 4}]}  # type: ignore[misc]
    assert "dots" not in visible_marks(load_style(blurred), source), "nothing is left of them"
    assert "flat areas" in visible_marks(load_style("poster"), source)
    assert visible_marks(load_style("ascii"), source)[0] == "letters", "a mark beside the main path"
    assert MARK_WORDS.keys() <= all_blocks().keys()


def test_gained_and_lost_blocks_are_named() -> None:
    before = load_style({"format": 1, "base": [{"block": "gaussian"}, {"block": "posterize"}]})
    after = load_style({"format": 1, "base": [{"block": "posterize"}, {"block": "noise"}]})
    assert name_step_changes(after, before) == "With grain, without blur"
    assert name_step_changes(before, before) == ""


def test_visible_changes_are_named_the_largest_first() -> None:
    picture = photograph("coffee")[::4, ::4]
    gray = picture.mean(axis=2, keepdims=True).repeat(3, axis=2).astype(np.uint8)
    assert names_of_changes(picture, picture) == []
    colors, change, *_ = names_of_changes(gray, picture)
    assert colors == "Gray" and "less colourful" in change.lower(), "other colours say most"
    assert names_of_changes((picture * 0.5).astype(np.uint8), picture)[0].startswith("Darker")
    assert names_of_changes(picture // 2 + 127, picture)[0].startswith("Lighter")
    slight = names_of_changes(np.minimum(picture, 252) + 3, picture)
    assert slight[0].startswith("A little ") and len(set(slight)) == len(slight)


def test_the_main_path_leads_through_the_steps_that_become_the_result() -> None:
    style = load_style(
        {"format": 1, "base": [{"block": "to_gray", "save": "gray"}, {"block": "gaussian", "save": "soft"},
                               {"from": "gray", "block": "blend", "other": "soft"}],
         "lines": [{"block": "flow_xdog"}]}
    )  # fmt: skip
    assert main_path(style.layers) == {0, 2, 3}
    assert main_path(load_style("plain").layers) == frozenset()
