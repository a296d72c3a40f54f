"""The style as plain data: layers of steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vidstyle.block import Color, Control, On, Parameter, Slider
from vidstyle.style.mask_declarations import MaskRef, Masks

LAYERS = ("base", "background", "lines")
"""The layers in the order in which they run; a step may use the pictures that earlier ones saved."""

SOURCE = "source"
"""The name of the input picture; every step may start from it."""

STEP_KEYS = ("block", "from", "save", "mute")
"""The keys of a step that are not parameters of its block."""


@dataclass(frozen=True)
class Step:
    """One step of a layer.

    Attributes:
        block: the name of a block, or empty for a step that only saves or selects a picture.
        values: parameters that differ from the block's defaults; colours and paths as text.
        save: the name under which the result is saved, or empty.
        source: the input, `from` in the file: a saved name or "source"; empty for the previous step.
        on: overrides what the block works on; only recipes set it.
        mute: whether to bypass the block: the input passes through, and is saved.
    """

    block: str
    values: dict[str, Any] = field(default_factory=dict)
    save: str = ""
    source: str = ""
    on: On | None = None
    mute: bool = False


KINDS = {
    "drawn": "Drawn",
    "painted": "Painted",
    "printed": "Printed",
    "screen": "On a screen",
    "film": "On film",
}
"""The kinds of looks that a style file may name, with the headings of lists."""


@dataclass(frozen=True)
class Style:
    """A named graph of filter blocks.

    `base` runs first and feeds the two others; `background` is the colour layer, multiplied by `paper`;
    `lines` is the coverage of the ink over it: lines * background + (1 - lines) * ink.

    Attributes:
        height: the picture height for which lengths ("px") are given; None uses them unchanged.
        steady: temporal smoothing, 0 to 1.
        strength: how much of the result is mixed with the source, 0 to 1.
        focus: how much finer the detail in small faces is, and how much writing is drawn, 0 to 1; needs a
            `height`.
        detail: factor by which lengths are shorter, up to `Slider.max_detail`; style files do not have it.
        keeps_detail: whether small faces and small pictures do not change the size of marks, because the user
            has chosen the detail or the height; style files do not have it.
        only: the mask inside which the style applies, or empty for the whole picture.
        keep: a mask inside which the source is kept, or empty.
        masks: the masks that the style declares, by name.
        behind: the style of everything except people, or None; its own `behind`, `masks`, `steady` and
            `focus` have no effect.
        folder: the folder to which paths in the style are relative; None where paths are not allowed.
        variants: for each variant's name the values that it sets, by their paths.
        kinds: what kind of look it is, of `KINDS`.
        aliases: other names by which a search finds the look, separated by commas, the most fitting first.
        knobs: the paths of the values that are worth adjusting first.
        labels: what values do in this style, by their paths, see `knobs`.
        replaces: the names of retired shipped styles, separated by spaces, that load this one; only shipped
            styles are searched for them.
        colors_from: the shipped style that the colours and tones of a random style come from.
    """

    name: str
    note: str = ""
    height: float | None = None
    ink: str = "#000000"
    paper: str = "#ffffff"
    steady: float = 0.0
    strength: float = 1.0
    focus: float = 1.0
    detail: float = 1.0
    keeps_detail: bool = False
    only: str = ""
    keep: str = ""
    base: tuple[Step, ...] = ()
    background: tuple[Step, ...] = ()
    lines: tuple[Step, ...] = ()
    folder: Path | None = None
    variants: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    kinds: tuple[str, ...] = ()
    aliases: str = ""
    knobs: tuple[str, ...] = ()
    labels: Mapping[str, str] = field(default_factory=dict)
    masks: Masks = field(default_factory=dict)
    behind: Style | None = None
    replaces: str = ""
    colors_from: str = ""

    @property
    def summary(self) -> str:
        """The first sentence of the note."""
        first, end, _ = self.note.partition(". ")
        return f"{first}{end.rstrip()}"

    @property
    def about(self) -> str:
        """The note without its end, which names the paths of values to tune."""
        return self.note.partition(" Tune ")[0]

    @property
    def is_plain(self) -> bool:
        """Whether it changes no picture."""
        own = bool(self.steps or self.behind)
        return not own and self.paper == Style.paper and self.steady == 0

    @property
    def layers(self) -> dict[str, tuple[Step, ...]]:
        """The steps of each layer, in the order in which they run."""
        return {layer: getattr(self, layer) for layer in LAYERS}

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps of all layers, in the order in which they run."""
        return self.base + self.background + self.lines


_CONTROLS: dict[str, Control] = {
    "height": Slider(
        16,
        65536,
        "picture height for which lengths in px are meant; they grow with taller pictures",
        unit="px",
        label="Reference height",
    ),
    "ink": Color("of outlines, hatching and solid shapes", label="Line colour", aliases=("ink", "pen")),
    "paper": Color(
        "colour of the paper, which tints the background", label="Paper colour", aliases=("paper", "canvas")
    ),
    "steady": Slider(
        0,
        1,
        "calms flicker while the film plays; 0 for off, 1 for strongest",
        label="Steadiness",
        aliases=("flicker", "shimmer", "boiling", "stabilize", "smooth over time"),
    ),
    "strength": Slider(
        0,
        1,
        "how much of the style is mixed with the source",
        label="Style strength",
        aliases=("opacity", "mix", "amount", "blend with the original", "fade"),
    ),
    "focus": Slider(
        0,
        1,
        "finer detail in small faces, and legible writing, from 0 (off) to 1",
        label="Detail in faces",
        aliases=("face", "portrait", "people", "eyes", "text", "letters", "handwriting"),
    ),
    "only": MaskRef(
        "mask inside which the style applies",
        on="luma",
        optional=True,
        none="everywhere",
        label="Only inside",
        aliases=("mask", "region", "people", "person", "face", "background", "green screen"),
    ),
    "keep": MaskRef(
        "mask inside which the source is kept",
        on="luma",
        optional=True,
        none="nothing",
        label="Keep original inside",
        aliases=("mask", "region", "people", "person", "face", "background"),
    ),
}
FIELDS = {name: Parameter(name, control, getattr(Style, name)) for name, control in _CONTROLS.items()}
"""The fields of a style that are values, declared like the parameters of blocks."""


def table_from_style(style: Style) -> dict[str, Any]:
    """Return the style in the form of a style file, without values at their defaults.

    >>> table_from_style(Style("flat", background=(Step("posterize", {"levels": 5}),)))
    {'format': 1, 'name': 'flat', 'background': [{'block': 'posterize', 'levels': 5}]}
    """
    table: dict[str, Any] = {"format": 1, "name": style.name}
    values = {name: getattr(style, name) for name in ("note", "aliases", "replaces", "colors_from", *FIELDS)}
    table |= {name: value for name, value in values.items() if value != getattr(Style, name)}
    table |= {"kinds": list(style.kinds)} if style.kinds else {}
    table |= {"knobs": list(style.knobs)} if style.knobs else {}
    table |= {"labels": dict(style.labels)} if style.labels else {}
    table |= {layer: list(map(_table_from_step, steps)) for layer, steps in style.layers.items() if steps}
    table |= {"masks": {name: dict(each) for name, each in style.masks.items()}} if style.masks else {}
    if style.behind is not None:
        behind = table_from_style(style.behind)
        table["behind"] = {key: each for key, each in behind.items() if each != "" and key != "format"}
    if style.variants:
        table["variants"] = {name: dict(values) for name, values in style.variants.items()}
    return table


def step_from_table(table: Mapping[str, Any]) -> Step:
    """Return a step as a style file holds it, whether it is valid or not."""
    values = {name: value for name, value in table.items() if name not in STEP_KEYS}
    block, source, save = (str(table.get(key, "")) for key in ("block", "from", "save"))
    return Step(block, values, save, source, mute=bool(table.get("mute")))


def _table_from_step(step: Step) -> dict[str, Any]:
    names = {"block": step.block, "from": step.source, "save": step.save}
    muted = {"mute": True} if step.mute else {}
    return {key: name for key, name in names.items() if name} | step.values | muted
