"""Locates the data files of the package, in a checkout or an installation, and the user's own."""

from __future__ import annotations

import os
import sys
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def asset_folder(name: str) -> Path:
    """The folder `shaders`, `filters_bank` or `styles`.

    A wheel contains all of them inside the package; in a checkout, the first two are next to it.

    Raises:
        FileNotFoundError: neither place has it, so the installation is broken.
    """
    for folder in (_PACKAGE / name, _PACKAGE.parent / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"{name}: not found next to {_PACKAGE}; reinstall vidstyle")


def configuration_folder() -> Path:
    """The folder of the user's own styles and configuration, which need not exist."""
    chosen = os.environ.get("XDG_CONFIG_HOME") or os.environ.get("APPDATA")
    home = "~/Library/Application Support" if sys.platform == "darwin" else "~/.config"
    return Path(chosen or os.path.expanduser(home)) / "vidstyle"
