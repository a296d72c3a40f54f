"""Whether only numbers and colours of a style changed: keys of everything else."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from vidstyle.style.change import expand
from vidstyle.style.model import Step, Style
from vidstyle.style.resolve import ResolvedStep
from vidstyle.style.wiring import wiring_of


def structure_key(style: Style) -> tuple[object, ...]:
    """Return a key of a style that is equal if only numbers and colours differ.

    Values of the other controls may require other passes, kernels or files. A file of the user may have
    changed, so that styles that read one are never equal.
    """
    layers = expand(style).layers
    wirings = [(layer, *map(wiring_of, steps)) for layer, steps in layers.items()]
    values = [list(_structural_values(step)) for steps in layers.values() for step in steps]
    masks = style.only, style.keep, style.masks
    behind = style.behind and structure_key(style.behind)
    return style.is_plain, style.steady > 0, style.strength < 1, masks, behind, wirings, values


def measurement_key(layers: Mapping[str, tuple[ResolvedStep, ...]]) -> tuple[object, ...]:
    """Return a key of resolved steps without their values: while it is equal, measurements remain valid."""
    return tuple((layer, *(step.wiring for step in steps)) for layer, steps in layers.items())


def _structural_values(step: Step) -> Iterator[object]:
    block = wiring_of(step).block
    for name, parameter in block.parameters.items() if block else ():
        value = step.values.get(name, parameter.default)
        if parameter.control.own_file(value):
            yield object()
        elif parameter.control.changes_structure:
            yield value
