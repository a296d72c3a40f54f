"""Shadows are lifted before a panel is drawn; what is lit stays as it is."""

import cv2
import numpy as np
from media import photograph

from vidstyle.comic.output.shadow_light import lift_shadows


def luma_of(color: np.ndarray) -> np.ndarray:
    return cv2.cvtColor(color, cv2.COLOR_RGB2LAB)[..., 0].astype(np.float32)


def test_a_face_in_the_dark_becomes_lighter_and_keeps_its_contrast() -> None:
    dark = (photograph("astronaut") * 0.25).astype(np.uint8)
    before, after = luma_of(dark), luma_of(lift_shadows(dark))
    face = slice(70, 180), slice(170, 270)
    assert after[face].mean() > 1.5 * before[face].mean()
    assert after[face].std() > 1.2 * before[face].std()


def test_lit_parts_next_to_shadows_stay_as_they_are() -> None:
    lit = cv2.resize(photograph("astronaut")[:200, 130:330], (320, 320))
    night = np.hstack([np.full((320, 320, 3), 12, np.uint8), np.maximum(lit, 170)])
    lifted = luma_of(lift_shadows(night))
    assert np.abs(lifted - luma_of(night))[:, 360:].max() <= 2
    assert lifted[:, :280].mean() > 1.3 * luma_of(night)[:, :280].mean()
