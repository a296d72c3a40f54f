"""A page on which the cues of a film are edited; it saves a cue file."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import cv2
import numpy as np

from vidstyle.cues.cue_file import CueTable, style_place
from vidstyle.cues.cue_list import CURVES, TRANSITIONS
from vidstyle.cues.times import seconds_text
from vidstyle.errors import printable
from vidstyle.export import join_modules, module_text
from vidstyle.gallery.style_samples import jpeg_address
from vidstyle.gallery.thumbnail import thumbnail
from vidstyle.pipeline.progress import clock
from vidstyle.style import Style, load_style, style_names
from vidstyle.style.change import apply_variant
from vidstyle.style.panel import panel

STILL_HEIGHT_PX = 180


@dataclass(frozen=True)
class SheetScene:
    """A scene on the page: where it begins and ends, in seconds, and its still as H x W x 3 uint8."""

    start: Fraction
    end: Fraction
    still: np.ndarray


def cue_sheet(
    film: str, file: Path, scenes: Sequence[SheetScene], rate: Fraction | None, cues: Sequence[CueTable]
) -> str:
    """Return a self-contained HTML page.

    Args:
        film: name of the film.
        file: the cue file to save; style files are relative to it.
        rate: frames per second, or None.
        cues: the cues to begin with.
    """
    folder = Path(__file__).parent
    template = Template((folder / "sheet.html").read_text(encoding="utf-8"))
    return template.substitute(
        heading=escape(f"Styles of {printable(film)}"),
        data=json.dumps(sheet_data(file, scenes, rate, cues), ensure_ascii=True).replace("<", "\\u003c"),
        style=module_text("components.css") + module_text("cues.css"),
        script=join_modules(folder / "sheet.js"),
    )


def sheet_data(
    file: Path,
    scenes: Sequence[SheetScene],
    rate: Fraction | None,
    cues: Sequence[CueTable],
    opened: Sequence[Style] = (),
) -> dict[str, Any]:
    """Return what `cue_editor.js` shows, for JSON.

    Args:
        file, scenes, rate, cues: see `cue_sheet`.
        opened: styles that replace styles of the same name.
    """
    styles = {name: load_style(style_place(file, name)) for name in _style_choices(cues)}
    return {
        "file": file.name,
        "rate": None if rate is None else seconds_text(rate),
        "end": seconds_text(scenes[-1].end),
        "scenes": [_scene(each) for each in scenes],
        "cues": [*cues],
        "styles": {
            name: _style(style) for name, style in (styles | {each.name: each for each in opened}).items()
        },
        "transitions": TRANSITIONS,
        "curves": CURVES,
    }


def _style_choices(cues: Iterable[CueTable]) -> list[str]:
    """Return the names of all shipped styles, and of the others in the cues, without variants."""
    used = (str(cue["style"]) for cue in cues if "style" in cue)
    shipped = style_names()
    return sorted({*shipped, *(name for name in map(_base, used) if name not in shipped)})


def _base(name: str) -> str:
    """Return the name of a style or a style file without its variant."""
    path, ending, _ = name.partition(".toml")
    return path + ending if ending else name.partition(":")[0]


def _style(style: Style) -> dict[str, Any]:
    """Return the thumbnail, the main controls, and for each variant the values of these controls."""
    entries = [entry for entry in panel(style, style)["entries"] if entry["main"]]
    paths = {entry["path"] for entry in entries}
    variants = {name: apply_variant(style, name) for name in style.variants}
    return {
        "picture": jpeg_address(thumbnail(style)),
        "entries": entries,
        "variants": {
            name: {
                entry["path"]: entry["value"]
                for entry in panel(varied, style)["entries"]
                if entry["path"] in paths
            }
            for name, varied in variants.items()
        },
    }


def _scene(scene: SheetScene) -> dict[str, Any]:
    height, width = scene.still.shape[:2]
    size = (max(1, round(width * STILL_HEIGHT_PX / height)), STILL_HEIGHT_PX)
    small = cv2.resize(scene.still, size, interpolation=cv2.INTER_AREA)
    return {
        "start": seconds_text(scene.start),
        "clock": clock(float(scene.start)),
        "still": jpeg_address(small),
    }
