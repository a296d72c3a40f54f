"""Files that the user names for a session: the model that finds people, and the backdrop behind them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

INSTALLED_MODEL = "modules/selfie_segmentation/selfie_segmentation_landscape.tflite"
"""The model in the package mediapipe (Apache-2.0); nothing else of the package is used."""
INSTALL_COMMAND = "pip install --no-deps mediapipe==0.10.14"
"""Without dependencies, as they would replace OpenCV."""
MODEL_VARIABLE, BACKDROP_VARIABLE = "VIDSTYLE_PEOPLE_MODEL", "VIDSTYLE_BACKDROP"
"""Environment variables with the paths of another model, and of a picture or film behind people."""


@contextmanager
def use_file(variable: str, path: Path) -> Iterator[None]:
    """Use this file within the block; child processes inherit it."""
    before = os.environ.get(variable)
    os.environ[variable] = str(path.absolute())
    try:
        yield
    finally:
        del os.environ[variable]
        if before is not None:
            os.environ[variable] = before


def backdrop_file() -> Path | None:
    """Return the picture or film to show behind people, if the user names one."""
    chosen = os.environ.get(BACKDROP_VARIABLE)
    return Path(chosen) if chosen else None


def people_model() -> Path | None:
    """Return the model to find people with; None if no model is installed."""
    if chosen := os.environ.get(MODEL_VARIABLE):
        return Path(chosen)
    found = find_spec("mediapipe")
    path = Path(found.origin).parent / INSTALLED_MODEL if found and found.origin else None
    return path if path and path.is_file() else None
