"""Halftone: the requested amount of ink, on screens at the angles of printing, fixed to the page."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pictures import noise, run_color, step, style

from vidstyle.blocks.halftone import INK_COLORS, _screens

SIDE = 240
CHANNEL = {"cyan": 0, "magenta": 1, "yellow": 2}
"""The channel of RGB that each ink absorbs."""
ANGLES = {"cyan": 15, "magenta": 75, "yellow": 0, "black": 45}


def asking_for(ink: str, area: float, side: int = SIDE) -> np.ndarray:
    """A flat picture that needs only one ink."""
    color = np.full((side, side, 3), 1 - area if ink == "black" else 1.0)
    if ink != "black":
        color[..., CHANNEL[ink]] = 1 - area
    return color


def printed(color: np.ndarray, **values: Any) -> np.ndarray:
    return run_color(style(step("halftone", **{"gain": 0.0, "black": 1.0, "inks": "pure"} | values)), color)


def coverage(ink: str, area: float, **values: Any) -> float:
    """Return the share of the page that the ink covers; check that there is no other ink."""
    taken = 1 - printed(asking_for(ink, area), **values).astype(np.float64).mean(axis=(0, 1))
    if ink == "black":
        np.testing.assert_allclose(taken, taken[0], atol=1e-6)
        return float(taken[0])
    assert np.delete(taken, CHANNEL[ink]).max() < 1e-6
    return float(taken[CHANNEL[ink]])


@pytest.mark.parametrize("ink", ANGLES)
@pytest.mark.parametrize(("cell", "error"), [(3, 0.042), (6, 0.02), (8, 0.011), (11.3, 0.011), (20, 0.0065)])
def test_flat_patch_gets_requested_area_of_ink(ink: str, cell: float, error: float) -> None:
    """Small dots, which are all identical on a screen without rotation, are less exact than large ones."""
    for area in np.linspace(0, 1, 11):
        assert coverage(ink, area, cell=cell) == pytest.approx(area, abs=error), area


@pytest.mark.parametrize("ink", ANGLES)
def test_white_gets_no_ink_and_pure_ink_covers_everything(ink: str) -> None:
    for cell in (3, 6, 30):
        assert coverage(ink, 0, cell=cell) == 0
        assert coverage(ink, 1, cell=cell) == 1


def test_dot_gain_follows_its_formula() -> None:
    for area in (0.1, 0.3, 0.5, 0.8):
        expected = area + 4 * 0.15 * area * (1 - area)
        assert coverage("black", area, gain=0.15) == pytest.approx(expected, abs=0.015)
        assert coverage("cyan", area, gain=0.15, dot=0.7) == pytest.approx(
            0.7 * area + 4 * 0.15 * 0.7 * area * (1 - 0.7 * area), abs=0.015
        )


@pytest.mark.parametrize("dot", [0.2, 1, 1.5])
@pytest.mark.parametrize("gain", [0, 0.4])
def test_darker_is_never_printed_with_less_ink(dot: float, gain: float) -> None:
    areas = [coverage("black", area, dot=dot, gain=gain) for area in np.linspace(0, 1, 21)]
    assert np.diff(areas).min() > -0.005


def test_other_inks_print_tones_without_black() -> None:
    gray = np.full((SIDE, SIDE, 3), 0.5)
    without, half = printed(gray, black=0.0), printed(gray, black=0.5)
    np.testing.assert_allclose(1 - without.mean(axis=(0, 1)), 0.5, atol=0.015)
    # A quarter of black; the other inks print a third of the rest: (0.5 - 0.25) / (1 - 0.25).
    np.testing.assert_allclose(half.mean(axis=(0, 1)), 0.75 * (2 / 3), atol=0.015)


def test_press_has_separate_ink_colours() -> None:
    for number, ink in enumerate(ANGLES):
        page = printed(asking_for(ink, 1, side=40), inks="press")
        np.testing.assert_allclose(page, np.broadcast_to(INK_COLORS["press"][number], page.shape), atol=1e-5)


@pytest.mark.parametrize("ink", ANGLES)
def test_screens_have_printing_angles(ink: str) -> None:
    side, cell = 512, 8.0
    page = printed(asking_for(ink, 0.3, side), cell=cell)[..., CHANNEL.get(ink, 0)]
    window = np.hanning(side)
    spectrum = np.abs(np.fft.fft2((page - page.mean()) * window * window[:, None]))[:, : side // 2]
    down, across = np.unravel_index(spectrum.argmax(), spectrum.shape)
    down = down - side if down > side // 2 else down
    assert np.hypot(down, across) == pytest.approx(side / cell, abs=1)
    turned = (np.degrees(np.arctan2(down, across)) - ANGLES[ink] + 45) % 90 - 45
    assert abs(turned) < 1


def test_the_screen_stays_on_the_page() -> None:
    """A change in one part of a picture moves no dot in another part."""
    first, second = noise(120, 90, 3), noise(120, 90, 3)
    second[:50] = 1 - second[:50]
    pages = [printed(color) for color in (first, second)]
    radius = 10
    np.testing.assert_array_equal(pages[0][50 + radius :], pages[1][50 + radius :])
    assert np.abs(pages[0][:40] - pages[1][:40]).max() > 0.5


def test_ink_is_averaged_over_the_cell() -> None:
    """A pattern finer than the screen prints as its mean, wherever the dots' centres fall."""
    y, x = np.mgrid[:SIDE, :SIDE]
    checks = np.repeat(((x + y) % 2)[..., None], 3, axis=2)
    flat = np.full((SIDE, SIDE, 3), 0.5)
    assert np.abs(printed(checks, cell=9) - printed(flat, cell=9)).mean() < 0.02


def test_edges_are_anti_aliased() -> None:
    """Between ink and paper there is about one pixel of intermediate tones: neither jagged nor blurred."""
    page = printed(asking_for("black", 0.3), cell=16)[..., 0]
    between = ((page > 0.02) & (page < 0.98)).mean()
    rim = 2 * np.sqrt(np.pi * 0.3) / 16  # the rim of round dots, in pixels for each pixel of the page
    assert 0.6 * rim < between < 1.8 * rim


def test_a_wide_picture_needs_few_cells_and_looks_like_a_part_of_it() -> None:
    color = np.random.default_rng(5).random((24, 3000, 3)).astype(np.float32)
    whole, part = printed(color, cell=3.0), printed(color[:, :400], cell=3.0)
    np.testing.assert_allclose(whole[:, :390], part[:, :390], atol=1e-3)  # float32 over another width
    assert _screens(3.0, 0, *color.shape[:2])[1] < color[..., 0].size
