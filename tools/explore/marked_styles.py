"""Marked random styles, what the score reads of them, and models fitted to some of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tools.explore.kept_parts import parts_of, score_held_out, score_names, shares_of
from tools.explore.logistic_model import fit_model, with_mean
from tools.explore.marks import MIN_KEPT_SHARE, Row, kept_share
from vidstyle.explore.crops.crop_measures import FullSizeMetrics
from vidstyle.explore.paper.rules import Rules
from vidstyle.explore.score import MEASURES, log_odds, read_measures


@dataclass(frozen=True)
class MarkedStyles:
    """The marked styles by the same rules.

    Attributes:
        metrics: the metrics of each crop that people saw.
        shares: the share of people who kept each style, 0..1.
        pictures: the name of the picture of each style.
        sets: the name of its set of marks.
        colors: the shipped style of its colours, by the open rules.
        latest: whether it is of the sets that the scale of scores comes from.
    """

    rules: Rules
    metrics: Sequence[FullSizeMetrics]
    shares: np.ndarray
    pictures: np.ndarray
    sets: np.ndarray
    colors: np.ndarray
    latest: np.ndarray

    def read_numbers(self, fitted: np.ndarray) -> np.ndarray:
        """Return what a model that is fitted to some of the styles reads, one row for each style.

        Kept shares of colours come from these styles too: for each, from the styles of other pictures.
        """
        numbers = np.array([read_measures(each, self.rules) for each in self.metrics])
        if "parts" in (names := MEASURES[self.rules]):
            part, used = numbers[:, names.index("parts")], (self.colors[fitted].tolist(), self.shares[fitted])
            part[~fitted] = score_names(self.colors[~fitted].tolist(), shares_of(*used))
            part[fitted] = score_held_out(*used, self.pictures[fitted])
        return numbers

    def fit(self, numbers: np.ndarray, fitted: np.ndarray) -> dict[str, np.ndarray]:
        """Return the model fitted to some of the styles, on the scale of the latest of them."""
        model, latest = fit_model(numbers[fitted], self.shares[fitted]), self.latest & fitted
        return with_mean(model, numbers[latest], float(self.shares[latest].mean())) if latest.any() else model

    @property
    def kept(self) -> np.ndarray:
        """Whether each style counts as kept."""
        return self.shares >= MIN_KEPT_SHARE


def select_styles(
    rules: Rules,
    key: Sequence[Row],
    people: Sequence[dict[str, str]],
    metrics: Sequence[FullSizeMetrics],
    latest: Sequence[str],
) -> MarkedStyles:
    """Return the styles by some rules; `metrics` belong to rows of `key`, `latest` names the latest sets."""
    places = [place for place, each in enumerate(key) if each["rules"] == rules]
    rows = [key[place] for place in places]
    sets = np.array([each.get("set", "") for each in rows])
    return MarkedStyles(
        rules,
        [metrics[place] for place in places],
        np.array([kept_share(people, each["number"]) for each in rows]),
        np.array([each["picture"] for each in rows]),
        sets,
        np.array([parts_of(each)["colors"] if rules == "open" else "" for each in rows]),
        np.isin(sets, latest),
    )


def score_without(styles: MarkedStyles, groups: np.ndarray) -> np.ndarray:
    """Return the log-odds of each style by a model that was fitted to the styles of other groups."""
    scores = np.zeros(len(groups))
    for name in set(groups):
        here = groups == name
        numbers = styles.read_numbers(~here)
        scores[here] = log_odds(numbers[here], styles.fit(numbers, ~here))
    return scores
