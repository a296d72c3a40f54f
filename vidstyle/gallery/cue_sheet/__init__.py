"""A page on which the styles of a film's scenes are chosen; it saves a cue file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import cv2
import numpy as np

from vidstyle.cues.cue_list import CURVES, TRANSITIONS
from vidstyle.cues.times import seconds_text
from vidstyle.errors import printable
from vidstyle.export import join_modules
from vidstyle.gallery.style_samples import jpeg_address
from vidstyle.gallery.thumbnail import thumbnail
from vidstyle.pipeline.progress import clock
from vidstyle.style import Style

STILL_HEIGHT_PX = 180


@dataclass(frozen=True)
class SheetScene:
    """A scene on the page: where it begins, its style, and its still as H x W x 3 uint8."""

    start: Fraction
    style: str
    still: np.ndarray


def cue_sheet(
    film: str, cue_file: str, scenes: Sequence[SheetScene], rate: Fraction | None, styles: Mapping[str, Style]
) -> str:
    """Return a self-contained HTML page.

    Args:
        film, cue_file: names of the film and of the file to save.
        rate: frames per second, or None.
        styles: the styles to choose from, by their names.
    """
    data = {
        "file": cue_file,
        "rate": None if rate is None else seconds_text(rate),
        "scenes": [_scene(each) for each in scenes],
        "styles": {name: jpeg_address(thumbnail(style)) for name, style in styles.items()},
        "transitions": TRANSITIONS,
        "curves": CURVES,
    }
    folder = Path(__file__).parent
    template = Template((folder / "sheet.html").read_text(encoding="utf-8"))
    return template.substitute(
        heading=escape(f"Styles of {printable(film)}"),
        data=json.dumps(data, ensure_ascii=True).replace("<", "\\u003c"),
        script=join_modules(folder / "sheet.js"),
    )


def _scene(scene: SheetScene) -> dict[str, Any]:
    height, width = scene.still.shape[:2]
    size = (max(1, round(width * STILL_HEIGHT_PX / height)), STILL_HEIGHT_PX)
    small = cv2.resize(scene.still, size, interpolation=cv2.INTER_AREA)
    return {
        "start": seconds_text(scene.start),
        "clock": clock(float(scene.start)),
        "style": scene.style,
        "still": jpeg_address(small),
    }
