"""Measures how steady styles are on films, and prints a Markdown table.

    python -m tools.steadiness FOLDER_OR_CLIP ... [--styles ink ...] [--steady 0 0.5 1]

Of each clip it takes some frames in a row from the middle, reduced to a width, and finds their motion once.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import skimage.data

from tools.steadiness import Study
from tools.steadiness.clips import Clip, read_clip
from tools.steadiness.table import markdown
from vidstyle.errors import VidstyleError
from vidstyle.style import load_style, style_names

PHOTOGRAPH_SIZE = 640, 360


def main() -> None:
    """Print the table; progress goes to standard error."""
    options = _options()
    clips = list(_clips(options.clips, options.frames, options.size))
    photograph = cv2.resize(skimage.data.coffee()[:338], PHOTOGRAPH_SIZE, interpolation=cv2.INTER_AREA)
    study = Study(photograph, clips, options.device)
    figures = {}
    for name in options.styles:
        print(name, file=sys.stderr, flush=True)
        figures[name] = list(study.measure(load_style(name), options.steady))
    films = f"{len(clips)} clips, {options.frames} frames from the middle, at most {options.size} px wide"
    print(markdown(figures, options.steady, study.untouched, films), end="")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clips", type=Path, nargs="*", metavar="FOLDER_OR_CLIP")
    parser.add_argument("--styles", nargs="+", default=[name for name in style_names() if name != "plain"])
    parser.add_argument("--steady", nargs="+", type=float, default=[0.0, 0.5])
    parser.add_argument("--frames", type=int, default=14)
    parser.add_argument("--size", type=int, default=640)
    parser.add_argument("--device", default="cpu")
    return parser.parse_args()


def _clips(places: Iterable[Path], count: int, width: int) -> Iterator[Clip]:
    for place in places:
        for path in sorted(place.iterdir()) if place.is_dir() else [place]:
            try:
                yield read_clip(path, count, width)
                print(path.name, file=sys.stderr, flush=True)
            except VidstyleError as error:
                print(error, file=sys.stderr)


if __name__ == "__main__":
    main()
