"""Fit the score of `vidstyle explore` to marks of people, and report how well it agrees with them.

Usage: python -m tools.explore.score PICTURES CROPS KEY.json MARKS.json... [--write RULES...]

KEY.json lists the marked crops as `tools/explore/marking.py` writes them: number, rules, and the picture, a
path in PICTURES without its suffix, with the box of the crop. CROPS holds what people saw, as NUMBER.png.
Each MARKS.json holds the marks of one person, {"number": "keep" or "reject"}. Models are fitted to the share
of people who kept a style; it counts as kept if half of them or more did. Scores come from models fitted
without the picture, and therefore without its styles.
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

from tools.explore.marking import shown_picture
from vidstyle.explore.crops.crop_measures import ComparedCrop, FullSizeMetrics
from vidstyle.explore.crops.full_size import comparable_faces
from vidstyle.explore.gates import MIN_SCORES, fault
from vidstyle.explore.paper.rules import Rules
from vidstyle.explore.score import MAX_SPREADS, MEASURES, MODEL_FILE, log_odds
from vidstyle.regions.still_faces import StillFaces

DECAY, STEPS = 3.0, 25
"""What squared weights add to the loss, and steps of Newton's method."""
BEST_SHARE = 0.12
"""Of the styles, whose precision is reported: the best dozen of a hundred."""


def main() -> None:
    """See the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pictures", type=Path)
    parser.add_argument("crops", type=Path)
    parser.add_argument("key", type=Path)
    parser.add_argument("marks", type=Path, nargs="+")
    parser.add_argument(
        "--write",
        nargs="+",
        default=[],
        choices=list(MEASURES),
        help=f"rules whose model {MODEL_FILE.name} gets",
    )
    options = parser.parse_args()
    people = [json.loads(path.read_text(encoding="utf-8")) for path in options.marks]
    print_agreement(people)
    key = json.loads(options.key.read_text(encoding="utf-8"))
    key = [each for each in key if any(each["number"] in marks for marks in people)]
    metrics = measured(options.pictures, options.crops, key)
    models = json.loads(MODEL_FILE.read_text(encoding="utf-8"))
    for rules, names in MEASURES.items():
        here = [place for place, each in enumerate(key) if each["rules"] == rules]
        if not here:
            continue
        shares = np.array([kept_share(people, key[place]["number"]) for place in here])
        pictures = np.array([key[place]["picture"] for place in here])
        rows = np.array([[getattr(metrics[place], name) for name in names] for place in here])
        scores = held_out(rows, shares, pictures)
        print(f"{rules}, model in use: ", end="")
        model = {name: np.array(values) for name, values in models[rules].items()}
        report(rules, log_odds(rows, model), shares >= 0.5, pictures, [metrics[place] for place in here])
        print(f"{rules}, fitted without the picture: ", end="")
        report(rules, scores, shares >= 0.5, pictures, [metrics[place] for place in here])
        if rules in options.write:
            models[rules] = {name: np.vectorize(lambda x: float(f"{x:.4g}"))(each).tolist()
                             for name, each in fitted(rows, shares).items()}  # fmt: skip
    if options.write:
        MODEL_FILE.write_text(json.dumps(models) + "\n", encoding="utf-8")


def report(
    rules: Rules,
    scores: np.ndarray,
    kept: np.ndarray,
    pictures: np.ndarray,
    metrics: Sequence[FullSizeMetrics],
) -> None:
    """Print how well scores of unseen pictures agree with marks."""
    passes = np.array([not fault(each, rules) for each in metrics]) & (
        scores >= np.log(MIN_SCORES[rules] / (1 - MIN_SCORES[rules]))
    )
    best = np.argsort(-scores)[: round(BEST_SHARE * len(scores))]
    print(
        f"AUC {area(scores, kept):.3f}, within a picture {area(scores, kept, pictures):.3f}, "
        f"{kept.mean():.0%} of {len(kept)} kept, "
        f"{kept[passes].mean():.0%} of the {passes.sum()} that pass, "
        f"{kept[best].mean():.0%} of the best {len(best)}"
    )


def kept_share(people: Sequence[dict[str, str]], number: str) -> float:
    """The share of people who kept a style, of those who marked it."""
    marks = [each[str(number)] for each in people if str(number) in each]
    return marks.count("keep") / len(marks)


def print_agreement(people: Sequence[dict[str, str]]) -> None:
    """How often two people give the same mark."""
    for one, other in combinations(people, 2):
        both = one.keys() & other.keys()
        same = sum(one[number] == other[number] for number in both)
        if both:
            print(f"agreement: {same} of {len(both)}")


def measured(pictures: Path, crops: Path, key: Sequence[dict[str, Any]]) -> list[FullSizeMetrics]:
    """The metrics of each crop that people saw."""

    @cache
    def compared(name: str, box: tuple[int, ...]) -> ComparedCrop:
        left, top, right, bottom = box
        picture = shown_picture(pictures, name)
        found = comparable_faces(StillFaces().find("", lambda: picture), picture.shape[0])
        faces = [face.moved(-left, -top) for face in found]
        return ComparedCrop(np.ascontiguousarray(picture[top:bottom, left:right]), faces)

    def measure(each: dict[str, Any]) -> FullSizeMetrics:
        seen = cv2.imread(str(crops / f"{each['number']}.png"))
        assert seen is not None
        return compared(each["picture"], tuple(each["box"])).measure(np.ascontiguousarray(seen[..., ::-1]))

    with ThreadPoolExecutor() as pool:
        return list(pool.map(measure, key))


def held_out(rows: np.ndarray, shares: np.ndarray, pictures: np.ndarray) -> np.ndarray:
    """The log-odds of each row by a model that was fitted to the rows of other pictures."""
    scores = np.zeros(len(rows))
    for name in set(pictures):
        here = pictures == name
        scores[here] = log_odds(rows[here], fitted(rows[~here], shares[~here]))
    return scores


def fitted(rows: np.ndarray, kept: np.ndarray) -> dict[str, np.ndarray]:
    """The model of `log_odds`: linear logistic regression, by Newton's method.

    Args:
        kept: the share of people who kept each style, 0..1.
    """
    middle, spread = rows.mean(axis=0), rows.std(axis=0) + 1e-9
    normal = np.clip((rows - middle) / spread, -MAX_SPREADS, MAX_SPREADS)
    inputs = np.hstack([normal, np.ones((len(rows), 1))])
    decay = np.append(np.full(rows.shape[1], DECAY), 1e-6)
    weights = np.zeros(len(decay))
    for _ in range(STEPS):
        chance = 1 / (1 + np.exp(-inputs @ weights))
        curve = (inputs * (chance * (1 - chance))[:, None]).T @ inputs + np.diag(decay)
        weights -= np.linalg.solve(curve, inputs.T @ (chance - kept) + decay * weights)
    return {"middle": middle, "spread": spread, "linear": weights[:-1], "bias": weights[-1]}


def area(scores: np.ndarray, kept: np.ndarray, pictures: np.ndarray | None = None) -> float:
    """The area under the curve of ROC: how often a kept style has a higher score than a rejected one.

    Args:
        pictures: the picture of each style, if only styles of one picture are compared.
    """
    pairs = kept[:, None] & ~kept[None]
    if pictures is not None:
        pairs &= pictures[:, None] == pictures[None]
    return float((scores[:, None] > scores[None])[pairs].mean())


if __name__ == "__main__":
    main()
