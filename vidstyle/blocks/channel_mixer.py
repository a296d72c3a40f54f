"""Channel mixer: gray from chosen amounts of red, green and blue."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Slider, block
from vidstyle.core.color.deferred_color import Mixed


@block(
    "pixel",
    on="color",
    label="Mix channels",
    category="color",
    aliases=(
        "black and white film, monochrome mixer, orthochromatic, panchromatic, colour filter, red filter, "
        "yellow filter, infrared, hair, skin, gray"
    ),
)
def channel_mixer(
    picture: np.ndarray,
    red: Annotated[float, Slider(-2, 2, "share of red", explore=(0, 0.8), label="Red")] = 0.4,
    green: Annotated[float, Slider(-2, 2, "share of green", explore=(0, 0.4), label="Green")] = 0.1,
    blue: Annotated[float, Slider(-2, 2, "share of blue", explore=(0, 0.8), label="Blue")] = 0.5,
) -> Mixed:
    """Make a gray picture whose tones depend on colours, as black and white film does.

    red R + green G + blue B, clipped to 0..1. Shares with a sum of 1 keep grays; with a sum of 0 they select
    a colour: 0, 1 and -1 show yellow and green, such as fair hair and leaves, and neither skin nor sky.
    """
    row = np.array([red, green, blue, 0], np.float32)
    return Mixed(picture, np.stack([row, row, row]))
