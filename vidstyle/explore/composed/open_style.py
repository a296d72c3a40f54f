"""A random style by the open rules: colours of one shipped style, lines of another, and a palette."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import Any

from vidstyle.block import Color, Parameter, Slider
from vidstyle.blocks import all_blocks
from vidstyle.explore.colors import ensure_contrast, is_pale, palette, shift_color, to_oklch, tone_colors
from vidstyle.explore.composed.kept_parts import colors_origin, part_weight
from vidstyle.explore.composed.shipped_parts import (
    draws_tones,
    families,
    is_handmade,
    paper_grains,
    whole_layer,
)
from vidstyle.explore.random_steps import is_valid, join_layers, with_values, without_idle_steps
from vidstyle.style import LAYERS, Step, Style, style_from_table, table_from_style
from vidstyle.style.paths import find_value

KNOB_DEVIATION, VALUE_DEVIATION = 0.25, 0.05
"""Relative variation of the values that a style names as its knobs, and of all others."""
MAX_GROWTH_RATIO = 1.1
"""How much larger than in its style a mark may be: larger ones would hide faces."""
SCREEN_WEIGHT = 0.2
"""Weight of styles that are not handmade, relative to the others."""
OWN_LINES_SHARE = 0.3
"""Share of styles with their own lines, or without lines, where those of others fit."""
GRAIN_SHARE = 0.25
"""Share of styles with the grain of a paper, where no lines draw the tones."""
TONED_SHARE, TURNED_SHARE = 0.35, 0.6
"""Share of styles whose tones get colours from a palette, and of others whose own colours change."""
TURN_DEGREES = 60.0
"""Deviation of the angle by which colours turn around the colour wheel."""
EXPOSURE_SHARE = 0.7
"""How much of a second exposure lightens colours below lines that draw tones."""
MAX_INK_LIGHTNESS, MAX_INK_CHROMA = 0.25, 0.06
"""In Oklch, of ink over colours, and of ink that covers the dark parts of a picture."""


def open_style(random: Random, style: Style) -> Style:
    """Return the style with random layers, ink and paper."""
    while True:
        made = _composed(random, style)
        if is_valid(made):
            return made


def _composed(random: Random, style: Style) -> Style:
    weights = [
        part_weight("colors", each[0].name) * (1.0 if is_handmade(each[0]) else SCREEN_WEIGHT)
        for each in families()
    ]
    colors = _near(random, random.choices(families(), weights)[0])
    lines = _lines_for(random, colors)
    focus = max(colors.focus, lines.focus)
    parts = f"{style.note} Colours of {colors.name}{f', lines of {lines.name}' if lines.lines else ''}."
    made = replace(
        style,
        steady=colors.steady,
        focus=focus,
        ink=lines.ink,
        paper=colors.paper,
        note=parts,
        colors_from=colors_origin(colors),
    )
    made = join_layers(made, _layers(random, colors, lines))
    if made.background and made.lines and is_handmade(colors) and random.random() < TONED_SHARE:
        made = _toned(random, made)
    elif random.random() < TURNED_SHARE:
        made = _turned(random, made)
    return without_idle_steps(_with_readable_ink(made, covers=bool(made.background) or draws_tones(lines)))


def _near(random: Random, family: Sequence[Style]) -> Style:
    """Return a style of a family with other values, above all those of its knobs."""
    style = random.choice(family)
    own, table = table_from_style(style), table_from_style(_values_near(random, style))
    for path in style.knobs:
        knob = find_value(table, path)
        if isinstance(knob.parameter.control, Slider):
            value = find_value(own, path).get()
            knob.set(_value_near(random, knob.parameter, value, KNOB_DEVIATION))
    return style_from_table(table, style.name, folder=style.folder)


def _values_near(random: Random, style: Style) -> Style:
    layers: dict[str, Any] = {
        layer: tuple(_step_near(random, step) for step in style.layers[layer]) for layer in LAYERS
    }
    return replace(style, **layers)


def _step_near(random: Random, step: Step) -> Step:
    """Return a step with values near its own; options, colours and working sizes stay."""
    parameters = all_blocks()[step.block].parameters if step.block not in ("", "scale") else {}
    names = [
        name for name in step.values if name in parameters and isinstance(parameters[name].control, Slider)
    ]
    return with_values(
        step, lambda parameter, value: _value_near(random, parameter, value, VALUE_DEVIATION), names
    )


def _value_near(random: Random, parameter: Parameter, value: Any, spread: float) -> Any:
    """Return a value near another; a length is at most `MAX_GROWTH_RATIO` as large."""
    near = parameter.draw_near(random, value, spread)
    is_length = isinstance(parameter.control, Slider) and parameter.control.unit == "px"
    return min(near, type(near)(MAX_GROWTH_RATIO * value)) if is_length else near


def _lines_for(random: Random, colors: Style) -> Style:
    """Return a style whose lines suit the colours of another: handmade marks on handmade colours."""
    takes_lines = colors.background and is_handmade(colors) and not is_pale(colors.ink)
    if not takes_lines or random.random() < OWN_LINES_SHARE:
        return colors
    fitting = [
        family
        for family in families()
        if family[0].lines
        and is_handmade(family[0])
        and not is_pale(family[0].ink)
        # The colours are only a tint if their own lines draw the tones.
        and draws_tones(family[0]) >= (draws_tones(colors) and bool(colors.lines))
    ]
    weights = [part_weight("lines", family[0].name) for family in fitting]
    return _near(random, random.choices(fitting, weights)[0])


def _layers(random: Random, colors: Style, lines: Style) -> dict[str, Sequence[Step]]:
    """Return the base and the background of one style with the lines of another."""
    background = list(colors.background)
    if lines is colors:
        own: Sequence[Step] = colors.lines
    else:
        own = whole_layer(lines, "lines")
        if draws_tones(lines):
            background = _lightened(background)
    is_toned = bool(lines.lines) and draws_tones(lines)
    if background and is_handmade(colors) and not is_toned and random.random() < GRAIN_SHARE:
        background.append(_step_near(random, random.choice(paper_grains())))
    return {"base": colors.base, "background": background, "lines": own}


def _lightened(steps: Sequence[Step]) -> list[Step]:
    """Return the steps with a lighter result: a second exposure over the first."""
    return [
        *steps,
        Step("", save="dark"),
        Step("blend", {"other": "dark", "mode": "screen", "opacity": EXPOSURE_SHARE}),
    ]


def _toned(random: Random, style: Style) -> Style:
    """Return the style with a colour for each tone, instead of those of a gradient that it ends with."""
    shades = tone_colors(random)
    gradient = Step("gradient", dict(zip(all_blocks()["gradient"].parameters, shades, strict=True)))
    steps = style.background
    kept = steps[:-1] if steps[-1].block == "gradient" else steps
    return replace(style, background=(*kept, gradient), ink=shades[0], paper="#ffffff")


def _turned(random: Random, style: Style) -> Style:
    """Return the style with another ink and paper, and its colours turned around the colour wheel."""
    turn = random.gauss(0, TURN_DEGREES)
    ink, paper = palette(random, style)
    layers: dict[str, Any] = {
        layer: tuple(_step_turned(step, turn) for step in steps) for layer, steps in style.layers.items()
    }
    return replace(style, ink=ink, paper=paper, **layers)


def _step_turned(step: Step, turn: float) -> Step:
    parameters = all_blocks()[step.block].parameters if step.block else {}
    values = {
        name: shift_color(value, hue=turn) if isinstance(parameters[name].control, Color) else value
        for name, value in step.values.items()
    }
    return replace(step, values=values)


def _with_readable_ink(style: Style, covers: bool) -> Style:
    """Return the style with an ink that contrasts with its paper.

    Args:
        covers: whether the ink lies on colours or covers much of the picture: it is dark then.
    """
    ink, paper = style.ink, style.paper
    if not style.lines or is_pale(ink):
        return style
    if covers:
        lightness, chroma, _ = to_oklch(ink)
        ink = shift_color(ink, min(MAX_INK_LIGHTNESS - lightness, 0), min(MAX_INK_CHROMA - chroma, 0))
    ink, paper = ensure_contrast(ink, paper)
    return replace(style, ink=ink, paper=paper)
