"""Masks: regions of each frame, which steps read like saved pictures."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vidstyle.block import NAME_PATTERN, Color, Parameter, SavedRef, Slider, Switch
from vidstyle.block.reference_controls import Asset
from vidstyle.errors import suggest
from vidstyle.style.values import asset_path, read_values, to_text

PEOPLE, BACKGROUND = "people", "background"
REGIONS = (PEOPLE, BACKGROUND, "faces", "skin")
"""The masks that every style can read."""
BACKDROP = "backdrop"
"""The name of the picture or film that the user shows behind people."""
MAX_MASKS = 8
MAX_MASK_SIDE_PX = 8192
"""Maximum width and height of the picture of a mask."""
MAX_MASK_BYTES = 64 << 20
"""Maximum size of the file of a mask."""

_CONTROLS = {
    "color": Color("colour whose pixels are the mask", label="Mask colour"),
    "file": Asset("PNG picture that is the mask in every frame: white inside", Path, label="Mask picture"),
    "tolerance": Slider(
        0, 1, "distance from the colour up to which pixels are inside", label="Colour tolerance"
    ),
    "softness": Slider(0, 1, "width of the soft edge, as a distance from the colour", label="Soft edge"),
    "invert": Switch("whether to exchange inside and outside", label="Invert mask"),
}
_DEFAULTS: dict[str, Any] = {"color": "", "file": "", "tolerance": 0.15, "softness": 0.1, "invert": False}
MASK_VALUES = {name: Parameter(name, control, _DEFAULTS[name]) for name, control in _CONTROLS.items()}
"""The values of a mask that a style declares: one of `color` and `file`, and the others."""

Masks = Mapping[str, Mapping[str, Any]]
"""For each mask that a style declares, by name, the values that are in the file."""


def fixed_mask_level(name: str) -> float:
    """Return the level of a mask that is fixed: people fill the picture, and all other masks are empty."""
    return float(name == PEOPLE)


@dataclass(frozen=True)
class MaskRef(SavedRef):
    """The name of a mask."""

    range_text = "the name of a mask: " + ", ".join(REGIONS)

    def describe(self, is_integer: bool, saved: list[str]) -> dict[str, Any]:
        return super().describe(is_integer, [*saved, *REGIONS])


def read_masks(given: object, folder: Path | None, mistakes: list[str]) -> dict[str, dict[str, Any]]:
    """Return the masks in a style file; a line is appended to `mistakes` for each mistake."""
    if not isinstance(given, Mapping):
        mistakes.append(f'masks: {to_text(given)} is not a table; write screen = {{ color = "#00b140" }}')
        return {}
    if len(given) > MAX_MASKS:
        mistakes.append(f"masks: a style has at most {MAX_MASKS} masks")
        return {}
    return {
        name: _read_mask(f"masks.{name}: ", values, folder, mistakes)
        for name, values in given.items()
        if _is_free_name(name, mistakes)
    }


def _is_free_name(name: str, mistakes: list[str]) -> bool:
    if not re.fullmatch(NAME_PATTERN, name):
        mistakes.append(f"masks: {to_text(name)} is not a name of 1 to 64 letters, digits, _ and -")
    elif name in ("source", *REGIONS, BACKDROP):
        mistakes.append(f"masks: {name!r} is a picture of every style; choose another name")
    else:
        return True
    return False


def _read_mask(where: str, given: object, folder: Path | None, mistakes: list[str]) -> dict[str, Any]:
    if not isinstance(given, Mapping):
        mistakes.append(f'{where}{to_text(given)} is not a table; write {{ color = "#00b140" }}')
        return {}
    for key in given:
        if key not in MASK_VALUES:
            hint = suggest(str(key), MASK_VALUES)
            mistakes.append(f"{where}{to_text(key)} is not a value of a mask; {hint}")
    if ("color" in given) == ("file" in given):
        mistakes.append(f"{where}a mask has either color or file")
    values = read_values(MASK_VALUES, given, where, mistakes)
    if "file" in values:
        try:
            asset_path(folder, values["file"])
        except ValueError as error:
            mistakes.append(f"{where}file: {error}")
    return values
