"""Random parameter values, and composition of steps into valid styles."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest
from random import Random
from typing import Any

from vidstyle.block import Parameter, Slider
from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError
from vidstyle.style import LAYERS, SOURCE, Step, Style, style_from_table, table_from_style
from vidstyle.style.knobs import with_valid_paths
from vidstyle.style.wiring import rename_pictures, wiring_of

MIN_WORKING_SCALE = 0.2
"""Smallest working size in random styles; below it, the subject is not recognizable."""
MAX_BLUR_SCALE, MIN_BLUR_SCALE = 0.13, 0.03
"""Largest and smallest working size of wide blurs, which a later step combines with a larger picture."""
LATEST = ""
"""Stands for the result of the latest step among the names of saved pictures."""


def random_value(random: Random, parameter: Parameter, ends: tuple[float, float] | None = None) -> Any:
    """Return a random value; `ends` overrides the range of a slider."""
    if ends is not None and isinstance(parameter.control, Slider):
        return parameter.control.draw_between(random, ends, parameter.is_integer)
    return parameter.draw(random)


def step_near(random: Random, step: Step, spread: float, names: Iterable[str] | None = None) -> Step:
    """Return a step with values near its current ones: those of `names`, or all that it has."""
    varied = step.values if names is None else names
    return with_values(step, lambda parameter, value: parameter.draw_near(random, value, spread), varied)


def random_step(random: Random, block: str) -> Step:
    """Return a step with random values."""
    parameters = all_blocks()[block].parameters
    return with_values(Step(block), lambda parameter, _: parameter.draw(random), parameters)


def with_values(step: Step, change: Callable[[Parameter, Any], Any], names: Iterable[str]) -> Step:
    """Return the step with some values changed; values that become defaults stay omitted."""
    if not step.block:
        return step
    parameters = all_blocks()[step.block].parameters
    values = dict(step.values)
    for name in names:
        parameter = parameters[name]
        values[name] = change(parameter, values.get(name, parameter.default))
    kept = {
        name: value
        for name, value in values.items()
        if name in step.values or value != parameters[name].default
    }
    return replace(step, values=kept)


def join_layers(style: Style, layers: Mapping[str, Iterable[Step]]) -> Style:
    """Return a style with some layers replaced; their saved pictures get unique names.

    Args:
        style: the style with the other layers.
        layers: the new steps.
    """
    taken = {step.save for layer in LAYERS if layer not in layers for step in style.layers[layer]}
    return with_layers(style, {layer: _renamed(layers[layer], taken) for layer in LAYERS if layer in layers})


def with_fitting_sizes(style: Style, layers: Iterable[str] = LAYERS) -> Style:
    """Return the style with valid working sizes in these layers: not too small, at most the picture."""
    for layer in LAYERS:
        if layer in layers:
            base = style.base if layer != "base" else ()
            style = replace(style, **{layer: tuple(_fit_sizes(style.layers[layer], base))})  # type: ignore[arg-type]
    return style


def with_layers(style: Style, layers: Mapping[str, Sequence[Step]]) -> Style:
    """Return the style with some layers replaced, without variants and what refers to removed steps."""
    steps: dict[str, Any] = {layer: tuple(steps) for layer, steps in layers.items()}
    return with_valid_paths(replace(style, **steps, variants={}))


def without_idle_steps(style: Style) -> Style:
    """Return the style without steps whose results are unused."""
    used = {name for step in style.steps for name in wiring_of(step).reads.values()}
    layers: dict[str, tuple[Step, ...]] = {}
    for layer, steps in style.layers.items():
        kept: list[Step] = []
        for step, after in zip_longest(steps, steps[1:]):
            step = replace(step, save=step.save if step.save in used else "")
            if step.save or not (after and after.source):
                kept.append(step)
        layers[layer] = tuple(kept)
    cleaned = with_layers(style, layers)
    return cleaned if cleaned == style else without_idle_steps(cleaned)


def is_valid(style: Style) -> bool:
    """Whether the style is valid as a file."""
    try:
        style_from_table(table_from_style(style), style.name, folder=style.folder)
    except StyleError:
        return False
    return bool(style.steps)


def _renamed(steps: Iterable[Step], taken: set[str]) -> list[Step]:
    """Return the steps with unique names for saved pictures; add the names to `taken`."""
    names: dict[str, str] = {}
    out = []
    for step in steps:
        step = rename_pictures(step, names)
        if step.save:
            name, number = step.save, 2
            while name in taken:
                name, number = f"{step.save}_{number}", number + 1
            names[step.save] = name
            taken.add(name)
            step = replace(step, save=name)
        out.append(step)
    return out


def _fit_sizes(steps: Iterable[Step], base: Sequence[Step]) -> list[Step]:
    """Return the steps with working sizes that are neither too small nor larger than the picture."""
    sizes = _sizes_after(base)
    out = []
    for step in steps:
        before = sizes[step.source or LATEST]
        if step.block == "scale":
            wanted = before * _factor_of(step)
            least = MIN_WORKING_SCALE if wanted > MAX_BLUR_SCALE else MIN_BLUR_SCALE
            factor = scale_factor(min(max(wanted, least), 1.0) / before)
            step = replace(step, values=step.values | {"factor": factor})
        _add_size(sizes, step)
        out.append(step)
    return out


def _sizes_after(steps: Iterable[Step]) -> dict[str, float]:
    """Return the working sizes of saved pictures and of the latest one, relative to the picture."""
    sizes = {SOURCE: 1.0, LATEST: 1.0}
    for step in steps:
        _add_size(sizes, step)
    return sizes


def _add_size(sizes: dict[str, float], step: Step) -> None:
    size = sizes[step.source or LATEST] * (_factor_of(step) if step.block == "scale" else 1.0)
    sizes |= {LATEST: size, step.save or LATEST: size}


def _factor_of(step: Step) -> float:
    return float(step.values.get("factor", all_blocks()["scale"].parameters["factor"].default))


def scale_factor(wanted: float) -> float:
    """Return the nearest factor that `scale` takes, in few digits."""
    control = all_blocks()["scale"].parameters["factor"].control
    assert isinstance(control, Slider)
    return control.nearest(wanted, is_integer=False)
