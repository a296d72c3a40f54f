"""Pictures that show nothing: nearly one colour, as at the beginning of a film."""

from __future__ import annotations

import numpy as np

_MIN_DEVIATION = 12.0
"""Standard deviation of the codes of a picture, 0..255, below which it is nearly uniform."""


def is_nearly_uniform(picture: np.ndarray) -> bool:
    """Whether a picture, H x W x 3 uint8, is nearly one colour.

    >>> is_nearly_uniform(np.full((2, 2, 3), 9, np.uint8))
    True
    """
    return bool(picture.std() < _MIN_DEVIATION)
