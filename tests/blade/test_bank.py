"""Banks of learned filters: selection, inference, training, and the file format."""

from __future__ import annotations

import io
import os
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from covering import in_one_test
from media import photograph
from pictures import noise

from vidstyle.blade.bank import Bank
from vidstyle.blade.bank_file import REQUIRED_ARRAYS, load_bank, save_bank
from vidstyle.blade.bins import Bins, Feature
from vidstyle.blade.choice import choose_filters
from vidstyle.blade.draw import EMPTY_COLOR, GAP_PX, LEFT_PX, RIGHT_PX, TOP_PX, draw_bank
from vidstyle.blade.filtering import apply_filters
from vidstyle.blade.inference import RESAMPLING_METHOD, BankRun
from vidstyle.blade.regression import (
    NormalEquations,
    TrainingConfig,
    accumulate,
    as_filters,
    before_enlarging,
    solve_weights,
    squared_errors,
)
from vidstyle.blade.simd import pack_filters
from vidstyle.blade.structure_tensor import select_filters, window_radius, window_weights
from vidstyle.blade.symmetry import SYMMETRIES, Symmetry, pixel_pairs
from vidstyle.blade.training import mssim, psnr
from vidstyle.core.picture import WIDE_RANGE
from vidstyle.core.resample import resample, scaled_shape

BINS = Bins(24, 3, 3)
SHARED = replace(BINS, pitch=2)
CURVED = Bins(24, 1, 1, curvatures=5)
IMAGES = {
    "half turn": (lambda a: a[::-1, ::-1], lambda o, n: o),
    "mirror": (lambda a: a[:, ::-1], lambda o, n: -o % n),
    "quarter turn": (lambda a: np.rot90(a), lambda o, n: (o + n // 2) % n),
    "transposed": (lambda a: a.T, lambda o, n: (n // 2 - o) % n),
}
"""The effect of each symmetry on a picture, and on the number of an orientation."""


def face() -> np.ndarray:
    return photograph("astronaut")[..., 1][:301, 90:331].astype(np.float32) / 255


def random_bank(bins: Bins = BINS, size: int = 5, parts: int = 1, seed: int = 3) -> Bank:
    random = np.random.default_rng(seed)
    filters = random.normal(0, 0.1, (parts, bins.count, size, size))
    filters = filters + filters[:, :, ::-1, ::-1]
    filters[:, :, size // 2, size // 2] += 1 - filters.sum(axis=(2, 3))
    return Bank(bins, 1.5, filters.astype(np.float32), {"imitates": "nothing"})


def slowly_filtered(luma: np.ndarray, chosen: np.ndarray, filters: np.ndarray) -> np.ndarray:
    radius = filters.shape[1] // 2
    padded = np.pad(luma.astype(np.float64), radius, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, filters.shape[1:])
    return np.einsum("yxij,yxij->yx", windows, filters[chosen].astype(np.float64))


def learned(config: TrainingConfig, pictures: list[np.ndarray], apply: object) -> np.ndarray:
    sums = NormalEquations.empty(config)
    with ThreadPoolExecutor(2) as pool:
        for luma in pictures:
            sums.add(accumulate(config, luma, apply(luma), pool))  # type: ignore[operator]
    return as_filters(config, solve_weights(config, sums))


@pytest.mark.parametrize("rho", [0.3, 0.5, 1.0, 1.5, 2.3, 4.0])
def test_the_window_is_even_and_sums_to_one(rho: float) -> None:
    weights = window_weights(rho)
    assert len(weights) == 2 * window_radius(rho) and weights.sum() == pytest.approx(1, abs=1e-6)
    np.testing.assert_array_equal(weights, weights[::-1])


@pytest.mark.parametrize("name", IMAGES)
@pytest.mark.parametrize("bins", [BINS, SHARED], ids=["each", "shared"])
def test_rotated_picture_selects_rotated_bins(name: str, bins: Bins) -> None:
    turn, becomes = IMAGES[name]
    luma = (face() + noise(301, 241, high=1e-3))[: 302 - bins.pitch, : 242 - bins.pitch]
    before = turn(select_filters(luma, bins, 1.5))
    after = select_filters(np.ascontiguousarray(turn(luma)), bins, 1.5)
    rest = BINS.strengths * BINS.coherences
    expected = becomes(before // rest, BINS.orientations) * rest + before % rest
    assert (expected != after).mean() < 1e-4


@pytest.mark.parametrize("symmetry", SYMMETRIES, ids=lambda each: str(each.matrix))
def test_transformed_picture_selects_bins_expected_by_training(symmetry: Symmetry) -> None:
    bins = Bins(24, 1, 2, curvatures=7, features=(Feature("mean", 3, 1.0),))
    (a, b), (c, d) = symmetry.matrix

    def turned(plane: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray((plane.T if a == 0 else plane)[:: c + d, :: a + b])

    luma = cv2.GaussianBlur(noise(91, 83), (0, 0), 2)
    images = np.array([symmetry.bin_of(bins, number) for number in range(bins.count)])
    expected = images[turned(choose_filters(luma, bins, 1.5))]
    assert (expected != choose_filters(turned(luma), bins, 1.5)).mean() < 1e-3


def test_curvature_is_reciprocal_of_radius() -> None:
    rows, columns = np.mgrid[-40:41, -40:41].astype(np.float32)
    radius = np.hypot(rows, columns)
    bins = Bins(24, 1, 1, curvatures=101)
    chosen = select_filters(0.5 + 0.4 * np.sin(radius / 4), bins, 1.5)
    begins = np.array([bins.curvature_at(number) for number in range(102)])
    inside = (radius > 10) & (radius < 35)
    low, high = (begins[chosen[inside] % 101 + each] for each in (-1, 2))  # or in the neighbouring bin
    one_by_radius = 1 / radius[inside]
    to_the_left = chosen[inside] % 101 < 50
    assert to_the_left.mean() == pytest.approx(0.5, abs=0.02), "each line is also seen from its other end"
    bends = np.where(to_the_left, -one_by_radius, one_by_radius)
    assert ((low < bends) & (bends < high)).mean() > 0.95


def test_direction_strength_and_coherence_match_definitions() -> None:
    ramp = np.arange(64, dtype=np.float32)
    for degrees in range(0, 180, 15):
        angle = np.radians(degrees)
        luma = 22 / 255 * (ramp[None, :] * np.cos(angle) + ramp[:, None] * np.sin(angle))
        chosen = select_filters(luma.astype(np.float32), Bins(24, 6, 4, (10, 40), (0.2, 0.8)), 1.5)[
            20:44, 20:44
        ]
        orientation, strength, coherence = chosen // 24, chosen // 4 % 6, chosen % 4
        assert (orientation == round(degrees / 7.5) % 24).all()
        assert (strength == 2).all() and (coherence == 3).all(), (
            "a gradient of 22 levels, all in one direction"
        )
    flat = select_filters(np.full((9, 9), 0.5, np.float32), Bins(24, 6, 4), 1.5)
    assert (flat == 0).all()


def test_without_orientations_turned_edges_have_the_same_bin() -> None:
    luma, bins = np.zeros((17, 31), np.float32), Bins(1, 30, 1, (0, 90))
    luma[8:] = 0.2
    chosen = select_filters(luma, bins, 0.5)
    assert chosen[:3].max() == 0 and len(np.unique(chosen[8])) == 1
    np.testing.assert_array_equal(select_filters(np.ascontiguousarray(luma.T), bins, 0.5).T, chosen)
    np.testing.assert_array_equal(select_filters(luma[::-1].copy(), bins, 0.5)[::-1], chosen)


def test_all_bins_are_in_range_on_any_picture() -> None:
    for luma in (
        noise(50, 61),
        noise(1, 1),
        noise(1, 40),
        1e4 * noise(30, 30) - 5e3,
        np.zeros((7, 7), np.float32),
    ):
        for bins in (BINS, SHARED, CURVED):
            chosen = select_filters(luma, bins, 1.5)
            assert chosen.min() >= 0 and chosen.max() < bins.count


@pytest.mark.parametrize("bins", [BINS, SHARED, CURVED], ids=["each", "shared", "curved"])
def test_part_of_wide_picture_selects_same_filters_as_whole(bins: Bins) -> None:
    """Kernels process wide pictures in strips, which begin at other columns in a part."""
    luma, step, around = noise(20, 1300), bins.pitch, 20
    whole = select_filters(luma, bins, 1.5)
    for left in (20, 300, 700):
        part = select_filters(np.ascontiguousarray(luma[:, left - around : left + 580]), bins, 1.5)
        inside = slice(left // step, (left + 560) // step)
        np.testing.assert_array_equal(part[:, around // step : (around + 560) // step], whole[:, inside])


@pytest.mark.parametrize("rho", [0.4, 1.5, 2.0, 3.1, 8.0])
def test_squares_select_by_tensor_in_middle(rho: float) -> None:
    luma, radius = face(), window_radius(rho)
    weights = np.exp(-(np.arange(1.0 - radius, radius) ** 2) / (2 * rho**2))
    around = np.pad(luma, ((0, 1), (0, 1)), mode="edge")
    falling, rising = around[1:, 1:] - around[:-1, :-1], around[:-1, 1:] - around[1:, :-1]
    products = np.dstack([falling**2, falling * rising, rising**2])
    border = cv2.copyMakeBorder(products, *(radius,) * 4, cv2.BORDER_REPLICATE)
    tensor = cv2.sepFilter2D(border, -1, weights, weights)[radius:-radius:2, radius:-radius:2]
    angles = np.arctan2(tensor[..., 0] - tensor[..., 2], 2 * tensor[..., 1])
    expected = np.rint(angles * 24 / (2 * np.pi)).astype(int) % 24
    for top in (0, 1):  # the first square is incomplete
        found = select_filters(luma[top:], Bins(24, 1, 1, pitch=2), rho, top=top)
        assert (found == expected)[4 + radius :, radius:-radius].mean() > 0.97


@in_one_test("size", [3, 9, 11])
@in_one_test("shape", [(1, 1), (3, 7), (33, 41)])
@in_one_test("top", [0, 1])
def test_a_shared_filter_is_applied_to_all_pixels_of_its_square(
    size: int, shape: tuple[int, int], top: int
) -> None:
    luma, bank = noise(*shape), random_bank(size=size)
    squares = (shape[0] + top + 1) // 2, (shape[1] + 1) // 2
    chosen = np.random.default_rng(1).integers(0, BINS.count, squares).astype(np.int32)
    result = apply_filters(luma, chosen, pack_filters(bank.filters[0]), size, WIDE_RANGE, (0, 0), 2, top)
    of_each = chosen.repeat(2, 0).repeat(2, 1)[top : top + shape[0], : shape[1]]
    np.testing.assert_allclose(result, slowly_filtered(luma, of_each, bank.filters[0]), atol=2e-5)


@in_one_test("size", [3, 5, 7, 9, 11, 15])
@in_one_test("shape", [(1, 1), (3, 7), (20, 8), (33, 41)])
def test_vector_kernel_equals_plain_sum(size: int, shape: tuple[int, int]) -> None:
    luma, bank = noise(*shape), random_bank(size=size)
    chosen = np.random.default_rng(1).integers(0, BINS.count, shape).astype(np.int32)
    result = apply_filters(luma, chosen, pack_filters(bank.filters[0]), size, WIDE_RANGE)
    np.testing.assert_allclose(result, slowly_filtered(luma, chosen, bank.filters[0]), atol=2e-5)


@pytest.mark.parametrize("reselect", [True, False])
@pytest.mark.parametrize("passes", [1, 3])
@pytest.mark.parametrize("bins", [BINS, SHARED, CURVED], ids=["each", "shared", "curved"])
def test_bands_with_margin_equal_whole_picture(bins: Bins, passes: int, reselect: bool) -> None:
    luma = face()
    run = BankRun(random_bank(bins), (0.5,), 0.5, passes=passes, reselect=reselect)
    whole = run.run(luma)
    for top, bottom in ((0, 40), (100, 141), (251, 301)):
        above, below = min(run.radius, top), min(run.radius, 301 - bottom)
        band = run.run(luma[top - above : bottom + below], (above, below), top - above)
        np.testing.assert_array_equal(band[above : above + bottom - top], whole[top:bottom])


@pytest.mark.parametrize("bins", [BINS, SHARED, CURVED], ids=["each", "shared", "curved"])
def test_rows_of_whole_cache_lines_receive_result(bins: Bins) -> None:
    luma = np.ascontiguousarray(face()[:, :240])
    run = BankRun(random_bank(bins), (0.5,), 0.5, passes=2)
    whole, out = run.run(luma), np.full((44, 240), np.nan, np.float32)
    band = luma[100 - run.radius : 144 + run.radius]
    assert run.run(band, (run.radius,) * 2, 100 - run.radius, out) is out
    np.testing.assert_array_equal(out, whole[100:144])


def test_parts_and_picture_are_weighted() -> None:
    luma, bank = face(), random_bank(parts=2)
    one, two = (BankRun(bank, each, is_wide=True).run(luma) for each in ((1.0, 0.0), (0.0, 1.0)))
    mixed = BankRun(bank, (0.25, -2.0), 0.5, is_wide=True).run(luma)
    np.testing.assert_allclose(mixed, 0.25 * one - 2 * two + 0.5 * luma, atol=1e-5)
    np.testing.assert_allclose(BankRun(bank, (0.0, 0.0), 1.0, passes=4).run(luma), luma, atol=1e-6)


def test_training_recovers_linear_symmetric_filter() -> None:
    """A linear, symmetric filter is learned exactly, even in bins without samples."""
    kernel = cv2.getGaussianKernel(5, 1)
    config = TrainingConfig(BINS, 1.5, 5, smoothness=1e-9)
    luma = face() + noise(301, 241, high=0.02)
    found = learned(config, [luma], lambda z: [cv2.sepFilter2D(z, -1, kernel, kernel)])
    np.testing.assert_allclose(found[0], np.broadcast_to(kernel @ kernel.T, found[0].shape), atol=2e-3)


def test_reduced_target_is_optimal_after_enlarging() -> None:
    target = cv2.GaussianBlur(face(), (0, 0), 1.4)
    small = before_enlarging(target, scaled_shape(target.shape, 1 / 1.4))
    best = psnr(resample(small, target.shape, RESAMPLING_METHOD), target)
    assert best > 50
    for change in (noise(*small.shape, high=1e-3), resample(target, small.shape, "area") - small):
        for sign in (1, -1):
            assert psnr(resample(small + sign * change, target.shape, RESAMPLING_METHOD), target) < best
    assert before_enlarging(target, target.shape) is target


def test_smooth_resampling_keeps_tones_shapes_and_slopes_but_not_fine_detail() -> None:
    ramp = np.tile(np.linspace(0, 1, 120, dtype=np.float32), (90, 1))
    for shape in ((30, 40), (64, 85), (90, 300), (200, 50)):
        result = resample(ramp, shape, "smooth")
        wanted = ((np.arange(shape[1]) + 0.5) * 120 / shape[1] - 0.5) / 119
        inside, rows = slice(shape[1] // 8, -(shape[1] // 8)), (shape[0], 1)
        np.testing.assert_allclose(result[:, inside], np.tile(wanted, rows)[:, inside], atol=1e-3)
    checks = np.indices((96, 96)).sum(0).astype(np.float32) % 2
    smooth, area = (resample(checks, (60, 60), method)[5:-5, 5:-5] for method in ("smooth", "area"))
    assert np.ptp(smooth) < np.ptp(area) / 2
    colors = noise(20, 30, 3)
    channels = [resample(channel, (31, 17), "smooth") for channel in np.moveaxis(colors, 2, 0)]
    np.testing.assert_array_equal(resample(colors, (31, 17), "smooth"), np.dstack(channels))


def test_constants_are_kept_or_vanish_for_any_training() -> None:
    config = TrainingConfig(BINS, 1.5, 7, (1, 0))
    found = learned(config, [face()], lambda z: [np.sqrt(np.abs(z)), np.sin(9 * z)])
    np.testing.assert_allclose(found[0].sum(axis=(1, 2)), 1, atol=1e-5)
    np.testing.assert_allclose(found[1].sum(axis=(1, 2)), 0, atol=1e-5)


@pytest.mark.parametrize("bins", [Bins(8, 2, 2), CURVED], ids=["straight", "curved"])
def test_filters_have_the_eight_symmetries(bins: Bins) -> None:
    found = learned(TrainingConfig(bins, 1.0, 5), [face()], lambda z: [cv2.bilateralFilter(z, 5, 0.1, 2)])[0]
    is_symmetric = np.abs(found - found[:, ::-1, ::-1]).max(axis=(1, 2)) < 1e-6
    assert is_symmetric.mean() == 1 / bins.curvatures
    assert is_symmetric[bins.curvatures // 2 :: bins.curvatures].all(), "filters of straight lines"
    for symmetry in SYMMETRIES:
        for number in range(bins.count):
            turned = np.zeros((5, 5), np.float32)
            for row in range(5):
                for column in range(5):
                    down, right = symmetry.moved(row - 2, column - 2)
                    turned[down + 2, right + 2] = found[number, row, column]
            np.testing.assert_allclose(found[symmetry.bin_of(bins, number)], turned, atol=1e-5)


@pytest.mark.parametrize("bins", [Bins(8, 2, 2), Bins(8, 1, 1, curvatures=3)], ids=["straight", "curved"])
def test_training_on_rotated_pictures_gives_same_filters(bins: Bins) -> None:
    config = TrainingConfig(bins, 1.0, 5)
    blur = lambda z: [cv2.bilateralFilter(np.ascontiguousarray(z), 5, 0.1, 2)]  # noqa: E731
    upright = learned(config, [face()], blur)
    turned = learned(config, [np.ascontiguousarray(np.rot90(face()))], blur)
    np.testing.assert_allclose(turned, upright, atol=2e-3)


def test_number_of_threads_does_not_change_result() -> None:
    config, luma = TrainingConfig(BINS, 1.5, 5), face()
    sums = []
    for threads in (1, 3):
        with ThreadPoolExecutor(threads) as pool:
            sums.append(accumulate(config, luma, [luma * luma], pool))
    np.testing.assert_array_equal(sums[0].matrices, sums[1].matrices)
    np.testing.assert_array_equal(sums[0].vectors, sums[1].vectors)


@pytest.mark.parametrize("curvatures", [1, 3])
def test_residuals_equal_error_on_samples(curvatures: int) -> None:
    config, luma = TrainingConfig(Bins(8, 1, 1, curvatures=curvatures), 1.5, 5), face()
    target = cv2.bilateralFilter(luma, 9, 0.1, 3)
    with ThreadPoolExecutor(2) as pool:
        sums = accumulate(config, luma, [target], pool)
    weights = solve_weights(config, sums)
    bank = Bank(config.bins, 1.5, as_filters(config, weights))
    error = (BankRun(bank).run(luma) - target)[5:-5, 5:-5]
    mean = squared_errors(sums, weights)[0].sum() / sums.samples.sum()
    assert mean == pytest.approx(float(np.mean(error.astype(np.float64) ** 2)), rel=0.05)


def test_saved_bank_loads_unchanged_and_bytes_are_reproducible(tmp_path: Path) -> None:
    bank = random_bank(parts=2)
    for name in ("a.npz", "b.npz"):
        save_bank(bank, tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    found = load_bank(tmp_path / "a.npz")
    np.testing.assert_array_equal(found.filters, bank.filters)
    assert (found.bins, found.rho, found.about) == (bank.bins, bank.rho, bank.about)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz", "b.npz"]


def arrays_of(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as found:
        return {name: found[name] for name in found.files}


BAD = {
    "wrong version": {"format": np.int32(9)},
    "bins that do not fit": {"bins": np.array([24, 3, 4], np.int32)},
    "odd orientations": {"bins": np.array([23, 3, 3], np.int32)},
    "no bins": {"bins": np.array([0, 3, 3], np.int32)},
    "bins of another shape": {"bins": np.array([24, 3], np.int32)},
    "empty range": {"ranges": np.array([[10.0, 10.0], [0.2, 0.8]])},
    "NaN in a range": {"ranges": np.array([[10.0, np.nan], [0.2, 0.8]])},
    "no window": {"rho": np.float64(0)},
    "doubles": {"filters": np.zeros((1, 216, 5, 5))},
    "even size": {"filters": np.zeros((1, 216, 4, 4), np.float32)},
    "not square": {"filters": np.zeros((1, 216, 5, 7), np.float32)},
    "NaN": {"filters": np.full((1, 216, 5, 5), np.nan, np.float32)},
    "huge weights": {"filters": np.full((1, 216, 5, 5), 2e3, np.float32)},
    "more filters than texture numbers": {
        "bins": np.array([24, 10, 10], np.int32),
        "filters": np.zeros((1, 2400, 3, 3), np.float32),
    },
    "a window too wide for shaders": {"rho": np.float64(8.1)},
    "a range too narrow for floats": {"ranges": np.array([[0, 5e-324], [0.2, 0.8]])},
    "bins that are floats": {"bins": np.array([24, 3, np.inf])},
    "sliders of missing parts": {"about": np.frombuffer(b'{"sliders": [["p", 0, 1]]}', np.uint8)},
    "invalid description": {"about": np.zeros(3, np.uint8)},
    "description nested too deeply": {"about": np.full(100_000, ord("["), np.uint8)},
    "bins of infinity": {"bins": np.full(3, np.inf)},
    "rows of formats": {"format": np.zeros((3, 3), np.int32)},
}


@pytest.mark.parametrize("name", BAD)
def test_invalid_bank_is_refused_with_reason(name: str, tmp_path: Path) -> None:
    path = tmp_path / "bank.npz"
    save_bank(random_bank(), path)
    np.savez(path, **(arrays_of(path) | BAD[name]))
    with pytest.raises(ValueError) as raised:
        load_bank(path)
    assert "\n" not in str(raised.value) and len(str(raised.value)) > 10


def test_other_files_are_refused_as_banks(tmp_path: Path) -> None:
    path = tmp_path / "bank.npz"
    save_bank(random_bank(), path)
    whole, arrays = path.read_bytes(), arrays_of(path)
    pickled = io.BytesIO()
    np.savez(pickled, **(arrays | {"about": np.array([{"a": os.getcwd}], object)}))
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        for entry in REQUIRED_ARRAYS:
            archive.writestr(f"{entry}.npy", bytes(20 << 20))
    missing = io.BytesIO()
    np.savez(missing, **{key: array for key, array in arrays.items() if key != "rho"})
    header = b"\x93NUMPY\1\0\x76\0{'descr': '<f4', 'fortran_order': False, 'shape': (99999999, 99999999), }"
    hostile = [b"", b"not a zip", whole[:500], pickled.getvalue(), bomb.getvalue(), missing.getvalue()]
    hostile += [
        replaced(whole, "filters.npy", header.ljust(127) + b"\n"),
        replaced(whole, "rho.npy", b"(" * 9999),
    ]
    # Fields of the entries in the archive's directory: version, flags, method; then damaged data.
    hostile += [
        whole.replace(b"PK\1\2", b"PK\1\2" + field) for field in (b"\x14\3\xff\0", b"\x14\3\x14\0\1\0")
    ]
    hostile += [whole[:60] + bytes([byte]) * 300 + whole[360:] for byte in (0, 255)]
    directory = whole.index(b"PK\1\2")
    hostile.append(whole[: directory + 10] + b"\x0e" + whole[directory + 11 :])
    hostile.append(whole[:directory] + whole[directory : whole.index(b"PK\5\6")] * 20 + whole[-22:])
    for content in hostile:
        path.write_bytes(content)
        with pytest.raises(ValueError) as raised:
            load_bank(path)
        assert len(str(raised.value)) < 200


def replaced(whole: bytes, name: str, content: bytes) -> bytes:
    """Return the archive with other content of an entry."""
    made = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(whole)) as old, zipfile.ZipFile(made, "w") as new:
        for entry in old.namelist():
            new.writestr(entry, content if entry == name else old.read(entry))
    return made.getvalue()


def test_an_interrupted_save_leaves_the_old_bank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "bank.npz"
    save_bank(random_bank(seed=1), path)
    before = path.read_bytes()
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        save_bank(random_bank(seed=2), path)
    assert path.read_bytes() == before and os.listdir(tmp_path) == [path.name]


def test_fidelity_agrees_with_scikit_image() -> None:
    from skimage.metrics import structural_similarity

    one = face()
    two = cv2.GaussianBlur(one, (0, 0), 1.2)
    assert psnr(one, two) == pytest.approx(-10 * np.log10(np.mean((one.astype(float) - two) ** 2)))
    assert psnr(one, one) == float("inf") and mssim(one, one) == pytest.approx(1)
    theirs = structural_similarity(
        one, two, data_range=1, gaussian_weights=True, sigma=1.5, use_sample_covariance=False
    )
    assert mssim(one, two) == pytest.approx(theirs, abs=2e-3)


def test_a_bank_is_drawn_with_its_bins_in_rows_and_columns() -> None:
    bank = random_bank()
    lone = np.zeros_like(bank.filters)
    lone[0, 10, 2, 2], lone[0, 10, 0, 0], lone[0, 10, 4, 4] = 1, -0.5, -0.5
    samples = np.arange(BINS.count)
    drawn = draw_bank(replace(bank, filters=lone))
    assert (
        drawn.shape == (TOP_PX + 9 * 44 + GAP_PX, LEFT_PX + 24 * 44 + RIGHT_PX, 3) and drawn.dtype == np.uint8
    )
    # Filter 10 has the second orientation, the first strength and the second coherence.
    top, left = TOP_PX + 3 * 44, LEFT_PX + 44
    cell = drawn[top : top + 40, left : left + 40]
    assert cell[4, 4, 2] > cell[4, 4, 0], "negative is blue"
    assert cell[20, 20, 0] > cell[20, 20, 2], "positive is red"
    about = {"samples": samples.tolist(), "residuals": [samples.tolist()]}
    with_maps = draw_bank(replace(bank, filters=lone, about=about))
    assert len(with_maps) > len(drawn)
    assert tuple(with_maps[TOP_PX - 1, LEFT_PX - 1]) == EMPTY_COLOR, "no sample fell into the first bin"


def test_pairs_cover_a_filter_once() -> None:
    for size in (3, 5, 9):
        both = {pixel for down, right in pixel_pairs(size) for pixel in ((down, right), (-down, -right))}
        assert len(both) == size * size - 1 and (0, 0) not in both
