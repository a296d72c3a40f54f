"""Face detection by three cascaded networks (Zhang et al. 2016, MTCNN).

The weights come from the package mtcnn (MIT licence), of which no code is used: the networks run in NumPy.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np

from vidstyle.regions.boxes import Box
from vidstyle.regions.face_detection.face_weights import read_weights

Weights = list[np.ndarray]
_PoolingSizes = tuple[tuple[int, bool], ...]

NETWORKS = "pnet", "rnet", "onet"
"""Names of the files with the weights of the proposal, refinement and output networks."""

_WINDOW_SIDE_PX, _WINDOW_STRIDE_PX = 12, 2
"""Side of the window of the first network, and the distance of its windows."""
_PYRAMID_FACTOR = 0.709
"""Factor between the picture sizes of the first network: half the area."""
_INPUT_SIDES_PX = 24, 48
"""Input width and height of the second and third network."""
_POOLING_SIZES = ((3, True), (3, False)), ((3, True), (3, False), (2, True))
"""Sizes of the max pooling of these networks after each convolution except the last; see `_max_pool`."""
_MIN_SCORES = 0.6, 0.5, 0.75
"""Minimum score of each network, 0..1; for the third, the mean over all its views."""
_CONTRAST_LEVELS, _MIN_CONTRAST_LEVELS = 52.0, 8.0
"""Standard deviation of luma to which a face is stretched, and the minimum that is stretched, of 255."""
_SCORED_MARGIN_RATIO = 0.15
"""Margin around a face that is scored, at each side, in its sides."""
MAX_PROPOSALS = 40
"""Maximum number of proposals examined, the best first, where no crowd is searched."""
_MAX_OVERLAP_RATIOS = 0.5, 0.7, 0.7, 0.5
"""Maximum overlap of proposals of one size, of all sizes, after the second and after the third network."""
_MAX_PRODUCT_SIZE = 1 << 17
"""Maximum number of multiplications in one matrix product.

With more, BLAS libraries start their own threads, which busy-wait for the threads that detect other faces."""


def weights_folder() -> Path | None:
    """Return the folder with the weights of the installed package; None if it is not installed."""
    found = find_spec("mtcnn")
    folder = Path(found.origin).parent / "assets" / "weights" if found and found.origin else None
    return folder if folder and all((folder / f"{name}.lz4").is_file() for name in NETWORKS) else None


@cache
def load_networks(folder: Path) -> tuple[Weights, Weights, Weights]:
    """Return the weights of the three networks."""
    first, second, third = (read_weights(folder / f"{name}.lz4") for name in NETWORKS)
    return first, second, third


def find_faces(
    color: np.ndarray,
    networks: tuple[Weights, Weights, Weights],
    least: float,
    max_proposals: int = MAX_PROPOSALS,
) -> np.ndarray:
    """Detect faces in a picture, H x W x 3 uint8 RGB, that are at least `least` pixels high.

    The third network runs twice, the second time on the adjusted boxes, each time on four views of the box:
        for dark, rotated and half-hidden faces the views agree, for other objects they do not.

    Returns:
        Left, top, right and bottom in pixels, the score, 0..1, and the horizontal and vertical positions of
        left eye, right eye, nose, and left and right corner of the mouth: count x 15, the best score first.
    """
    first, second, third = networks
    boxes = _refine(color, _propose(color, first, least)[:max_proposals], second)
    found = _judge(color, boxes, third)
    # Below this score even a perfect second run would not reach the minimum mean.
    found = _suppress_overlaps(found[found[:, 4] > 2 * _MIN_SCORES[2] - 1], _MAX_OVERLAP_RATIOS[3])
    again = _judge(color, _make_square(found), third)
    again[:, 4] = (found[:, 4] + again[:, 4]) / 2
    return _suppress_overlaps(again[again[:, 4] > _MIN_SCORES[2]], _MAX_OVERLAP_RATIOS[3], by_smaller=True)


def score_face(color: np.ndarray, box: Box, networks: tuple[Weights, Weights, Weights]) -> float:
    """Return how much a part of a picture, H x W x 3 uint8, looks like a face to the third network: 0..1."""
    across, down = _SCORED_MARGIN_RATIO * box.width, _SCORED_MARGIN_RATIO * box.height
    square = _make_square(np.array([[*box.padded(across, down, down), 1.0]]))
    return float(_judge(color, square, networks[2])[0, 4])


def _normalize(color: np.ndarray) -> np.ndarray:
    """Convert uint8 pictures to the input range of the networks."""
    return (color - np.float32(127.5)) / np.float32(128)


def _propose(color: np.ndarray, weights: Weights, least: float) -> np.ndarray:
    """Return square boxes that may contain a face, with their scores: count x 5."""
    height, width = color.shape[:2]
    scale, found = _WINDOW_SIDE_PX / least, [np.empty((0, 5))]
    while min(height, width) * scale >= _WINDOW_SIDE_PX:
        size = math.ceil(width * scale), math.ceil(height * scale)
        color = cv2.resize(color, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
        moves, scores = _run_first_network(_normalize(color), weights)
        rows, columns = np.nonzero(scores > _MIN_SCORES[0])
        corners = np.stack([columns, rows, columns, rows], axis=1) * _WINDOW_STRIDE_PX + np.array(
            [0, 0, _WINDOW_SIDE_PX, _WINDOW_SIDE_PX]
        )
        boxes = (corners + moves[rows, columns] * _WINDOW_SIDE_PX) / scale
        scored = np.hstack([boxes, scores[rows, columns, np.newaxis]])
        found.append(_suppress_overlaps(scored, _MAX_OVERLAP_RATIOS[0]))
        scale *= _PYRAMID_FACTOR
    return _make_square(_suppress_overlaps(np.concatenate(found), _MAX_OVERLAP_RATIOS[1]))


def _run_first_network(picture: np.ndarray, weights: Weights) -> tuple[np.ndarray, np.ndarray]:
    """Return the offsets of each window's box (rows x columns x 4) and its score (rows x columns).

    Offsets are in sides of the window.
    """
    values = picture[np.newaxis]
    for number, layer in enumerate(_group(weights[:9], 3)):
        values = _rectify(_convolve(values, *layer[:2]), layer[2])
        values = values if number else _max_pool(values, 2)
    moves, scores = (_convolve(values, *weights[first : first + 2])[0] for first in (9, 11))
    return moves, _probability(scores)


def _refine(color: np.ndarray, boxes: np.ndarray, weights: Weights) -> np.ndarray:
    """Return the adjusted boxes that the second network accepts, as squares, with scores: count x 5."""
    if not len(boxes):
        return boxes
    moves, logits = _run_network(
        [_crop_patch(color, box, _INPUT_SIDES_PX[0]) for box in boxes], weights, _POOLING_SIZES[0]
    )
    moved = np.hstack([_move_edges(boxes, moves), _probability(logits)[:, np.newaxis]])
    return _make_square(_suppress_overlaps(moved[moved[:, 4] > _MIN_SCORES[1]], _MAX_OVERLAP_RATIOS[2]))


def _judge(color: np.ndarray, boxes: np.ndarray, weights: Weights) -> np.ndarray:
    """Return the third network's result for square boxes, the mean over their views; see `find_faces`."""
    if not len(boxes):
        return np.empty((0, 15))
    views = [view for box in boxes for view in _views(_crop_patch(color, box, _INPUT_SIDES_PX[1]))]
    moves, marks, logits = (
        each.reshape(len(boxes), -1, each.shape[1])
        for each in _run_network(views, weights, _POOLING_SIZES[1])
    )
    # Two eyes, a nose and two corners of the mouth: first all positions across, then all positions down.
    places = np.stack([marks[..., :5], marks[..., 5:]], axis=3)
    moves[:, 1::2] = moves[:, 1::2][..., [2, 1, 0, 3]] * (-1, 1, -1, 1)
    places[:, 1::2] = places[:, 1::2][:, :, [1, 0, 2, 4, 3]] * (-1, 1) + (1, 0)
    corners, sides = boxes[:, :2], boxes[:, 2:3] - boxes[:, :1]
    scores = _probability(logits).mean(axis=1, keepdims=True)
    points = corners[:, None] + places.mean(axis=1) * sides[:, None]
    return np.hstack([_move_edges(boxes, moves.mean(axis=1)), scores, points.reshape(len(boxes), -1)])


def _views(patch: np.ndarray) -> Iterator[np.ndarray]:
    """Yield a patch, H x W x 3 uint8, unchanged and with more contrast, each followed by its mirror image."""
    light = patch.mean(axis=2)
    gain = _CONTRAST_LEVELS / max(float(light.std()), _MIN_CONTRAST_LEVELS)
    middle = float(light.mean())
    stretched = (patch - middle) * gain + (middle + 128) / 2
    for view in (patch, stretched.clip(0, 255).astype(np.uint8)):
        yield from (view, view[:, ::-1])


def _run_network(patches: list[np.ndarray], weights: Weights, pooled: _PoolingSizes) -> list[np.ndarray]:
    """Return the outputs of the second or third network for patches of its size: each count x values."""
    values = _normalize(np.stack(patches))
    for place, layer in enumerate(_group(weights[: 3 * len(pooled) + 3], 3)):
        values = _rectify(_convolve(values, *layer[:2]), layer[2])
        values = _max_pool(values, *pooled[place]) if place < len(pooled) else values
    matrix, offset, slope, *heads = weights[3 * len(pooled) + 3 :]
    # The weight matrices have columns before rows.
    flat = values.transpose(0, 2, 1, 3).reshape(len(patches), -1)
    inner = _rectify(_multiply(flat, matrix) + offset, slope)
    return [_multiply(inner, head) + by for head, by in _group(heads, 2)]


def _move_edges(boxes: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return boxes with their edges shifted by fractions of their sides."""
    return np.asarray(boxes[:, :4] + moves * (boxes[:, 2:3] - boxes[:, :1]))


def _crop_patch(color: np.ndarray, box: np.ndarray, side: int) -> np.ndarray:
    """Crop and resize the part of a picture in a square box; gray outside the picture."""
    height, width = color.shape[:2]
    left, top, right, bottom = box[:4].round().astype(int)
    right, bottom = max(right, left + 1), max(bottom, top + 1)
    part = color[max(0, top) : max(0, bottom), max(0, left) : max(0, right)]
    room = max(0, -top), max(0, bottom - height), max(0, -left), max(0, right - width)
    if any(room):
        part = cv2.copyMakeBorder(part, *room, cv2.BORDER_CONSTANT, value=(127, 127, 127))
    return cv2.resize(part, (side, side), interpolation=cv2.INTER_LINEAR)


def _convolve(values: np.ndarray, kernel: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Convolve count x H x W x channels without padding."""
    count, height, width, channels = values.shape
    rows, columns, _, outputs = kernel.shape
    flat = values.reshape(-1, channels)
    length = len(flat) - (rows - 1) * width - (columns - 1)
    # Neighbours in a row are adjacent in memory; values that wrap around to the next row are cut off below.
    adjacent = np.hstack([flat[column : len(flat) - columns + 1 + column] for column in range(columns)])
    result = np.empty((len(flat), outputs), np.float32)
    result[:] = offset
    for row in range(rows):
        part = adjacent[row * width : row * width + length]
        result[:length] += _multiply(part, kernel[row].reshape(-1, outputs))
    return result.reshape(count, height, width, outputs)[:, : height - rows + 1, : width - columns + 1]


def _multiply(values: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Multiply two matrices in blocks of at most `_MAX_PRODUCT_SIZE` multiplications."""
    inner, outputs = matrix.shape
    if inner * outputs > _MAX_PRODUCT_SIZE:
        half = inner // 2
        return _multiply(values[:, :half], matrix[:half]) + _multiply(values[:, half:], matrix[half:])
    rows = _MAX_PRODUCT_SIZE // (inner * outputs)
    whole = len(values) // rows * rows
    parts = np.matmul(values[:whole].reshape(-1, rows, inner), matrix).reshape(whole, outputs)
    return np.concatenate([parts, values[whole:] @ matrix])


def _rectify(values: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Multiply negative values by the slope of their channel, in place."""
    below = np.minimum(values, 0)
    below *= slope.ravel() - 1
    values += below
    return values


def _max_pool(values: np.ndarray, side: int, padded: bool = True) -> np.ndarray:
    """Apply max pooling of `side` x `side` values with stride 2; `padded`: with padding at the end."""
    height, width = values.shape[1:3]
    if padded:
        down, across = (max(0, (math.ceil(each / 2) - 1) * 2 + side - each) for each in (height, width))
        room = (0, 0), (down // 2, down - down // 2), (across // 2, across - across // 2), (0, 0)
        values = np.pad(values, room, constant_values=-np.inf)
        height, width = values.shape[1:3]
    tall, wide = (height - side) // 2 + 1, (width - side) // 2 + 1
    parts = [
        values[:, row : row + 2 * tall - 1 : 2, column : column + 2 * wide - 1 : 2]
        for row in range(side)
        for column in range(side)
    ]
    best = parts[0]
    for part in parts[1:]:
        best = np.maximum(best, part)
    return best


def _probability(values: np.ndarray) -> np.ndarray:
    """Return the softmax of two values in the last axis: the probability of the second."""
    return 1 / (1 + np.exp(np.clip(values[..., 0] - values[..., 1], -80, 80)))


def _make_square(boxes: np.ndarray) -> np.ndarray:
    """Return boxes as squares around the same centres, with their scores."""
    middle = (boxes[:, :2] + boxes[:, 2:4]) / 2
    half = (boxes[:, 2:4] - boxes[:, :2]).max(axis=1, keepdims=True) / 2
    return np.hstack([middle - half, middle + half, boxes[:, 4:]])


def _suppress_overlaps(boxes: np.ndarray, most: float, by_smaller: bool = False) -> np.ndarray:
    """Return the best boxes that overlap by at most `most`, the best first (non-maximum suppression).

    The overlap is relative to the union of both boxes, or with `by_smaller` to the smaller one.
    """
    order = np.argsort(-boxes[:, 4], kind="stable")
    areas = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
    kept: list[int] = []
    while len(order):
        best, order = int(order[0]), order[1:]
        kept.append(best)
        low, high = (
            np.maximum(boxes[best, :2], boxes[order, :2]),
            np.minimum(boxes[best, 2:4], boxes[order, 2:4]),
        )
        common = np.prod(np.maximum(0, high - low), axis=1)
        both = np.minimum(areas[best], areas[order]) if by_smaller else areas[best] + areas[order] - common
        order = order[common <= most * both]
    return boxes[kept]


def _group(weights: Weights, size: int) -> Iterator[tuple[np.ndarray, ...]]:
    """Yield the weights of each layer."""
    return zip(*[iter(weights)] * size, strict=True)
