"""Taste learned from clicks: which of several pictures somebody would take."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

SPREAD = 1.0
"""Standard deviation of each weight before the first click; features vary by about 1."""
STEPS = 30
"""Most steps of Newton's method; it takes about six."""


class Taste:
    """A linear utility of features, learned from choices by the model of Bradley and Terry.

    Whoever takes one picture out of several prefers it to each of the others, with the probability
    1 / (1 + exp(u_other - u_taken)). The weights are the most probable ones, with a normal prior.

    >>> taste = Taste(2)
    >>> taste.learn(np.array([1.0, 0.0]), [np.array([0.0, 0.0]), np.array([0.0, 1.0])])
    >>> taste.utility(np.array([1.0, 0.0])) > taste.utility(np.array([0.0, 1.0]))
    True
    """

    def __init__(self, features: int) -> None:
        self._differences = np.empty((0, features))
        self._strengths = np.empty(0)
        self.weights = np.zeros(features)

    def learn(self, taken: np.ndarray, others: Sequence[np.ndarray], strength: float = 1.0) -> None:
        """Record a choice.

        Args:
            taken, others: features, each a vector.
            strength: how much the choice counts.
        """
        if not others:
            return
        self._differences = np.vstack([self._differences, taken - np.array(others)])
        self._strengths = np.append(self._strengths, np.full(len(others), strength))
        self.weights = self._fitted(self.weights)

    def utility(self, features: np.ndarray) -> np.ndarray:
        """What the features are worth, for one vector or each of several; only differences mean anything."""
        result: np.ndarray = features @ self.weights
        return result

    def _fitted(self, weights: np.ndarray) -> np.ndarray:
        """The weights of the highest posterior probability, which is log-concave."""
        prior = np.eye(len(weights)) / SPREAD**2
        for _ in range(STEPS):
            lost = 1 / (1 + np.exp(np.clip(self._differences @ weights, -50, 50)))
            slope = (lost * self._strengths) @ self._differences - prior @ weights
            bend = (self._differences.T * (lost * (1 - lost) * self._strengths)) @ self._differences + prior
            step = np.linalg.solve(bend, slope)
            weights = weights + step
            if np.abs(step).max() < 1e-6:
                break
        return weights
