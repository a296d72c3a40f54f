"""A style made ready for pictures of one size: recipes expanded, lengths in pixels, assets read.

And keys that tell whether only numbers and colours of a style changed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from vidstyle.blade.bank import Bank
from vidstyle.blade.before.percentile_curve import SETTLE_SECONDS
from vidstyle.block import Asset, Block, PageRegion
from vidstyle.core.color.film_colors import FilmTable
from vidstyle.errors import StyleError
from vidstyle.style import SOURCE, Step, Style, expand
from vidstyle.style.mask_declarations import PEOPLE
from vidstyle.style.values import asset_path
from vidstyle.style.wiring import StepWiring, wire_layers, wiring_of

_Read = Callable[[Asset, Path], Any]


@dataclass(frozen=True)
class ResolvedStep:
    """A step with nothing left to look up.

    Attributes:
        wiring: its block, its channels, and the pictures that it reads and saves.
        values: every parameter as the function takes it, without those that name pictures.
    """

    wiring: StepWiring
    values: dict[str, Any]

    @property
    def block(self) -> Block | None:
        return self.wiring.block

    @property
    def settle(self) -> float | None:
        """Time constant in seconds of the percentiles that it measures; None if it measures none."""
        bank = self.values.get("bank")
        if isinstance(bank, Bank):
            return None if bank.curve is None else SETTLE_SECONDS
        is_measured = self.block is not None and self.block.kind == "measured"
        return float(self.values.get("settle", 0)) if is_measured else None


def has_fixed_marks(layers: Mapping[str, tuple[ResolvedStep, ...]]) -> bool:
    """Return whether any step of a style makes marks that lie still on the page, as dots and hatching do."""
    blocks = ((each.block, each.values) for each in _steps(layers) if each.block)
    marking = ((block, values) for block, values in blocks if PageRegion in block.injected.values())
    return any(not block.moves_for(values) for block, values in marking)


def has_moving_marks(layers: Mapping[str, tuple[ResolvedStep, ...]]) -> bool:
    """Return whether any step of a style makes marks that move with the objects of a film."""
    return any(map(_moves, _steps(layers)))


def _moves(step: ResolvedStep) -> bool:
    return step.block is not None and step.block.moves_for(step.values)


def _steps(layers: Mapping[str, tuple[ResolvedStep, ...]]) -> Iterator[ResolvedStep]:
    return (step for steps in layers.values() for step in steps)


def film_tables(layers: Mapping[str, tuple[ResolvedStep, ...]]) -> list[FilmTable]:
    """Return the tables of a style that hold the film's own colours."""
    values = (value for steps in layers.values() for step in steps for value in step.values.values())
    return [value for value in values if isinstance(value, FilmTable)]


def layers_behind(style: Style) -> dict[str, str]:
    """Return the names, in resolved steps, of the layers of `style.behind`, by the names in that style."""
    return {layer: f"behind.{layer}" for layer in style.layers} if style.behind else {}


def masks_read(style: Style) -> list[str]:
    """Return the names of the masks that a style reads, each once."""
    found = [style.only, style.keep]
    for wired in wire_layers(expand(style).layers, style.masks):
        reads = wired.wiring.reads.values()
        found += [name for name in reads if name != SOURCE and wired.savers[name] is None]
    if style.behind is not None:
        found += [*masks_read(style.behind), PEOPLE]
    return list(dict.fromkeys(filter(None, found)))


def resolve(style: Style, height: int, width: int) -> dict[str, tuple[ResolvedStep, ...]]:
    """Return the steps of each layer for pictures of this size, and of `layers_behind`.

    Lengths of a style that names a `height` grow with the picture's shorter side, so that a turned
    picture looks alike, and edges keep their width in pixels. Scaled values stay in the range of their
    sliders, except for lengths, which may be longer.

    Raises:
        StyleError: an asset cannot be read.
    """
    growth = 1.0 if style.height is None else min(height, width) / style.height
    read = cache(lambda control, path: control.read(path))  # once for all steps
    steps = {
        layer: tuple(_prepare_step(style, step, growth, read) for step in steps)
        for layer, steps in expand(style).layers.items()
    }
    behind = resolve(style.behind, height, width) if style.behind else {}
    return steps | {name: behind[layer] for layer, name in layers_behind(style).items()}


def _prepare_step(style: Style, step: Step, growth: float, read: _Read) -> ResolvedStep:
    wiring = wiring_of(step)
    block = wiring.block
    if block is None:
        return ResolvedStep(wiring, {})
    values = block.arguments_for(step.values)
    values = {
        name: _prepare_value(
            style,
            block.parameters[name].control.scale(value, growth, values, style.detail),
            block,
            name,
            read,
        )
        for name, value in values.items()
        if name not in block.saved_refs
    }
    return ResolvedStep(wiring, values)


def _prepare_value(style: Style, value: Any, block: Block, name: str, read: _Read) -> Any:
    control = block.parameters[name].control
    if isinstance(control, Asset) and value:
        try:
            shipped = control.shipped()
            return read(control, shipped[value] if value in shipped else asset_path(style.folder, value))
        except (ValueError, OSError) as error:
            raise StyleError(style.name, [f"{block.name}: {name}: {value!r}: {error}"]) from None
    return value


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
    """Return a key of resolved steps without their values: while it is equal, memory remains valid."""
    return tuple(
        (layer, *((step.wiring, step.settle is None, _moves(step)) for step in steps))
        for layer, steps in layers.items()
    )


def _structural_values(step: Step) -> Iterator[object]:
    block = wiring_of(step).block
    for name, parameter in block.parameters.items() if block else ():
        value = step.values.get(name, parameter.default)
        if parameter.control.own_file(value):
            yield object()
        elif parameter.control.changes_structure:
            yield value
