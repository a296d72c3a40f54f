"""Scores of pictures: by built-in metrics, or by a model of the user."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import cv2
import numpy as np

from vidstyle.errors import InputError
from vidstyle.explore.crops.crop_measures import FullSizeMetrics
from vidstyle.explore.paper.rules import Rules

MODEL_FILE = Path(__file__).with_name("score.json")
"""The models fitted by `tools/explore/score.py`, by rules."""
MEASURES: dict[Rules, tuple[str, ...]] = {
    "paper": ("likeness", "tone_concentration", "face_structure"),
    "open": ("structure_kept", "smeared", "face_structure", "parts"),
}
"""What a model reads, of `FullSizeMetrics`: those that agree best with people on unseen pictures."""
WORDS = {
    "likeness": "fine detail",
    "tone_concentration": "flat tones",
    "structure_kept": "structure",
    "smeared": "texture",
    "face_structure": "faces",
    "parts": "the style of its colours",
}
"""The measures that models read, in plain words."""
FACE_MEASURES = {"face_structure"}
"""Those that do not count for pictures without a face."""
MIN_SHOWN_REASON = 0.2
"""Log-odds from which a measure is named in a verdict."""
MAX_SPREADS = 3.0
"""Spreads from the middle beyond which a measure counts no more."""

JUDGE_SIDE_PX = 224
JUDGE_MEAN_LEVEL, JUDGE_LEVEL_DEVIATION = np.array([0.485, 0.456, 0.406]), np.array([0.229, 0.224, 0.225])
"""Normalization of RGB for models trained on ImageNet with PyTorch."""
CLASS_COUNT = 10


def score(measures: FullSizeMetrics, rules: Rules = "open") -> float:
    """Return the probability that people keep a style, 0..1: a logistic regression, fitted to marks.

    Args:
        rules: the rules of the style, each with a separate model.
    """
    return float(1 / (1 + np.exp(-log_odds(read_measures(measures, rules), _models()[rules]))))


def reasons(measures: FullSizeMetrics, rules: Rules = "open") -> dict[str, float]:
    """Return what each measure adds to the log-odds of the score: positive numbers speak for the style."""
    parts = contributions(read_measures(measures, rules), _models()[rules])
    return {name: float(part) for name, part in zip(MEASURES[rules], parts, strict=True)}


def verdict(measures: FullSizeMetrics, rules: Rules = "open") -> str:
    """Return the score in a line, and which measures speak for and against the style."""
    parts = sorted(reasons(measures, rules).items(), key=lambda part: -abs(part[1]))
    sides = {
        "for it": [WORDS[name] for name, part in parts if part >= MIN_SHOWN_REASON],
        "against it": [WORDS[name] for name, part in parts if part <= -MIN_SHOWN_REASON],
    }
    said = [f"{side}: {', '.join(names)}" for side, names in sides.items() if names]
    return "; ".join([f"Score {100 * score(measures, rules):.0f} of 100", *said])


def read_measures(measures: FullSizeMetrics, rules: Rules) -> np.ndarray:
    """Return what the model of some rules reads: NaN for faces if there is none."""
    unseen = set() if measures.has_face else FACE_MEASURES
    return np.array([np.nan if name in unseen else getattr(measures, name) for name in MEASURES[rules]])


def log_odds(numbers: np.ndarray, model: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the log-odds of the score for measures along the last axis.

    Args:
        model: "middle" and "spread" of the measures, the weights "linear", and "bias".
    """
    return np.asarray(contributions(numbers, model).sum(axis=-1) + model["bias"])


def contributions(numbers: np.ndarray, model: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return what each measure adds to the log-odds; NaN adds nothing."""
    normal = np.clip((numbers - model["middle"]) / model["spread"], -MAX_SPREADS, MAX_SPREADS)
    return np.asarray(np.nan_to_num(normal) * model["linear"])


def spread_out(signatures: np.ndarray, scores: np.ndarray, count: int) -> list[int]:
    """Return the indices of the best distinct pictures.

    Farthest-point selection weighted by score: the first is the best; each next one has the largest product
    of its score and its distance to the nearest selected one.
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

    Input: 1 x 3 x 224 x 224 RGB with ImageNet normalization. Output: the shares of ten classes, 1 to 10, or
    one number.

    Raises:
        InputError: the model cannot be read, or has another input or output.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._net = cv2.dnn.readNetFromONNX(str(path))
            classes = self._run(np.zeros((JUDGE_SIDE_PX, JUDGE_SIDE_PX, 3), np.uint8)).size
        except cv2.error as error:
            reason = " ".join(str(error.err or error).split())[:80]
            raise InputError(path, f"is not a model that scores pictures: {reason}") from None
        if classes not in (1, CLASS_COUNT):
            raise InputError(
                path,
                f"returns {classes} numbers instead of one, or of the probabilities of {CLASS_COUNT} classes",
            )

    def __call__(self, picture: np.ndarray) -> float:
        """Return the score of a picture, H x W x 3 uint8; for classes, their mean."""
        given = self._run(picture)
        if given.size == 1:
            return float(given[0])
        shares = given / max(float(given.sum()), 1e-9)
        return float(shares @ np.arange(1, CLASS_COUNT + 1))

    def _run(self, picture: np.ndarray) -> np.ndarray:
        small = cv2.resize(picture, (JUDGE_SIDE_PX, JUDGE_SIDE_PX), interpolation=cv2.INTER_AREA)
        normal = (small / 255.0 - JUDGE_MEAN_LEVEL) / JUDGE_LEVEL_DEVIATION
        self._net.setInput(normal.transpose(2, 0, 1)[None].astype(np.float32))
        return np.asarray(self._net.forward()).reshape(-1)


@cache
def _models() -> dict[str, dict[str, np.ndarray]]:
    models = json.loads(MODEL_FILE.read_text(encoding="utf-8"))
    return {
        rules: {name: np.array(values) for name, values in model.items()} for rules, model in models.items()
    }
