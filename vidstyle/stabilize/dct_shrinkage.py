"""Sliding DCT shrinkage: removes noise, blocks and ringing, and keeps edges."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.kernels import compiled

BLOCK_SIZE = 8
"""Side of a block, as in JPEG."""
THRESHOLD_FACTOR = 2.7
"""Threshold of a coefficient in standard deviations of its noise; the best fidelity on photographs."""

_C1, _C2, _C3, _C4, _C5, _C6, _C7 = (np.float32(0.5 * np.cos(k * np.pi / 16)) for k in range(1, BLOCK_SIZE))


def dct_matrix() -> np.ndarray:
    """Return the matrix of the orthonormal DCT of 8 samples, 8 x 8 float32; a row is a frequency."""
    angles = np.outer(np.arange(BLOCK_SIZE), 2 * np.arange(BLOCK_SIZE) + 1) * np.pi / 16
    scale = np.where(np.arange(BLOCK_SIZE) == 0, np.sqrt(0.125), 0.5)[:, None]
    return np.asarray(scale * np.cos(angles), np.float32)


def shrink(plane: np.ndarray, deviations: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """Return a plane without its noise, H x W float32.

    Each block of 8 x 8 pixels, at every position, loses the DCT coefficients that are below the threshold of
    noise. A pixel becomes the mean of its 64 blocks, weighted by how few coefficients they keep, as in Dabov
    et al. 2007, "Image denoising by sparse 3-D transform-domain collaborative filtering".

    Args:
        plane: H x W float32.
        deviations: standard deviation of the noise at each pixel, H x W float32.
        factors: deviation of the noise at each frequency relative to it, 8 x 8; the first is not used.
    """
    margin = BLOCK_SIZE - 1
    padded = cv2.copyMakeBorder(plane, margin, margin, margin, margin, cv2.BORDER_REFLECT_101)
    local = cv2.blur(deviations, (BLOCK_SIZE, BLOCK_SIZE), borderType=cv2.BORDER_REFLECT_101)
    # Block (y, x) covers rows y - 7 to y of the plane; the blurred deviations are about its centre.
    local = cv2.copyMakeBorder(local, 3, 4, 3, 4, cv2.BORDER_REFLECT_101)
    thresholds = np.ascontiguousarray(THRESHOLD_FACTOR * factors.T, np.float32)
    thresholds[0, 0] = 0
    width = plane.shape[1] + margin
    rows, sums, block = np.zeros((3, BLOCK_SIZE, BLOCK_SIZE, width), np.float32)
    weights = np.zeros((BLOCK_SIZE, width), np.float32)
    kept, numerator, denominator = np.zeros((3, width + margin), np.float32)
    out = np.empty(plane.shape, np.float32)
    _shrink_rows(padded, local, thresholds, rows, sums, block, weights, kept, numerator, denominator, out)
    return out


@compiled(fastmath=True, noalias=True)
def _shrink_rows(  # type: ignore[no-untyped-def]
    padded, deviations, thresholds, rows, sums, block, weights, kept, numerator, denominator, out
):
    """Write rows; `padded` has 7 more of them on both sides, and `sums` and `weights` are zero."""
    width = deviations.shape[1]
    for y in range(7):
        _transform_row(padded[y], rows[y], width)
    for y in range(out.shape[0] + 7):
        _transform_row(padded[y + 7], rows[(y + 7) % 8], width)
        _fill(kept, np.float32(0))
        for k in range(8):
            _threshold(rows, y, k, deviations[y], thresholds, block[k], kept)
        for x in range(width):
            kept[x] = np.float32(1) / max(kept[x], np.float32(1))
        for k in range(8):
            _add_block(block[k], kept, sums, y, k, width)
        for j in range(8):
            _add(weights[(y + j) % 8], kept, 0, width)
        if y >= 7:
            _fill(numerator, np.float32(0))
            _fill(denominator, np.float32(0))
            _invert_row(sums[y % 8], block[0], width)
            for j in range(8):
                _add(numerator, block[0, j], j, width)
                _add(denominator, weights[y % 8], j, width)
            for x in range(out.shape[1]):
                out[y - 7, x] = numerator[x + 7] / denominator[x + 7]
        for k in range(8):
            _fill(sums[y % 8, k], np.float32(0))
        _fill(weights[y % 8], np.float32(0))


@compiled(fastmath=True, noalias=True)
def _fill(row, value):  # type: ignore[no-untyped-def]
    for x in range(row.size):
        row[x] = value


@compiled(fastmath=True, noalias=True)
def _add(total, row, shift, width):  # type: ignore[no-untyped-def]
    for x in range(width):
        total[x + shift] += row[x]


@compiled(fastmath=True, noalias=True)
def _transform_row(row, out, width):  # type: ignore[no-untyped-def]
    """Transform the 8 samples from each position on: coefficient k of position x is `out[k, x]`."""
    a, b, c, d, e, f, g, h = out[0], out[1], out[2], out[3], out[4], out[5], out[6], out[7]
    for x in range(width):
        a[x], b[x], c[x], d[x], e[x], f[x], g[x], h[x] = _transform(
            row[x], row[x + 1], row[x + 2], row[x + 3], row[x + 4], row[x + 5], row[x + 6], row[x + 7]
        )


@compiled(fastmath=True, noalias=True)
def _threshold(rows, y, k, deviations, thresholds, block, count):  # type: ignore[no-untyped-def]
    """Transform 8 rows of coefficients k, write those above the noise, and add their number to `count`."""
    a, b, c, d = rows[y % 8, k], rows[(y + 1) % 8, k], rows[(y + 2) % 8, k], rows[(y + 3) % 8, k]
    e, f, g, h = rows[(y + 4) % 8, k], rows[(y + 5) % 8, k], rows[(y + 6) % 8, k], rows[(y + 7) % 8, k]
    t, u, v, w = thresholds[k, 0], thresholds[k, 1], thresholds[k, 2], thresholds[k, 3]
    i, j, m, n = thresholds[k, 4], thresholds[k, 5], thresholds[k, 6], thresholds[k, 7]
    for x in range(deviations.size):
        noise = deviations[x]
        found = _transform(a[x], b[x], c[x], d[x], e[x], f[x], g[x], h[x])
        p, q, r, s = (
            _above(found[0], noise * t),
            _above(found[1], noise * u),
            _above(found[2], noise * v),
            _above(found[3], noise * w),
        )
        block[0, x], block[1, x], block[2, x], block[3, x] = p, q, r, s
        count[x] += _one(p) + _one(q) + _one(r) + _one(s)
        p, q, r, s = (
            _above(found[4], noise * i),
            _above(found[5], noise * j),
            _above(found[6], noise * m),
            _above(found[7], noise * n),
        )
        block[4, x], block[5, x], block[6, x], block[7, x] = p, q, r, s
        count[x] += _one(p) + _one(q) + _one(r) + _one(s)


@compiled(fastmath=True, noalias=True)
def _above(value, threshold):  # type: ignore[no-untyped-def]
    return value if abs(value) >= threshold else np.float32(0)


@compiled(fastmath=True, noalias=True)
def _one(value):  # type: ignore[no-untyped-def]
    return np.float32(0) if value == 0 else np.float32(1)


@compiled(fastmath=True, noalias=True)
def _add_block(block, weights, sums, y, k, width):  # type: ignore[no-untyped-def]
    """Transform blocks back into 8 rows of coefficients k, and add them to `sums`."""
    a, b, c, d = sums[y % 8, k], sums[(y + 1) % 8, k], sums[(y + 2) % 8, k], sums[(y + 3) % 8, k]
    e, f, g, h = sums[(y + 4) % 8, k], sums[(y + 5) % 8, k], sums[(y + 6) % 8, k], sums[(y + 7) % 8, k]
    for x in range(width):
        p, q, r, s, t, u, v, w = _inverted(block, x)
        weight = weights[x]
        a[x] += weight * p
        b[x] += weight * q
        c[x] += weight * r
        d[x] += weight * s
        e[x] += weight * t
        f[x] += weight * u
        g[x] += weight * v
        h[x] += weight * w


@compiled(fastmath=True, noalias=True)
def _invert_row(row, out, width):  # type: ignore[no-untyped-def]
    a, b, c, d, e, f, g, h = out[0], out[1], out[2], out[3], out[4], out[5], out[6], out[7]
    for x in range(width):
        a[x], b[x], c[x], d[x], e[x], f[x], g[x], h[x] = _inverted(row, x)


@compiled(fastmath=True, noalias=True)
def _transform(a, b, c, d, e, f, g, h):  # type: ignore[no-untyped-def]
    """Return the orthonormal DCT of 8 samples, from sums and differences of mirrored ones."""
    s, t, u, v = a + h, b + g, c + f, d + e
    i, j, k, m = a - h, b - g, c - f, d - e
    p, q, r, w = s + v, t + u, s - v, t - u
    return (
        (p + q) * _C4,
        i * _C1 + j * _C3 + k * _C5 + m * _C7,
        r * _C2 + w * _C6,
        i * _C3 - j * _C7 - k * _C1 - m * _C5,
        (p - q) * _C4,
        i * _C5 - j * _C1 + k * _C7 + m * _C3,
        r * _C6 - w * _C2,
        i * _C7 - j * _C5 + k * _C3 - m * _C1,
    )


@compiled(fastmath=True, noalias=True)
def _inverted(block, x):  # type: ignore[no-untyped-def]
    """Return the 8 samples of the coefficients `block[:, x]`."""
    p, q = (block[0, x] + block[4, x]) * _C4, (block[0, x] - block[4, x]) * _C4
    r, s = block[2, x] * _C2 + block[6, x] * _C6, block[2, x] * _C6 - block[6, x] * _C2
    a, b, c, d = p + r, q + s, q - s, p - r
    k, m, n, o = block[1, x], block[3, x], block[5, x], block[7, x]
    e = k * _C1 + m * _C3 + n * _C5 + o * _C7
    f = k * _C3 - m * _C7 - n * _C1 - o * _C5
    g = k * _C5 - m * _C1 + n * _C7 + o * _C3
    h = k * _C7 - m * _C5 + n * _C3 - o * _C1
    return a + e, b + f, c + g, d + h, d - h, c - g, b - f, a - e
