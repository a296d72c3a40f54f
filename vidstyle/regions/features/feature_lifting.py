"""Takes eyes, nose and mouth off a picture, and keeps their tones.

A morphological closing finds details that are darker than the skin around them, as for writing. The style
then draws a face without lines, and cannot make an eye larger than it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import PartLuma
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.areas import Areas, eye_doubt, feature_areas, has_dark_glasses
from vidstyle.regions.features.blurring import blurred, enlarged, resized
from vidstyle.regions.features.calm_skin import skin_luma, without_grain
from vidstyle.regions.features.portrait import face_darkness
from vidstyle.regions.features.windows import reduced_window
from vidstyle.regions.masks import face_mask, inner_mask, mask_box
from vidstyle.regions.patches import Patch, plane_area

MAX_DRAWN_HEIGHT_PX = 224
"""Height of a face above which its features come from a reduced copy."""
GLASSES_FACTOR, GLASSES_AREA_FACTOR = 2.0, 1.6
"""How much larger than an eye dark glasses are, and how much larger their area is than that of an eye."""
DRAWN_FACTOR = 1.5
"""Factor of `inner_mask`, so that all of the face but its edge is drawn."""
LIGHT_RATIO = 0.08
"""Standard deviation of the Gaussian that finds light and shade on a face, relative to its height."""


class Features(NamedTuple):
    """The features of a face.

    The planes of a large face have the size of a reduced copy of the window.

    Attributes:
        window: their box in the picture.
        weight: how much of the face is drawn, H x W float32, 0..1, at most `amount`.
        darkness: see `face_darkness`.
        areas: masks of the features.
        face: the face.
        amount: how much of the features has been lifted, 0..1.
    """

    window: Rectangle
    weight: np.ndarray
    darkness: np.ndarray
    areas: Areas
    face: Face
    amount: float


class LiftedFace(NamedTuple):
    """A face whose features have been taken off a picture; its planes may be reduced, see `Features`.

    Attributes:
        window: its box in the picture.
        luma: the window before, H x W float32, 0..1.
        inner: mask of the face, H x W float32, 0..1.
        areas: masks of its features.
        height: of the face in these planes, in pixels.
        face: the face.
        amount: how much of the features has been taken off, 0..1.
    """

    window: Rectangle
    luma: np.ndarray
    inner: np.ndarray
    areas: Areas
    height: float
    face: Face
    amount: float

    def features(self) -> Features:
        """Return the features, to be drawn."""
        darkness = face_darkness(self.luma, self.inner, self.areas, self.height)
        weight = np.minimum(np.float32(DRAWN_FACTOR) * self.inner, 1)
        weight *= np.float32(self.amount * self.face.opacity)
        return Features(self.window, weight, darkness, self.areas, self.face, self.amount)


def lift_features(
    picture: Picture, patches: Sequence[Patch], amount: float, share: float = 1.0
) -> list[LiftedFace]:
    """Change the patches of a picture in place: take off features. Return the faces that had any.

    Args:
        picture: the picture of all patches.
        patches: the patches.
        amount: how much of the features is drawn later, 0..1.
        share: how much of that is taken off, 0..1.
    """
    lifted = list[LiftedFace]()
    for patch, face in ((each, each.face) for each in patches if amount and each.face):
        window = Box(*map(round, mask_box(face.box))).intersection(patch.window)
        if window.area and (found := _lift(picture, patch, face, window, amount, share)):
            lifted.append(found)
    return lifted


def _lift(
    picture: Picture, patch: Patch, face: Face, window: Rectangle, amount: float, share: float
) -> LiftedFace | None:
    """Take off the features of a face in a window; None, and no change, if it has no eyes."""
    place = window.moved(patch.place.left - patch.window.left, patch.place.top - patch.window.top)
    part = PartLuma(picture, plane_area(place, (1, 1)))
    luma = part.luma
    seen, inside = reduced_window(face, window, MAX_DRAWN_HEIGHT_PX)
    small = resized(luma, (inside.height, inside.width))
    amount *= 1 - eye_doubt(small, seen, inside)
    if not amount:
        return None
    small, height = without_grain(small), seen.box.height
    skin = skin_luma(small, height)
    eye_factor = 1.0
    if has_dark_glasses(skin, seen, inside):
        skin, eye_factor = skin_luma(small, GLASSES_FACTOR * height), GLASSES_AREA_FACTOR
    areas = feature_areas(seen, inside, eye_factor)
    areas = areas._replace(whole=areas.whole * face_mask(seen.box, inside))
    # The closing spreads a bright cheek over a shaded one, as a disc.
    even = np.minimum(skin, blurred(small, LIGHT_RATIO * height))
    ground, whole = (enlarged(each, luma.shape) for each in (even, areas.whole))
    # Grain stays where features were. A reduced copy does not have it.
    part.add(np.float32(share * amount) * whole * (ground - (small if small.shape == luma.shape else luma)))
    return LiftedFace(window, small, inner_mask(seen.box, inside), areas, height, face, amount)
