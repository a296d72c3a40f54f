"""Speeds published in the paper: Garcia-Dorado et al., IET Computer Vision 2020, table 1."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PaperFigure:
    """Speed of a style of the paper in megapixels per second.

    Attributes:
        style: its number.
        desktop: on a GTX 1080.
        mobile: on a Pixel 2018.
    """

    style: int
    desktop: float
    mobile: float


# fmt: off
PAPER_SPEEDS = (
    (1719.4, 124.4), (2405.5, 156.9), (1469.1, 128.4), (357.5, 30.3), (1469.4, 92.3), (458.7, 40.0),
    (1637.5, 131.0), (2295.9, 169.4), (675.2, 114.0), (4069.9, 241.8), (4138.8, 240.7), (1804.9, 126.0),
    (1323.3, 101.3),
)
# fmt: on
"""Speed on the desktop and the mobile GPU for each style."""
PAPER_FIGURES = tuple(PaperFigure(number, *speeds) for number, speeds in enumerate(PAPER_SPEEDS, start=1))
"""The speeds of all styles. For single filters the paper only has a chart without numbers."""

XEON_ETF_SPEED = 27.1
"""Megapixels per second of one pass of learned ETF on a CPU, a Xeon E5-1650v3 (section 5.4.2)."""
MOBILE_FILTER_SPEEDS = (38.21, 223.03)
"""Megapixels per second of learned 5 x 5 filters on the CPU and the GPU of a Pixel 2018 (section 2.4)."""

PAPER_STYLE_NUMBERS = {"ink": 1, "crayon": 2, "sketch": 3, "cartoon": 4, "impressionist": 5}
"""The style of the paper that each style resembles: five of the six that the paper describes (section 6.1).

The look is the same, and so are the filters named in the description, except for `OTHER_FILTERS`. The paper
states neither parameters nor the number of passes, and the styles here adapt to the brightness of the picture
first, so that speeds compare similar looks, not equal work. Style 6 has no counterpart any more, and styles 7
to 13 of the paper, which are only shown as pictures, never had one."""

OTHER_FILTERS = {
    "crayon": "`strokes` for the grain",
    "sketch": "`lic` for the hatching",
    "cartoon": "`kuwahara` for ETF",
    "impressionist": "`strokes` for the brush of ETF",
}
"""Styles that replace a filter of the paper's style: the filter here, and the one of the paper."""


def figure_for(style: str) -> PaperFigure | None:
    """Return the figure of the paper for the style that `style` is modelled on, or None."""
    return next((figure for figure in PAPER_FIGURES if figure.style == PAPER_STYLE_NUMBERS.get(style)), None)
