"""The rules of the paper for random styles (section 6.2), as data."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

Rules = Literal["open", "paper"]

STYLE_HEIGHT = 720
"""The height of random styles, to which lengths refer; same as in the shipped styles."""
DEFAULT_STEADY = 0.5
"""Temporal smoothing of random styles; same as in the shipped styles."""

PAPER_HEIGHT = 1080
"""The height to which the paper's lengths refer: full HD, the size at which it shows its filters in real time
on a phone."""
FULL_SIZE = 300
"""The paper's size that stands for the size of the picture."""
LINE_VARIANCE_RATIO = 0.5
"""Variance of lines, in squared pixels, relative to the paper's sigma. At 1, lines of masts, eyes and blades
of grass ran together, and people rejected most styles."""
TONE_RAMP_SHARE = 0.4
"""Share of each step of tones that is a ramp: hard steps drew pale spots and bands on cheeks, for which
people rejected all 15 styles of a portrait, and 0.8 leaves a smoothed photograph."""
PAPER_SECTION = "paper, section 6.2"


@dataclass(frozen=True)
class FilterRule:
    """A filter of random styles.

    Attributes:
        block: the block that is this filter.
        parameters: parameters drawn uniformly from the range that the block declares for random styles.
        ends: ranges of parameters whose unit in the paper differs, in the unit of the block.
        fixed: values that differ from the defaults of the block.
        repeats: whether a style may use it more than once.
        source: where the paper defines it, and how we interpret it.
    """

    block: str
    parameters: tuple[str, ...] = ()
    ends: dict[str, tuple[float, float]] = field(default_factory=dict)
    fixed: dict[str, float | str] = field(default_factory=dict)
    repeats: bool = False
    source: str = PAPER_SECTION


FILTER_COUNT_RANGE = (4, 9)
"""Minimum and maximum number of filters, including conversion to gray; uniformly distributed."""
GRAY_SHARE = 0.2
"""Share of styles with a conversion to gray, at a random position."""
GRAY_RULE = FilterRule("to_gray", source=f"{PAPER_SECTION}: To GrayScale (20 % probability)")

FILTER_RULES = (
    FilterRule(
        "flow_dog",
        ("p",),
        ends={"sigma": (math.sqrt(LINE_VARIANCE_RATIO * 0.5), math.sqrt(LINE_VARIANCE_RATIO * 8))},
        repeats=True,
        source=f"{PAPER_SECTION}: XDoG (sigma 0.5 to 8, p 1 to 40). Section 4.2 C calls sigma the variance "
        "of the Gaussian, and 7 x 7 filters hold no deviation of 8 pixels, so our deviation is the root of "
        "its half. The threshold is a separate filter, as in section 4.2 C, where Flow-XDoG has no other "
        "parameters",
    ),
    FilterRule(
        "tvf",
        fixed={"passes": 2, "flow": "variation", "time": 8.0, "accurate": True},
        repeats=True,
        source=f"{PAPER_SECTION}: TVF, without parameters. Section 4.2 B says that it makes a picture "
        "piecewise constant, which is the flow of total variation. Two long passes flatten skin, water and "
        "grass, of which lines would be worms; several TVF share the time of one, as three people kept none "
        "of 17 styles that smoothed two or three times as much",
    ),
    FilterRule(
        "soft_threshold",
        ("phi", "epsilon"),
        source=f"{PAPER_SECTION}: Soft Threshold (phi 0.013 to 0.059, epsilon 50 to 110)",
    ),
    FilterRule("detail", ("delta",), source=f"{PAPER_SECTION}: Detail Control (delta -100 to 60)"),
    FilterRule(
        "luma_posterize",
        ("levels",),
        fixed={"softness": TONE_RAMP_SHARE},
        source=f"{PAPER_SECTION}: Luma Posterization (level 5 to 12), with soft transitions",
    ),
    FilterRule("saturation", ("factor",), source=f"{PAPER_SECTION}: Saturation (saturation 1.5 to 2.2)"),
    FilterRule(
        "scale",
        ends={"factor": (math.sqrt(100 / FULL_SIZE), 1)},
        source=f"{PAPER_SECTION}: Size (size 100 to 300), read as a number of pixels, and {FULL_SIZE} as the "
        "full size: results in the paper are sharp, which a height of 100 to 300 lines cannot give",
    ),
)
"""Filters of random styles; all that are still allowed are equally likely."""

MAX_GAIN = 41.0
"""Limit for the product of 1 + p of all XDoG filters of a style: each amplifies detail by 1 + p, and the
paper's range ends at a p of 40."""
SMOOTH_BLOCK, LINE_BLOCK, CUT_BLOCK, TONES_BLOCK = "tvf", "flow_dog", "soft_threshold", "luma_posterize"
"""Each style has the two layers of section 4: lines, which are XDoG and its threshold (section 5.4.3), over a
background of the other filters. TVF comes before both, as lines would draw the noise of smooth areas
otherwise. Without lines, or without flat tones, a style only smooths the photograph: of 120 styles by a
reading with one layer, in which XDoG sharpened the colours, three people kept 15."""
DETAIL_BLOCK, COLOR_BLOCK = "detail", "saturation"
"""Detail comes before TVF: after it, it blurred edges of flat tones or drew rings around them, and of 46 such
styles people kept 4. Colours follow TVF."""
