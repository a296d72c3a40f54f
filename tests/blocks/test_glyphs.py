"""`glyphs`: which glyph a cell gets, how it is drawn, and which files are refused."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from pictures import noise, run_color, run_luma, step, style

from vidstyle.blocks.glyphs import MIN_DIFFERENCE_GAIN, TONE_WEIGHT, read_alphabet, shipped_alphabets
from vidstyle.core.marks.glyph_alphabet import ZONE_COUNT

(TABLE,) = read_alphabet(shipped_alphabets()["letters"])
GLYPHS = np.stack(np.split(TABLE[:-ZONE_COUNT], TABLE.shape[1] // 24, axis=1))
COVER = GLYPHS.mean(axis=(1, 2)) / GLYPHS[-1].mean()
MAX_TONE_TIE = float(np.sqrt(MIN_DIFFERENCE_GAIN / TONE_WEIGHT))
"""Of glyphs whose tones differ by less, the first is chosen."""


def test_the_letters_have_all_tones() -> None:
    assert len(GLYPHS) >= 40 and COVER[0] == 0
    assert np.diff(COVER).max() < 0.12


def test_an_even_cell_as_large_as_a_glyph_shows_the_nearest_in_tone() -> None:
    for tone in np.linspace(0, 1, 23):
        made = run_luma(style(step("glyphs", cell=24)), np.full((40, 24), tone))
        differences = np.abs(GLYPHS * min(tone / 0.1, 1) - made).max(axis=(1, 2))
        chosen = differences.argmin()
        assert differences[chosen] < 1e-6
        assert abs(COVER[chosen] - tone) < np.hypot(np.abs(COVER - tone).min(), MAX_TONE_TIE) + 1e-6


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("ends", [((2, 37), (21, 2)), ((2, 2), (21, 37)), ((2, 34), (21, 34))])
def test_a_line_in_a_cell_becomes_a_similar_glyph(ends: tuple[tuple[int, int], ...], turned: bool) -> None:
    line = cv2.line(np.zeros((40, 24), np.float32), *ends, 1.0, 5, cv2.LINE_AA)
    line = line[::-1, ::-1] if turned else line
    made = run_luma(style(step("glyphs", cell=24)), line)
    likeness = [np.corrcoef(each.ravel(), line.ravel())[0, 1] for each in (made, *GLYPHS[1:])]
    assert likeness[0] > max(0.3, 0.6 * max(likeness[1:]))


@pytest.mark.parametrize("cell", [3, 7, 10.4, 50])
def test_glyphs_have_same_coverage_at_any_size(cell: float) -> None:
    width = 2 * int(cell / 2 + 0.5)
    height = round(width * 5 / 3)
    for tone, glyph in zip(COVER, GLYPHS, strict=True):
        made = run_luma(style(step("glyphs", cell=cell)), np.full((2 * height, 3 * width), tone))
        assert made.mean() == pytest.approx(
            min(tone / 0.1, 1) * glyph.mean(), abs=MAX_TONE_TIE * float(GLYPHS[-1].mean()) + 1e-5
        )
        np.testing.assert_array_equal(made[:height, :width], made[height:, width : 2 * width])


def test_cells_use_mean_colour_at_full_brightness() -> None:
    color = noise(30, 36, 3, low=0.2)
    cells = color.reshape(3, 10, 6, 6, 3).transpose(0, 2, 1, 3, 4).reshape(3, 6, 60, 3)
    made = run_color(style(step("glyphs", cell=6)), color)
    means = np.repeat(np.repeat(cells.mean(axis=2), 10, axis=0), 6, axis=1)
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
