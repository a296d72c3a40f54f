"""The inputs and settings that determine a render, as texts that a later run can compare."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import fields
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.blocks import all_blocks
from vidstyle.core.machine.versions import version_of
from vidstyle.cues.cue_list import CueList
from vidstyle.cues.rotation import StyleChoice, styles_of
from vidstyle.errors import UsageError
from vidstyle.media.codecs import ffmpeg_version
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.media.read.sequence import find_sequence_files, is_pattern
from vidstyle.media.write.containers import RESUMABLE_ENDINGS
from vidstyle.media.write.run_record import Fingerprint
from vidstyle.media.write.writer import is_resumable
from vidstyle.regions.chosen_files import backdrop_file, people_model
from vidstyle.style import Style, expand
from vidstyle.style.mask_declarations import BACKDROP, BACKGROUND, PEOPLE
from vidstyle.style.model import FIELDS
from vidstyle.style.resolve import masks_read, resolve
from vidstyle.style.values import asset_path
from vidstyle.version import __version__

HARMLESS_OPTIONS = ("allow_url", "max_pixels", "overwrite", "new_sound")
"""Options that change no picture."""
STABLE_FRAMES = 100
"""Frames after which a style with temporal smoothing gives the same pictures, wherever it began."""
NOMINAL_SIZE_PX = 720, 1280
"""Height and width of a picture for which the steps of a style are resolved, where its size is irrelevant."""
SETTLED_FACTOR = 7
"""Time constants after which smoothed measurements of a film differ by less than a thousandth."""


def check_resumable(source: str | Path, target: str | Path, write: WriteOptions) -> None:
    """Raise UsageError if an unfinished target of this source cannot be resumed."""
    # A missing source is reported when it is opened.
    is_file = is_pattern(source) or Path(source).is_file() or not os.path.lexists(source)
    if str(source) == "-" or "://" in str(source) or not is_file:
        raise UsageError("--resume", f"{source} cannot be read twice", "it works for films in files")
    if not is_resumable(target, write):
        remedy = f"it works for {', '.join(RESUMABLE_ENDINGS)} and numbered pictures"
        raise UsageError("--resume", f"{target} cannot be resumed", remedy)


def render_fingerprint(
    source: str | Path,
    target: str | Path,
    style: Style | CueList,
    read: ReadOptions,
    write: WriteOptions,
    resume: bool,
    **more: object,
) -> Fingerprint | None:
    """Return the fingerprint of a render; None if it cannot be continued.

    Args:
        source, target, style, read, write, resume: of `render`.
        more: what else decides the pictures, by its name.
    """
    files = find_sequence_files(str(source)) if is_pattern(source) else [Path(source)]
    if not all(file.is_file() for file in files) or not is_resumable(target, write):
        return None
    parts = {"source": _signature(files), **setting_parts(style, read, write, **more)}
    return Fingerprint(parts, resume)


def setting_parts(
    style: StyleChoice, read: ReadOptions, write: WriteOptions, **more: object
) -> dict[str, str]:
    """Return everything that determines a render, except its source, for a `Fingerprint`."""
    options: dict[str, Any] = {
        field.name: getattr(each, field.name)
        for each in (read, write)
        for field in fields(each)
        if field.name not in HARMLESS_OPTIONS
    }
    parts = {"style": _look_digest(style), **options, **more, "build": build()}
    return {name: str(part) for name, part in parts.items()}


def warm_up_frames(style: Style | CueList, rate: float) -> int:
    """Return the number of earlier frames that a style needs for the same picture as in the whole film.

    Args:
        rate: frames a second.
    """
    if any(map(masks_read, styles_of(style))):
        return sys.maxsize  # masks follow people from the beginning of a scene
    layers = (layer for each in styles_of(style) for layer in resolve(each, *NOMINAL_SIZE_PX).values())
    settle = max((step.settle or 0 for layer in layers for step in layer), default=0)
    return STABLE_FRAMES + round(SETTLED_FACTOR * settle * rate)


def build() -> str:
    """Return the versions of what makes the pictures."""
    faces = "with" if find_spec("mtcnn") else "without"
    libraries = (
        f"FFmpeg {ffmpeg_version()}, OpenCV {_opencv_version()}, NumPy {np.__version__}, {faces} faces"
    )
    return f"vidstyle {__version__}, {libraries}"


def _opencv_version() -> str:
    with suppress(ImportError):  # importing OpenCV would take longest of all
        return version_of("opencv-contrib-python-headless")
    import cv2  # installed under another name, such as opencv-python

    return cv2.__version__


def _arguments(block: str, values: dict[str, Any]) -> dict[str, Any]:
    return all_blocks()[block].arguments_for(values) if block else {}


def _look_digest(look: StyleChoice) -> str:
    """Of a style, of all cues, or of styles that take turns."""
    if isinstance(look, Style):
        return _style_digest(look)
    if isinstance(look, CueList):
        times = [repr((each.time, each.transition, each.seconds, each.curve)) for each in look.cues]
    else:
        times = [repr((look.change, look.seed))]
    return _digest([*times, *map(_style_digest, look.styles)])


def _style_digest(style: Style) -> str:
    """Of every value of every step, defaults too, and of the files that it names."""
    expanded = expand(style)
    steps = [
        (
            layer,
            step.block,
            step.on,
            step.save,
            step.source,
            sorted(_arguments(step.block, step.values).items()),
        )
        for layer, each in expanded.layers.items()
        for step in each
    ]
    values = [getattr(style, name) for name in (*FIELDS, "keeps_detail")]
    behind = _style_digest(style.behind) if style.behind else ""
    return _digest([repr((values, style.masks, steps)), behind, _signature(_assets(expanded))])


def _assets(style: Style) -> Iterable[Path]:
    """Yield the files that a style reads, and those that the user names for it."""
    yield from (asset_path(style.folder, each["file"]) for each in style.masks.values() if "file" in each)
    model = people_model()
    if model is not None and {PEOPLE, BACKGROUND} & set(masks_read(style)):
        yield model
    backdrop = backdrop_file()
    if backdrop is not None and BACKDROP in masks_read(style):
        yield backdrop
    for step in style.steps:
        for name, parameter in all_blocks()[step.block].parameters.items() if step.block else ():
            if file := parameter.control.own_file(step.values.get(name)):
                path = asset_path(style.folder, file)
                yield from sorted(path.rglob("*")) if path.is_dir() else [path]


def _signature(files: Iterable[Path]) -> str:
    """Of the files' names, sizes and times of change."""
    found = [(path.name, path.stat()) for path in files]
    return _digest(f"{name} {status.st_size} {status.st_mtime_ns}" for name, status in found)


def _digest(texts: Iterable[str]) -> str:
    return hashlib.sha256("\n".join(texts).encode("utf-8", "surrogateescape")).hexdigest()[:16]
