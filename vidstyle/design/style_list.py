"""The styles that the designer lists."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from vidstyle.errors import StyleError
from vidstyle.style import load_style, popular_first


def list_styles(folder: Path) -> dict[str, str]:
    """Return the names of all styles, with what `load_style` reads for each.

    Those of `popular_first` come first, then the valid style files of the folder, into which the designer
    saves.
    """
    listed = {name: name for name in popular_first()}
    for path in sorted(folder.absolute().glob("*.toml")):
        with suppress(StyleError):  # a TOML file of another program
            load_style(str(path))
            listed.setdefault(path.stem, str(path))
    return listed
