"""Fixtures for the tests of comic pages."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

from vidstyle.comic.analyze import faces, film
from vidstyle.comic.analyze.face_networks import find_faces, load_networks
from vidstyle.comic.analyze.features import Candidate, extract_features


@pytest.fixture(scope="package", autouse=True)
def pictures_are_measured_once() -> Iterator[None]:
    """Many tests look at the same films: what is found in a picture is remembered."""
    found: dict[tuple[bytes, tuple[int, ...], float], np.ndarray] = {}
    measured: dict[tuple[bytes, object, float, object], Candidate] = {}

    def remembered_faces(color: np.ndarray, networks: Any, least: float) -> np.ndarray:
        key = color.tobytes(), color.shape, least
        if key not in found:
            found[key] = find_faces(color, networks, least)
        return found[key].copy()

    def remembered_features(color: np.ndarray, time: float, shape: tuple[int, int]) -> Candidate:
        key = color.tobytes(), color.shape, time, shape
        if key not in measured:
            measured[key] = extract_features(color, time, shape)
        return measured[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(faces, "find_faces", remembered_faces)
        patch.setattr(faces, "load_networks", cache(load_networks))
        patch.setattr(film, "extract_features", remembered_features)
        yield
