"""Measure how steady styles are on films, and print a Markdown table.

    python -m tools.steadiness FOLDER_OR_CLIP ... [--styles ink ...] [--steady 0 0.5 1]
    python -m tools.steadiness FOLDER_OR_CLIP ... --mark-motion --size 960 --frames 24 [--styles ink ...]

It uses successive frames from the middle of each clip, scaled down to a maximum width. `--mark-motion`
measures instead whether marks stay on the page or move with objects: correlation on the page | along the
motion.
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
from tools.steadiness.mark_motion import compare_mark_motion
from tools.steadiness.table import format_mark_motion, format_steadiness
from vidstyle.errors import VidstyleError
from vidstyle.style import load_style, style_names

PHOTOGRAPH_SIZE_PX = 640, 360


def main() -> None:
    """Print the table; progress goes to standard error."""
    options = _parse_options()
    clips = list(_read_clips(options.clips, options.frames, options.size))
    if options.mark_motion:
        print(_mark_motion_table(options, dict(clips)), end="")
    else:
        print(_steadiness_table(options, [clip for _, clip in clips]), end="")


def _mark_motion_table(options: argparse.Namespace, clips: dict[str, Clip]) -> str:
    styles = [load_style(name) for name in options.styles]
    columns = [compare_mark_motion(styles, clip, options.device) for clip in clips.values()]
    return format_mark_motion(options.styles, list(clips), columns)


def _steadiness_table(options: argparse.Namespace, clips: list[Clip]) -> str:
    photograph = cv2.resize(skimage.data.coffee()[:338], PHOTOGRAPH_SIZE_PX, interpolation=cv2.INTER_AREA)
    study = Study(photograph, clips, options.device)
    measured = {}
    for name in options.styles:
        print(name, file=sys.stderr, flush=True)
        measured[name] = list(study.measure(load_style(name), options.steady))
    films = f"{len(clips)} clips, {options.frames} frames from the middle, at most {options.size} px wide"
    return format_steadiness(measured, options.steady, study.source, films)


def _parse_options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clips", type=Path, nargs="*", metavar="FOLDER_OR_CLIP")
    parser.add_argument("--styles", nargs="+", default=[name for name in style_names() if name != "plain"])
    parser.add_argument("--steady", nargs="+", type=float, default=[0.0, 0.5])
    parser.add_argument("--frames", type=int, default=14, help="frames of each clip (default: 14)")
    parser.add_argument("--size", type=int, default=640, help="maximum width in pixels (default: 640)")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--mark-motion", action="store_true", help="measure whether marks stay on the page")
    return parser.parse_args()


def _read_clips(places: Iterable[Path], count: int, width: int) -> Iterator[tuple[str, Clip]]:
    for place in places:
        for path in sorted(place.iterdir()) if place.is_dir() else [place]:
            try:
                yield path.stem, read_clip(path, count, width)
                print(path.name, file=sys.stderr, flush=True)
            except VidstyleError as error:
                print(error, file=sys.stderr)


if __name__ == "__main__":
    main()
