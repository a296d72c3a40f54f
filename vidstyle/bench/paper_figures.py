"""The speeds that the paper gives: Garcia-Dorado et al., IET Computer Vision 2020, table 1."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PaperFigure:
    """Megapixels a second of one of the paper's styles.

    Attributes:
        style: its number.
        desktop: on a GTX 1080.
        mobile: on a Pixel 2018.
    """

    style: int
    desktop: float
    mobile: float


# fmt: off
SPEEDS = (
    (1719.4, 124.4), (2405.5, 156.9), (1469.1, 128.4), (357.5, 30.3), (1469.4, 92.3), (458.7, 40.0),
    (1637.5, 131.0), (2295.9, 169.4), (675.2, 114.0), (4069.9, 241.8), (4138.8, 240.7), (1804.9, 126.0),
    (1323.3, 101.3),
)
# fmt: on
"""On the desktop and the mobile GPU, style by style."""
FIGURES = tuple(PaperFigure(number, *speeds) for number, speeds in enumerate(SPEEDS, start=1))
"""All of them. Single filters the paper gives only as a drawing, from which no numbers can be read."""

BLADE_ETF_XEON = 27.1
"""Megapixels a second of one pass of learned ETF on a CPU, a Xeon E5-1650v3 (section 5.4.2)."""
BLADE_MOBILE = (38.21, 223.03)
"""Megapixels a second of learned 5 x 5 filters on a Pixel 2018, on its CPU and its GPU (section 2.4)."""

ALIKE = {"ink": 1, "crayon": 2, "sketch": 3, "abstraction": 4, "paint": 5, "blob": 6}
"""Which of its styles ours were made after: the six that the paper describes in words (section 6.1).

Alike are the look and the filters that the words name: for instance Flow-XDoG, a threshold, Gaussian
smoothing and a tint in style 1. The values, and how often a filter runs, the paper does not give, and ours
first adapt to how light the picture is: so the speeds are of like looks, not of equal work. Styles 7 to 13
are only shown as pictures, and none of ours claims to be one of them."""


def figure_for(style: str) -> PaperFigure | None:
    """The figure of the paper's style that one of ours was made after, if there is one."""
    return next((figure for figure in FIGURES if figure.style == ALIKE.get(style)), None)
