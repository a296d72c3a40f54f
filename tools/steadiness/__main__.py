"""Measures how steady styles are on films, and prints a Markdown table.

    python -m tools.steadiness FOLDER_OR_CLIP ... [--styles ink ...] [--steady 0 0.5 1]
    python -m tools.steadiness FOLDER_OR_CLIP ... --following --size 960 --frames 24 [--styles ink ...]

Of each clip it takes some frames in a row from the middle, reduced to a width, and finds their motion once.
`--following` measures instead what the marks of styles follow: correlation on the page | along the motion.
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
from tools.steadiness.following import correlations
from tools.steadiness.table import markdown, markdown_of_following
from vidstyle.errors import VidstyleError
from vidstyle.style import load_style, style_names

PHOTOGRAPH_SIZE = 640, 360


def main() -> None:
    """Print the table; progress goes to standard error."""
    options = _options()
    clips = list(_clips(options.clips, options.frames, options.size))
    if options.following:
        print(_following(options, dict(clips)), end="")
    else:
        print(_table(options, [clip for _, clip in clips]), end="")


def _following(options: argparse.Namespace, clips: dict[str, Clip]) -> str:
    styles = [load_style(name) for name in options.styles]
    columns = [correlations(styles, clip, options.device) for clip in clips.values()]
    return markdown_of_following(options.styles, list(clips), columns)


def _table(options: argparse.Namespace, clips: list[Clip]) -> str:
    photograph = cv2.resize(skimage.data.coffee()[:338], PHOTOGRAPH_SIZE, interpolation=cv2.INTER_AREA)
    study = Study(photograph, clips, options.device)
    figures = {}
    for name in options.styles:
        print(name, file=sys.stderr, flush=True)
        figures[name] = list(study.measure(load_style(name), options.steady))
    films = f"{len(clips)} clips, {options.frames} frames from the middle, at most {options.size} px wide"
    return markdown(figures, options.steady, study.untouched, films)


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
    parser.add_argument("--following", action="store_true")
    return parser.parse_args()


def _clips(places: Iterable[Path], count: int, width: int) -> Iterator[tuple[str, Clip]]:
    for place in places:
        for path in sorted(place.iterdir()) if place.is_dir() else [place]:
            try:
                yield path.stem, read_clip(path, count, width)
                print(path.name, file=sys.stderr, flush=True)
            except VidstyleError as error:
                print(error, file=sys.stderr)


if __name__ == "__main__":
    main()
