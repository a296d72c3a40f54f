"""Reference filters against closed forms, invariants and independent schemes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest
from covering import in_one_test
from pictures import noise

from vidstyle.blade.references import (
    detail_base,
    edge_tangent_flow,
    flow_dog_parts,
    second_order_tv_flow,
    tv_flow,
)
from vidstyle.errors import UsageError

Y, X = np.mgrid[-40:41, -40:41].astype(float)
INSIDE = np.s_[16:-16, 16:-16]
"""The area from which no line reaches the border."""


def flow_dog(luma: np.ndarray, sigma: float, p: float, sigma_m: float = 2, rho: float = 2) -> np.ndarray:
    """The high-emphasis filter of Flow-XDoG, as the block combines it from its parts."""
    smooth, difference = flow_dog_parts(luma, sigma, sigma_m, rho)
    return smooth + np.float32(p) * difference


def detail(luma: np.ndarray, delta: float) -> np.ndarray:
    """Detail control, as the block combines it from the picture and its base."""
    fine = luma.astype(np.float64)
    return (fine + delta / 100 * (fine - detail_base(luma))).astype(np.float32)


ALL: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "edge tangent flow": edge_tangent_flow,
    "mean curvature motion": lambda luma: tv_flow(luma, 2),
    "true tv flow": lambda luma: tv_flow(luma, 4, gradient_power=0),
    "flow dog": lambda luma: flow_dog(luma, 1, p=10),
    "narrow flow dog": lambda luma: flow_dog(luma, 0.5, p=10),
    "less detail": lambda luma: detail(luma, -60),
    "more detail": lambda luma: detail(luma, 60),
}
AVERAGES = [name for name in ALL if "dog" not in name and "more" not in name]
"""Filters whose result stays within the range of their input."""

every = pytest.mark.parametrize("name", ALL)
angles = pytest.mark.parametrize("angle", [0, 10, 22.5, 45, 70])


def cumulative(distance: np.ndarray, sigma: float) -> np.ndarray:
    """A step from 0 to 1 at distance 0, blurred by a Gaussian."""
    return np.vectorize(math.erf)(distance / sigma / math.sqrt(2)) / 2 + 0.5


def across(angle: float) -> np.ndarray:
    """Distance from a straight line through the middle, whose normal has this angle in degrees."""
    turn = math.radians(angle)
    return X * math.cos(turn) + Y * math.sin(turn)


def edge(angle: float, sigma: float = 1.0) -> np.ndarray:
    return (0.2 + 0.6 * cumulative(across(angle), sigma)).astype(np.float32)


def disc(radius: float, low: float = 0.2, high: float = 0.8) -> np.ndarray:
    return (low + (high - low) * cumulative(radius - np.hypot(X, Y), 0.7)).astype(np.float32)


def smooth_noise(seed: int = 1, sigma: float = 3.0) -> np.ndarray:
    picture = cv2.GaussianBlur(noise(96, 96, seed=seed), (0, 0), sigma)
    return (0.5 + (picture - 0.5) * 0.15 / picture.std()).clip(0, 1).astype(np.float32)


def rms(picture: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(picture, dtype=float))))


# Facts about all filters


@every
@in_one_test("level", [0.0, 0.3, 1.0])
def test_a_constant_stays(name: str, level: float):
    out = ALL[name](np.full((20, 30), level, np.float32))
    assert np.abs(out - level).max() < 2e-6


@every
@in_one_test("shape", [(1, 1), (1, 9), (9, 1), (2, 2), (5, 40)])
def test_any_shape_gives_finite_result_and_keeps_input(name: str, shape: tuple[int, int]):
    luma = noise(*shape)
    before = luma.copy()
    out = ALL[name](luma)
    assert out.dtype == np.float32 and out.shape == shape and np.isfinite(out).all()
    assert not np.shares_memory(out, luma) and (luma == before).all()


@every
def test_it_commutes_with_rotations_and_reflections(name: str):
    luma = smooth_noise(sigma=1.5)[:50, :70]
    out = ALL[name](luma)
    assert np.abs(ALL[name](np.rot90(luma)) - np.rot90(out)).max() < 1e-5
    assert np.abs(ALL[name](luma[:, ::-1]) - out[:, ::-1]).max() < 1e-5
    assert np.abs(ALL[name](luma.T) - out.T).max() < 1e-5


@pytest.mark.parametrize("name", AVERAGES)
def test_an_average_stays_within_the_range_and_near_the_mean(name: str):
    luma = noise(64, 64, low=0.2, high=0.7)
    out = ALL[name](luma)
    assert luma.min() - 1e-6 <= out.min() and out.max() <= luma.max() + 1e-6
    assert abs(out.mean() - luma.mean()) < 0.005
    assert out.std() < 0.9 * luma.std()


@pytest.mark.parametrize(
    ("call", "subject"),
    [
        (lambda luma: edge_tangent_flow(luma, sigma=0), "sigma"),
        (lambda luma: edge_tangent_flow(luma, rho=-1), "rho"),
        (lambda luma: tv_flow(luma, math.nan), "time"),
        (lambda luma: tv_flow(luma, 1, gradient_power=2), "gradient_power"),
        (lambda luma: flow_dog(luma, 1, 10, sigma_m=math.inf), "sigma_m"),
        (lambda luma: detail_base(luma, contrast=0), "contrast"),
    ],
)
def test_invalid_settings_are_refused(call: Callable[..., Any], subject: str):
    with pytest.raises(UsageError, match=f"^{subject} cannot be "):
        call(noise(8, 8))


# Edge tangent flow


@angles
def test_straight_edge_stays_unchanged(angle: float):
    luma = edge(angle, sigma=1.5)
    assert np.abs(edge_tangent_flow(luma) - luma)[INSIDE].max() < 0.008
    assert np.abs(cv2.GaussianBlur(luma, (0, 0), 2) - luma)[INSIDE].max() > 0.05  # a Gaussian would change it


def test_rings_stay_unchanged():
    """A line that is followed without midpoints would leave its ring."""
    radius = np.hypot(X, Y)
    luma = 0.5 + 0.3 * np.cos(radius * 2 * math.pi / 12)
    ring = (radius > 8) & (radius < 24)
    assert np.abs(edge_tangent_flow(luma, sigma=3) - luma)[ring].max() < 0.015


@pytest.mark.parametrize("sigma", [1.0, 2.0, 4.0])
def test_along_parallel_structure_it_is_a_gaussian(sigma: float):
    """Stripes of period 4, and weak noise along them; the tensor's mixed term averages to 0."""
    weak = 0.02 * np.random.default_rng(3).standard_normal(160)
    stripes = 0.5 + 0.3 * np.sin(np.arange(80) * math.pi / 2)
    out = edge_tangent_flow(stripes[:, None] + weak, sigma, rho=3)
    size = 2 * math.ceil(4 * sigma) + 1
    wanted = stripes[:, None] + cv2.GaussianBlur(weak[None], (size, 1), sigma)
    inside = np.s_[16:-16, 16:-16]
    assert np.abs(out - wanted)[inside].max() < 0.001
    assert np.abs(weak).max() > 0.03


def test_faint_noise_in_flat_areas_becomes_weaker():
    luma = 0.5 + noise(80, 80, low=-0.5 / 255, high=0.5 / 255)
    out = edge_tangent_flow(luma)
    assert rms(out - 0.5) < 0.6 * rms(luma - 0.5)


def test_more_passes_smooth_along_the_edge_only():
    luma = (edge(30, sigma=1.5) + noise(81, 81, low=-0.05, high=0.05)).astype(np.float32)
    out = luma
    for _ in range(3):
        out = edge_tangent_flow(out)
    near = np.abs(across(30))[INSIDE] < 3
    error = (out - edge(30, sigma=1.5))[INSIDE][near]
    assert rms(error) < 0.5 * rms((luma - edge(30, sigma=1.5))[INSIDE][near])


# Mean curvature motion: the paper's TV flow


def test_papers_scheme_agrees_with_ours() -> None:
    luma = cv2.GaussianBlur(disc(9), (0, 0), 1)
    ours, theirs = tv_flow(luma, 4), second_order_tv_flow(luma, 4)
    change, difference = (float(np.square(each - ours).mean()) for each in (luma, theirs))
    assert difference < 0.1 * change
    # Rounding errors grow in flat areas.
    np.testing.assert_allclose(theirs, theirs.T, atol=0.02)
    with pytest.raises(UsageError):
        second_order_tv_flow(luma, 0)


@pytest.mark.parametrize(("radius", "time"), [(20, 60), (12, 30), (8, 20)])
@pytest.mark.parametrize("contrast", [(0.2, 0.8), (0.7, 0.5)])
def test_a_disc_shrinks_by_its_curvature(radius: float, time: float, contrast: tuple[float, float]):
    low, high = contrast
    out = tv_flow(disc(radius, low, high), time)
    area = ((out - low) / (high - low) > 0.5).sum()
    assert math.sqrt(area / math.pi) == pytest.approx(math.sqrt(radius**2 - 2 * time), abs=0.25)


def median_motion(luma: np.ndarray, time: float, radius: float = 2.0) -> np.ndarray:
    """Mean curvature motion by the median of a circle (Oberman 2004), with bilinear samples."""
    turns = np.arange(48) * 2 * math.pi / 48
    rows, columns = np.mgrid[: luma.shape[0], : luma.shape[1]].astype(np.float32)
    out = luma.astype(np.float32)
    step = 0.125
    for _ in range(round(time / step)):
        circle = [
            cv2.remap(
                out,
                columns + np.float32(radius * math.cos(turn)),
                rows + np.float32(radius * math.sin(turn)),
                cv2.INTER_CUBIC,
                borderMode=cv2.BORDER_REPLICATE,
            )
            for turn in turns
        ]
        out = out + np.float32(step * 2 / radius**2) * (np.median(circle, axis=0) - out)
    return out


def test_it_agrees_with_the_median_scheme():
    luma = smooth_noise()
    ours, theirs = tv_flow(luma, 4), median_motion(luma, 4)
    assert rms(ours - theirs) < 0.15 * rms(ours - luma)


def test_contrast_does_not_matter_to_curvature():
    luma = smooth_noise(2)
    curve, moved = np.square, tv_flow(luma, 4)
    assert rms(tv_flow(curve(luma), 4) - curve(moved)) < 0.03 * rms(curve(moved) - curve(luma))


@angles
def test_curvature_leaves_straight_edges(angle: float):
    """Except for the last level at the foot of the edge, where gradients are faint."""
    luma = edge(angle, sigma=1.5)
    assert np.abs(tv_flow(luma, 4) - luma)[INSIDE].max() < 0.006


@angles
def test_curvature_makes_no_extremes_at_sharp_edges(angle: float):
    out = tv_flow(edge(angle, sigma=0.3), 2)
    assert 0.2 - 1e-6 < out.min() and out.max() < 0.8 + 1e-6


@pytest.mark.parametrize(("power", "time"), [(1, 0.3), (0, 0.07)])
def test_two_flows_of_half_the_time_equal_one_flow(power: int, time: float):
    """Also at times that are not a multiple of the maximum step."""
    luma = noise(40, 50)
    twice, once = tv_flow(tv_flow(luma, time, power), time, power), tv_flow(luma, 2 * time, power)
    assert rms(twice - once) < 0.1 * rms(once - luma)


def test_a_single_pixel_vanishes():
    luma = np.full((21, 21), 0.5, np.float32)
    luma[10, 10] = 1
    assert tv_flow(luma, 4).max() < 0.52


# True total variation flow


@pytest.mark.parametrize(("radius", "time"), [(6, 6), (6, 12), (12, 12)])
def test_a_disc_loses_height(radius: float, time: float):
    """Its levels decrease by 2 t / r and its rim stays; its loss is added to the plane around it."""
    luma = disc(radius)
    lost = 255 * (luma - tv_flow(luma, time, gradient_power=0))
    inside = np.hypot(X, Y) < radius
    assert lost[inside].mean() == pytest.approx(2 * time / radius, rel=0.12)
    assert abs(lost.mean()) < 1e-4


def test_the_total_variation_falls_and_the_mean_is_kept():
    def total_variation(luma: np.ndarray) -> float:
        down, right = np.diff(luma, axis=0)[:, :-1], np.diff(luma, axis=1)[:-1]
        return float(np.hypot(down, right).sum())

    luma = noise(50, 60)
    flows = [luma, *(tv_flow(luma, time, gradient_power=0) for time in (0.5, 2, 8, 30))]
    variations = [total_variation(flow) for flow in flows]
    assert all(later < 0.99 * earlier for earlier, later in zip(variations, variations[1:], strict=False))
    assert all(abs(flow.mean(dtype=float) - luma.mean(dtype=float)) < 1e-5 for flow in flows)


def test_the_two_flows_differ_as_defined():
    """The true flow reduces every contrast by the same amount, curvature by a share of it."""
    strong, weak = disc(6, 0.2, 0.8), disc(6, 0.2, 0.4)
    lost_strong, lost_weak = ((luma - tv_flow(luma, 6, gradient_power=0))[40, 40] for luma in (strong, weak))
    assert lost_strong == pytest.approx(lost_weak, rel=0.06)
    moved_strong, moved_weak = (np.abs(luma - tv_flow(luma, 6)).max() for luma in (strong, weak))
    assert moved_strong == pytest.approx(3 * moved_weak, rel=0.05)


# Flow-guided difference of Gaussians


@angles
@pytest.mark.parametrize("sigma", [0.5, 1.0, 2.0])
@pytest.mark.parametrize(("p", "allowed"), [(0, 0.01), (20, 0.035)])
def test_across_a_step_it_is_the_difference_of_gaussians(
    angle: float, sigma: float, p: float, allowed: float
):
    def blurred(more: float) -> np.ndarray:
        return 0.2 + 0.6 * cumulative(across(angle), math.hypot(1.5, more))

    wanted = (1 + p) * blurred(sigma) - p * blurred(1.6 * sigma)
    out = flow_dog(edge(angle, sigma=1.5), sigma, p)
    assert np.abs(out - wanted)[INSIDE].max() < allowed
    assert p == 0 or out.max() > 0.9  # it sharpens: with the Gaussians swapped it would blur


def test_it_is_linear_in_p():
    luma = noise(40, 50)
    smooth, difference = flow_dog_parts(luma, 1.2, sigma_m=3, rho=1.5)
    for p in (0, 1, 21.7, 40):
        out = flow_dog(luma, 1.2, p, sigma_m=3, rho=1.5)
        np.testing.assert_allclose(out, smooth + p * difference, atol=2e-6)


def test_it_is_smoothed_along_the_flow():
    """A noisy line becomes uniform; the difference of Gaussians alone would leave it spotted."""
    line = 0.8 - 0.6 * np.exp(-(across(30) ** 2) / 4)
    luma = (line + np.random.default_rng(4).normal(0, 0.1, line.shape)).astype(np.float32)
    on_line = np.abs(across(30))[INSIDE] < 0.5
    even, uneven = (flow_dog(luma, 1, 10, sigma_m)[INSIDE][on_line] for sigma_m in (4, 0.2))
    assert even.std() < 0.5 * uneven.std()


# Detail


def test_zero_change_of_detail_keeps_every_bit():
    luma = noise(40, 50)
    assert detail(luma, 0).tobytes() == luma.tobytes()


def test_it_is_linear_between_the_base_and_more_detail():
    luma = noise(40, 50)
    base = detail_base(luma)
    assert np.array_equal(detail(luma, -100), base)
    for delta in (-60, 30, 60):
        np.testing.assert_allclose(detail(luma, delta), luma + delta / 100 * (luma - base), atol=1e-6)


def test_base_matches_definition():
    luma, radius = noise(14, 15), 4
    padded = np.pad(luma.astype(float), radius + 1, mode="edge")
    base = detail_base(luma, contrast=60, spread=1.7)
    for row, column in [(0, 0), (7, 7), (13, 4), (5, 14)]:
        here = padded[row + radius : row + radius + 3, column + radius : column + radius + 3]
        total = weights = 0.0
        for down in range(2 * radius + 1):
            for right in range(2 * radius + 1):
                there = padded[row + down : row + down + 3, column + right : column + right + 3]
                away = (down - radius) ** 2 + (right - radius) ** 2
                unlike = np.mean((here - there) ** 2) * 255**2
                weight = math.exp(-unlike / (2 * 60**2) - away / (2 * 1.7**2))
                total, weights = total + weight * there[1, 1], weights + weight
        assert base[row, column] == pytest.approx(total / weights, abs=1e-5)


@angles
def test_the_base_has_no_halo_and_less_noise(angle: float):
    clean = edge(angle, sigma=0.6)
    base = detail_base(clean)
    assert clean.min() - 1e-6 <= base.min() and base.max() <= clean.max() + 1e-6
    assert np.abs(base - clean)[INSIDE].max() < 0.04  # the edge keeps its position and slope
    noisy = clean + np.random.default_rng(5).normal(0, 4 / 255, clean.shape).astype(np.float32)
    assert rms((detail_base(noisy) - clean)[INSIDE]) < 0.5 * rms((noisy - clean)[INSIDE])
