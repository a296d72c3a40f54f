"""Output of the page: styles in the folder of the user, exports and films in the working folder."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from vidstyle.assets import asset_folder
from vidstyle.errors import UsageError
from vidstyle.export.export_style import export_style
from vidstyle.pipeline.progress import Progress
from vidstyle.pipeline.render import render
from vidstyle.preview.clip import Clip
from vidstyle.preview.places import checked_name, checked_path, refuse_existing
from vidstyle.style import PLAIN, Style, user_styles

EXPORT_KINDS = ("html", "hook", "toml")
FILM_SUFFIX, PICTURE_SUFFIX = ".mp4", ".png"


def save(style: Style, name: str, overwrite: bool = False) -> Path:
    """Save a style to the folder of the user, where all commands find it by name.

    Raises:
        UsageError: the name is invalid, or is the name of a shipped style or an existing file.
        OutputError: the file cannot be written.
    """
    folder = user_styles()
    name = checked_name(name, ".toml")
    folder.mkdir(parents=True, exist_ok=True)
    target = checked_path(folder, name, ".toml")
    if target.stem == PLAIN or (asset_folder("styles") / target.name).exists():
        raise UsageError(name, "is the name of a style that comes with vidstyle", "choose another name")
    refuse_existing(target, overwrite)
    export_style(replace(style, name=target.stem), target, overwrite=overwrite)
    return target


def write_export(style: Style, name: str, kind: str) -> Path:
    """Export a style to the working folder.

    Args:
        kind: of `EXPORT_KINDS`.

    Raises:
        UsageError: the name is invalid, or the file exists.
        OutputError: the file cannot be written.
    """
    target = checked_path(Path.cwd(), name, f".{kind}")
    refuse_existing(target, False)
    export_style(replace(style, name=target.stem), target)
    return target


def render_clip(
    clip: Clip, style: Style, name: str, watch: Callable[[Progress], None], stop: threading.Event
) -> Path:
    """Render the whole clip to the working folder.

    Raises:
        UsageError: the name is invalid, the file exists, or the clip comes from a camera.
        VidstyleError: see `render`.
    """
    source = clip.file()
    if source is None:
        raise UsageError(clip.name, "is a camera", "give a film to render it")
    target = checked_path(Path.cwd(), name, FILM_SUFFIX if clip.count > 1 else PICTURE_SUFFIX)
    refuse_existing(target, False)
    render(source, target, style, on_progress=watch, stop=stop)
    return target
