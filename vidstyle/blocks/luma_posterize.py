"""Luma posterization: a few flat tones, colours kept."""

from __future__ import annotations

from typing import Annotated, Any

from vidstyle.block import Block, block
from vidstyle.blocks.posterize import posterize

_TONE_PARAMETERS = posterize.parameters


@block(
    "recipe",
    on="luma",
    label="Flat tones",
    category="tone",
    aliases=(
        "posterize, cartoon, toon, cel shading, anime, steps, bands, simplify, levels, fewer tones, abstract"
    ),
)
def luma_posterize(
    levels: Annotated[int, _TONE_PARAMETERS["levels"].control] = _TONE_PARAMETERS["levels"].default,
    softness: Annotated[float, _TONE_PARAMETERS["softness"].control] = _TONE_PARAMETERS["softness"].default,
) -> list[tuple[Block, dict[str, Any]]]:
    """Reduce light and shade to a few flat tones; colours stay.

    Luma is quantized, chroma is kept. Paper, section 4.2 A: `posterize` between `to_gray` and `to_color`.
    """
    return [(posterize, {"levels": levels, "softness": softness})]
