"""A style as plain data: layers of steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vidstyle.block import Color, Control, On, Slider

LAYERS = ("base", "background", "lines")
"""The layers in the order in which they run; a step sees what earlier ones have saved."""

SOURCE = "source"
"""The name of the untouched picture; every step may start from it."""

FIELDS: dict[str, Control] = {
    "height": Slider(16, 65536, "the picture's height for which lengths are meant", unit="px"),
    "ink": Color("what the lines are drawn in"),
    "paper": Color("what the background lies on"),
    "steady": Slider(0, 1, "how much of what flickers in a film is held: 0 lets it boil, 1 keeps it still"),
}
"""The fields of a style that are values, declared as the parameters of blocks are."""


@dataclass(frozen=True)
class Step:
    """One step of a layer.

    Attributes:
        block: the name of a block, or empty for a step that only saves or starts anew.
        values: parameters that differ from the block's defaults; colours and paths as text.
        save: the name under which the result is kept, or empty.
        source: where it starts, `from` in the file: a saved name or "source"; empty is the step before.
        on: what the block works on instead of what it declares; only recipes set it.
    """

    block: str
    values: dict[str, Any] = field(default_factory=dict)
    save: str = ""
    source: str = ""
    on: On | None = None


@dataclass(frozen=True)
class Style:
    """A named look.

    `base` runs first and feeds the two others; `background` is the colour layer; `lines` is laid over
    it: lines * background + (1 - lines) * ink. `paper` multiplies the background.

    Attributes:
        height: the height of picture that lengths ("px") are meant for; None takes them as they are.
        steady: how much of what flickers in a film is held, 0 to 1.
        folder: where the paths in the style start, or None when it may hold no paths.
        variants: values to be set on the style, by their paths, under the name of each variant.
    """

    name: str
    note: str = ""
    height: float | None = None
    ink: str = "#000000"
    paper: str = "#ffffff"
    steady: float = 0.0
    base: tuple[Step, ...] = ()
    background: tuple[Step, ...] = ()
    lines: tuple[Step, ...] = ()
    folder: Path | None = None
    variants: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def is_plain(self) -> bool:
        """Whether it leaves every picture as it is."""
        return not self.steps and self.paper == Style.paper and self.steady == 0

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps of all layers, in the order in which they run."""
        return self.base + self.background + self.lines


def table_from_style(style: Style) -> dict[str, Any]:
    """The style as a style file holds it, without what is at its default.

    >>> table_from_style(Style("flat", background=(Step("posterize", {"levels": 5}),)))
    {'format': 1, 'name': 'flat', 'background': [{'block': 'posterize', 'levels': 5}]}
    """
    table: dict[str, Any] = {"format": 1, "name": style.name}
    for name in ("note", *FIELDS):
        if getattr(style, name) != getattr(Style, name):
            table[name] = getattr(style, name)
    for layer in LAYERS:
        if steps := getattr(style, layer):
            table[layer] = [_table_from_step(step) for step in steps]
    if style.variants:
        table["variants"] = {name: dict(values) for name, values in style.variants.items()}
    return table


def _table_from_step(step: Step) -> dict[str, Any]:
    words = {"block": step.block, "from": step.source, "save": step.save}
    return {key: word for key, word in words.items() if word} | step.values
