"""The inputs and settings that determine a render, as texts that a later run can compare."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

import vidstyle
from vidstyle.blocks import all_blocks
from vidstyle.core.versions import version_of
from vidstyle.errors import UsageError
from vidstyle.media.codecs import ffmpeg_version
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.media.read.sequence import is_pattern, numbered_files
from vidstyle.media.write.run_record import Fingerprint
from vidstyle.media.write.writer import is_resumable
from vidstyle.style import Style, expand
from vidstyle.style.values import asset_path

HARMLESS = ("allow_url", "max_pixels", "overwrite", "new_sound")
"""Options that change no picture."""
STABLE_FRAMES = 100
"""Frames after which a style with temporal smoothing gives the same pictures, wherever it began."""
SETTLED_FACTOR = 7
"""Time constants after which smoothed measurements of a film differ by less than a thousandth."""


def check_resumable(source: str | Path, target: str | Path, write: WriteOptions) -> None:
    """Raise UsageError if an unfinished target of this source cannot be continued."""
    # A missing source is reported when it is opened.
    is_file = is_pattern(source) or Path(source).is_file() or not os.path.lexists(source)
    if str(source) == "-" or "://" in str(source) or not is_file:
        raise UsageError("--resume", f"{source} cannot be read twice", "it works for films in files")
    if not is_resumable(target, write):
        remedy = "it works for .mp4, .mov, .mkv, .webm and numbered pictures"
        raise UsageError("--resume", f"{target} cannot be continued", remedy)


def render_fingerprint(
    source: str | Path,
    target: str | Path,
    style: Style,
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
    files = numbered_files(str(source)) if is_pattern(source) else [Path(source)]
    if not all(file.is_file() for file in files) or not is_resumable(target, write):
        return None
    options: dict[str, Any] = {
        field.name: getattr(each, field.name)
        for each in (read, write)
        for field in fields(each)
        if field.name not in HARMLESS
    }
    parts = {"source": _signature(files), "style": _style_digest(style), **options, **more, "build": build()}
    return Fingerprint({name: str(part) for name, part in parts.items()}, resume)


def warm_up_frames(style: Style, rate: float) -> int:
    """Return the number of earlier frames that a style needs for the same picture as in the whole film.

    Args:
        rate: frames a second.
    """
    settle = max(
        (_arguments(step.block, step.values).get("settle") or 0 for step in expand(style).steps), default=0
    )
    return STABLE_FRAMES + round(SETTLED_FACTOR * settle * rate)


def build() -> str:
    """Return the versions of what makes the pictures."""
    # Importing it would take longest of all.
    opencv = version_of("opencv-contrib-python-headless")
    libraries = f"FFmpeg {ffmpeg_version()}, OpenCV {opencv}, NumPy {np.__version__}"
    return f"vidstyle {vidstyle.__version__}, {libraries}"


def _arguments(block: str, values: dict[str, Any]) -> dict[str, Any]:
    return all_blocks()[block].arguments_for(values) if block else {}


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
    values = style.height, style.ink, style.paper, style.steady
    return _digest([repr((values, steps)), _signature(_assets(expanded))])


def _assets(style: Style) -> Iterable[Path]:
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
