"""Chooses styles that suit the scenes of a film."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.explore.matching.like import rank_styles
from vidstyle.media.resize import reduce_picture
from vidstyle.style import Style

MAX_SIDE_PX = 360
"""Maximum longer side of the stills that styles are compared on."""


def suiting_styles(stills: Sequence[np.ndarray], styles: Sequence[Style]) -> list[Style]:
    """Return a style for each scene: the one that changes brightness, colours and contrast of it least.

    The style of the scene before is chosen only if there is no other.

    Args:
        stills: a picture of each scene, H x W x 3 uint8.
    """
    chosen: list[Style] = []
    for still in stills:
        small = reduce_picture(still, MAX_SIDE_PX)
        others = [style for style in styles if not chosen or style is not chosen[-1]] or styles
        chosen.append(rank_styles(small, small, others)[0].style)
    return chosen
