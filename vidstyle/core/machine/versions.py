"""Versions of installed packages."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path


@cache
def version_of(package: str) -> str:
    """Return the version of an installed package, by the name that it is installed under.

    Taken from the name of its folder of metadata: importing `importlib.metadata` takes longer than all else
    that this is asked for.

    Raises:
        ImportError: it is not installed.
    """
    for folder in sys.path:
        for found in Path(folder).glob(f"{package.replace('-', '_')}-*.dist-info"):
            return found.stem.partition("-")[2]
    from importlib import metadata

    return metadata.version(package)
