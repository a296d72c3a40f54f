"""Every shipped style still matches its golden pictures.

`tools/renew_goldens.py` renews the pictures after a style, or a block that it uses, was changed on purpose.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from goldens import FOLDER, STYLES, Difference, check, drawn, golden, shipped

from vidstyle.style import load_style, override


def test_every_style_has_a_golden_and_every_golden_a_style() -> None:
    assert sorted(path.stem for path in FOLDER.iterdir()) == STYLES, "run tools/renew_goldens.py"


@pytest.mark.parametrize("name", STYLES)
def test_a_style_draws_what_it_drew(name: str, tmp_path: Path) -> None:
    check(name, shipped(name), tmp_path)


def test_a_changed_style_is_noticed_and_its_pictures_are_named(tmp_path: Path) -> None:
    changed = override(load_style("poster"), ["lines.posterize.levels=5"])
    with pytest.raises(AssertionError, match="poster: .* levels off") as caught:
        check("poster", drawn(changed), tmp_path)
    paths = sorted(tmp_path.iterdir())
    assert [path.name for path in paths] == [
        "poster-difference.png", "poster-golden.png", "poster-got.png"
    ]  # fmt: skip
    assert all(str(path) in str(caught.value) for path in paths)


def test_a_style_without_a_golden_is_noticed(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="new: has no golden"):
        check("new", shipped("ink"), tmp_path)


def test_a_faint_change_everywhere_and_a_strong_one_in_few_places_are_noticed() -> None:
    kept = golden("blob")
    assert kept is not None
    faint = np.where(kept < 255, kept + 1, kept - 1).astype(np.uint8)
    strong = kept.copy()
    strong[:1] ^= 16
    assert Difference.of(kept, kept).small
    assert not Difference.of(faint, kept).small
    assert not Difference.of(strong, kept).small
    ink = load_style("ink")
    assert not Difference.of(drawn(replace(ink, ink="#c04610")), drawn(ink)).small
