"""Fit the score of `vidstyle explore` to marks of people, and report how well it agrees with them.

Usage: python -m tools.explore.score PICTURES CROPS KEY.json MARKS.json... [--write RULES...]

KEY.json lists the marked crops as `tools/explore/marking.py` writes them: number, rules, the text of the
style, and the picture, a path in PICTURES without its suffix, with the box of the crop. CROPS holds what
people saw, as NUMBER.png. Each MARKS.json holds the marks of one person, {"number": "keep" or "reject"}.
Models are fitted to the share of people who kept a style; it counts as kept if half of them or more did.
Scores come from models fitted without the picture, and therefore without its styles; so do the shares of the
parts of styles by the open rules, see `tools/explore/kept_parts.py`. Rows of KEY.json may name their "set" of
marks: with --latest, the mean score of these sets is the share of people who kept their styles.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tools.explore.kept_parts import score_parts
from tools.explore.logistic_model import area_under_curve, fit_model, round_model, with_mean
from tools.explore.marking import read_picture
from tools.explore.marks import MIN_KEPT_SHARE, Row, kept_share
from vidstyle.explore.crops.crop_measures import ComparedCrop, FullSizeMetrics
from vidstyle.explore.crops.full_size import comparable_faces, sharp_faces
from vidstyle.explore.gates import doubt, fault
from vidstyle.explore.paper.rules import Rules
from vidstyle.explore.score import MEASURES, MODEL_FILE, log_odds, read_measures
from vidstyle.regions.still_faces import StillFaces

BEST_SHARE = 0.12
"""Share of the styles whose precision is reported: the best dozen of a hundred."""


@dataclass(frozen=True)
class MarkedStyles:
    """The marked styles by the same rules.

    Attributes:
        metrics: the metrics of each crop that people saw.
        shares: the share of people who kept each style, 0..1.
        pictures: the name of the picture of each style.
        sets: the name of its set of marks.
    """

    rules: Rules
    metrics: Sequence[FullSizeMetrics]
    shares: np.ndarray
    pictures: np.ndarray
    sets: np.ndarray

    @property
    def numbers(self) -> np.ndarray:
        """What the model reads, one row for each style."""
        return np.array([read_measures(each, self.rules) for each in self.metrics])

    @property
    def kept(self) -> np.ndarray:
        """Whether each style counts as kept."""
        return self.shares >= MIN_KEPT_SHARE


def main() -> None:
    """Fit and report; see the top of the file."""
    options = _parse_options()
    people = [json.loads(path.read_text(encoding="utf-8")) for path in options.marks]
    print_agreement(people)
    key = json.loads(options.key.read_text(encoding="utf-8"))
    key = [each for each in key if any(each["number"] in marks for marks in people)]
    metrics = measure_crops(options.pictures, options.crops, key)
    models = json.loads(MODEL_FILE.read_text(encoding="utf-8"))
    for rules in MEASURES:
        styles = select_styles(rules, key, people, metrics)
        if not styles.metrics:
            continue
        print_rankings(styles, models[rules])
        if rules in options.write:
            model = fit_model(styles.numbers, styles.shares)
            if (latest := np.isin(styles.sets, options.latest)).any():
                model = with_mean(model, styles.numbers[latest], float(styles.shares[latest].mean()))
            models[rules] = round_model(model)
    if options.write:
        MODEL_FILE.write_text(json.dumps(models) + "\n", encoding="utf-8")


def _parse_options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pictures", type=Path)
    parser.add_argument("crops", type=Path)
    parser.add_argument("key", type=Path)
    parser.add_argument("marks", type=Path, nargs="+")
    text = f"rules whose model in {MODEL_FILE.name} is replaced"
    parser.add_argument("--write", nargs="+", default=[], choices=list(MEASURES), help=text)
    parser.add_argument("--latest", nargs="+", default=[], help="sets of marks that the scale comes from")
    return parser.parse_args()


def select_styles(
    rules: Rules,
    key: Sequence[Row],
    people: Sequence[dict[str, str]],
    metrics: Sequence[FullSizeMetrics],
) -> MarkedStyles:
    """Return the styles by some rules; `metrics` has those of each row of `key`."""
    places = [place for place, each in enumerate(key) if each["rules"] == rules]
    rows, measured = [key[place] for place in places], [metrics[place] for place in places]
    if rules == "open":
        parts = score_parts(rows, people)
        measured = [each._replace(parts=part) for each, part in zip(measured, parts, strict=True)]
    return MarkedStyles(
        rules,
        measured,
        np.array([kept_share(people, each["number"]) for each in rows]),
        np.array([each["picture"] for each in rows]),
        np.array([each.get("set", "") for each in rows]),
    )


def print_agreement(people: Sequence[dict[str, str]]) -> None:
    """Print how often two people give the same mark."""
    for one, other in combinations(people, 2):
        both = one.keys() & other.keys()
        same = sum(one[number] == other[number] for number in both)
        if both:
            print(f"agreement: {same} of {len(both)}")


def print_rankings(styles: MarkedStyles, model: Mapping[str, Any]) -> None:
    """Print how the model in use, if it reads the same, and models fitted without the picture rank styles."""
    if len(model["middle"]) == len(MEASURES[styles.rules]):
        used = log_odds(styles.numbers, {name: np.array(values) for name, values in model.items()})
        print(f"{styles.rules}, model in use: {describe_ranking(styles, used)}")
    print(f"{styles.rules}, fitted without the picture: {describe_ranking(styles, score_held_out(styles))}")


def describe_ranking(styles: MarkedStyles, scores: np.ndarray) -> str:
    """Return in a line how well scores agree with marks.

    Args:
        scores: the log-odds of each style.
    """
    kept, chances = styles.kept, 1 / (1 + np.exp(-scores))
    faults = [
        fault(metrics, styles.rules) or doubt(chance, styles.rules)
        for metrics, chance in zip(styles.metrics, chances, strict=True)
    ]
    passes = np.array([not each for each in faults])
    best = np.argsort(-scores)[: round(BEST_SHARE * len(scores))]
    return (
        f"AUC {area_under_curve(scores, kept):.3f}, "
        f"within a picture {area_under_curve(scores, kept, styles.pictures):.3f}, "
        f"{kept.mean():.0%} of {len(kept)} kept, "
        f"{kept[passes].mean():.0%} of the {passes.sum()} that pass, "
        f"{kept[best].mean():.0%} of the best {len(best)}"
    )


def measure_crops(pictures: Path, crops: Path, key: Sequence[Row]) -> list[FullSizeMetrics]:
    """Return the metrics of each crop that people saw."""

    @cache
    def source(name: str, box: tuple[int, ...]) -> ComparedCrop:
        left, top, right, bottom = box
        picture = read_picture(pictures, name)
        found = comparable_faces(StillFaces().find("", lambda: picture), picture.shape[0])
        faces = [face.moved(-left, -top) for face in sharp_faces(found, picture)]
        return ComparedCrop(np.ascontiguousarray(picture[top:bottom, left:right]), faces)

    def measure(each: Row) -> FullSizeMetrics:
        seen = cv2.imread(str(crops / f"{each['number']}.png"))
        assert seen is not None
        crop = source(each["picture"], tuple(each["box"]))
        return crop.measure(np.ascontiguousarray(seen[..., ::-1]))

    with ThreadPoolExecutor() as pool:
        return list(pool.map(measure, key))


def score_held_out(styles: MarkedStyles) -> np.ndarray:
    """Return the log-odds of each style by a model that was fitted to the styles of other pictures."""
    numbers, scores = styles.numbers, np.zeros(len(styles.metrics))
    for name in set(styles.pictures):
        here = styles.pictures == name
        scores[here] = log_odds(numbers[here], fit_model(numbers[~here], styles.shares[~here]))
    return scores


if __name__ == "__main__":
    main()
