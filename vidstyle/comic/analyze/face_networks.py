"""Face detection by three cascaded networks (Zhang et al. 2016, MTCNN).

The weights come from the package mtcnn (MIT licence), of which nothing else is used; the networks run here,
in NumPy.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np

Weights = list[np.ndarray]
_Pooling = tuple[tuple[int, bool], ...]

NETWORKS = "pnet", "rnet", "onet"
"""Files of the weights: of proposals, of refinement and of the final output."""

_CELL, _STRIDE = 12, 2
"""Side of the window that the first network sees, and the distance of its windows, in pixels."""
_PYRAMID = 0.709
"""Factor between the sizes that the first network is run on: half the area."""
_SIDES = 24, 48
"""Sides of the pictures that the second and third network see."""
_POOLED = ((3, True), (3, False)), ((3, True), (3, False), (2, True))
"""Sizes of the largest values that these take after each convolution but the last; see `_largest`."""
_SURE = 0.6, 0.5, 0.75
"""Minimum score of each network, 0..1; of the third, on average of all its looks."""
_CONTRAST, _LEAST_CONTRAST = 52.0, 8.0
"""The standard deviation of light to which a face is stretched, and the least that is stretched, of 255."""
_MOST = 40
"""Proposals that are looked at, the best."""
_OVERLAP = 0.5, 0.7, 0.7, 0.5
"""Maximum overlap of proposals of one size, of all sizes, after the second and after the third network."""
_PRODUCT = 1 << 17
"""Multiplications in one product of matrices: with more, libraries of linear algebra start threads of their
own, which wait in loops for the threads that look for other faces."""


def weights_folder() -> Path | None:
    """Where the weights of the installed package are; None if it is not installed."""
    found = find_spec("mtcnn")
    folder = Path(found.origin).parent / "assets" / "weights" if found and found.origin else None
    return folder if folder and all((folder / f"{name}.lz4").is_file() for name in NETWORKS) else None


@cache
def load_networks(folder: Path) -> tuple[Weights, Weights, Weights]:
    """The weights of the three networks."""
    first, second, third = (_load_weights(folder / f"{name}.lz4") for name in NETWORKS)
    return first, second, third


def _load_weights(path: Path) -> Weights:
    import joblib
    import lz4.frame

    # Given the path, joblib closes the file before its own reader of lz4: Python 3.13 reports that.
    with lz4.frame.open(path) as file:
        return joblib.load(file)


def find_faces(color: np.ndarray, networks: tuple[Weights, Weights, Weights], least: float) -> np.ndarray:
    """Faces in a picture, H x W x 3 uint8 RGB, that are at least so many pixels high.

    The third network looks twice, the second time where it has moved a box, and each time at four views of
    it: dark, turned and half hidden faces differ from other things in what all of them say.

    Returns:
        Left, top, right and bottom in pixels, the score, 0..1, and the middle of the mouth, across and down,
        of each: count x 7, the surest first.
    """
    first, second, third = networks
    boxes = _refined(color, _proposals(color, first, least), second)
    found = _judged(color, boxes, third)
    # Of less, not even a second look that is quite sure makes a face.
    found = _without_doubles(found[found[:, 4] > 2 * _SURE[2] - 1], _OVERLAP[3])
    again = _judged(color, _square(found), third)
    again[:, 4] = (found[:, 4] + again[:, 4]) / 2
    return _without_doubles(again[again[:, 4] > _SURE[2]], _OVERLAP[3], by_smaller=True)


def _normalized(color: np.ndarray) -> np.ndarray:
    """Pictures of uint8 as the networks expect them."""
    return (color - np.float32(127.5)) / np.float32(128)


def _proposals(color: np.ndarray, weights: Weights, least: float) -> np.ndarray:
    """Square boxes that may hold a face, with their scores: count x 5."""
    height, width = color.shape[:2]
    scale, found = _CELL / least, [np.empty((0, 5))]
    while min(height, width) * scale >= _CELL:
        size = math.ceil(width * scale), math.ceil(height * scale)
        color = cv2.resize(color, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
        moves, scores = _first_network(_normalized(color), weights)
        rows, columns = np.nonzero(scores > _SURE[0])
        corners = np.stack([columns, rows, columns, rows], axis=1) * _STRIDE + np.array([0, 0, _CELL, _CELL])
        boxes = (corners + moves[rows, columns] * _CELL) / scale
        scored = np.hstack([boxes, scores[rows, columns, np.newaxis]])
        found.append(_without_doubles(scored, _OVERLAP[0]))
        scale *= _PYRAMID
    return _square(_without_doubles(np.concatenate(found), _OVERLAP[1])[:_MOST])


def _first_network(picture: np.ndarray, weights: Weights) -> tuple[np.ndarray, np.ndarray]:
    """How the box of each window moves, in cells (rows x columns x 4), and its score (rows x columns)."""
    values = picture[np.newaxis]
    for number, layer in enumerate(_grouped(weights[:9], 3)):
        values = _rectified(_convolved(values, *layer[:2]), layer[2])
        values = values if number else _largest(values, 2)
    moves, scores = (_convolved(values, *weights[first : first + 2])[0] for first in (9, 11))
    return moves, _probability(scores)


def _refined(color: np.ndarray, boxes: np.ndarray, weights: Weights) -> np.ndarray:
    """What the second network keeps of square boxes, moved, scored and square again: count x 5."""
    if not len(boxes):
        return boxes
    moves, logits = _outputs([_patch(color, box, _SIDES[0]) for box in boxes], weights, _POOLED[0])
    moved = np.hstack([_moved(boxes, moves), _probability(logits)[:, np.newaxis]])
    return _square(_without_doubles(moved[moved[:, 4] > _SURE[1]], _OVERLAP[2]))


def _judged(color: np.ndarray, boxes: np.ndarray, weights: Weights) -> np.ndarray:
    """What the third network says of square boxes, on average of their views; see `find_faces`."""
    if not len(boxes):
        return np.empty((0, 7))
    views = [view for box in boxes for view in _views(_patch(color, box, _SIDES[1]))]
    moves, marks, logits = (
        each.reshape(len(boxes), -1, each.shape[1]) for each in _outputs(views, weights, _POOLED[1])
    )
    # Of two eyes, a nose and two corners of the mouth, first all places across, then all down.
    mouths = np.stack([marks[..., 3:5].mean(axis=2), marks[..., 8:10].mean(axis=2)], axis=2)
    moves[:, 1::2] = moves[:, 1::2][..., [2, 1, 0, 3]] * (-1, 1, -1, 1)
    mouths[:, 1::2, 0] = 1 - mouths[:, 1::2, 0]
    corners, sides = boxes[:, :2], boxes[:, 2:3] - boxes[:, :1]
    scores = _probability(logits).mean(axis=1, keepdims=True)
    return np.hstack([_moved(boxes, moves.mean(axis=1)), scores, corners + mouths.mean(axis=1) * sides])


def _views(patch: np.ndarray) -> Iterator[np.ndarray]:
    """A patch, H x W x 3 uint8, as it is and with more contrast, each followed by its mirror image."""
    light = patch.mean(axis=2)
    gain = _CONTRAST / max(float(light.std()), _LEAST_CONTRAST)
    middle = float(light.mean())
    stretched = (patch - middle) * gain + (middle + 128) / 2
    for view in (patch, stretched.clip(0, 255).astype(np.uint8)):
        yield from (view, view[:, ::-1])


def _outputs(patches: list[np.ndarray], weights: Weights, pooled: _Pooling) -> list[np.ndarray]:
    """The outputs of the second or third network for patches of its size: each count x values."""
    values = _normalized(np.stack(patches))
    for place, layer in enumerate(_grouped(weights[: 3 * len(pooled) + 3], 3)):
        values = _rectified(_convolved(values, *layer[:2]), layer[2])
        values = _largest(values, *pooled[place]) if place < len(pooled) else values
    matrix, offset, slope, *heads = weights[3 * len(pooled) + 3 :]
    # The matrices were made for columns before rows.
    flat = values.transpose(0, 2, 1, 3).reshape(len(patches), -1)
    inner = _rectified(_product(flat, matrix) + offset, slope)
    return [_product(inner, head) + by for head, by in _grouped(heads, 2)]


def _moved(boxes: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Square boxes whose edges move by shares of their sides."""
    return np.asarray(boxes[:, :4] + moves * (boxes[:, 2:3] - boxes[:, :1]))


def _patch(color: np.ndarray, box: np.ndarray, side: int) -> np.ndarray:
    """The part of a picture in a square box at another size; gray beyond the edges."""
    height, width = color.shape[:2]
    left, top, right, bottom = box[:4].round().astype(int)
    right, bottom = max(right, left + 1), max(bottom, top + 1)
    part = color[max(0, top) : max(0, bottom), max(0, left) : max(0, right)]
    room = max(0, -top), max(0, bottom - height), max(0, -left), max(0, right - width)
    if any(room):
        part = cv2.copyMakeBorder(part, *room, cv2.BORDER_CONSTANT, value=(127, 127, 127))
    return cv2.resize(part, (side, side), interpolation=cv2.INTER_LINEAR)


def _convolved(values: np.ndarray, kernel: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Convolution of count x H x W x channels without a border."""
    count, height, width, channels = values.shape
    rows, columns, _, outputs = kernel.shape
    flat = values.reshape(-1, channels)
    length = len(flat) - (rows - 1) * width - (columns - 1)
    # Neighbours in a row lie side by side in memory; what wraps around to the next row is cut off below.
    beside = np.hstack([flat[column : len(flat) - columns + 1 + column] for column in range(columns)])
    result = np.empty((len(flat), outputs), np.float32)
    result[:] = offset
    for row in range(rows):
        part = beside[row * width : row * width + length]
        result[:length] += _product(part, kernel[row].reshape(-1, outputs))
    return result.reshape(count, height, width, outputs)[:, : height - rows + 1, : width - columns + 1]


def _product(values: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """The product of two matrices, in parts of at most `_PRODUCT` multiplications."""
    inner, outputs = matrix.shape
    if inner * outputs > _PRODUCT:
        half = inner // 2
        return _product(values[:, :half], matrix[:half]) + _product(values[:, half:], matrix[half:])
    rows = _PRODUCT // (inner * outputs)
    whole = len(values) // rows * rows
    parts = np.matmul(values[:whole].reshape(-1, rows, inner), matrix).reshape(whole, outputs)
    return np.concatenate([parts, values[whole:] @ matrix])


def _rectified(values: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Negative values times the slope of their channel; changed in place."""
    below = np.minimum(values, 0)
    below *= slope.ravel() - 1
    values += below
    return values


def _largest(values: np.ndarray, side: int, padded: bool = True) -> np.ndarray:
    """The largest of each `side` x `side` values, at every second place; `padded`: beyond the end, too."""
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
    """Softmax of two values in the last axis: the share of the second."""
    return 1 / (1 + np.exp(np.clip(values[..., 0] - values[..., 1], -80, 80)))


def _square(boxes: np.ndarray) -> np.ndarray:
    """Boxes as squares around the same centres, with their scores."""
    middle = (boxes[:, :2] + boxes[:, 2:4]) / 2
    half = (boxes[:, 2:4] - boxes[:, :2]).max(axis=1, keepdims=True) / 2
    return np.hstack([middle - half, middle + half, boxes[:, 4:]])


def _without_doubles(boxes: np.ndarray, most: float, by_smaller: bool = False) -> np.ndarray:
    """The best boxes that overlap by no more: shares of both together, or of the smaller; the best first."""
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


def _grouped(weights: Weights, size: int) -> Iterator[tuple[np.ndarray, ...]]:
    """The weights of each layer."""
    return zip(*[iter(weights)] * size, strict=True)
