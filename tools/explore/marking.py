"""Draw random styles on sheets for people to mark, and write a key for `tools/explore/score.py`.

Usage: python -m tools.explore.marking PICTURES OUT --seed SEED --at PICTURE X,Y --at ... [options]

Each picture, a path in PICTURES without its suffix, is shown at 1080 lines at most; X,Y is the middle
of the crop, 0..1. For each rules and picture, styles are drawn by seeds until enough pass the gates:
`--drawn` in the order of their seeds, then `--pool`, of which the best `--best` of all pictures are shown,
and `--failed` that failed a gate at full size. OUT gets sheets of six crops at 1:1 in random order, the
crops, and key.json, which holds the text of each style: styles by the open rules depend on the shipped
styles, so a seed may give another one later.
"""

from __future__ import annotations

import argparse
import json
import math
import tomllib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import count
from pathlib import Path
from random import Random
from typing import NamedTuple, get_args

import cv2
import numpy as np

from tools.explore.marks import Row
from vidstyle.core.machine.cores import available_cores
from vidstyle.explore.candidates import examine
from vidstyle.explore.crops.full_size import FullSize
from vidstyle.explore.generate import random_style
from vidstyle.explore.measure import Original
from vidstyle.explore.paper.rules import Rules
from vidstyle.gallery.preview import read_still
from vidstyle.gallery.style_samples import restyle_picture, sheet_of
from vidstyle.regions.still_faces import StillFaces
from vidstyle.style import load_style, style_text

SHOWN_HEIGHT = 1080
"""Height at which taller pictures are shown."""
CROP_SIZE = 480, 360
SHEET_COLUMNS, SHEET_CROP_COUNT = 3, 6
LABEL_PX, GAP_PX = 23, 3
SEED_BATCH_SIZE = 16
"""Number of seeds that are tried at a time."""
DEFAULT_COUNTS = {"drawn": 15, "pool": 25, "best": 12, "failed": 3}


class DrawnStyles(NamedTuple):
    """Styles of a picture that passed the gates, styles that failed at full size, and the number tried."""

    passed: list[Row]
    failed: list[Row]
    tried: int


def main() -> None:
    """Draw and write; see the top of the file."""
    options = _parse_options()
    rows = [row for rules in get_args(Rules) for row in draw_rules(rules, options)]
    Random(options.seed).shuffle(rows)
    rows = [each | {"number": str(number)} for number, each in enumerate(rows, 1)]
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "key.json").write_text(json.dumps(rows, indent=1), encoding="utf-8")
    write_sheets(options.pictures, options.out, rows)


def _parse_options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pictures", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", required=True)
    parser.add_argument("--at", nargs=2, action="append", required=True, metavar=("PICTURE", "X,Y"))
    for name, number in DEFAULT_COUNTS.items():
        parser.add_argument(f"--{name}", type=int, default=number)
    return parser.parse_args()


def draw_rules(rules: Rules, options: argparse.Namespace) -> Iterator[Row]:
    """Yield the styles by some rules that are shown: of each picture, then the best of all pictures."""
    pool: list[Row] = []
    for place, (name, at) in enumerate(options.at):
        picture = read_picture(options.pictures, name)
        found = draw_styles(picture, f"{options.seed}-{place}", rules, options.drawn + options.pool)
        print(f"{rules} {name}: {found.tried} tried", flush=True)
        shown = {"picture": name, "box": crop_box(picture.shape, *map(float, at.split(",")))}
        yield from (each | shown | {"part": "drawn"} for each in found.passed[: options.drawn])
        yield from (each | shown | {"part": "failed"} for each in found.failed[: options.failed])
        pool += [each | shown | {"part": "best"} for each in found.passed[options.drawn :]]
    yield from sorted(pool, key=lambda each: -each["score"])[: options.best]


def read_picture(pictures: Path, name: str) -> np.ndarray:
    """Read a picture at the size at which it is shown, H x W x 3 uint8."""
    picture = read_still(next(pictures.glob(f"{name}.*")), max_side=math.inf)
    height, width = picture.shape[:2]
    if height <= SHOWN_HEIGHT:
        return picture
    size = round(width * SHOWN_HEIGHT / height), SHOWN_HEIGHT
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


def crop_box(shape: tuple[int, ...], x: float, y: float) -> tuple[int, int, int, int]:
    """Return the crop around a point, 0..1, within the picture: left, top, right, bottom."""
    width, height = CROP_SIZE
    left = min(max(round(x * shape[1] - width / 2), 0), shape[1] - width)
    top = min(max(round(y * shape[0] - height / 2), 0), shape[0] - height)
    return left, top, left + width, top + height


def draw_styles(picture: np.ndarray, seed: str, rules: Rules, wanted: int) -> DrawnStyles:
    """Draw styles by successive seeds until `wanted` pass."""
    examine_seed = partial(_examine_seed, Original(picture), FullSize(picture), rules)
    passed, failed, numbers, tried = list[Row](), list[Row](), count(), 0
    with ThreadPoolExecutor(available_cores()) as pool:
        while len(passed) < wanted:
            seeds = [f"{seed}-{next(numbers)}" for _ in range(SEED_BATCH_SIZE)]
            for each in pool.map(examine_seed, seeds):
                if len(passed) < wanted:
                    tried += 1
                    (failed if each["fault"] else passed).append(each)
    return DrawnStyles(passed, [each for each in failed if each["metrics"]], tried)


def _examine_seed(original: Original, crops: FullSize, rules: Rules, seed: str) -> Row:
    style = random_style(seed, rules)
    found = examine(original, crops, style, rules)
    metrics = found.full_size and found.full_size._asdict()
    return {
        "rules": rules,
        "style": style_text(style),
        "score": found.score,
        "fault": found.fault,
        "metrics": metrics,
    }


def write_sheets(pictures: Path, out: Path, rows: list[Row]) -> None:
    """Write the crops, and sheets of them."""
    shown = {name: read_picture(pictures, name) for name in {each["picture"] for each in rows}}
    faces = {name: StillFaces().find(name, partial(shown.__getitem__, name)) for name in shown}

    def render_crop(row: Row) -> np.ndarray:
        left, top, right, bottom = row["box"]
        name, style = row["picture"], load_style(tomllib.loads(row["style"]))
        crop = restyle_picture(shown[name], style, faces[name])[top:bottom, left:right]
        cv2.imwrite(str(out / f"{row['number']}.png"), crop[..., ::-1])
        return label_crop(crop, row["number"])

    with ThreadPoolExecutor(available_cores()) as pool:
        for first in range(0, len(rows), SHEET_CROP_COUNT):
            sheet = sheet_of(pool.map(render_crop, rows[first : first + SHEET_CROP_COUNT]), SHEET_COLUMNS)
            path = out / f"sheet-{first // SHEET_CROP_COUNT + 1:02}.png"
            cv2.imwrite(str(path), sheet[..., ::-1])


def label_crop(crop: np.ndarray, number: str) -> np.ndarray:
    """Return the crop below its number."""
    framed = cv2.copyMakeBorder(
        crop, LABEL_PX, GAP_PX, GAP_PX, GAP_PX, cv2.BORDER_CONSTANT, value=(255, 255, 255)
    )
    return cv2.putText(framed, number, (6, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 2, cv2.LINE_AA)


if __name__ == "__main__":
    main()
