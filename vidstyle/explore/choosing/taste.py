"""Taste learned from clicks: predicts which of several pictures the user prefers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

WEIGHT_DEVIATION = 1.0
"""Standard deviation of each weight before the first click; features vary by about 1."""
MAX_NEWTON_STEPS = 30
"""Maximum number of Newton steps; about six are usual."""


class Taste:
    """A linear utility of features, learned from choices with the Bradley-Terry model.

    A choice means that the user prefers the picture to each of the others, with the probability
    1 / (1 + exp(u_other - u_taken)). The weights are the maximum a posteriori estimate with a normal prior.

    >>> taste = Taste(np.zeros(2))
    >>> taste.learn(np.array([1.0, 0.0]), [np.array([0.0, 0.0]), np.array([0.0, 1.0])])
    >>> bool(taste.utility(np.array([1.0, 0.0])) > taste.utility(np.array([0.0, 1.0])))
    True
    """

    def __init__(self, prior: np.ndarray) -> None:
        """`prior`: the weights before the first choice."""
        self._differences = np.empty((0, len(prior)))
        self._prior = self.weights = prior

    def learn(self, taken: np.ndarray, others: Sequence[np.ndarray]) -> None:
        """Record a choice; `taken` and `others` are features, each a vector."""
        self._differences = np.vstack([self._differences, *(taken - each for each in others)])
        self.weights = self._fit(self.weights)

    def utility(self, features: np.ndarray) -> np.ndarray:
        """Return the utility of one or several feature vectors; only differences are meaningful."""
        result: np.ndarray = features @ self.weights
        return result

    def _fit(self, weights: np.ndarray) -> np.ndarray:
        """Return the weights with the highest posterior probability, which is log-concave."""
        inverse = np.eye(len(weights)) / WEIGHT_DEVIATION**2
        for _ in range(MAX_NEWTON_STEPS):
            lost = 1 / (1 + np.exp(np.clip(self._differences @ weights, -50, 50)))
            slope = lost @ self._differences - inverse @ (weights - self._prior)
            bend = (self._differences.T * (lost * (1 - lost))) @ self._differences + inverse
            step = np.linalg.solve(bend, slope)
            weights = weights + step
            if np.abs(step).max() < 1e-6:
                break
        return weights
