"""Luma posterization: a few flat tones, colours kept."""

from __future__ import annotations

from typing import Annotated, Any

from vidstyle.block import Block, block
from vidstyle.blocks.posterize import posterize


@block("recipe", on="luma")
def luma_posterize(
    levels: Annotated[int, posterize.parameters["levels"].control] = posterize.parameters["levels"].default,
    softness: Annotated[float, posterize.parameters["softness"].control] = posterize.parameters[
        "softness"
    ].default,
) -> list[tuple[Block, dict[str, Any]]]:
    """Reduce luma to a few flat tones and keep the colours.

    Paper, section 4.2 A: posterization between to_gray and to_color.
    """
    return [(posterize, {"levels": levels, "softness": softness})]
