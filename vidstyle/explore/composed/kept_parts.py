"""How often people kept random styles with the colours or the lines of each shipped style."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Literal

from vidstyle.style import Style

Part = Literal["colors", "lines"]

SHARES_FILE = Path(__file__).with_name("kept_parts.json")
"""For each part, the share of marks that were "keep" by shipped style, and of all styles as "mean"; computed
by `tools/explore/kept_parts.py` from 437 random styles on 38 photographs that three people marked."""
SHARE_POWER = 3.0
"""How strongly the share decides how often a part is drawn. Weights from four of five sets of marks would
have raised the kept share of the fifth from 54 to 64 % on average; rare parts are still drawn."""


def part_weight(part: Part, style: str) -> float:
    """Return how often a part of a shipped style is drawn, relative to the others.

    Args:
        style: its name, without variant.
    """
    return float(_kept_share(part, style) ** SHARE_POWER)


def parts_favor(style: Style) -> float:
    """Return how much its colours and tones speak for a style: log-odds of being kept, 0 on average.

    Lines do not count: with them, the order of sets of marks that were left out was worse.
    """
    return log_odds(_kept_share("colors", colors_origin(style))) - log_odds(_kept_share("colors", ""))


def colors_origin(style: Style) -> str:
    """Return the name of the shipped style that the colours come from; of other styles, their own name."""
    return style.colors_from or style.name.partition(":")[0]


def _kept_share(part: Part, style: str) -> float:
    shares = kept_shares()[part]
    return shares.get(style, shares["mean"])


@cache
def kept_shares() -> dict[Part, dict[str, float]]:
    """Return the content of `SHARES_FILE`."""
    shares: dict[Part, dict[str, float]] = json.loads(SHARES_FILE.read_text(encoding="utf-8"))
    return shares


def log_odds(share: float) -> float:
    """Return the logarithm of the odds of a share between 0 and 1."""
    return math.log(share / (1 - share))
