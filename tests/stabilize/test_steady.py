"""Temporal stabilization on the CPU: noise is removed, motion is kept."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from films import RATE, VIDEO, noisy, page, panned_film, picture, still_film
from pictures import SOURCES, planes, run, same_bits, step, style

from vidstyle.core.bands import ONE_THREAD
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.stabilize.blend import source_rows
from vidstyle.stabilize.blend_codes import FULL_WEIGHT
from vidstyle.stabilize.flow import dense_flow
from vidstyle.stabilize.motion import noise_level
from vidstyle.stabilize.segment import SEGMENT_SIZE
from vidstyle.stabilize.stabilizer import Stabilized, Stabilizer
from vidstyle.stabilize.warp import moves_of
from vidstyle.style import Style, load_style, override

PLAIN = style()
LINES = style(step("gaussian", sigma=1), step("sobel"))
STROKES = style(step("pattern"))
"""A style with marks fixed to the page."""


def restyled(chosen: Style, film: Iterable[Picture], steady: float) -> list[Picture]:
    with CpuRenderer(replace(chosen, steady=steady), 2) as renderer:
        return [renderer.run(each, number / RATE) for number, each in enumerate(film)]


def flicker(film: list[Picture], first: int = 5) -> float:
    """Return the mean difference between the luma of successive pictures, in codes."""
    lumas = [np.asarray(each.luma, np.float64) for each in film[first:]]
    return float(np.mean([np.abs(a - b).mean() for a, b in zip(lumas, lumas[1:], strict=False)]))


@pytest.mark.parametrize("chosen", [PLAIN, LINES, STROKES], ids=["plain", "lines", "strokes"])
def test_still_scene_flickers_less_with_higher_steady(chosen: Style) -> None:
    boiling, half, still = (flicker(restyled(chosen, still_film(12), steady)) for steady in (0, 0.5, 1))

    assert half < 0.5 * boiling
    assert still < 0.5 * half


def test_chroma_is_stabilized() -> None:
    def chroma_flicker(steady: float) -> float:
        film = [
            replace(each, luma=each.chroma[0], chroma=None) for each in restyled(PLAIN, still_film(9), steady)
        ]  # type: ignore[index]
        return flicker(film)

    assert chroma_flicker(0.5) < 0.5 * chroma_flicker(0)


@pytest.mark.parametrize("reads", [True, False])
def test_chroma_that_a_style_never_reads_is_not_stabilized(
    reads: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen = style(*([] if reads else [step("to_gray")]), step("brightness", factor=1.1), steady=0.5)
    film, before, stable = list(still_film(3)), Stabilizer.before, []

    def noted(*arguments: Any) -> Stabilized:
        stable.append(before(*arguments))
        return stable[-1]

    monkeypatch.setattr(Stabilizer, "before", noted)
    result = restyled(chosen, film, 0.5)[-1]
    assert all((each.picture.chroma is not None) == reads for each in stable)

    monkeypatch.setattr(Stabilizer, "before", lambda *arguments: before(*arguments[:-1]))
    assert same_bits(restyled(chosen, film, 0.5)[-1], result)


@pytest.mark.parametrize("reads", [(True, True, False, False), (False, False, True, True)])
def test_luma_continues_where_a_style_begins_or_ends_to_read_chroma(reads: tuple[bool, ...]) -> None:
    """As where the strength of a gray style moves to 1 or away from it."""

    def stable(reads: Iterable[bool]) -> list[Stabilized]:
        stage, found = Stabilizer(0.5, False), []
        for number, (each, is_read) in enumerate(zip(still_film(4), reads, strict=True)):
            pair = stage.follow(each, number / RATE, False)
            found.append(stage.before(each, pair.warp() if pair else None, ONE_THREAD, is_read))
        return found

    for one, other in zip(stable(reads), stable([True] * 4), strict=True):
        assert np.array_equal(one.picture.luma, other.picture.luma)  # type: ignore[arg-type]
        assert (one.warp is None) == (other.warp is None)
    assert [each.picture.chroma is not None for each in stable(reads)] == [*reads]


def test_noise_is_removed_under_moving_camera() -> None:
    stage, wide = Stabilizer(0.5, False), page(180, 320 + 3 * 10)
    for number, each in enumerate(panned_film(10)):
        pair = stage.follow(each, number / RATE, False)
        stabilized = stage.before(each, pair.warp() if pair else None, ONE_THREAD).picture

    clean = picture(wide[:, 27 : 27 + 320], replace(VIDEO, depth=16)).luma
    assert each.luma is not None and stabilized.luma is not None and clean is not None
    inner = np.s_[8:-8, 8:-40]  # new areas of the picture have no previous samples

    def error(luma: np.ndarray) -> float:
        return float(np.sqrt(np.mean((luma[inner].astype(np.float64) - clean[inner]) ** 2)))

    assert error(stabilized.luma) < 0.75 * error(each.luma.astype(np.float64) * 256)


def disc(number: int) -> np.ndarray:
    """A bright, sharp disc that moves over a quiet picture by 17 pixels per frame, too fast for the flow."""
    planes = np.full((120, 240, 3), 128, np.float32)
    planes[..., 0] = 70
    rows, columns = np.indices((120, 240))
    planes[(rows - 60) ** 2 + (columns - 20 - 17 * number) ** 2 < 12**2, 0] = 200
    return planes


@pytest.mark.parametrize("chosen", [PLAIN, LINES], ids=["plain", "lines"])
def test_moving_object_leaves_no_trail(chosen: Style) -> None:
    film = [picture(noisy(disc(number), 2, number)) for number in range(10)]

    boiling, steady = (restyled(chosen, film, each)[-1].luma for each in (0, 0.5))

    assert boiling is not None and steady is not None
    off = np.abs(boiling.astype(float) - steady)
    assert off.mean() < 2.5  # the noise
    assert off[:, : 20 + 17 * 9 - 12 - 4].max() < 15  # where the disc was: it was 130 brighter
    assert np.percentile(off, 99.8) < 10


def test_cut_restarts_stabilization() -> None:
    other = page(180, 320, "rocket")
    film = [*still_film(6), *(picture(noisy(other, 4, number)) for number in range(3))]

    assert same_bits(restyled(PLAIN, film, 1.0)[6], film[6])


@pytest.mark.parametrize("times", [(0, 5.0), (1.0, 0.96)], ids=["gap", "back"])
def test_jump_in_time_restarts_stabilization(times: tuple[float, float]) -> None:
    first, second = still_film(2)

    with CpuRenderer(style(steady=1), 2) as renderer:
        renderer.run(first, times[0])
        assert same_bits(renderer.run(second, times[1]), second)


def test_new_size_restarts_stabilization() -> None:
    with CpuRenderer(style(steady=1), 2) as renderer:
        renderer.run(next(still_film(1)), 0)
        small = next(still_film(1, shape=(90, 160)))
        assert same_bits(renderer.run(small, 1 / RATE), small)


def test_single_picture_depends_on_no_other() -> None:
    first, second = still_film(2)
    chosen = style(step("brightness"), steady=1)
    with CpuRenderer(chosen, 2) as renderer:
        renderer.run(first)

        assert same_bits(renderer.run(second), run(chosen, second))


@pytest.mark.parametrize("kind", SOURCES)
@pytest.mark.parametrize("rgb", [False, True])
def test_every_kind_of_picture_keeps_kind_and_colours(kind: str, rgb: bool) -> None:
    source = SOURCES[kind]
    kept = [plane.copy() for plane in planes(source)]
    plain = run(style(step("brightness", factor=1)), source, time=0, rgb=rgb)

    with CpuRenderer(style(step("brightness", factor=1), steady=0.5), 2) as renderer:
        results = [renderer.run(source, number / RATE, rgb=rgb) for number in range(3)]

    for result in results:
        assert result.encoding == plain.encoding
        for one, two in zip(planes(result), planes(plain), strict=True):
            tolerance = 2e-3 if one.dtype == np.float32 else 2 ** max(0, plain.encoding.depth - 8)
            assert one.dtype == two.dtype and np.abs(one.astype(float) - two).max() <= tolerance
    assert all(np.array_equal(one, two) for one, two in zip(planes(source), kept, strict=True))


def test_alpha_stays_unchanged() -> None:
    random = np.random.default_rng(1)
    with CpuRenderer(style(step("brightness"), steady=1), 2) as renderer:
        for number in range(3):
            array = random.integers(0, 255, (20, 30, 4)).astype(np.uint8)
            alpha = renderer.run(Picture.from_array(array), number / RATE, rgb=True).alpha
            assert alpha is not None and np.array_equal(alpha, array[..., 3])


@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (1, 40), (33, 1)])
def test_no_size_is_too_small(shape: tuple[int, int]) -> None:
    film = restyled(LINES, still_film(3, shape=shape), 0.5)

    assert all(each.shape == shape for each in film)


@pytest.mark.parametrize("shape", [(30, 320), (320, 30), (17, 171), (20, 480)])
def test_motion_of_narrow_pictures_is_found(shape: tuple[int, int]) -> None:
    """OpenCV ends the process for the wide ones without padding."""
    before = np.random.default_rng(3).integers(0, 255, shape).astype(np.uint8)
    before = cv2.GaussianBlur(before, (0, 0), 2)
    now = np.roll(before, 3, axis=1)
    flow = dense_flow(now, before)
    assert flow.shape == (*shape, 2)
    inner = flow[6:-6, 8:-8] if min(shape) > 20 else flow[4:-4, 8:-8]
    assert np.median(inner[..., 0]) == pytest.approx(-3, abs=0.5)


def test_memory_order_does_not_affect_result() -> None:
    film = list(panned_film(3))
    turned = [
        replace(
            each, luma=np.asfortranarray(each.luma), chroma=tuple(map(np.asfortranarray, each.chroma or ()))
        )
        for each in film
    ]

    pairs = zip(restyled(LINES, film, 0.5), restyled(LINES, turned, 0.5), strict=True)
    assert all(same_bits(*pair) for pair in pairs)


def test_the_result_does_not_depend_on_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = restyled(LINES, panned_film(4), 0.5)
    monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1)
    monkeypatch.setattr("vidstyle.stabilize.stabilizer.BAND_RADIUS_ROWS", 1)

    assert all(same_bits(*pair) for pair in zip(whole, restyled(LINES, panned_film(4), 0.5), strict=True))


def test_fixed_marks_do_not_move_with_picture() -> None:
    """A camera pans over a smooth surface: its strokes stay fixed to the page."""
    wide = cv2.GaussianBlur(page(180, 320 + 3 * 12), (0, 0), 3)
    film = [picture(wide[:, 3 * number : 3 * number + 320]) for number in range(12)]

    apart, steady = (restyled(STROKES, film, each) for each in (0, 0.5))

    assert flicker(steady) < 1.02 * flicker(apart)


def blended(
    plane: np.ndarray, before: np.ndarray, flow: np.ndarray | None, weight: float, limit: float = np.inf
) -> tuple[np.ndarray, np.ndarray]:
    """Return a plane blended with the previous one, and the weights, 0..1."""
    out, weights = np.empty(plane.shape, before.dtype), np.empty(plane.shape, np.uint8)
    moves = moves_of(flow, plane.shape[1], (1, 1), before.dtype)
    source_rows(plane, (1, 0), before, moves, weight, limit, None, (1, 1), out, weights)(0, plane.shape[0])
    return out, weights / FULL_WEIGHT


@pytest.mark.parametrize("moved", [(6.0, -4.0), (2.5, 1.25)])
def test_a_plane_is_moved_along_the_flow(moved: tuple[float, float]) -> None:
    rows, columns = np.indices((60, 90), np.float32)

    def ramp(x: float, y: float) -> np.ndarray:
        return (7 * (columns + x) + 11 * (rows + y)).astype(np.float32)

    flow = np.tile(np.float32(moved), (15, 22, 1))
    now, _ = blended(np.zeros_like(rows), ramp(0, 0), flow, 1)

    inner = np.s_[8:-8, 8:-8]
    np.testing.assert_allclose(now[inner], ramp(*moved)[inner], atol=0.01)


@pytest.mark.parametrize("shape", [(61, 90), (40, 1), (1, 40), (2, 3), (1, 1), (9, 64)])
@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
def test_every_sample_comes_from_previous_position(shape: tuple[int, int], dtype: type[np.generic]) -> None:
    random = np.random.default_rng(5)
    before = random.uniform(0, 65535, shape).astype(dtype)
    flow = random.uniform(-9, 9, (max(1, shape[0] // 5), max(1, shape[1] // 4), 2)).astype(np.float32)
    flow[: shape[0] // 15] = 0
    now, _ = blended(np.zeros(shape, dtype), before, flow, 0.9)
    now = now / np.float32(0.9)

    rows, columns = np.indices(shape, np.float32)
    places = (columns[0] // SEGMENT_SIZE * SEGMENT_SIZE + SEGMENT_SIZE / 2) / shape[1] * flow.shape[1] - 0.5
    grid = flow[((rows[:, 0] + 0.5) / shape[0] * flow.shape[0]).astype(int)]
    across, down = (
        np.array([np.interp(places, np.arange(flow.shape[1]), row[:, axis]) for row in grid], np.float32)
        for axis in (0, 1)
    )
    wanted = cv2.remap(
        before.astype(np.float32),
        columns + across,
        rows + down,
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    # OpenCV rounds positions to a 32nd of a sample, and noise has steep slopes.
    np.testing.assert_allclose(now, wanted, atol=65535 / 32)
    assert np.abs(now - wanted).mean() < 65535 / 100


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
def test_weight_depends_on_size_of_change(dtype: type[np.generic]) -> None:
    before = np.full((9, 9), 1000, dtype)
    for change, weight in ((0, 1.0), (100, 0.5), (200, 1 / 17)):
        now, weights = blended(np.full((9, 9), 1000 + change, dtype), before, None, 0.5, limit=100)
        # Half a step of change; the limit has at least nine steps.
        tolerance = 0.04 if dtype == np.uint16 and change else 0.5 / FULL_WEIGHT
        np.testing.assert_allclose(weights, weight, atol=tolerance)
        wanted = 1000 + change - 0.5 * weight * change
        np.testing.assert_allclose(now, wanted, atol=0.5 * tolerance * change + 1)


@pytest.mark.parametrize("deviation", [2.0, 4.0, 10.0])
@pytest.mark.parametrize("encoding", [VIDEO, Encoding(depth=10)], ids=["8", "10"])
def test_noise_is_estimated(deviation: float, encoding: Encoding) -> None:
    planes = np.full((200, 300, 3), 120, np.float32)
    planes[:, 100:, 0] += np.linspace(0, 60, 200, dtype=np.float32)  # a slope is no noise

    found = noise_level(picture(noisy(planes, deviation, 1), encoding)) * 219

    assert found == pytest.approx(np.hypot(deviation, 0.29), rel=0.12)


def test_a_clean_photograph_has_little_noise() -> None:
    assert noise_level(picture(page(180, 320))) * 219 < 1.5


def test_steady_is_read_from_style_and_overridden_by_set() -> None:
    assert override(load_style("sketch"), ["steady=0.25"]).steady == 0.25
    assert not replace(PLAIN, steady=0.5).is_plain
