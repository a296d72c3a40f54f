"""Mixes the pictures of two styles.

Encoded samples are mixed, not linear light. A fade from black ink to white paper then
brightens evenly to the eye; in linear light it would be nearly white after a third of its time. Editing
programs do the same.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.cues.cue_list import Moment


def mixed_picture(ending: Picture, active: Picture, moment: Moment) -> Picture:
    """Return the picture of a transition.

    Args:
        ending, active: the picture in both styles.
        moment: has the transition and its share.
    """
    ending, active = _with_chroma(ending, active), _with_chroma(active, ending)
    planes = [each for each in (ending.luma, *(ending.chroma or ()), ending.color) if each is not None]
    mix = _wiped if moment.transition == "wipe" else _faded

    def mixed(plane: np.ndarray, kind: str) -> np.ndarray:
        return plane if kind == "alpha" else mix(planes.pop(0), plane, moment.share)

    return active.map_planes(mixed)


def _with_chroma(picture: Picture, other: Picture) -> Picture:
    """Return the picture with neutral chroma if only the other has some: a gray picture may be unchanged."""
    if picture.luma is None or picture.chroma is not None or other.chroma is None:
        return picture
    neutral = picture.encoding.chroma_levels[0]
    blue, red = (np.full_like(plane, neutral) for plane in other.chroma)
    return replace(picture, chroma=(blue, red))


def _faded(ending: np.ndarray, active: np.ndarray, share: float) -> np.ndarray:
    return np.asarray(cv2.addWeighted(ending, 1 - share, active, share, 0)).reshape(active.shape)


def _wiped(ending: np.ndarray, active: np.ndarray, share: float) -> np.ndarray:
    edge = round(share * active.shape[1])
    return np.concatenate([active[:, :edge], ending[:, edge:]], axis=1)
