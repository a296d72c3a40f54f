"""Every shipped style still matches its golden pictures.

`tools/renew_goldens.py` renews the pictures after an intended change to a style or to a block that it uses.
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
def test_style_matches_golden(name: str, tmp_path: Path) -> None:
    check(name, shipped(name), tmp_path)


def test_changed_style_is_reported_with_pictures(tmp_path: Path) -> None:
    changed = override(load_style("cartoon"), ["posterize#1.levels=2"])
    with pytest.raises(AssertionError, match="cartoon: .* levels off") as caught:
        check("cartoon", drawn(changed), tmp_path)
    paths = sorted(tmp_path.iterdir())
    assert [path.name for path in paths] == [
        "cartoon-difference.png", "cartoon-golden.png", "cartoon-got.png"
    ]  # fmt: skip
    assert all(str(path) in str(caught.value) for path in paths)


def test_style_without_golden_is_reported(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="new: has no golden"):
        check("new", shipped("ink"), tmp_path)


def test_faint_global_and_strong_local_changes_are_reported() -> None:
    kept = golden("poster")
    assert kept is not None
    faint = np.where(kept < 255, kept + 1, kept - 1).astype(np.uint8)
    strong = kept.copy()
    strong[:1] ^= 16
    assert Difference.of(kept, kept).small
    assert not Difference.of(faint, kept).small
    assert not Difference.of(strong, kept).small
    ink = load_style("ink")
    assert not Difference.of(drawn(replace(ink, ink="#c04610")), drawn(ink)).small
