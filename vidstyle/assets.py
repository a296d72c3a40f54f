"""Locates the data files of the package, in a checkout or an installation."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def asset_folder(name: str) -> Path:
    """The folder `shaders`, `filters_bank` or `styles`.

    A wheel holds all of them inside the package; in a checkout the first two lie beside it.

    Raises:
        FileNotFoundError: neither place has it, so the installation is broken.
    """
    for folder in (_PACKAGE / name, _PACKAGE.parent / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"{name}: not found beside {_PACKAGE}; reinstall vidstyle")
