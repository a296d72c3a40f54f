"""Validation of file names from a page."""

from __future__ import annotations

import re
from pathlib import Path

from vidstyle.errors import OutputError, UsageError

_VALID_NAME = re.compile(r"\w[\w .()+-]{0,98}")
_RESERVED_NAME = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
"""Matches names of devices on Windows."""


def check_path(folder: Path, name: str, ending: str = "") -> Path:
    """Return the path for a file name from a page.

    Args:
        ending: the required extension, added if it is missing; "": any extension.

    Raises:
        UsageError: the name is not a plain file name, is hidden, has another extension, or is a link.
    """
    path = folder / check_name(name, ending)
    if path.is_symlink():
        raise UsageError(name, "is a link", "choose another name")
    if not folder.is_dir():
        raise OutputError(folder, "no longer exists")
    return path


def check_name(name: str, ending: str = "") -> str:
    """Return a file name from a page with its extension; arguments and errors as in `check_path`."""
    if ending and not name.lower().endswith(ending):
        name += ending
    if (
        not _VALID_NAME.fullmatch(name)
        or name.endswith((" ", "."))
        or ".." in name
        or _RESERVED_NAME.fullmatch(name)
    ):
        raise UsageError(name, "is not a file name", "use letters, digits, spaces and - . _ ( ) +")
    if not ending and not Path(name).suffix:
        raise UsageError(name, "has no ending", "end it in .mp4, .png or another that render takes")
    return name


def refuse_existing(path: Path, overwrite: bool) -> None:
    """Refuse to write over a file unless that was asked for.

    Raises:
        UsageError: the file exists, and it was not.
    """
    if path.exists() and not overwrite:
        raise UsageError(path.name, "exists in that folder", "confirm that it may be replaced")
    if path.exists() and not path.is_file():
        raise UsageError(path.name, "is not a file", "choose another name")
