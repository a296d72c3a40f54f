"""The command line that is equivalent to what the designer shows."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path

from vidstyle.errors import UsageError
from vidstyle.preview.clip import Clip
from vidstyle.style import Step, Style
from vidstyle.style.panel import panel


def command_line(clip: Clip, look: str, name: str, frames: int | None) -> str:
    """Return the command that restyles a clip.

    Args:
        look: the options for the style, see `look_options`.
        name: the file to write; empty for a default.
        frames: the number of frames to render; None or 0 for all.
    """
    source = clip.source
    if clip.live:
        return f"vidstyle live {shlex.quote(source)} {look}"
    output = shlex.quote(name or f"output{Path(source).suffix}")
    limit = f" --frames {frames}" if frames else ""
    return f"vidstyle render {shlex.quote(source)} {output} {look}{limit}"


def look_options(style: Style, start: Style | None, file: Path | None, is_saved: bool) -> str:
    """Return the options that select a style.

    Args:
        start: the style that was last opened or saved; None for a new style or a draft.
        file: its file, or None.
        is_saved: whether the file has all changes.

    Raises:
        UsageError: more than values have changed, and the style is not saved.
    """
    if start is not None and _without_values(style) == _without_values(start):
        start = replace(start, name=str(file)) if file else start
        return str(panel(replace(style, name=start.name), start)["text"])
    if file is not None and is_saved:
        return f"--style {shlex.quote(str(file))}"
    raise UsageError("the command", "needs the style in a file", "save it first")


def _without_values(style: Style) -> dict[str, list[Step]]:
    """Return the steps of a style without values, which are all that options of a command can change."""
    return {layer: [replace(step, values={}) for step in steps] for layer, steps in style.layers.items()}
