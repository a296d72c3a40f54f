"""`pixelate`, `dither` and `palette` against plain formulas, and their files."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from covering import in_one_test
from media import photograph
from pictures import noise, run_color, run_luma, step, style

from vidstyle import Renderer, stylize
from vidstyle.blocks.dither import read_thresholds, shipped_thresholds
from vidstyle.blocks.palette import read_palette, shipped_palettes

FILM_PALETTES = [name for name in shipped_palettes() if name.startswith("film")]
PALETTES = sorted(shipped_palettes().keys() - FILM_PALETTES)


def oklab(color: np.ndarray) -> np.ndarray:
    """Convert by definition, float64, from linear light through XYZ and cones."""
    linear = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    to_xyz = [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
    to_cones = [
        [0.8189330101, 0.3618667424, -0.1288597137],
        [0.0329845436, 0.9293118715, 0.0361456387],
        [0.0482003018, 0.2643662691, 0.6338517070],
    ]
    to_lab = [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
    return np.cbrt(linear @ np.transpose(to_xyz) @ np.transpose(to_cones)) @ np.transpose(to_lab)


@pytest.mark.parametrize("name", PALETTES)
def test_palette_uses_nearest_colour(name: str) -> None:
    color = noise(60, 70, 3).astype(np.float64)
    lines = shipped_palettes()[name].read_text().split()
    colors = np.array([list(bytes.fromhex(line[1:])) for line in lines]) / 255
    away = np.linalg.norm(oklab(color)[..., None, :] - oklab(colors), axis=-1)
    made = run_color(style(step("palette", colors=name)), color)
    chosen = np.abs(made[..., None, :] - colors).max(axis=-1).argmin(axis=-1)
    np.testing.assert_allclose(made, colors[chosen], atol=1e-6)
    lost = np.take_along_axis(away, chosen[..., None], -1)[..., 0] - away.min(axis=-1)
    assert lost.max() < 2e-3 and (lost > 1e-6).mean() < 2e-3


@pytest.mark.parametrize(
    ("text", "fault"),
    [("", "has 0"), ("#000000", "has 1"), ("#000000\n" * 65, "has 65"), ("#000000 " * 600, "larger than 4"),
     ("film 1", "has 1"), ("film 65", "has 65"), ("film many", "'film' is not"),
     ("#000000\nred\n", "'red' is not #rrggbb"), ("#000000\n\xff\n", "is not #rrggbb")],
)  # fmt: skip
def test_a_wrong_palette_is_refused(text: str, fault: str, tmp_path: Path) -> None:
    (tmp_path / "colors.txt").write_bytes(text.encode("latin-1"))
    with pytest.raises(ValueError, match=fault):
        read_palette(tmp_path / "colors.txt")


def patches(colors: list[str], seed: int = 1) -> np.ndarray:
    """Vertical stripes of these colours, with slight noise; 48 x 80."""
    stripes = np.array([list(bytes.fromhex(color)) for color in colors], float)
    wide = stripes[np.arange(80) * len(colors) // 80]
    return (wide + np.random.default_rng(seed).normal(0, 2, (48, 80, 3))).clip(0, 255).astype(np.uint8)


def colors_of(picture: np.ndarray) -> np.ndarray:
    return np.unique(picture.reshape(-1, 3), axis=0).astype(int)


DAY = ["20304a", "4a90c2", "d8e6f0", "c24f2a", "e8c060", "3f6b35", "8a8a86", "f4f4f0"]


def test_a_palette_of_the_film_has_its_main_colours() -> None:
    made = stylize(patches(DAY), style(step("palette", colors="film-8")), "cpu")
    wanted = np.array([list(bytes.fromhex(color)) for color in DAY])
    found = colors_of(made)
    assert len(found) == 8
    assert np.abs(found[:, None] - wanted).max(axis=2).min(axis=0).max() <= 3


def test_film_colours_are_stable_and_restart_at_cut() -> None:
    """Noise in other frames moves no colour; slow changes are followed; after a cut all colours restart."""
    chosen = style(step("palette", colors="film-8"))
    day, other = patches(DAY), photograph("coffee")[::8, ::7][:48, :80]
    with Renderer(chosen, "cpu") as renderer:
        first = renderer(day, 0.0)
        still = renderer(patches(DAY, seed=2), 0.04)
        for frame in range(2, 90):
            dim = renderer((day * 0.9).astype(np.uint8), frame / 25)
        after = renderer(other, 3.6)
    np.testing.assert_array_equal(colors_of(first), colors_of(still))
    assert len(colors_of(dim)) == 8 and 0.88 < dim.mean() / first.mean() < 0.92
    np.testing.assert_array_equal(after, stylize(other, chosen, "cpu"))


@in_one_test("name", sorted(shipped_thresholds()))
@in_one_test("tone", [0.0, 0.2, 0.5, 0.7, 1.0])
def test_density_of_points_equals_tone(name: str, tone: float) -> None:
    two_tones = step("dither", thresholds=name, strength=1), step("posterize", levels=2, softness=0)
    made = run_luma(style(*two_tones), np.full((128, 128), tone, np.float32))
    (tile,) = read_thresholds(shipped_thresholds()[name])
    assert made.mean() == pytest.approx(tone, abs=0.5 / min(tile.size, 256) + 1e-6)
    assert set(np.unique(made)) <= {0, 1}


def test_blue_noise_has_no_low_frequencies() -> None:
    (tile,) = read_thresholds(shipped_thresholds()["blue"])
    power = np.abs(np.fft.fft2(tile - tile.mean())) ** 2
    frequency = np.hypot(*np.meshgrid(*[np.fft.fftfreq(len(tile))] * 2))
    assert power[frequency < 0.15].mean() < 0.02 * power[frequency > 0.3].mean()


def test_dither_adds_its_tile_in_cells_of_whole_pixels(tmp_path: Path) -> None:
    tile = np.array([[10, 200, 30], [90, 90, 255]], np.uint8)
    cv2.imwrite(str(tmp_path / "own.png"), tile)
    luma = noise(23, 31, low=0.3, high=0.7)
    made = run_luma(
        style(step("dither", thresholds="own.png", strength=0.4, cell=2.6), folder=tmp_path), luma
    )
    ranks = (np.array([[0, 4, 1], [2.5, 2.5, 5]]) + 0.5) / 6
    page = np.kron(np.tile(ranks, (9, 9)), np.ones((3, 3)))[:23, :31]
    np.testing.assert_allclose(made, luma + 0.4 * (page - 0.5), atol=1e-6)


@pytest.mark.parametrize("size", [1, 4, 6.7, 64])
def test_pixelate_is_the_mean_of_squares(size: float) -> None:
    color, side = noise(45, 70, 3), round(size)
    made = run_color(style(step("pixelate", size=size)), color)
    for top in range(0, 45, side):
        for left in range(0, 70, side):
            square = np.s_[top : top + side, left : left + side]
            mean = color[square].mean(axis=(0, 1), dtype=np.float64)
            np.testing.assert_allclose(made[square], np.broadcast_to(mean, made[square].shape), atol=1e-6)
