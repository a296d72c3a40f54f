"""Pattern filling: strokes that nest and are fixed to the page, and tiles of the user."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from pictures import noise, run_color, run_luma, step, style

from vidstyle.blocks.pattern import LAYOUT_DEGREES
from vidstyle.errors import StyleError

PAGE = (96, 128)


def drawn(luma: float | np.ndarray, **values: object) -> np.ndarray:
    return run_luma(style(step("pattern", **values)), np.broadcast_to(luma, PAGE))


@pytest.mark.parametrize("layout", LAYOUT_DEGREES)
@pytest.mark.parametrize("levels", [2, 5, 9])
@pytest.mark.parametrize("softness", [0, 0.35, 1])
def test_strokes_of_a_lighter_tone_are_in_every_darker_one(layout: str, levels: int, softness: float) -> None:
    pages = [
        drawn(tone, layout=layout, levels=levels, softness=softness) for tone in np.linspace(1.05, -0.05, 45)
    ]
    assert pages[0].min() == 1
    for lighter, darker in zip(pages, pages[1:], strict=False):
        assert np.all(darker <= lighter)
    assert pages[-1].mean() < pages[0].mean() - 0.1


@pytest.mark.parametrize("levels", [2, 5, 9])
def test_number_of_tones_equals_levels(levels: int) -> None:
    pages = [drawn(tone, levels=levels, softness=0.0) for tone in np.linspace(0.002, 0.998, 8 * levels)]
    means = np.array([page.mean() for page in pages]).reshape(levels, 8)
    np.testing.assert_array_equal(means, np.repeat(means[:, :1], 8, axis=1))
    assert np.all(np.diff(means[:, 0]) > 0.01)
    assert means[-1, 0] == 1


def test_strokes_fade_in_where_they_are_soft() -> None:
    tones = np.linspace(0.4, 0.6, 400)
    means = np.array([drawn(tone, levels=2, softness=0.35).mean() for tone in tones])
    assert np.abs(np.diff(means)).max() < 0.003
    fading = tones[(means > means.min() + 1e-5) & (means < 1 - 1e-5)]
    assert fading[-1] - fading[0] == pytest.approx(0.35 / 2, abs=0.01)


@pytest.mark.parametrize("width", [0.1, 0.24, 0.6])
@pytest.mark.parametrize("spacing", [5, 11])
def test_strokes_cover_their_width(width: float, spacing: float) -> None:
    page = drawn(0, levels=2, width=width, spacing=spacing, wobble=0.0, angle=90, layout="parallel")
    whole = page[:, : 11 * spacing]
    assert 1 - whole.mean() == pytest.approx(width, abs=0.005)
    np.testing.assert_allclose(page[:, :-spacing], page[:, spacing:], atol=1.01 / 255)
    np.testing.assert_allclose(page, np.broadcast_to(page[:1], PAGE), atol=1.01 / 255)


@pytest.mark.parametrize("angle", [-60, 0, 30, 45])
def test_strokes_rise_by_their_angle(angle: float) -> None:
    page = drawn(0, levels=2, spacing=8, wobble=0.0, angle=angle, layout="parallel")[:96, :96]
    window = np.hanning(96)
    spectrum = np.abs(np.fft.fft2((page - page.mean()) * window * window[:, None]))[:, :48]
    down, across = np.unravel_index(spectrum.argmax(), spectrum.shape)
    down = down - 96 if down > 48 else down
    # The wave runs square to the strokes, and rows are counted downwards.
    turned = (np.degrees(np.arctan2(-down, across)) + 90 - angle + 90) % 180 - 90
    assert abs(turned) < 5


def test_strokes_stay_on_the_page() -> None:
    first, second = noise(*PAGE), noise(*PAGE)
    second[:, :60] = 1 - second[:, :60]
    pages = [drawn(luma) for luma in (first, second)]
    np.testing.assert_array_equal(pages[0][:, 60:], pages[1][:, 60:])
    assert np.any(pages[0][:, :60] != pages[1][:, :60])


def test_wobble_is_the_same_in_every_frame() -> None:
    np.testing.assert_array_equal(drawn(0.3, wobble=1.0), drawn(0.3, wobble=1.0))
    assert np.abs(drawn(0.3, wobble=1.0) - drawn(0.3, wobble=0.0)).max() > 0.5


def test_a_pattern_is_gray() -> None:
    page = run_color(style(step("pattern")), noise(*PAGE, 3))
    np.testing.assert_array_equal(page, np.repeat(page[..., :1], 3, axis=2))


def tiles_in(folder: Path, **tiles: np.ndarray) -> Path:
    (folder / "tiles").mkdir()
    for name, tile in tiles.items():
        assert cv2.imwrite(str(folder / "tiles" / f"{name}.png"), tile)
    return folder


def checks(dark: int, light: int, size: tuple[int, int]) -> np.ndarray:
    y, x = np.mgrid[: size[0], : size[1]]
    return np.where((x // 2 + y // 3) % 2, dark, light).astype(np.uint8)


def test_tiles_are_repeated_over_the_page_darkest_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tiles = {"b": checks(0, 80, (6, 4)), "c": checks(90, 160, (9, 10)), "a": checks(200, 255, (30, 20))}
    chosen = style(step("pattern", tiles="tiles", softness=0.0), folder=tiles_in(tmp_path, **tiles))
    luma = noise(*PAGE)
    luma = luma[np.abs(luma * 3 % 1 - 0.5) < 0.49][: 64 * 100].reshape(64, 100)
    level = np.floor(luma * 3).astype(int)
    repeated = [np.tile(tile, (16, 25))[:64, :100] / 255 for tile in tiles.values()]
    expected = np.choose(level, repeated)
    np.testing.assert_allclose(run_luma(chosen, luma), expected, atol=1e-6)
    monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1)
    np.testing.assert_allclose(run_luma(chosen, luma), expected, atol=1e-6)


def test_tiles_blend_where_they_are_soft(tmp_path: Path) -> None:
    folder = tiles_in(tmp_path, a=np.full((4, 4), 51, np.uint8), b=np.full((4, 4), 204, np.uint8))
    luma = np.linspace(0, 1, 1001)[None]
    out = run_luma(style(step("pattern", tiles="tiles", softness=0.4), folder=folder), luma)[0]
    assert np.all(np.diff(out) >= -1e-6)
    assert out[[0, 500, 1000]] == pytest.approx([0.2, 0.5, 0.8], abs=5e-4)
    assert out[[399, 601]] == pytest.approx([0.2, 0.8], abs=1e-5)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ({"a.png": b""}, "needs 2 to 32"),
        ({"a.png": b"GIF89a", "b.png": b"x"}, "a.png is not a PNG"),
        (
            {"a.png": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x10\0\0\0\x10\0", "b.png": b""},
            "not a PNG of at most",
        ),
        ({"a.png": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x10\0\0\0\x10", "b.png": b""}, "a.png is damaged"),
    ],
)
def test_invalid_tiles_are_named(tmp_path: Path, content: dict[str, bytes], reason: str) -> None:
    (tmp_path / "tiles").mkdir()
    for name, data in content.items():
        (tmp_path / "tiles" / name).write_bytes(data)
    with pytest.raises(StyleError, match=reason) as caught:
        run_luma(style(step("pattern", tiles="tiles"), folder=tmp_path), noise(4, 4))
    assert "'tiles'" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_pipe_among_tiles_is_refused_without_waiting(tmp_path: Path) -> None:
    folder = tiles_in(tmp_path, a=np.zeros((4, 4), np.uint8))
    os.mkfifo(folder / "tiles" / "b.png")
    with pytest.raises(StyleError, match="b.png is not a file"):
        run_luma(style(step("pattern", tiles="tiles"), folder=tmp_path), noise(4, 4))
