"""Random parameter values, and composition of steps into valid styles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest
from random import Random
from typing import Any

from vidstyle.block import Parameter, Slider
from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError
from vidstyle.explore.phrases import BASE_RESULT, names_used
from vidstyle.style import LAYERS, SOURCE, Step, Style, style_from_table, table_from_style
from vidstyle.style.knobs import with_valid_paths
from vidstyle.style.wiring import rename_pictures, wiring_of

MIN_WORKING_SCALE = 0.2
"""Smallest working size in random styles; below it, the subject is not recognizable."""
EDGE_BLOCKS = ("luma_posterize", "posterize", "soft_threshold")
"""Blocks that turn gradients into edges."""
MIN_BLUR_SCALE = 0.125
"""Smallest working size of wide blurs."""


def random_value(random: Random, parameter: Parameter, ends: tuple[float, float] | None = None) -> Any:
    """Return a random value; `ends` overrides the range of a slider."""
    if ends is not None and isinstance(parameter.control, Slider):
        return parameter.control.draw_between(random, ends, parameter.is_integer)
    return parameter.draw(random)


def step_near(random: Random, step: Step, spread: float, names: Iterable[str] | None = None) -> Step:
    """Return a step with values near its current ones: those of `names`, or all that it has."""
    varied = step.values if names is None else names
    return _with(step, lambda parameter, value: parameter.draw_near(random, value, spread), varied)


def random_step(random: Random, block: str, ends: Mapping[str, tuple[float, float]] | None = None) -> Step:
    """Return a step with random values."""
    parameters = all_blocks()[block].parameters
    given = ends or {}
    return _with(
        Step(block),
        lambda parameter, _: random_value(random, parameter, given.get(parameter.name)),
        parameters,
    )


def _with(step: Step, change: Any, names: Iterable[str]) -> Step:
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
    """Return a style with some layers replaced.

    Args:
        style: the style with the other layers.
        layers: the new steps. `BASE_RESULT` stands for the result of the base layer; saved pictures get
            unique names, and working sizes are limited to `MIN_WORKING_SCALE`..1.
    """
    built = {layer: list(steps) for layer, steps in style.layers.items() if layer not in layers}
    taken = {step.save for steps in built.values() for step in steps}
    for layer in LAYERS:
        if layer in layers:
            base = built.get("base", []) if layer != "base" else []
            steps = [step for step in _fit_sizes(layers[layer], base) if not _is_idle(step)]
            if layer != "base":
                steps = _sharpen(steps, base)
            built[layer] = _on_base(rename_saved(steps, taken), base, taken)
    return with_layers(style, built)


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


def _on_base(steps: list[Step], base: Sequence[Step], taken: set[str]) -> list[Step]:
    """Return the steps of a layer with the result of the base layer saved under a name."""
    if not any(BASE_RESULT in wiring_of(step).reads.values() for step in steps):
        return steps
    if base and base[-1].save:
        return [rename_pictures(step, {BASE_RESULT: base[-1].save}) for step in steps]
    first = rename_saved([Step("", save="base")], taken)
    return first + [rename_pictures(step, {BASE_RESULT: first[0].save}) for step in steps]


def rename_saved(steps: Iterable[Step], taken: set[str]) -> list[Step]:
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


def without_idle_steps(style: Style) -> Style:
    """Return the style without steps whose results are unused."""
    used = {name for step in style.steps for name in names_used(step)}
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


def _fit_sizes(steps: Iterable[Step], base: Sequence[Step]) -> list[Step]:
    """Return the steps with working sizes that are neither too small nor larger than the picture."""
    parameter = all_blocks()["scale"].parameters["factor"]
    sizes = {BASE_RESULT: _final_size(base)}
    now, out = sizes[BASE_RESULT], []
    for step in steps:
        now = sizes.get(step.source, 1.0) if step.source else now
        if step.block == "scale":
            wanted = now * step.values.get("factor", parameter.default)
            # Smaller for wide blurs, which a later step combines with a larger picture.
            least = MIN_WORKING_SCALE if wanted > MIN_BLUR_SCALE else MIN_BLUR_SCALE
            factor = scale_factor(min(max(wanted, least), 1.0) / now)
            now *= factor
            step = replace(step, values=step.values | {"factor": factor})
        sizes[step.save] = now
        out.append(step)
    return out


def scale_factor(wanted: float) -> float:
    """Return the nearest factor that `scale` takes, in few digits."""
    control = all_blocks()["scale"].parameters["factor"].control
    assert isinstance(control, Slider)
    return control.nearest(wanted, is_integer=False)


def _is_idle(step: Step) -> bool:
    return step.block == "scale" and step.values.get("factor") == 1 and not (step.save or step.source)


def _sharpen(steps: list[Step], base: Sequence[Step]) -> list[Step]:
    """Return the steps with the last edge block at full size, as in shipped styles."""
    last = max((place for place, step in enumerate(steps) if step.block in EDGE_BLOCKS), default=0)
    size = _final_size([*base, Step("", save=BASE_RESULT), *steps[:last]])
    if not last or steps[last].source or size > 0.95:
        return steps
    factor = scale_factor(1 / size)
    return [*steps[:last], Step("scale", {"factor": factor}), *steps[last:]]


def _final_size(steps: Sequence[Step]) -> float:
    """Return the working size after these steps, relative to the picture."""
    parameter = all_blocks()["scale"].parameters["factor"]
    sizes, now = {SOURCE: 1.0}, 1.0
    for step in steps:
        now = sizes.get(step.source, now)
        now *= step.values.get("factor", parameter.default) if step.block == "scale" else 1.0
        sizes[step.save] = now
    return now
