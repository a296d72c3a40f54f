"""Fit the model of the score to shares of people who kept styles, and compare scores with marks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vidstyle.explore.score import MAX_SPREADS, log_odds

DECAY_FACTOR, NEWTON_STEPS = 3.0, 25
"""What squared weights add to the loss, and steps of Newton's method."""


def fit_model(numbers: np.ndarray, shares: np.ndarray) -> dict[str, np.ndarray]:
    """Return a model for `log_odds`: linear logistic regression, by Newton's method.

    Args:
        numbers: the measures of each style in a row; NaN counts as the mean.
        shares: the share of people who kept each style, 0..1.
    """
    middle, spread = np.nanmean(numbers, axis=0), np.nanstd(numbers, axis=0) + 1e-9
    normal = np.nan_to_num(np.clip((numbers - middle) / spread, -MAX_SPREADS, MAX_SPREADS))
    inputs = np.hstack([normal, np.ones((len(numbers), 1))])
    decay = np.append(np.full(numbers.shape[1], DECAY_FACTOR), 1e-6)
    weights = np.zeros(len(decay))
    for _ in range(NEWTON_STEPS):
        chance = 1 / (1 + np.exp(-inputs @ weights))
        curve = (inputs * (chance * (1 - chance))[:, None]).T @ inputs + np.diag(decay)
        weights -= np.linalg.solve(curve, inputs.T @ (chance - shares) + decay * weights)
    return {"middle": middle, "spread": spread, "linear": weights[:-1], "bias": weights[-1]}


def with_mean(model: Mapping[str, np.ndarray], numbers: np.ndarray, mean: float) -> dict[str, np.ndarray]:
    """Return the model with the bias at which the mean score of some styles is `mean`."""
    bias, odds = 0.0, log_odds(numbers, {**model, "bias": np.array(0.0)})
    for _ in range(NEWTON_STEPS):
        chances = 1 / (1 + np.exp(-odds - bias))
        bias += (mean - chances.mean()) / (chances * (1 - chances)).mean()
    return {**model, "bias": np.array(bias)}


def round_model(model: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Return the model with four significant digits, for JSON."""
    return {name: np.vectorize(lambda x: float(f"{x:.4g}"))(each).tolist() for name, each in model.items()}


def area_under_curve(scores: np.ndarray, kept: np.ndarray, pictures: np.ndarray | None = None) -> float:
    """Return the area under the ROC curve: how often a kept style has a higher score than a rejected one.

    Equal scores count as half.

    Args:
        pictures: the picture of each style, if only styles of one picture are compared.
    """
    pairs = kept[:, None] & ~kept[None]
    if pictures is not None:
        pairs &= pictures[:, None] == pictures[None]
    difference = (scores[:, None] - scores[None])[pairs]
    return float(((difference > 0) + 0.5 * (difference == 0)).mean())
