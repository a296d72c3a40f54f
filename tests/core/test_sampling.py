"""Measured blocks over time: sampling, the time constant, and resets."""

from __future__ import annotations

import math

import numpy as np
import pytest
from media import photograph
from pictures import FLOAT, noise, step, style

from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.sampling import MAX_SIDE_SAMPLES, ExponentialSmoother, sample_plane
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.style import Style


@pytest.mark.parametrize("shape", [(1, 1), (5, 2000), (320, 320), (321, 640), (1080, 1920, 3), (2160, 3840)])
def test_the_small_copy_is_small_and_made_of_the_pictures_own_pixels(shape: tuple[int, ...]) -> None:
    plane = np.arange(np.prod(shape), dtype=np.float32).reshape(shape)
    copy = sample_plane(plane)
    assert max(copy.shape[:2]) <= MAX_SIDE_SAMPLES
    assert min(copy.shape) >= 1
    assert np.isin(copy, plane).all()
    if max(shape[:2]) <= MAX_SIDE_SAMPLES:
        np.testing.assert_array_equal(copy, plane)


def test_percentiles_of_the_small_copy_are_those_of_the_picture() -> None:
    luma = photograph("astronaut")[..., 1].astype(np.float32) / 255
    of_all, of_copy = (np.percentile(each, (2, 5, 50, 95, 98)) for each in (luma, sample_plane(luma)))
    np.testing.assert_allclose(of_copy, of_all, atol=0.01)


def test_numbers_approach_each_measure_with_the_time_constant() -> None:
    smoother = ExponentialSmoother()
    start, goal = np.array([0.0, 1.0]), np.array([1.0, 0.5])
    np.testing.assert_array_equal(smoother.follow(start, 10.0, 0.4), start)
    for time in (10.1, 10.4, 10.45, 11.2):
        followed = smoother.follow(goal, time, 0.4)
        np.testing.assert_allclose(followed, goal + (start - goal) * math.exp(-(time - 10) / 0.4), atol=1e-9)


@pytest.mark.parametrize(
    ("time", "constant"), [(None, 0.4), (5.1, 0), (4.9, 0.4)], ids=["alone", "off", "back"]
)
def test_numbers_follow_at_once(time: float | None, constant: float) -> None:
    """A picture that stands alone, a constant of 0, and a jump back in time."""
    smoother = ExponentialSmoother()
    smoother.follow(np.array([0.0]), 5.0, 0.4)
    assert smoother.follow(np.array([1 / 3]), time, constant) == 1 / 3


@pytest.mark.parametrize("change", [0.0, 1e-4, 0.3])
def test_numbers_forget_how_they_began(change: float) -> None:
    """Bit for bit, also for a constant measure, which they reach; see `WARM_UP_FACTOR` of segments."""
    random = np.random.default_rng(5)
    measures = 0.4 + change * random.random((300, 2))
    early, late = ExponentialSmoother(), ExponentialSmoother()
    early.follow(np.array([0.9, 0.1]), -0.04, 0.4)
    for number, measure in enumerate(measures):
        results = [each.follow(measure, number / 25, 0.4) for each in (early, late)]
    np.testing.assert_array_equal(*results)
    if not change:
        np.testing.assert_allclose(results[0], measures[0], atol=2**-32)


def test_restarted_numbers_take_the_next_measure() -> None:
    smoother = ExponentialSmoother()
    smoother.follow(np.array([0.0]), 5.0, 0.4)
    smoother.restart()
    assert smoother.follow(np.array([1 / 3]), 5.1, 0.4) == 1 / 3, "exactly, as at the start of a film"


def picture(low: float, high: float, shape: tuple[int, int] = (40, 50), seed: int = 1) -> Picture:
    """Noise between two ends, mirrored so that its mean does not say much of them; each seed is a scene."""
    return Picture(FLOAT, luma=noise(*shape, low=low, high=high, seed=seed))


def black_and_gain(renderer: CpuRenderer, source: Picture, time: float | None) -> tuple[float, float]:
    """What equalize took for black, and its gain, read off the pixels that are not cut off."""
    out = renderer.run(source, time).luma
    assert out is not None and source.luma is not None
    inside = (out > 0.1) & (out < 0.9)
    gain, offset = np.polyfit(source.luma[inside].astype(np.float64), out[inside], 1)
    return -offset / gain, gain


EQUALIZE = style(step("equalize", low=5, high=95, lift=0, settle=0.5))


def test_a_block_settles_over_time() -> None:
    """A little more light in every frame is no cut; the block follows with its own constant."""
    with CpuRenderer(EQUALIZE) as renderer:
        black, _ = black_and_gain(renderer, picture(0.3, 0.6), 2.0)
        assert black == pytest.approx(0.315, abs=0.003)
        first, _ = black_and_gain(renderer, picture(0.32, 0.62), 2.1)
        second, _ = black_and_gain(renderer, picture(0.32, 0.62), 2.5)
    assert first - black == pytest.approx(0.02 * (1 - math.exp(-0.1 / 0.5)), abs=1e-4)
    assert second - black == pytest.approx(0.02 * (1 - math.exp(-0.5 / 0.5)), abs=1e-4)


@pytest.mark.parametrize("style_", [EQUALIZE, style(step("gaussian", sigma=0), *EQUALIZE.background)])
def test_a_block_starts_afresh_at_a_cut(style_: Style) -> None:
    with CpuRenderer(style_) as renderer:
        black_and_gain(renderer, picture(0.0, 0.3), 2.0)
        after_cut = black_and_gain(renderer, picture(0.6, 0.9, seed=2), 2.04)
    assert after_cut == pytest.approx((0.615, 1 / 0.27), abs=0.02)


def test_a_block_starts_afresh_at_another_size() -> None:
    with CpuRenderer(EQUALIZE) as renderer:
        black_and_gain(renderer, picture(0.3, 0.6), 2.0)
        black, _ = black_and_gain(renderer, picture(0.32, 0.62, (41, 50)), 2.04)
    assert black == pytest.approx(0.335, abs=0.003)


def test_a_picture_that_stands_alone_remembers_nothing() -> None:
    with CpuRenderer(EQUALIZE) as renderer:
        black_and_gain(renderer, picture(0.3, 0.6), None)
        black, _ = black_and_gain(renderer, picture(0.32, 0.62), None)
    assert black == pytest.approx(0.335, abs=0.003)


def test_each_block_has_its_own_memory() -> None:
    """Two of the same in two layers, one that settles and one that does not."""
    quick, slow = step("equalize", settle=0.0), step("equalize", settle=10.0)
    with (
        CpuRenderer(style(quick, lines=(slow,))) as both,
        CpuRenderer(style(quick)) as background,
        CpuRenderer(style(slow)) as lines,
    ):
        for number in range(3):
            source = picture(0.3 + 0.02 * number, 0.6 + 0.02 * number)
            pages = [renderer.run(source, number / 25).luma for renderer in (both, background, lines)]
            np.testing.assert_allclose(pages[0], pages[1] * pages[2], atol=1e-6)
        assert np.abs(pages[1] - pages[2]).max() > 0.1


def test_a_measure_is_taken_of_what_the_block_gets() -> None:
    """Not of the source: brightness before it changes what it finds."""
    source = picture(0.2, 0.4)
    with CpuRenderer(
        style(step("brightness", factor=2.0), step("equalize", low=0, high=100, lift=0))
    ) as renderer:
        out = renderer.run(source, 0.0).luma
    assert out is not None
    assert (out.min(), out.max()) == pytest.approx((0, 1), abs=1e-5)


def test_luma_of_video_and_of_rgb_measure_alike() -> None:
    color = noise(30, 40, 3, low=0.2, high=0.5)
    luma = (color.astype(np.float64) @ (0.2126, 0.7152, 0.0722)).astype(np.float32)
    codes = np.rint(16 + 219 * luma).astype(np.uint8)
    sources = [
        Picture(FLOAT, color=color),
        Picture(Encoding(subsampling=(1, 1)), luma=codes, chroma=(np.full_like(codes, 128),) * 2),
    ]
    for source in sources:
        with CpuRenderer(style(step("equalize", lift=0))) as renderer:
            out = renderer.run(source, 0.0, FLOAT).luma
        black, white = np.percentile(luma, (5, 95))
        np.testing.assert_allclose(out, np.clip((luma - black) / (white - black), 0, 1), atol=0.03)
