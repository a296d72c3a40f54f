"""How likely a picture is to be kept: by own measures, or by a model of the user's own."""

from __future__ import annotations

import json
from functools import cache
from itertools import combinations_with_replacement
from pathlib import Path

import cv2
import numpy as np

from vidstyle.errors import InputError
from vidstyle.explore.measure import Measures

MODEL = Path(__file__).with_name("score.json")
"""What `tools/explore/score.py` has fitted."""

JUDGE_SIDE = 224
JUDGE_MEAN, JUDGE_SPREAD = np.array([0.485, 0.456, 0.406]), np.array([0.229, 0.224, 0.225])
"""By which models expect RGB to be normalized that were trained on ImageNet with PyTorch."""
CLASSES = 10


def score(measures: Measures) -> float:
    """How much a picture is like those that shipped styles make, and unlike random ones: 0..1.

    A logistic regression on measures and their products, fitted to both on ten photographs.
    """
    middle, spread, weights = _model()
    exponent = products((np.array(measures) - middle) / spread) @ weights
    return float(1 / (1 + np.exp(-exponent)))


def products(numbers: np.ndarray) -> np.ndarray:
    """1, the numbers along the last axis, and the products of any two of them."""
    pairs = combinations_with_replacement(range(numbers.shape[-1]), 2)
    columns = [numbers[..., one] * numbers[..., other] for one, other in pairs]
    return np.concatenate([np.ones((*numbers.shape[:-1], 1)), numbers, np.stack(columns, -1)], axis=-1)


def fitted_weights(good: np.ndarray, other: np.ndarray, decay: float) -> dict[str, list[float]]:
    """The model that tells good pictures from others, both as rows of measures and of equal weight in all.

    Logistic regression by Newton's method, with squared weights times `decay` added to the loss.
    """
    rows = np.concatenate([good, other])
    middle, spread = rows.mean(0), rows.std(0)
    inputs = products((rows - middle) / spread)
    wanted = np.repeat([1.0, 0.0], [len(good), len(other)])
    shares = np.where(wanted == 1, len(rows) / len(good), len(rows) / len(other)) / 2
    penalty = decay * np.eye(inputs.shape[1])
    penalty[0, 0] = 0
    weights = np.zeros(inputs.shape[1])
    for _ in range(50):
        found = 1 / (1 + np.exp(-inputs @ weights))
        slope = inputs.T @ (shares * (found - wanted)) + penalty @ weights
        bend = (inputs * (shares * found * (1 - found))[:, None]).T @ inputs + penalty
        weights -= np.linalg.solve(bend, slope)
    return {"middle": middle.tolist(), "spread": spread.tolist(), "weights": weights.tolist()}


def spread_out(signatures: np.ndarray, scores: np.ndarray, count: int) -> list[int]:
    """The indices of the best that do not look alike: each is far from all before it, or much better.

    Farthest points by signature, weighted by score: the first is the best, each next one the largest product
    of its score and its distance to the nearest one chosen.
    """
    chosen: list[int] = []
    nearest = np.ones(len(scores))
    worth = np.array(scores, float)
    while len(chosen) < min(count, len(scores)):
        best = int(np.argmax(worth * nearest))
        away = np.linalg.norm(signatures - signatures[best], axis=1)
        nearest = np.minimum(nearest, away) if chosen else away
        worth[best] = -1.0
        chosen.append(best)
    return chosen


class Judge:
    """A model that scores pictures, such as NIMA, as an ONNX file.

    It takes 1 x 3 x 224 x 224 of RGB, normalized as ImageNet's, and gives the shares of ten classes, 1 to 10,
    or one number.

    Raises:
        InputError: it cannot be read, or takes or gives something else.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._net = cv2.dnn.readNetFromONNX(str(path))
            classes = self._run(np.zeros((JUDGE_SIDE, JUDGE_SIDE, 3), np.uint8)).size
        except cv2.error as error:
            reason = " ".join(str(error.err or error).split())[:80]
            raise InputError(path, f"is not a model that can judge: {reason}") from None
        if classes not in (1, CLASSES):
            raise InputError(
                path, f"gives {classes} numbers; a judge gives one, or the shares of {CLASSES} classes"
            )

    def __call__(self, picture: np.ndarray) -> float:
        """The score of a picture, H x W x 3 uint8; of classes their mean."""
        given = self._run(picture)
        if given.size == 1:
            return float(given[0])
        shares = given / max(float(given.sum()), 1e-9)
        return float(shares @ np.arange(1, CLASSES + 1))

    def _run(self, picture: np.ndarray) -> np.ndarray:
        small = cv2.resize(picture, (JUDGE_SIDE, JUDGE_SIDE), interpolation=cv2.INTER_AREA)
        normal = (small / 255.0 - JUDGE_MEAN) / JUDGE_SPREAD
        self._net.setInput(normal.transpose(2, 0, 1)[None].astype(np.float32))
        return np.asarray(self._net.forward()).reshape(-1)


@cache
def _model() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    model = json.loads(MODEL.read_text(encoding="utf-8"))
    return np.array(model["middle"]), np.array(model["spread"]), np.array(model["weights"])
