"""`glyphs`: which glyph a cell gets, how it is drawn, and which files are refused."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from pictures import noise, run_color, run_luma, step, style

from vidstyle.blocks.glyphs import read_alphabet, shipped_alphabets

(TABLE,) = read_alphabet(shipped_alphabets()["letters"])
GLYPHS = np.stack(np.split(TABLE[:-1], TABLE.shape[1] // 24, axis=1))


def test_the_letters_differ_evenly_in_tone() -> None:
    cover = GLYPHS.mean(axis=(1, 2))
    assert len(GLYPHS) >= 10 and cover[0] == 0
    assert 0.015 < np.diff(cover).min() and np.diff(cover).max() < 0.08


def test_a_cell_as_large_as_a_glyph_shows_the_nearest_in_tone() -> None:
    cover = GLYPHS.mean(axis=(1, 2)) / GLYPHS[-1].mean()
    for tone in np.linspace(0, 1, 23):
        made = run_luma(style(step("glyphs", cell=24)), np.full((40, 24), tone))
        dim = min(tone / 0.1, 1)
        np.testing.assert_allclose(made, dim * GLYPHS[np.abs(cover - tone).argmin()], atol=1e-6)


@pytest.mark.parametrize("cell", [3, 7, 10.4, 50])
def test_glyphs_have_same_coverage_at_any_size(cell: float) -> None:
    width = int(cell + 0.5)
    height = round(width * 5 / 3)
    for number, glyph in enumerate(GLYPHS):
        tone = TABLE[-1, number] + 1e-3
        made = run_luma(style(step("glyphs", cell=cell)), np.full((2 * height, 3 * width), tone))
        assert made.mean() == pytest.approx(min(tone / 0.1, 1) * glyph.mean(), abs=1e-5)
        np.testing.assert_array_equal(made[:height, :width], made[height:, width : 2 * width])


def test_cells_use_mean_colour_at_full_brightness() -> None:
    color = noise(36, 42, 3, low=0.2)
    cells = color.reshape(3, 12, 6, 7, 3).transpose(0, 2, 1, 3, 4).reshape(3, 6, 84, 3)
    mixed = cells[:, :, ::-1].reshape(3, 6, 12, 7, 3).transpose(0, 2, 1, 3, 4).reshape(color.shape)
    made, other = (run_color(style(step("glyphs", cell=7)), each) for each in (color, mixed))
    np.testing.assert_allclose(made, other, atol=1e-5)
    means = np.repeat(np.repeat(cells.mean(axis=2), 12, axis=0), 7, axis=1)
    pure = means / means.max(axis=2, keepdims=True)
    np.testing.assert_allclose(made, made.max(axis=2, keepdims=True) * pure, atol=1e-5)


def test_inverted_glyphs_are_black_on_white() -> None:
    luma = noise(30, 33)
    made, other = (
        run_luma(style(step("glyphs", cell=5, invert=invert)), each)
        for invert, each in ((True, luma), (False, 1 - luma))
    )
    np.testing.assert_allclose(made, 1 - other, atol=1e-6)


@pytest.mark.parametrize(("height", "width"), [(10, 15), (9, 12), (10, 6), (4, 4), (10, 12)])
def test_wrong_alphabets_are_refused(height: int, width: int, tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "own.png"), np.full((height, width), 90, np.uint8))
    with pytest.raises(ValueError, match=r"^(needs 2 or more glyphs|has glyphs of only one tone)"):
        read_alphabet(tmp_path / "own.png")
