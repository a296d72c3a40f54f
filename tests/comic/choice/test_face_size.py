"""Panels are large enough for the face that they show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from comic_key_frames import LANDSCAPE

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.cost import panel_costs
from vidstyle.comic.layout.weights import LayoutWeights
from vidstyle.regions.boxes import Box

FACE = Box(800.0, 300.0, 950.0, 480.0)
"""A sixth of the height of the picture."""
WIDTHS, HEIGHTS = np.array([1.0, 320, 432, 1280]), np.array([1.0, 180, 243, 720])


def rise(key_frame: KeyFrame, face_px: float) -> np.ndarray:
    """Return by how much the wanted height of faces raises the costs of the panels of the picture's shape."""
    costs = [
        np.diagonal(
            panel_costs([key_frame], np.array([1e5]), WIDTHS, HEIGHTS, LayoutWeights(face_px=each))[0]
        )[1:]
        for each in (face_px, 0.0)
    ]
    return costs[0] - costs[1]


def test_a_panel_in_which_a_face_is_too_small_costs_more() -> None:
    """A close-up shows it larger; a picture without a face may have any size."""
    usual = KeyFrame(0, LANDSCAPE, 0.5, FACE, (FACE,), 0)
    small, medium, large = rise(usual, 90)
    assert small > medium > 0 == large
    near, wide = (rise(replace(usual, framing=framing), 90) for framing in ("near", "wide"))
    assert near[0] < small < wide[0]
    assert not rise(replace(usual, faces=()), 90).any()
