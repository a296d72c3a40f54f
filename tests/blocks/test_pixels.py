"""Pixel blocks against plain float64 formulas."""

from __future__ import annotations

import colorsys

import numpy as np
import pytest
from covering import in_one_test
from pictures import FLOAT, noise, run, run_color, run_luma, step, style

from vidstyle.blocks.blend import MODE_FORMULAS, blend
from vidstyle.blocks.local_exposure import local_exposure
from vidstyle.core.picture import RANGES, Encoding, Picture

WEIGHTS = np.array([0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize(
    ("phi", "epsilon", "black", "half", "ramp"),
    [
        (0.013, 50, 0.43, 0.69, 106),
        (0.013, 110, 0.11, 0.39, 106),
        (0.059, 50, 0.005, 0.10, 23),
        (0.059, 110, 0.000, 0.003, 23),
        (0.017, 79.5, 0.13, 0.41, 81),
    ],
)
def test_soft_threshold_numbers(phi: float, epsilon: float, black: float, half: float, ramp: float) -> None:
    """The output at 0 and at half the cut-off, and the grey levels between 10 % and 90 %."""
    levels = np.arange(-255, 256, 0.25)
    luma = np.concatenate([[0, epsilon / 2], levels])[None] / 255
    out = run_luma(style(step("soft_threshold", phi=phi, epsilon=epsilon)), luma)[0]
    assert out[:2] == pytest.approx([black, half], abs=0.006)
    at_10, at_90 = np.interp([0.1, 0.9], out[2:], levels)
    assert at_90 - at_10 == pytest.approx(ramp, abs=0.7)


@pytest.mark.parametrize(("phi", "epsilon"), [(0.001, 0), (0.03, 110), (0.2, 255), (1, 127.5)])
def test_soft_threshold_is_equation_1(phi: float, epsilon: float) -> None:
    color = noise(30, 40, 3, low=-0.2, high=1.2)
    expected = 1 + np.tanh(np.minimum(0, phi * (255 * color.astype(np.float64) - epsilon)))
    chosen = style(step("soft_threshold", phi=phi, epsilon=epsilon))
    np.testing.assert_allclose(run_color(chosen, color), expected, atol=2e-6)
    np.testing.assert_allclose(run_luma(chosen, color[..., 0]), expected[..., 0], atol=2e-6)


@pytest.mark.parametrize("levels", [2, 3, 5, 10, 32])
def test_hard_posterize_is_the_floor_formula(levels: int) -> None:
    color = noise(60, 40, 3, low=-0.3, high=1.3).astype(np.float64)
    color = color[np.abs(color - np.rint(color * levels) / levels) > 1e-4].reshape(1, -1)
    expected = np.clip(np.floor(color * levels), 0, levels - 1) / (levels - 1)
    out = run_luma(style(step("posterize", levels=levels, softness=0)), color)
    np.testing.assert_allclose(out, expected, atol=1e-6)


@in_one_test("levels", range(2, 33))
def test_hard_posterize_gives_only_its_tones(levels: int) -> None:
    """Also for 8-bit codes exactly on the border of two tones."""
    luma = np.arange(256, dtype=np.uint8)[None]
    encoding = Encoding(full_range=True, subsampling=(1, 1))
    out = run(style(step("posterize", levels=levels, softness=0)), Picture(encoding, luma=luma), target=FLOAT)
    assert out.luma is not None
    tones = out.luma[0] * np.float32(levels - 1)
    np.testing.assert_allclose(tones, np.rint(tones), atol=1e-5)
    assert len(set(np.rint(tones))) == levels
    assert np.all(np.diff(tones) >= 0)


@pytest.mark.parametrize("softness", [0.05, 0.15, 0.5, 1])
@pytest.mark.parametrize("levels", [2, 7, 32])
def test_soft_posterize_is_continuous(levels: int, softness: float) -> None:
    values = np.linspace(-0.1, 1.1, 200_001)[None]
    out = run_luma(style(step("posterize", levels=levels, softness=softness)), values)[0].astype(np.float64)
    rise = np.diff(out)
    assert rise.min() >= -1e-6
    steepest = 1.5 * levels / softness / (levels - 1) * (values[0, 1] - values[0, 0])
    assert rise.max() < 1.1 * steepest + 1e-6
    assert (out[0], out[-1]) == (0, 1)


@pytest.mark.parametrize("levels", [3, 10])
def test_posterize_is_flat_for_the_rest_of_each_step(levels: int) -> None:
    softness = 0.2
    inside = (
        np.arange(levels)[:, None] + np.linspace(0.5 * softness + 0.01, 1 - 0.5 * softness - 0.01, 9)
    ) / levels
    out = run_luma(style(step("posterize", levels=levels, softness=softness)), inside)
    np.testing.assert_allclose(
        out, np.broadcast_to(np.arange(levels)[:, None] / (levels - 1), out.shape), atol=1e-6
    )


def test_luma_posterize_is_posterize_on_luma_with_original_chroma() -> None:
    source = Picture(FLOAT, luma=noise(9, 11), chroma=(noise(9, 11, low=-0.1, high=0.1), noise(9, 11)))
    out = run(style(step("luma_posterize", levels=6)), source)
    assert out.luma is not None
    np.testing.assert_array_equal(out.luma, run_luma(style(step("posterize", levels=6)), source.luma))
    assert out.chroma is source.chroma


@pytest.mark.parametrize("factor", [0, 0.5, 1, 1.3, 4])
def test_brightness(factor: float) -> None:
    luma = noise(20, 30, low=-0.2, high=1.2)
    expected = np.clip(luma.astype(np.float64) * factor, 0, 1)
    np.testing.assert_allclose(run_luma(style(step("brightness", factor=factor)), luma), expected, atol=1e-6)


@in_one_test("factor", [0, 0.5, 1, 1.8, 4])
@in_one_test("matrix", ["bt601", "bt709", "bt2020"])
def test_saturation_moves_away_from_gray(factor: float, matrix: str) -> None:
    color = noise(20, 30, 3)
    weights = {"bt601": (0.299, 0.587, 0.114), "bt709": WEIGHTS, "bt2020": (0.2627, 0.678, 0.0593)}[matrix]
    gray = (color.astype(np.float64) @ weights)[..., None]
    picture = Picture(Encoding(matrix, True, 0, (1, 1)), color=color)
    out = run(style(step("saturation", factor=factor)), picture, rgb=True)
    np.testing.assert_allclose(out.color, np.clip(gray + factor * (color - gray), 0, 1), atol=1e-5)


@pytest.mark.parametrize("angle", [-180, -60, 0, 30, 90, 180])
def test_hue_rotates_chroma_plane(angle: float) -> None:
    """Anticlockwise with blue difference to the right, luma kept; with muted colours that are not clipped."""
    luma, angles = np.full((8, 9), 0.5), np.radians(np.arange(72).reshape(8, 9) * 5.0)
    blue, red = 0.1 * np.cos(angles), 0.1 * np.sin(angles)
    planes = [plane.astype(np.float32) for plane in (luma, blue, red)]
    picture = Picture(FLOAT, luma=planes[0], chroma=(planes[1], planes[2]))
    out = run(style(step("hue", angle=angle)), picture)
    assert out.chroma is not None
    turned = angles + np.radians(angle)
    np.testing.assert_allclose(out.luma, luma, atol=1e-6)
    np.testing.assert_allclose(out.chroma, [0.1 * np.cos(turned), 0.1 * np.sin(turned)], atol=1e-6)


def test_hue_changes_nothing_at_0_and_full_turn() -> None:
    color = noise(20, 30, 3)
    turned = [run_color(style(step("hue", angle=angle)), color) for angle in (-180, 180, 0)]
    np.testing.assert_allclose(turned[0], turned[1], atol=1e-6)
    np.testing.assert_allclose(turned[2], color, atol=1e-6)
    assert np.abs(turned[0] - color).max() > 0.5


def test_hue_adds_its_tint_in_levels_of_255() -> None:
    color = noise(20, 30, 3)
    out = run_color(style(step("hue", angle=0, red=51, green=-102, blue=255)), color)
    np.testing.assert_allclose(out, np.clip(color + [0.2, -0.4, 1], 0, 1), atol=1e-6)


def test_channel_mixer_tells_fair_hair_from_skin_and_keeps_grays() -> None:
    hair, skin, gray = (0.85, 0.8, 0.6), (0.9, 0.7, 0.6), (0.4, 0.4, 0.4)
    color = np.array([[hair, skin, gray]])
    yellow = run_color(style(step("channel_mixer", red=-1, green=2, blue=-1)), color)
    np.testing.assert_allclose(yellow[0], [[0.15] * 3, [0] * 3, [0] * 3], atol=1e-6)
    mixed = run_color(style(step("channel_mixer", red=0.5, green=-1, blue=1.5)), color)
    np.testing.assert_allclose(mixed[0], [[0.525] * 3, [0.65] * 3, [0.4] * 3], atol=1e-6)


def test_local_exposure_gives_dark_figures_no_bright_rim() -> None:
    """A dark figure is brightened; an adjacent wall is not, although local brightness is blurred."""
    luma = np.array([[0.2, 0.6]], np.float32)
    near, wide = np.full_like(luma, 0.2), np.full_like(luma, 0.6)
    values = {"near": near, "wide": wide, "lift": 1, "even": 0, "limits": RANGES["luma"]}
    gray = local_exposure(luma, out=np.empty_like(luma), **values)
    np.testing.assert_allclose(gray, [[0.2 / 0.6, 0.6 / (1 - (0.6 - 0.48))]], atol=1e-6)
    color = np.stack([luma] * 3, 2)
    made = local_exposure(color, out=np.empty_like(color), **values)
    np.testing.assert_allclose(made, np.stack([gray] * 3, 2), atol=1e-6)


@pytest.mark.parametrize(("hue", "saturation"), [(0, 1), (30, 0.55), (200, 0.3), (360, 1), (120, 0)])
def test_colorize_is_hsl_with_luma_as_lightness(hue: float, saturation: float) -> None:
    color = noise(6, 7, 3)
    out = run_color(style(step("colorize", hue=hue, saturation=saturation)), color)
    lightness = color.astype(np.float64) @ WEIGHTS
    expected = [[colorsys.hls_to_rgb(hue / 360, each, saturation) for each in row] for row in lightness]
    np.testing.assert_allclose(out, expected, atol=1e-6)


def test_gradient_gives_five_tones_their_colours_and_mixes_between_them() -> None:
    names, colors = ("black", "dark", "middle", "bright", "white"), noise(5, 3)
    tints = {
        name: "#" + bytes(np.rint(255 * each).astype(np.uint8)).hex()
        for name, each in zip(names, colors, strict=True)
    }
    tones = np.linspace(-0.25, 1.25, 37, dtype=np.float32)
    out = run_color(style(step("gradient", **tints)), np.repeat(tones[None, :, None], 3, axis=2))
    places, stops = np.clip(tones, 0, 1), np.linspace(0, 1, 5)
    exact = np.rint(255 * colors) / 255
    expected = np.stack([np.interp(places, stops, exact[:, channel]) for channel in range(3)], axis=1)
    np.testing.assert_allclose(out[0], expected, atol=1e-5)


BLENDS = [
    ("normal", 0.8, 0.2),
    ("multiply", 0.2, 0.12),
    ("screen", 0.85, 0.68),
    ("overlay", 0.4, 0.36),
    ("hard_light", 0.7, 0.24),
    ("soft_light", 0.25 * 0.25 * -0.6 + 1.6 * 0.25, 0.6 * 0.6 * 0.6 + 0.4 * 0.6),
    ("darken", 0.25, 0.2),
    ("lighten", 0.8, 0.6),
    ("add", 1.0, 0.8),
    ("subtract", 0.0, 0.4),
    ("difference", 0.55, 0.4),
    ("grain_extract", 0.0, 0.9),
    ("grain_merge", 0.55, 0.3),
    ("divide", 0.3125, 1.0),
    ("dodge", 1.0, 0.75),
    ("burn", 0.0625, 0.0),
]
"""Results of 0.25 below 0.8, and of 0.6 below 0.2. Soft light is Pegtop's, (1 - 2a) b b + 2 a b."""


def test_every_mode_has_its_known_values() -> None:
    assert {mode for mode, *_ in BLENDS} == set(MODE_FORMULAS)


@in_one_test("mode, light, dark", BLENDS)
@in_one_test("opacity", [1, 0.25])
def test_blend_modes_on_known_values(mode: str, light: float, dark: float, opacity: float) -> None:
    below, above = np.array([[0.25, 0.6]]), np.array([[0.8, 0.2]])
    out = blended(below, above, mode=mode, opacity=opacity)
    np.testing.assert_allclose(out, below + opacity * (np.array([[light, dark]]) - below), atol=1e-6)


def blended(
    below: np.ndarray, above: np.ndarray, mask: np.ndarray | None = None, **values: object
) -> np.ndarray:
    """Run the block on gray and on RGB, which must agree."""
    below, above = below.astype(np.float32), above.astype(np.float32)
    mask = None if mask is None else mask.astype(np.float32)
    values |= {"mask": mask, "limits": RANGES["luma"]}
    gray = blend(below, other=above, out=np.empty_like(below), **values)
    colors = [np.stack([each] * 3, 2) for each in (below, above)]
    color = blend(colors[0], other=colors[1], out=np.empty_like(colors[0]), **values)
    np.testing.assert_allclose(color, np.stack([gray] * 3, 2), atol=1e-7)
    return np.asarray(gray)


def test_a_mask_multiplies_the_opacity() -> None:
    below, above, mask = noise(3, 4), noise(3, 4, seed=2), noise(3, 4, seed=3)
    out = blended(below, above, mask, opacity=0.5)
    np.testing.assert_allclose(out, below + 0.5 * mask * (above - below), atol=1e-6)


def test_blend_takes_saved_pictures_by_name() -> None:
    color = noise(12, 10, 3)
    steps = [
        step("soft_threshold", save="mask"),
        step("brightness", source="source", factor=0.5, save="dark"),
        step("saturation", source="source", factor=0),
        step("blend", other="dark", mode="multiply", opacity=1.0, mask="mask"),
    ]
    gray = np.repeat((color @ WEIGHTS)[..., None], 3, axis=2)
    dark = color - 0.5 * gray
    mask = (1 + np.tanh(np.minimum(0, 0.03 * (255 * color - 110)))) @ WEIGHTS
    expected = np.clip(gray + mask[..., None] * (gray * dark - gray), 0, 1)
    np.testing.assert_allclose(run_color(style(*steps), color), expected, atol=1e-5)
