"""Darkness of faces: light and shade are weakened, and features are sharpened."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.regions.features.areas import Areas
from vidstyle.regions.features.portrait import SHADE_WEIGHT, face_darkness

HEIGHT = 80
SHAPE = 120, 400
INNER = np.ones(SHAPE, np.float32)
EYE, MOLE = np.s_[40:60, 195:215], np.s_[40:60, 120:140]


def areas_around(*places: tuple[slice, slice]) -> Areas:
    mask = np.zeros(SHAPE, np.float32)
    for place in places:
        mask[place] = 1
    return Areas(mask, mask, mask, mask)


def test_half_of_the_shade_is_removed() -> None:
    luma = np.tile(np.linspace(0.7, 0.4, SHAPE[1], dtype=np.float32), (SHAPE[0], 1))
    luma[EYE] = 0.1
    luma[20:22, 90:92] += 0.1
    darkness = face_darkness(luma, INNER, areas_around(EYE), HEIGHT)
    spot = darkness[20:22, 95:97].mean() - darkness[20:22, 90:92].mean()
    across = darkness[10, 300] - darkness[10, 100]
    shown = across / spot / ((luma[10, 100] - luma[10, 300]) / 0.1)
    assert abs(1 - shown - SHADE_WEIGHT) < 0.05


def test_features_are_sharper_than_skin() -> None:
    """The same soft spot is darker in an eye than on a cheek."""
    luma = np.full(SHAPE, 0.6, np.float32)
    for place in (EYE, MOLE):
        luma[place][8:12, 8:12] = 0.3
    darkness = face_darkness(cv2.GaussianBlur(luma, (0, 0), 1.5), INNER, areas_around(EYE), HEIGHT)
    assert darkness[EYE].max() > 1.3 * darkness[MOLE].max()
