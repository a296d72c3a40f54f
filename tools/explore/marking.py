"""Draws random styles on sheets for people to mark, and a key for `tools/explore/score.py`.

Usage: python -m tools.explore.marking PICTURES OUT --seed SEED --at PICTURE X,Y --at ... [options]

Each picture, a path in PICTURES without its suffix, is shown at 1080 lines; X,Y is the middle of the crop,
0..1. For each rules and picture, styles are drawn by seeds until enough pass the gates: `--drawn` in the
order of their seeds, then `--pool`, of which the best `--best` of all pictures are shown, and `--failed`
that failed a gate at full size. OUT gets sheets of six crops at 1:1 in random order, the crops, and
key.json, which holds the text of each style: styles by the open rules depend on the shipped styles, so a
seed may give another one later.
"""

from __future__ import annotations

import argparse
import json
import math
import tomllib
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path
from random import Random
from typing import Any, get_args

import cv2
import numpy as np

from vidstyle.core.machine.cores import available_cores
from vidstyle.errors import InputError
from vidstyle.explore.candidates import examine
from vidstyle.explore.crops.full_size import FullSize
from vidstyle.explore.generate import random_style
from vidstyle.explore.measure import Original
from vidstyle.explore.paper.rules import Rules
from vidstyle.gallery.preview import read_still
from vidstyle.gallery.style_samples import restyle_picture, sheet_of
from vidstyle.regions.still_faces import StillFaces
from vidstyle.style import load_style, style_text

HEIGHT = 1080
"""Height at which pictures are shown."""
CROP_SIZE = 480, 360
COLUMNS, CROPS_PER_SHEET = 3, 6
LABEL_PX, GAP_PX = 23, 3

Row = dict[str, Any]


def main() -> None:
    """See the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pictures", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", required=True)
    parser.add_argument("--at", nargs=2, action="append", required=True, metavar=("PICTURE", "X,Y"))
    for name, number in (("drawn", 15), ("pool", 25), ("best", 12), ("failed", 3)):
        parser.add_argument(f"--{name}", type=int, default=number)
    options = parser.parse_args()
    rows: list[Row] = []
    for rules in get_args(Rules):
        pool: list[Row] = []
        for place, (name, at) in enumerate(options.at):
            picture = shown_picture(options.pictures, name)
            found = draw(picture, f"{options.seed}-{place}", rules, options.drawn + options.pool)
            box = box_at(picture.shape, *map(float, at.split(",")))
            print(f"{rules} {name}: {found['tried']} tried", flush=True)
            for part, of in (
                ("drawn", found["passed"][: options.drawn]),
                ("failed", found["failed"][: options.failed]),
            ):
                rows += [each | {"part": part, "picture": name, "box": box} for each in of]
            pool += [
                each | {"part": "best", "picture": name, "box": box}
                for each in found["passed"][options.drawn :]
            ]
        rows += sorted(pool, key=lambda each: -each["score"])[: options.best]
    Random(options.seed).shuffle(rows)
    rows = [each | {"number": str(number)} for number, each in enumerate(rows, 1)]
    write(options.pictures, options.out, rows)


def shown_picture(pictures: Path, name: str) -> np.ndarray:
    """A picture at the size at which it is shown, H x W x 3 uint8."""
    picture = read_still(next(pictures.glob(f"{name}.*")), max_side=math.inf)
    if picture.shape[0] < HEIGHT:
        raise InputError(name, f"has {picture.shape[0]} lines, fewer than {HEIGHT}", "choose a larger one")
    width = round(picture.shape[1] * HEIGHT / picture.shape[0])
    return cv2.resize(picture, (width, HEIGHT), interpolation=cv2.INTER_AREA)


def box_at(shape: tuple[int, ...], x: float, y: float) -> tuple[int, int, int, int]:
    """The crop around a point, 0..1, within the picture: left, top, right, bottom."""
    width, height = CROP_SIZE
    left = min(max(round(x * shape[1] - width / 2), 0), shape[1] - width)
    top = min(max(round(y * shape[0] - height / 2), 0), shape[0] - height)
    return left, top, left + width, top + height


def draw(picture: np.ndarray, seed: str, rules: Rules, wanted: int) -> dict[str, Any]:
    """Draw styles until `wanted` pass; those that fail at full size are returned, too."""
    original, crops = Original(picture), FullSize(picture)

    def row(number: int) -> Row:
        style = random_style(f"{seed}-{number}", rules)
        found = examine(original, crops, style, rules)
        return {"rules": rules, "style": style_text(style), "score": found.score, "fault": found.fault,
                "metrics": found.full_size and found.full_size._asdict()}  # fmt: skip

    passed, failed, numbers, tried = list[Row](), list[Row](), count(), 0
    with ThreadPoolExecutor(available_cores()) as pool:
        while len(passed) < wanted:
            for each in pool.map(row, [next(numbers) for _ in range(16)]):
                if len(passed) < wanted:
                    tried += 1
                    (failed if each["fault"] else passed).append(each)
    return {"passed": passed, "failed": [each for each in failed if each["metrics"]], "tried": tried}


def write(pictures: Path, out: Path, rows: list[Row]) -> None:
    """Write sheets, crops and the key."""
    out.mkdir(parents=True, exist_ok=True)
    (out / "key.json").write_text(json.dumps(rows, indent=1), encoding="utf-8")
    shown = {name: shown_picture(pictures, name) for name in {each["picture"] for each in rows}}
    faces = {name: StillFaces().find(name, lambda name=name: shown[name]) for name in shown}  # type: ignore[misc]

    def crop(row: Row) -> np.ndarray:
        left, top, right, bottom = row["box"]
        whole = restyle_picture(
            shown[row["picture"]], load_style(tomllib.loads(row["style"])), faces[row["picture"]]
        )
        part = whole[top:bottom, left:right]
        cv2.imwrite(str(out / f"{row['number']}.png"), part[..., ::-1])
        return labelled(part, row["number"])

    with ThreadPoolExecutor(available_cores()) as pool:
        for first in range(0, len(rows), CROPS_PER_SHEET):
            sheet = sheet_of(pool.map(crop, rows[first : first + CROPS_PER_SHEET]), COLUMNS)
            path = out / f"sheet-{first // CROPS_PER_SHEET + 1:02}.png"
            cv2.imwrite(str(path), sheet[..., ::-1])


def labelled(part: np.ndarray, number: str) -> np.ndarray:
    """The crop below its number."""
    framed = cv2.copyMakeBorder(
        part, LABEL_PX, GAP_PX, GAP_PX, GAP_PX, cv2.BORDER_CONSTANT, value=(255, 255, 255)
    )
    return cv2.putText(framed, number, (6, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 2, cv2.LINE_AA)


if __name__ == "__main__":
    main()
