"""The style that shows what leaves one step of another."""

from __future__ import annotations

from dataclasses import replace

from vidstyle.style import Step, Style

AFTER_BASE = "after base"
"""A name that no style file can have."""


def solo(style: Style, layer: str, place: int) -> Style:
    """The style whose result is the picture that leaves a step, on white paper and with no ink over it."""
    style = replace(style, paper=Style.paper, strength=1.0, variants={}, knobs=())
    if layer == "base":
        return replace(style, base=style.base[: place + 1], background=(), lines=())
    if layer == "background":
        return replace(style, background=style.background[: place + 1], lines=())
    # Lines may use what the background saves, and begin where the base has ended.
    background = (*style.background, Step("", source=AFTER_BASE), *style.lines[: place + 1])
    return replace(style, base=(*style.base, Step("", save=AFTER_BASE)), background=background, lines=())
