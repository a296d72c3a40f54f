"""Styles that show the output of one step."""

from __future__ import annotations

from dataclasses import replace

from vidstyle.style import Step, Style

AFTER_BASE = "after base"
"""A picture name that style files cannot use."""


def solo(style: Style, layer: str, place: int) -> Style:
    """Return a style whose result is the output of a step, without ink and paper."""
    style = replace(
        style,
        paper=Style.paper,
        strength=1.0,
        only="",
        keep="",
        behind=None,
        variants={},
        knobs=(),
        labels={},
    )
    if layer == "base":
        return replace(style, base=style.base[: place + 1], background=(), lines=())
    if layer == "background":
        return replace(style, background=style.background[: place + 1], lines=())
    # Lines may use what the background saves, and begin where the base has ended.
    background = (*style.background, Step("", source=AFTER_BASE), *style.lines[: place + 1])
    return replace(style, base=(*style.base, Step("", save=AFTER_BASE)), background=background, lines=())
