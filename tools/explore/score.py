"""Fits the score of `vidstyle explore` to marks of people, and says how well it agrees with them.

Usage: python -m tools.explore.score FOLDER KEY.json MARKS.json... [--write]

KEY.json lists the marked styles: number, rules, seed, and picture, a path in FOLDER without its suffix. Each
MARKS.json holds the marks of one person, {"number": "keep" or "reject"}; the majority counts, and ties are
left out. Scores come from models fitted without the picture, and therefore without its styles.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from vidstyle.explore.full_size import FullSize, FullSizeMetrics
from vidstyle.explore.gates import MIN_SCORE, fault
from vidstyle.explore.generate import random_style
from vidstyle.explore.score import MAX_SPREADS, MODEL_FILE, comparable, log_odds
from vidstyle.gallery.preview import read_still

HEIGHT = 1080
"""Height at which pictures are shown."""
LINEAR_DECAY, SQUARE_DECAY, STEPS = 1.0, 3.0, 30
"""What squared weights add to the loss, and steps of Newton's method."""
BEST_SHARE = 0.12
"""Of the styles, whose precision is reported: the best dozen of a hundred."""


def main() -> None:
    """See the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("key", type=Path)
    parser.add_argument("marks", type=Path, nargs="+")
    parser.add_argument("--write", action="store_true", help=f"write {MODEL_FILE.name}")
    options = parser.parse_args()
    people = [json.loads(path.read_text(encoding="utf-8")) for path in options.marks]
    print_agreement(people)
    key = [
        each
        for each in json.loads(options.key.read_text(encoding="utf-8"))
        if majority(people, each["number"])
    ]
    rows, kept = (
        measured(options.folder, key),
        np.array([majority(people, each["number"]) > 0 for each in key]),
    )
    pictures, rules = (np.array([each[name] for each in key]) for name in ("picture", "rules"))
    scores = held_out(rows, kept, pictures)
    passes = np.array([not fault(FullSizeMetrics(*row)) for row in rows])
    passes &= scores >= np.log(MIN_SCORE / (1 - MIN_SCORE))
    print(f"{len(kept)} styles on {len(set(pictures))} pictures, {kept.mean():.0%} kept: ", end="")
    print(f"AUC {area(scores, kept):.3f}")
    for name in sorted(set(rules)):
        of = rules == name
        best = np.argsort(-scores[of])[: round(BEST_SHARE * of.sum())]
        print(f"  {name}: AUC {area(scores[of], kept[of]):.3f}, {kept[of].mean():.0%} kept,"
              f" {kept[of & passes].mean():.0%} of the {(of & passes).sum()} that pass,"
              f" {kept[of][best].mean():.0%} of the best {len(best)}")  # fmt: skip
    if options.write:
        model = {name: np.vectorize(lambda x: float(f"{x:.4g}"))(each).tolist()
                 for name, each in fitted(rows, kept).items()}  # fmt: skip
        MODEL_FILE.write_text(
            json.dumps({"measures": FullSizeMetrics._fields, **model}) + "\n", encoding="utf-8"
        )


def majority(people: Sequence[dict[str, str]], number: int) -> int:
    """Marks to keep minus marks to reject."""
    marks = [each[str(number)] for each in people if str(number) in each]
    return marks.count("keep") - marks.count("reject")


def print_agreement(people: Sequence[dict[str, str]]) -> None:
    """How often two people give the same mark."""
    for one, other in combinations(people, 2):
        both = one.keys() & other.keys()
        same = sum(one[number] == other[number] for number in both)
        print(f"agreement: {same} of {len(both)}")


def measured(folder: Path, key: Sequence[dict[str, Any]]) -> np.ndarray:
    """The full-size metrics of each style on its picture."""

    @cache
    def crops(name: str) -> FullSize:
        picture = read_still(next(folder.glob(f"{name}.*")))
        size = round(picture.shape[1] * HEIGHT / picture.shape[0]), HEIGHT
        return FullSize(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))

    for name in sorted({each["picture"] for each in key}):
        crops(name)
    with ThreadPoolExecutor() as pool:
        rows = pool.map(
            lambda each: crops(each["picture"]).measure(random_style(each["seed"], each["rules"])), key
        )
        return np.array(list(rows))


def held_out(rows: np.ndarray, kept: np.ndarray, pictures: np.ndarray) -> np.ndarray:
    """The log-odds of each row by a model that was fitted to the rows of other pictures."""
    scores = np.zeros(len(rows))
    for name in set(pictures):
        here = pictures == name
        scores[here] = log_odds(rows[here], fitted(rows[~here], kept[~here]))
    return scores


def fitted(rows: np.ndarray, kept: np.ndarray) -> dict[str, np.ndarray]:
    """The model of `log_odds`: logistic regression on measures and their squares, by Newton's method."""
    numbers = comparable(rows)
    middle, spread = numbers.mean(axis=0), numbers.std(axis=0) + 1e-9
    normal = np.clip((numbers - middle) / spread, -MAX_SPREADS, MAX_SPREADS)
    inputs = np.hstack([normal, normal * normal - 1, np.ones((len(rows), 1))])
    count = rows.shape[1]
    decay = np.repeat([LINEAR_DECAY, SQUARE_DECAY, 1e-6], [count, count, 1])
    weights = np.zeros(len(decay))
    for _ in range(STEPS):
        chance = 1 / (1 + np.exp(-inputs @ weights))
        curve = (inputs * (chance * (1 - chance))[:, None]).T @ inputs + np.diag(decay)
        weights -= np.linalg.solve(curve, inputs.T @ (chance - kept) + decay * weights)
    return {"middle": middle, "spread": spread, "linear": weights[:count],
            "square": weights[count:-1], "bias": weights[-1]}  # fmt: skip


def area(scores: np.ndarray, kept: np.ndarray) -> float:
    """The area under the curve of ROC: how often a kept style has a higher score than a rejected one."""
    return float(np.mean(scores[kept][:, None] > scores[~kept][None]))


if __name__ == "__main__":
    main()
