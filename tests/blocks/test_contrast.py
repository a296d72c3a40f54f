"""Blocks that measure the contrast of a picture, against plain float64 formulas."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import noise, run_luma, step, style

from vidstyle.style import Step


@pytest.mark.parametrize(("low", "high"), [(5, 95), (0, 100), (20, 60)])
def test_equalize_stretches_between_percentiles(low: float, high: float) -> None:
    luma = noise(90, 120, low=0.3, high=0.6) ** 2
    black, white = np.percentile(luma, (low, high))
    expected = np.clip((luma - black) / (white - black), 0, 1)
    np.testing.assert_allclose(
        run_luma(style(step("equalize", low=low, high=high, lift=0)), luma), expected, atol=1e-5
    )


def test_equalize_does_not_amplify_flat_pictures() -> None:
    luma = 0.5 + (noise(40, 50) - 0.5) / 255
    out = run_luma(style(step("equalize", lift=0)), luma)
    assert out.min() == 0
    assert out.max() == pytest.approx((luma.max() - np.percentile(luma, 5)) * 255 / 8, abs=1e-4)


def darkened(power: float) -> np.ndarray:
    """Return noise from black to white whose middle tone is 0.5 to this power."""
    return noise(90, 120) ** np.float32(power)


@pytest.mark.parametrize(
    "chosen", [step("equalize", low=0, high=100), step("minimum_range", dynamic_range=0)]
)
def test_a_dim_picture_gets_light_and_keeps_black_and_white(chosen: Step) -> None:
    luma = darkened(3)
    out = run_luma(style(chosen), luma)
    assert np.median(luma) == pytest.approx(0.125, abs=0.02)
    assert 0.2 < np.median(out) < 0.3
    assert (out.min(), out.max()) == pytest.approx((luma.min(), luma.max()), abs=1e-3)
    assert np.all(np.diff(out.ravel()[np.argsort(luma.ravel())]) >= -1e-6)


def test_night_stays_night() -> None:
    """Its noise would be lifted with it."""
    luma = darkened(7)
    out = run_luma(style(step("equalize", low=0, high=100, lift=1)), luma)
    lit = luma > 1e-3
    assert np.max(out[lit] / luma[lit]) < 3
    assert np.median(out) < 0.03
    assert np.max((out / luma)[(luma > 1e-4) & (luma < 0.003)]) < 1.4


def test_a_bright_picture_gets_no_more_light() -> None:
    luma = darkened(1)
    np.testing.assert_allclose(
        run_luma(style(step("equalize", low=0, high=100)), luma),
        run_luma(style(step("equalize", low=0, high=100, lift=0)), luma),
        atol=1e-6,
    )


def test_a_picture_without_black_gets_none() -> None:
    """A deep blue sky is no night, though nothing is darker."""
    luma = noise(90, 120, low=0.18, high=0.9)
    assert run_luma(style(step("equalize", low=0, high=100)), luma).min() > 0.1
    assert run_luma(style(step("equalize", low=0, high=100, lift=0)), luma).min() == 0


@pytest.mark.parametrize(("low", "high"), [(0.4, 0.6), (0.0, 0.2), (0.8, 1.0), (0.1, 0.3)])
def test_minimum_range_widens_to_the_range_and_stays_inside(low: float, high: float) -> None:
    luma = noise(90, 120, low=low, high=high)
    out = run_luma(style(step("minimum_range", dynamic_range=153, lift=0)), luma)
    before, after = np.percentile(luma, (5, 95)), np.percentile(out, (5, 95))
    assert after[1] - after[0] == pytest.approx(0.6, abs=1e-4)
    assert -1e-5 <= after[0] and after[1] <= 1 + 1e-5
    moved = np.clip(before.mean(), 0.3, 0.7)
    expected = np.clip((luma - before.mean()) * 0.6 / (before[1] - before[0]) + moved, 0, 1)
    np.testing.assert_allclose(out, expected, atol=1e-4)


def test_minimum_range_keeps_picture_with_larger_range() -> None:
    luma = noise(90, 120)
    np.testing.assert_array_equal(run_luma(style(step("minimum_range", dynamic_range=200)), luma), luma)
