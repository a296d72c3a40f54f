"""The light of a panel: lighter shadows, no change or darker lights, whichever keeps its forms apart."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np

from vidstyle.comic.analyze.similarity import SAME_SIMILARITY, THUMBNAIL_SIZE, similarity
from vidstyle.comic.output.shadow_light import lift_shadows
from vidstyle.comic.output.structure_loss import measure_structure_loss
from vidstyle.media.resize import reduce_picture

Light = Callable[[np.ndarray], np.ndarray]
"""Changes the light of a picture, H x W x 3 uint8."""
_DRAFT_SIDE_PX = 400
"""Longer side of the drafts that are compared."""
_EXPONENT_STEPS = 1.5, 2.2
"""Exponents that darken lights, relative to the range of the picture."""
_PERCENTILE_RANGE = 0.5, 99.7
"""Percentiles of luma between which these exponents apply."""
_MIN_LIGHT = 1e-3
"""Smallest relative luma."""
_MIN_LOSS, _MAX_LOSS_RATIO = 0.055, 0.65
"""Structure loss of the usual light from which others are tried; and loss of another light, relative to the
best one before it, up to which it is chosen.

They were tuned on 59 panels of 14 films and a folder, in 5 styles: if more panels change, vivid pages become
dark.
"""


class LightChoice:
    """Chooses the light of panels; panels of one view have the same."""

    def __init__(self) -> None:
        self._known = list[tuple[str, np.ndarray, Light]]()

    def choose(
        self, style: str, frame: np.ndarray, source: np.ndarray, draw: Callable[[np.ndarray], np.ndarray]
    ) -> Light:
        """Return the light of a panel: as before in a similar frame, or see `choose_light`.

        Args:
            style: name of the style of the panel.
            frame: the whole frame, H x W x 3 uint8.
            source: the part that the panel shows.
            draw: draws a small picture in that style.
        """
        thumbnail = cv2.resize(frame, THUMBNAIL_SIZE, interpolation=cv2.INTER_AREA)
        for known_style, known, light in self._known:
            if known_style == style and similarity([thumbnail, known])[0, 1] >= SAME_SIMILARITY:
                return light
        light = choose_light(source, draw)
        self._known.append((style, thumbnail, light))
        return light


def choose_light(source: np.ndarray, draw: Callable[[np.ndarray], np.ndarray]) -> Light:
    """Return the change of light with which the style keeps the forms of a picture apart.

    It is the usual one, lighter shadows, unless it loses much and another less, see `measure_structure_loss`.
    Lighter shadows can merge dark objects, and a style can turn all lights of a picture to paper.

    Args:
        source: the picture, H x W x 3 uint8.
        draw: draws a small picture in the style of the panel.
    """
    small = reduce_picture(source, _DRAFT_SIDE_PX)
    best, *others = _LIGHTS
    least = measure_structure_loss(small, draw(best(small)))
    for each in others if least >= _MIN_LOSS else ():
        loss = measure_structure_loss(small, draw(each(small)))
        if loss < _MAX_LOSS_RATIO * least:
            best, least = each, loss
    return best


def darken_lights(color: np.ndarray, exponent: float) -> np.ndarray:
    """Return a picture, H x W x 3 uint8, whose luma is raised to a power within its range; hues stay."""
    picture = color.astype(np.float32) / 255
    luma = np.maximum(_MIN_LIGHT, cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))
    low, high = np.percentile(luma, _PERCENTILE_RANGE)
    span = max(_MIN_LIGHT, float(high - low))
    relative = np.maximum(_MIN_LIGHT, (luma - low) / span)
    wanted = low + span * np.where(relative < 1, relative**exponent, relative)
    return np.clip(255 * picture * (wanted / luma)[..., np.newaxis] + 0.5, 0, 255).astype(np.uint8)


_LIGHTS: tuple[Light, ...] = (
    lift_shadows,
    np.asarray,
    *(partial(darken_lights, exponent=each) for each in _EXPONENT_STEPS),
)
"""Changes of light, the usual one first."""
