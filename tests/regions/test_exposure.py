"""Tones of faces approach one range, before the style stretches them."""

from __future__ import annotations

import numpy as np
import pytest

from vidstyle.regions.features.exposure import (
    FACE_LUMA_RANGE,
    FACE_QUANTILES,
    PAGE_QUANTILES,
    Stretch,
    expose_face,
)
from vidstyle.renderer import stylize
from vidstyle.style import load_style

SKIN = np.ones((80, 80), np.float32)


@pytest.mark.parametrize(("dark", "bright"), [(0.02, 0.2), (0.7, 0.98), (0.3, 0.4)])
def test_tones_of_a_face_approach_one_range(dark: float, bright: float) -> None:
    luma = np.float32(np.linspace(dark, bright, 6400).reshape(80, 80))
    tones = np.quantile(luma, FACE_QUANTILES)
    after = np.quantile(expose_face(luma, tones, SKIN, 60.0, Stretch(0.5, 1.0)), FACE_QUANTILES)
    assert np.ptp(after) > 1.2 * np.ptp(tones)
    assert (
        abs(after.mean() - np.mean(FACE_LUMA_RANGE))
        < 0.7 * abs(tones.mean() - np.mean(FACE_LUMA_RANGE)) + 0.02
    )


@pytest.mark.parametrize("curve", [1, 2])
def test_the_stretch_is_what_styles_do(curve: float) -> None:
    """Else skin that is bright on a dull page becomes paper white."""
    page = np.tile(np.linspace(0.02, 0.55, 200, dtype=np.float32)[:, None] ** curve, (100, 1, 3))
    equalize = {"block": "equalize", "low": 1, "high": 99.7}
    wanted = stylize(page, load_style({"format": 1, "name": "x", "background": [equalize]}), device="cpu")
    shown = Stretch.of(*np.quantile(page, PAGE_QUANTILES)).shown(page)
    assert np.abs(np.clip(shown, 0, 1) - wanted).max() < 0.02


def test_exposure_takes_the_stretch_of_the_style_into_account() -> None:
    """What a style stretches later has the same tones as what it does not."""
    luma = np.float32(np.linspace(0.4, 0.6, 6400).reshape(80, 80))
    tones, stretch = np.quantile(luma, FACE_QUANTILES), Stretch.of(0.4, 0.45, 0.55, 0.7)
    assert stretch.gain > 2 and np.allclose(stretch.luma(stretch.shown(luma)), luma, atol=1e-6)
    exposed = expose_face(luma, tones, SKIN, 60.0, stretch)
    shown = expose_face(stretch.shown(luma), stretch.shown(tones), SKIN, 60.0, Stretch(0.5, 1.0))
    assert np.allclose(stretch.shown(exposed), shown, atol=1e-5)
