"""Labelled pictures side by side in one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import cv2
import numpy as np

LABEL = 24
GAP = 4
SHAPE = 16 / 10
"""Width to height that a sheet comes near to."""
MAX_SIDE = 480
"""Of one picture on a sheet of samples, in pixels."""


def labelled(picture: np.ndarray, name: str) -> np.ndarray:
    """The picture, H x W x 3 uint8, in a white frame with its name above."""
    framed = cv2.copyMakeBorder(picture, LABEL, GAP, GAP, GAP, cv2.BORDER_CONSTANT, value=(255, 255, 255))
    at = (GAP, LABEL - 8)
    return cv2.putText(framed, name, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 1, cv2.LINE_AA)


def sheet_of(pictures: Iterable[np.ndarray], columns: int) -> np.ndarray:
    """All pictures, which have one size, so many in a row; H x W x 3 uint8."""
    pictures = list(pictures)
    pictures += [np.full_like(pictures[0], 255)] * (-len(pictures) % columns)
    rows = (pictures[first : first + columns] for first in range(0, len(pictures), columns))
    return np.vstack([np.hstack(row) for row in rows])


def sheet_of_samples(named: Sequence[tuple[str, np.ndarray]]) -> np.ndarray:
    """Pictures of one size with their names, reduced, in so many columns that the sheet is a good shape."""
    height, width = named[0][1].shape[:2]
    factor = min(1, MAX_SIDE / max(height, width))
    size = max(1, round(width * factor)), max(1, round(height * factor))
    columns = round((len(named) * SHAPE * (size[1] + LABEL) / size[0]) ** 0.5)
    return sheet_of(
        (labelled(cv2.resize(each, size, interpolation=cv2.INTER_AREA), name) for name, each in named),
        min(max(1, columns), len(named)),
    )
