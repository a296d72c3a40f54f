"""The paper's rules for random styles (section 6.2), as data."""

from __future__ import annotations

from dataclasses import dataclass, field

STYLE_HEIGHT = 720
"""The picture height for which random styles give lengths; that of the shipped styles."""
DEFAULT_STEADY = 0.5
"""Temporal smoothing of random styles; that of the shipped styles."""

PAPER_SECTION = "paper, section 6.2"


@dataclass(frozen=True)
class FilterRule:
    """A filter that a random style may have.

    Attributes:
        block: the block that is this filter.
        parameters: those that are drawn evenly from the ends that the block declares for random styles.
        ends: those whose ends have another unit in the paper, with their ends in the block's.
        repeats: whether a style may have it more than once.
        source: where it is said, and how it is read.
    """

    block: str
    parameters: tuple[str, ...] = ()
    ends: dict[str, tuple[float, float]] = field(default_factory=dict)
    repeats: bool = False
    source: str = PAPER_SECTION


FILTER_COUNT_RANGE = (4, 9)
"""How many filters a style has, the conversion to gray among them; any number is as likely."""
GRAY_SHARE = 0.2
"""The share of styles that are converted to gray, at any place among their filters."""
GRAY_RULE = FilterRule("to_gray", source=f"{PAPER_SECTION}: To GrayScale (20 % probability)")

FILTER_RULES = (
    FilterRule(
        "flow_dog",
        ("sigma", "p"),
        repeats=True,
        source=f"{PAPER_SECTION}: XDoG (sigma 0.5 to 8, p 1 to 40). Its threshold is a filter by itself, as in "
        "section 4.2 C, where Flow-XDoG has no other parameters",
    ),
    FilterRule("tvf", repeats=True, source=f"{PAPER_SECTION}: TVF, without parameters"),
    FilterRule(
        "soft_threshold",
        ("phi", "epsilon"),
        source=f"{PAPER_SECTION}: Soft Threshold (phi 0.013 to 0.059, epsilon 50 to 110)",
    ),
    FilterRule("detail", ("delta",), source=f"{PAPER_SECTION}: Detail Control (delta -100 to 60)"),
    FilterRule("luma_posterize", ("levels",), source=f"{PAPER_SECTION}: Luma Posterization (level 5 to 12)"),
    FilterRule("saturation", ("factor",), source=f"{PAPER_SECTION}: Saturation (saturation 1.5 to 2.2)"),
    FilterRule(
        "scale",
        ends={"factor": (100 / STYLE_HEIGHT, 300 / STYLE_HEIGHT)},
        source=f"{PAPER_SECTION}: Size (size 100 to 300), read as the working height where it is {STYLE_HEIGHT}",
    ),
)
"""Each filter is as likely as any other that may still come; their order is that in which they are drawn."""
