"""The styles that the designer lists."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from vidstyle.errors import StyleError
from vidstyle.style import load_style, popular_first


def list_styles(folder: Path) -> dict[str, str]:
    """Return the name of each style, and the name or path to load it by.

    The styles of `popular_first` lead; the valid style files of `folder`, where the designer saves, follow.
    """
    listed = {name: name for name in popular_first()}
    for path in sorted(folder.absolute().glob("*.toml")):
        with suppress(StyleError):  # a TOML file of another program
            load_style(str(path))
            listed.setdefault(path.stem, str(path))
    return listed
