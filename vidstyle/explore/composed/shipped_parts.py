"""Parts of the shipped styles that random styles are composed of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

from vidstyle.assets import asset_folder
from vidstyle.style import SOURCE, Step, Style, load_style, style_from_table
from vidstyle.style.variants import table_of_variant
from vidstyle.style.wiring import wiring_of

HANDMADE_KINDS = {"drawn", "painted", "printed"}
"""Kinds of looks that are marks on paper or canvas. Lines of one suit the colours of another."""
MAX_GRAIN_PX, MAX_GRAIN_AMOUNT = 2.5, 0.2
"""Size and amount of noise that is the grain of a paper, not marks."""


def shipped_styles() -> list[Style]:
    """Return the styles that come with the program, sorted by name."""
    return [load_style(path) for path in sorted(asset_folder("styles").glob("*.toml"))]


@cache
def families() -> tuple[tuple[Style, ...], ...]:
    """Return each shipped style with its variants, itself first."""
    return tuple((style, *_variants(style)) for style in shipped_styles())


def _variants(style: Style) -> Iterator[Style]:
    for name in style.variants:
        yield style_from_table(table_of_variant(style, name), style.name, folder=style.folder)


def whole_layer(style: Style, layer: str) -> list[Step]:
    """Return the steps of the base and of a layer, which start from the source."""
    if not style.layers[layer]:
        return []
    first, *others = *style.base, *style.layers[layer]
    return [replace(first, source=first.source or SOURCE), *others]


def is_handmade(style: Style) -> bool:
    """Whether a style is marks on paper or canvas only."""
    return HANDMADE_KINDS.issuperset(style.kinds)


def draws_tones(style: Style) -> bool:
    """Whether the lines of a style alone draw the picture: the colours below are only a tint."""
    return not style.background or any(step.block == "line_screen" for step in style.lines)


@cache
def single_steps(layer: str) -> tuple[Step, ...]:
    """Return the steps of a layer, in all shipped styles, that neither read nor save other pictures."""
    steps = (step for style in shipped_styles() for step in style.layers[layer])
    return tuple(step for step in steps if step.block and not (wiring_of(step).reads or step.save))


@cache
def paper_grains() -> tuple[Step, ...]:
    """Return the fine noise of handmade styles."""
    steps = (step for style in shipped_styles() if is_handmade(style) for step in style.background)
    return tuple(
        replace(step, save="")
        for step in steps
        if step.block == "noise"
        and step.values["kind"] == "soft"
        and not step.values.get("colored")
        and step.values["size"] <= MAX_GRAIN_PX
        and step.values["amount"] <= MAX_GRAIN_AMOUNT
    )
