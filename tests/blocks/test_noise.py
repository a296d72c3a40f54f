"""`noise` and `shift` against their documentation."""

from __future__ import annotations

import numpy as np
import pytest
from gpu import Sessions, faults, film_picture
from pictures import noise, run_color, run_luma, same_bits, step, style

from vidstyle.block import drawing_at, moment_of
from vidstyle.core.picture import Encoding
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.style import Style

sessions = Sessions.fixture()

GRAY = np.full((96, 128), 0.5, np.float32)


def added(**values: object) -> np.ndarray:
    """Return the values that noise of full range adds to middle gray."""
    return run_luma(style(step("noise", amount=1.0, **values)), GRAY) - 0.5


def slowness(page: np.ndarray) -> float:
    """The share of the power in waves longer than 16 pixels."""
    power = np.abs(np.fft.fft2(page - page.mean())) ** 2
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(96), np.fft.fftfreq(128), indexing="ij"))
    return float(power[frequency < 1 / 16].sum() / power.sum())


@pytest.mark.parametrize("kind", ["points", "soft", "clouds"])
def test_noise_has_mean_0_and_stays_in_range(kind: str) -> None:
    page = added(kind=kind, size=2)
    assert abs(page.mean()) < 0.02 and 0.3 < np.abs(page).max() <= 0.5
    half = run_luma(style(step("noise", kind=kind, size=2, amount=0.5)), GRAY) - 0.5
    np.testing.assert_allclose(half, page / 2, atol=1e-6)


def test_points_are_whole_pixels_and_stretch_makes_them_wide() -> None:
    page = added(kind="points", size=2.6, stretch=3)
    cells = page[::3, ::8]
    np.testing.assert_array_equal(page, np.kron(cells, np.ones((3, 8)))[:96, :128])
    assert len(np.unique(cells)) > 0.99 * cells.size


def test_larger_noise_has_lower_frequencies_and_clouds_have_detail() -> None:
    fine, coarse, clouds = added(size=2), added(size=24), added(kind="clouds", size=24)
    assert slowness(fine) < 0.2 < 0.8 < slowness(clouds) < slowness(coarse)


def test_coloured_noise_differs_between_channels() -> None:
    gray = np.repeat(GRAY[..., None], 3, axis=2)
    for colored in (False, True):
        page = run_color(style(step("noise", amount=1, size=2, colored=colored)), gray).reshape(-1, 3)
        relation = np.corrcoef(page.T)[np.triu_indices(3, 1)]
        assert (np.abs(relation) < 0.1).all() if colored else (relation > 0.999).all()


@pytest.mark.parametrize(("x", "y"), [(3, 0), (-5, 2), (0, -7), (64, 64)])
@pytest.mark.parametrize(("plate", "channel"), [("red", 0), ("green", 1), ("blue", 2)])
def test_one_plate_moves_and_others_stay(x: int, y: int, plate: str, channel: int) -> None:
    color = noise(40, 50, 3)
    rows, columns = (np.arange(40) - y).clip(0, 39), (np.arange(50) - x).clip(0, 49)
    expected = color.copy()
    expected[..., channel] = color[np.ix_(rows, columns)][..., channel]
    made = run_color(style(step("shift", plate=plate, x=x, y=y)), color)
    np.testing.assert_allclose(made, expected, atol=1e-6)


def test_parts_of_a_pixel_are_interpolated() -> None:
    color = noise(20, 30, 3)
    made = run_color(style(step("shift", plate="all", x=-0.25, y=0.5)), color)
    across = 0.75 * color[:, :-1] + 0.25 * color[:, 1:]
    np.testing.assert_allclose(made[1:, :-1], (across[:-1] + across[1:]) / 2, atol=1e-6)


def test_moving_chroma_keeps_luma() -> None:
    color, weights = noise(40, 50, 3, low=0.4, high=0.6), Encoding("bt709").weights
    made = run_color(style(step("shift", plate="chroma", x=6)), color)
    np.testing.assert_allclose(made @ weights, color @ weights, atol=1e-5)
    chroma = made - (made @ weights)[..., None]
    np.testing.assert_allclose(chroma[:, 6:], (color - (color @ weights)[..., None])[:, :-6], atol=1e-5)


def test_rows_sway_independently_within_range() -> None:
    ramp = np.repeat(np.tile(np.arange(200, dtype=np.float32) / 200, (96, 1))[..., None], 3, axis=2)
    made = run_color(style(step("shift", plate="all", x=0, jitter=4)), ramp)
    swayed = 200 * (ramp - made)[:, 20:-20, 0]
    assert np.abs(swayed - swayed[:, :1]).max() < 1e-3
    assert 2 < np.abs(swayed).max() <= 4 and np.unique(swayed[:, 0].round(3)).size > 80
    assert np.abs(np.diff(swayed[:, 0])).max() < 1.1


TIMES = [0.0, 0.04, 0.1, 0.16, 3600.0]


@pytest.mark.parametrize(
    "chosen",
    [style(step("noise", rate=10, amount=1.0)), style(step("shift", plate="all", jitter=3.0, rate=10))],
    ids=["noise", "shift"],
)
def test_random_parts_change_at_given_rate(chosen: Style, sessions: Sessions) -> None:
    """Also on the GPU, at the same times."""
    picture = film_picture(48, 64)
    with CpuRenderer(chosen) as renderer:
        first, same, *others = (renderer.run(picture, time) for time in TIMES)
    assert same_bits(first, same) and same_bits(others[0], others[1])
    assert not same_bits(first, others[0]) and not same_bits(others[0], others[2])
    assert not [line for time in TIMES for line in faults(sessions, chosen, picture, str(time), time=time)]


def test_drawings_are_whole_numbers_even_after_a_day() -> None:
    assert [drawing_at(moment_of(time), 25) for time in (None, 0.0, 0.039, 0.04, 1.0)] == [0, 0, 0, 1, 25]
    assert 0 <= drawing_at(moment_of(1e6), 60) < 1 << 32
    assert drawing_at(moment_of(-0.04), 25) >= 0
