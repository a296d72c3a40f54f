"""Styles with values between the values of two others."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from vidstyle.blocks import all_blocks
from vidstyle.style import Step, Style
from vidstyle.style.model import FIELDS


def differ_in_values_only(one: Style, other: Style) -> bool:
    """Whether two styles have the same steps and regions, so that one can move to the other."""
    return _without_values(one) == _without_values(other)


def style_between(one: Style, other: Style, share: float) -> Style:
    """Return a style between two that differ in values only.

    Numbers and colours move; other values jump at the end.

    Args:
        share: 0 for the first style, 1 for the second.
    """
    fields = {
        name: field.between(getattr(one, name), getattr(other, name), share) for name, field in FIELDS.items()
    }
    layers: dict[str, Any] = {
        layer: tuple(
            _step_between(step, after, share) for step, after in zip(steps, other.layers[layer], strict=True)
        )
        for layer, steps in one.layers.items()
    }
    return replace(one, **fields, **layers)


def _without_values(style: Style) -> tuple[object, ...]:
    steps = [[replace(step, values={}) for step in steps] for steps in style.layers.values()]
    return style.folder, style.only, style.keep, style.masks, style.behind, steps


def _step_between(one: Step, other: Step, share: float) -> Step:
    if one.values == other.values:
        return one
    parameters = all_blocks()[one.block].parameters
    values = {
        name: parameter.between(
            one.values.get(name, parameter.default), other.values.get(name, parameter.default), share
        )
        for name, parameter in parameters.items()
        if name in one.values or name in other.values
    }
    return replace(one, values=values)
