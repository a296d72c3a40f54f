"""The styles that the designer lists."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from vidstyle.errors import StyleError
from vidstyle.style import load_style, style_names

FIRST_STYLES = (
    "ink", "poster", "comic", "cartoon", "watercolor",
    "sketch", "oil", "impressionist", "neon", "crayon",
)  # fmt: skip
"""The styles that a start screen lists and renders first, in rows: those that most people look for, and in
each row first those that need the least compiling at a first start."""


def list_styles(folder: Path) -> dict[str, str]:
    """Return the names of all styles, with what `load_style` reads for each.

    `FIRST_STYLES` come first, then the others of `style_names`, then the valid style files of the folder,
    into which the designer saves.
    """
    listed = {name: name for name in dict.fromkeys((*FIRST_STYLES, *style_names()))}
    for path in sorted(folder.absolute().glob("*.toml")):
        with suppress(StyleError):  # a TOML file of another program
            load_style(str(path))
            listed.setdefault(path.stem, str(path))
    return listed
