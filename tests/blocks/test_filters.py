"""Filters and the working size, against plain float64 formulas."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from covering import in_one_test
from media import photograph
from pictures import noise, run, run_color, run_luma, step, style

from vidstyle.blocks.kuwahara import kuwahara
from vidstyle.core.picture import Encoding, Picture
from vidstyle.style import Step


def convolved(plane: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Correlation with a small odd kernel, the border repeated, by summing shifted copies."""
    down, across = (side // 2 for side in kernel.shape)
    padded = np.pad(plane.astype(np.float64), ((down, down), (across, across)), mode="edge")
    height, width = plane.shape
    return sum(
        kernel[y, x] * padded[y : y + height, x : x + width]
        for y in range(kernel.shape[0])
        for x in range(kernel.shape[1])
    )


def gaussian_kernel(sigma: float) -> np.ndarray:
    radius = int(np.ceil(3 * sigma))
    line = np.exp(-(np.arange(-radius, radius + 1) ** 2) / (2 * sigma**2))
    return np.outer(line, line) / line.sum() ** 2


@pytest.mark.parametrize("sigma", [0.4, 1, 2.3, 5])
def test_gaussian_is_a_convolution(sigma: float) -> None:
    color = noise(33, 47, 3)
    expected = np.stack(
        [convolved(color[..., channel], gaussian_kernel(sigma)) for channel in range(3)], axis=2
    )
    np.testing.assert_allclose(run_color(style(step("gaussian", sigma=sigma)), color), expected, atol=2e-6)
    gray = run_luma(style(step("gaussian", sigma=sigma)), color[..., 1])
    np.testing.assert_allclose(gray, expected[..., 1], atol=2e-6)


def test_gaussian_of_0_changes_nothing() -> None:
    luma = noise(9, 8)
    np.testing.assert_array_equal(run_luma(style(step("gaussian", sigma=0)), luma), luma)


@pytest.mark.parametrize("gain", [0.5, 2, 16])
@pytest.mark.parametrize("invert", [False, True])
def test_sobel_is_the_length_of_the_gradient(gain: float, invert: bool) -> None:
    luma = noise(31, 29, high=0.4)
    across = convolved(luma, np.array([[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]]))
    down = convolved(luma, np.array([[-1, -2, -1], [0, 0, 0], [1, 2, 1]]))
    expected = np.minimum(gain / 4 * np.hypot(across, down), 1)
    out = run_luma(style(step("sobel", gain=gain, invert=invert)), luma)
    np.testing.assert_allclose(out, 1 - expected if invert else expected, atol=1e-5)


@pytest.mark.parametrize("angle", [0, 30, 90, 210])
def test_sobel_of_a_ramp_does_not_depend_on_its_direction(angle: float) -> None:
    y, x = np.mgrid[:20, :20]
    ramp = 0.5 + 0.01 * (x * np.cos(np.radians(angle)) + y * np.sin(np.radians(angle)))
    out = run_luma(style(step("sobel", gain=4)), ramp)
    np.testing.assert_allclose(out[1:-1, 1:-1], 2 * 4 * 0.01, atol=1e-5)


def test_sobel_of_a_full_step_is_its_gain() -> None:
    luma = np.repeat([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]], 6, axis=0)
    out = run_luma(style(step("sobel", gain=0.75)), luma)
    np.testing.assert_allclose(out, np.repeat([[0, 0, 0.75, 0.75, 0, 0]], 6, axis=0), atol=1e-6)


@pytest.mark.parametrize("angle", [135, 0, -60])
def test_relief_of_a_ramp_is_its_slope_towards_the_light(angle: float) -> None:
    rise = np.array([0.02, -0.01])  # to the right, and down
    ramp = (rise[0] * np.arange(12) + rise[1] * np.arange(10)[:, None] + 0.4).astype(np.float32)
    out = run_luma(style(step("relief", depth=8.0, angle=angle)), ramp)
    towards = -np.cos(np.radians(angle)), np.sin(np.radians(angle))
    np.testing.assert_allclose(out[1:-1, 1:-1], 0.5 + 8 * rise @ towards, atol=1e-5)
    beside_border = 0.5 + 8 * (rise[0] / 2 * towards[0] + rise[1] * towards[1])
    np.testing.assert_allclose(out[1:-1, 0], beside_border, atol=1e-5)


def test_sobel_draws_gray_lines_on_a_colour_picture() -> None:
    out = run_color(style(step("sobel")), noise(9, 9, 3))
    np.testing.assert_array_equal(out, np.repeat(out[..., :1], 3, axis=2))


def sector_weights(away: np.ndarray, radius: float) -> np.ndarray:
    """Weights of points in a unit circle, n x 2, in eight sectors, n x 8."""
    lift = 2 / radius
    narrowness = (lift + np.cos(0.58)) / np.sin(0.58) ** 2
    turns = np.arange(8) * np.pi / 4
    ahead = np.outer(away[:, 0], np.cos(turns)) + np.outer(away[:, 1], np.sin(turns))
    aside = np.outer(away[:, 1], np.cos(turns)) - np.outer(away[:, 0], np.sin(turns))
    shares = np.maximum(ahead + lift - narrowness * aside**2, 0) ** 2
    weights = shares / shares.sum(axis=1, keepdims=True) * np.exp(-3.125 * (away**2).sum(axis=1))[:, None]
    return weights / weights.sum(axis=0)


@pytest.mark.parametrize(
    ("radius", "sharpness", "orientation", "size"),
    [(1, 0, 0, 1), (2.3, 3, 5, 1), (4, 2, 11, 1), (8, 1, 22, 1), (12, 2, 3, 3), (23, 1, 17, 5)],
)
def test_kuwahara_is_a_mean_of_means_in_sectors(
    radius: float, sharpness: int, orientation: int, size: int
) -> None:
    """At large radii, squares of pixels share a weight."""
    color, turn = noise(19, 70, 3), orientation * np.pi / 16
    flow = np.zeros((19, 70, 3), np.float32)
    flow[:] = 0.5 + 0.2 * np.cos(turn), 0.5 + 0.2 * np.sin(turn), 1  # the fourth of eight ellipses
    out = np.empty_like(color)
    kuwahara.function(color, (0, 0), out, flow, radius, 0.8, sharpness)
    radius /= size
    rows, columns = (each.reshape(-1) for each in np.mgrid[-16:17, -16:17])
    longer, angle = 1 + 0.8 * 3.5 / 8, turn / 2 + np.pi / 2
    along = (np.cos(angle) * columns + np.sin(angle) * rows) / (radius * longer)
    across = (np.cos(angle) * rows - np.sin(angle) * columns) / (radius / longer)
    inside = along**2 + across**2 <= 1.0001
    weights = sector_weights(np.stack([along, across], axis=1)[inside], radius)
    beyond = 17 * size
    padded = np.pad(color.astype(np.float64), ((beyond, beyond), (beyond, beyond), (0, 0)), mode="edge")
    corners = beyond + size * np.stack([rows, columns], axis=1)[inside]

    def weighted(values: np.ndarray) -> np.ndarray:
        values = cv2.blur(values, (size, size))
        return np.tensordot(weights.T, np.stack([values[y : y + 19, x : x + 70] for y, x in corners]), 1)

    means = weighted(padded)
    variance = (weighted(padded**2) - means**2).sum(axis=3)
    shares = 1 / (1 + (255 * np.maximum(variance, 0)) ** 2**sharpness)
    expected = (shares[..., None] * means).sum(axis=0) / shares.sum(axis=0)[..., None]
    np.testing.assert_allclose(out, expected, atol=0.4 / 255)


@in_one_test("factor", [0.05, 0.33, 0.5, 1, 1.7, 4])
@in_one_test("size", [(1, 1), (2, 9), (37, 41)])
def test_scale_restores_size_and_keeps_flat_colours(factor: float, size: tuple[int, int]) -> None:
    out = run_color(style(step("scale", factor=factor)), np.full((*size, 3), (0.2, 0.5, 0.7)))
    np.testing.assert_allclose(out, np.broadcast_to((0.2, 0.5, 0.7), (*size, 3)), atol=1e-6)


@in_one_test("step_of", [(1, 1), (2, 2), (2, 1), (4, 1)])
@in_one_test("factor", [0.5, 2])
@in_one_test("after", [(), (step("saturation", factor=1.0),)])
def test_scale_moves_nothing(step_of: tuple[int, int], factor: float, after: tuple[Step, ...]) -> None:
    """Ramps and colours keep their position after scaling, whether mixed with luma there or not."""
    y, x = np.mgrid[:48, :64]
    luma = (0.2 + 0.005 * x + 0.004 * y).astype(np.float32)
    encoding = Encoding(depth=0, full_range=True, subsampling=step_of, siting=(0.0, 0.5))
    across, down = step_of
    rows, columns = encoding.chroma_shape(48, 64)
    chroma_y = np.arange(rows)[:, None] * down + (0.5 if down > 1 else 0)
    blue = (0.002 * (np.arange(columns) * across) - 0.003 * chroma_y).astype(np.float32)
    picture = Picture(encoding, luma=luma, chroma=(blue, -blue))
    out = run(style(step("scale", factor=factor, method="area", back="bilinear"), *after), picture)
    assert out.luma is not None and out.chroma is not None
    np.testing.assert_allclose(out.luma[4:-4, 4:-4], luma[4:-4, 4:-4], atol=1e-5)
    np.testing.assert_allclose(out.chroma[0][4:-4, 4:-4], blue[4:-4, 4:-4], atol=1e-5)


def test_scale_enlarges_by_named_method() -> None:
    """Nearest neighbours give blocks of equal pixels; the method of another step has no effect."""
    luma = noise(16, 16)
    small = luma.reshape(4, 4, 4, 4).mean(axis=(1, 3))
    blocks = run_luma(style(step("scale", factor=0.25, back="nearest")), luma)
    np.testing.assert_allclose(blocks, np.kron(small, np.ones((4, 4))), atol=1e-6)
    smooth = run_luma(style(step("scale", factor=0.25, back="bilinear")), luma)
    assert np.abs(smooth - blocks).max() > 0.05


def test_each_layer_enlarges_by_its_method() -> None:
    luma = noise(16, 16)
    small = luma.reshape(4, 4, 4, 4).mean(axis=(1, 3))
    lines = (
        step("brightness", factor=4.0),
        step("scale", factor=0.5, back="bicubic"),
        step("brightness", factor=4.0),
    )
    chosen = style(step("scale", factor=0.25, back="nearest"), lines=lines)
    out = run_luma(chosen, np.full_like(luma, 0.9) * 0 + luma)
    alone = run_luma(style(lines=lines, ink="#000000"), luma)
    np.testing.assert_allclose(out, np.kron(small, np.ones((4, 4))) * alone, atol=1e-5)


def test_filters_after_scale_act_coarser() -> None:
    """A blur of 1 px at half size is about equal to a blur of 2 px."""
    luma = photograph("astronaut")[100:228, 160:288, 1] / 255
    coarse = run_luma(style(step("scale", factor=0.5), step("gaussian", sigma=2)), luma)
    fine, none = (run_luma(style(step("gaussian", sigma=sigma)), luma) for sigma in (4.1, 2))
    assert np.abs(coarse - fine).mean() < 0.2 * np.abs(coarse - none).mean()


@pytest.mark.parametrize(("threshold", "sparsity"), [(4, 1.5), (64, 0), (1, 8)])
def test_contour_weighs_the_gradient_of_all_channels_against_noise_and_clutter(
    threshold: float, sparsity: float
) -> None:
    color, weights = noise(21, 17, 3), np.array([0.2126, 0.7152, 0.0722])
    across = [
        convolved(color[..., each], np.array([[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]])) for each in range(3)
    ]
    down = [convolved(color[..., each], np.array([[-1, -2, -1], [0, 0, 0], [1, 2, 1]])) for each in range(3)]
    squared = np.tensordot(weights, np.square(across) + np.square(down), 1) / 16
    clutter = sparsity * (color @ weights)
    expected = squared / (squared + (threshold / 255) ** 2 + clutter**2)
    out = run_color(style(step("contour", threshold=threshold, sparsity=sparsity)), color)
    np.testing.assert_allclose(out, np.repeat(expected[..., None], 3, axis=2), atol=1e-4)


def test_contour_shows_an_edge_between_colours_of_one_brightness() -> None:
    red, green = [0.6, 0.3, 0.3], [0.3, 0.3 + 0.3 * 0.2126 / 0.7152, 0.3]
    color = np.array([[red] * 4 + [green] * 4] * 6, np.float32)
    weights = np.array([0.2126, 0.7152, 0.0722])
    np.testing.assert_allclose(color @ weights, (color @ weights)[0, 0], atol=1e-3)
    out = run_color(style(step("contour", sparsity=0)), color)[..., 0]
    assert out[:, 3:5].min() > 0.9 and out[:, :3].max() < 1e-3


def test_contour_drops_edges_that_are_no_stronger_than_those_around() -> None:
    alone = np.zeros((9, 40, 3), np.float32)
    alone[:, 20:] = 0.1
    crowded = np.repeat(0.1 * (np.arange(40) // 2 % 2)[None, :, None], 9, axis=0).repeat(3, axis=2)
    steps = (
        step("sobel", gain=1),
        step("gaussian", sigma=4, save="clutter"),
        step("contour", source="source", clutter="clutter", sparsity=3),
    )
    assert run_color(style(*steps), alone).max() > 0.7
    assert run_color(style(*steps), crowded)[:, 12:-12].max() < 0.2


def kept_by_lines(luma: np.ndarray, reach: int) -> np.ndarray:
    """Closing plus opening by lines that begin, end or have their middle at each pixel, minus the picture."""
    rows, columns = np.indices(luma.shape)
    closed, opened = np.full(luma.shape, np.inf), np.full(luma.shape, -np.inf)
    for right, down in [(1, 0), (1, 0.5), (1, 1), (0.5, 1), (0, 1), (-0.5, 1), (-1, 1), (-1, 0.5)]:
        steps = np.rint(reach / np.hypot(right, down))
        shifts = [
            [np.floor(number * steps * part / 6 + 0.5 + 1e-6).astype(int) for part in (down, right)]
            for number in range(-6, 7)
        ]
        points = np.stack(
            [
                luma[np.clip(rows + y, 0, luma.shape[0] - 1), np.clip(columns + x, 0, luma.shape[1] - 1)]
                for y, x in shifts
            ]
        )
        for line in (points[:7], points[6:], points[3:10]):
            closed, opened = np.minimum(closed, line.max(0)), np.maximum(opened, line.min(0))
    return closed + opened - luma


@pytest.mark.parametrize(("length", "reach"), [(2.4, 1), (3, 2), (8.9, 8), (13.5, 13)])
def test_despeckle_closes_and_opens_by_lines(length: float, reach: int) -> None:
    luma = cv2.GaussianBlur(noise(40, 600), (0, 0), 1)
    out = run_luma(style(step("despeckle", length=length, contrast=40)), luma)
    change = kept_by_lines(luma, reach) - luma
    np.testing.assert_allclose(out, luma + change / (1 + (255 / 40 * change) ** 4), atol=1e-6)


def test_despeckle_removes_specks_and_keeps_lines() -> None:
    luma = np.full((60, 60), 0.5, np.float32)
    specks = luma.copy()
    specks[10:14, 10:14], specks[40:44, 20:23] = 0.4, 0.6
    out = run_luma(style(step("despeckle", length=8, contrast=255)), specks)
    np.testing.assert_allclose(out, luma, atol=1e-4)
    strong = np.where(specks == 0.4, 0, luma).astype(np.float32)
    kept = run_luma(style(step("despeckle", length=8, contrast=25)), strong)
    np.testing.assert_allclose(kept, strong, atol=0.01)
    for angle in range(0, 180, 15):
        turn = np.deg2rad(angle)
        rows, columns = np.indices(luma.shape) - 30
        lines = np.where(np.abs(rows * np.cos(turn) - columns * np.sin(turn)) < 1.5, 0, luma)
        out = run_luma(style(step("despeckle", length=8)), lines.astype(np.float32))
        assert out[30, 30] == 0, angle


def test_despeckle_of_length_1_changes_nothing() -> None:
    luma = noise(9, 8)
    np.testing.assert_array_equal(run_luma(style(step("despeckle", length=1)), luma), luma)
