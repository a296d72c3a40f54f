"""Fit the score of `vidstyle explore` to marks of people, and report how well it agrees with them.

Usage: python -m tools.explore.score PICTURES CROPS KEY.json MARKS.json... [--write RULES...]

KEY.json lists the marked crops as `tools/explore/marking.py` writes them: number, rules, the text of the
style, and the picture, a path in PICTURES without its suffix, with the box of the crop. CROPS holds what
people saw, as NUMBER.png. Each MARKS.json holds the marks of one person, {"number": "keep" or "reject"}.
Models are fitted to the share of people who kept a style; it counts as kept if half of them or more did.
Scores come from models fitted without the picture, or without its set of marks as rows of KEY.json may name
it; so do the shares of the colours of styles by the open rules, see `tools/explore/kept_parts.py`. With
--latest, the mean score of these sets is the share of people who kept their styles.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tools.explore.logistic_model import area_under_curve, round_model
from tools.explore.marked_styles import MarkedStyles, score_without, select_styles
from tools.explore.marking import read_picture
from tools.explore.marks import Row
from vidstyle.explore.crops.crop_measures import ComparedCrop, FullSizeMetrics
from vidstyle.explore.crops.full_size import comparable_faces, sharp_faces
from vidstyle.explore.gates import doubt, fault
from vidstyle.explore.score import MEASURES, MODEL_FILE, log_odds
from vidstyle.regions.still_faces import StillFaces

BEST_SHARE = 0.12
"""Share of the styles whose precision is reported: the best dozen of a hundred."""


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
        styles = select_styles(rules, key, people, metrics, options.latest)
        if not styles.metrics:
            continue
        everything = np.full(len(styles.metrics), True)
        numbers = styles.read_numbers(everything)
        print_rankings(styles, numbers, models[rules])
        if rules in options.write:
            models[rules] = round_model(styles.fit(numbers, everything))
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


def print_agreement(people: Sequence[dict[str, str]]) -> None:
    """Print how often two people give the same mark."""
    for one, other in combinations(people, 2):
        both = one.keys() & other.keys()
        same = sum(one[number] == other[number] for number in both)
        if both:
            print(f"agreement: {same} of {len(both)}")


def print_rankings(styles: MarkedStyles, numbers: np.ndarray, model: Mapping[str, Any]) -> None:
    """Print how the model in use, if it reads the same, and models fitted to other styles rank styles."""
    if len(model["middle"]) == len(MEASURES[styles.rules]):
        used = log_odds(numbers, {name: np.array(values) for name, values in model.items()})
        print_ranking(styles, "model in use", used)
    for name, groups in {"the picture": styles.pictures, "the set": styles.sets}.items():
        if len(set(groups)) > 1:
            print_ranking(styles, f"fitted without {name}", score_without(styles, groups))


def print_ranking(styles: MarkedStyles, name: str, scores: np.ndarray) -> None:
    """Print how well scores, as log-odds, agree with the marks of all styles, and of the latest."""
    for sets, which in {"all": np.full(len(scores), True), "latest": styles.latest}.items():
        if which.any():
            print(f"{styles.rules}, {name}, {sets}: {describe_ranking(styles, scores, which)}")


def describe_ranking(styles: MarkedStyles, scores: np.ndarray, which: np.ndarray) -> str:
    """Return in a line how well the scores of some styles agree with marks."""
    chances = 1 / (1 + np.exp(-scores))
    passes = [
        not (fault(metrics, styles.rules) or doubt(chance, styles.rules))
        for metrics, chance in zip(styles.metrics, chances, strict=True)
    ]
    kept, passed, given = styles.kept[which], np.array(passes)[which], scores[which]
    best = np.argsort(-given)[: round(BEST_SHARE * len(given))]
    return (
        f"AUC {area_under_curve(given, kept):.3f}, "
        f"within a picture {area_under_curve(given, kept, styles.pictures[which]):.3f}, "
        f"{kept.sum()} of {len(kept)} kept, "
        f"{kept[passed].sum()} of the {passed.sum()} that pass, "
        f"{kept[best].sum()} of the best {len(best)}"
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


if __name__ == "__main__":
    main()
