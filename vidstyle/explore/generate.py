"""Random styles, by the paper's rules or by open ones, and variations of any style.

Everything here is pure: the same arguments give the same style. What a style was made by is the last part of
its note, from "Random:" on: the rules and the seed, and what was then changed with which seed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from hashlib import sha256
from random import Random
from typing import Literal

from vidstyle.blocks import all_blocks
from vidstyle.explore.colors import calm_saturation, is_pale, palette, readable, shifted
from vidstyle.explore.phrases import LAYER_END, Phrase, closed_layer, grammar
from vidstyle.explore.random_steps import (
    is_valid,
    join_layers,
    random_step,
    random_value,
    step_near,
    with_fitting_sizes,
    with_layers,
    without_idle_steps,
)
from vidstyle.explore.rules import (
    DEFAULT_STEADY,
    FILTER_COUNT_RANGE,
    FILTER_RULES,
    GRAY_RULE,
    GRAY_SHARE,
    STYLE_HEIGHT,
    FilterRule,
)
from vidstyle.style import LAYERS, Step, Style

Rules = Literal["open", "paper"]
LOCKS = ("lines", "background", "colors", "steps")
"""What a variation may leave as it is: a layer and the base; ink, paper and tints; which steps there are."""

MAX_ATTEMPTS = 24
"""How often a change that would not be valid is drawn anew; then only values change."""
MAX_PHRASES = 9
"""The most phrases of a layer."""
SAME_STYLE_SHARE = 0.6
"""How often a phrase is followed by one of the same style."""
PHRASE_DEVIATION = 0.2
"""How far the values of a phrase move, as in `near`."""
FREE_BLOCKS = ("brightness", "colorize", "equalize", "etf", "halftone", "hue", "luma_posterize", "tvf")
"""Blocks that may stand anywhere in a background, whatever the shipped styles do."""
FREE_SHARE = 0.25
"""The share of styles that have one."""
LINEAGE_PREFIX = "Random: "
MAX_LINEAGE_CHARACTERS = 900


def random_style(seed: int | str, rules: Rules = "open") -> Style:
    """A random style.

    Args:
        seed: any number or short text.
        rules: "paper" for the paper's, section 6.2; "open" for phrases of the shipped styles in new order,
            and palettes.

    >>> random_style(7) == random_style(7), random_style(7) == random_style(8)
    (True, False)
    """
    random = Random(f"{rules} {seed}")
    name = f"{rules}-{seed}"
    style = Style(name, f"{LINEAGE_PREFIX}{rules} rules, seed {seed}.", STYLE_HEIGHT, steady=DEFAULT_STEADY)
    return _paper_style(random, style) if rules == "paper" else _open_style(random, style)


def mutate(style: Style, seed: int | str, distance: float = 0.4, locks: Iterable[str] = ()) -> Style:
    """The style with other values.

    Args:
        distance: how far, from 0 (the style itself) to 1.
        locks: of `LOCKS`.
    """
    random, locks = Random(f"mutate {seed}"), frozenset(locks)
    spread = 0.7 * distance
    layers = {
        layer: tuple(
            step if _is_kept(step, locks) else step_near(random, _told(step), spread) for step in steps
        )
        if layer in _open_layers(locks)
        else steps
        for layer, steps in style.layers.items()
    }
    changed = with_fitting_sizes(with_layers(style, layers), _open_layers(locks))
    if "colors" not in locks:
        changed = _recolored(random, changed, distance)
    return _made(changed, f"other values, distance {distance:g}, seed {seed}")


def alter(style: Style, seed: int | str, locks: Iterable[str] = ()) -> Style:
    """The style with one step changed, added or removed; where no step may be, with other values."""
    random, locks = Random(f"alter {seed}"), frozenset(locks)
    layers = [layer for layer in _open_layers(locks) if style.layers[layer] or layer != "base"]
    for _ in range(MAX_ATTEMPTS if layers and "steps" not in locks else 0):
        layer = random.choice(layers)
        steps = _altered(random, layer, style.layers[layer])
        changed = with_fitting_sizes(with_layers(style, {layer: steps}), _open_layers(locks))
        if steps != style.layers[layer] and is_valid(changed):
            return _made(changed, f"one step changed, seed {seed}")
    return mutate(style, seed, locks=locks)


def cross(style: Style, other: Style, seed: int | str, locks: Iterable[str] = ()) -> Style:
    """The style with a whole layer of another one, and the colour that belongs to it."""
    random, locks = Random(f"cross {seed}"), frozenset(locks)
    choices = [layer for layer in ("lines", "background") if layer in _open_layers(locks)]
    choices = [layer for layer in choices if other.layers[layer] != style.layers[layer]]
    for _ in range(MAX_ATTEMPTS if choices and "steps" not in locks else 0):
        layer = random.choice(choices)
        changed = _with_layer(random, style, other, layer, locks)
        if "colors" not in locks:
            ink = other.ink if layer == "lines" else style.ink
            paper = other.paper if layer == "background" or random.random() < 0.5 else style.paper
            ink, paper = readable(ink, paper) if changed.lines else (ink, paper)
            changed = replace(changed, ink=ink, paper=paper)
        if is_valid(changed):
            return _made(changed, f"{layer} of {other.name}, seed {seed}")
    return mutate(style, seed, locks=locks)


def _paper_style(random: Random, style: Style) -> Style:
    count = random.randint(*FILTER_COUNT_RANGE)
    is_gray = random.random() < GRAY_SHARE
    rules: list[FilterRule] = []
    while len(rules) < count - is_gray:
        rules.append(random.choice([rule for rule in FILTER_RULES if rule.repeats or rule not in rules]))
    if is_gray:
        rules.insert(random.randint(0, len(rules)), GRAY_RULE)
    steps = []
    for rule in rules:
        parameters = all_blocks()[rule.block].parameters
        names = (*rule.parameters, *rule.ends)
        values = {name: random_value(random, parameters[name], rule.ends.get(name)) for name in names}
        steps.append(Step(rule.block, values))
    return replace(style, background=tuple(steps))


def _open_style(random: Random, style: Style) -> Style:
    counted = grammar()
    while True:
        present = random.choices(list(counted.layers), list(counted.layers.values()))[0]
        phrases = {layer: _phrases(random, layer) for layer in present}
        colors = palette(random, phrases["lines"][-1].origin if "lines" in phrases else None)
        layers = {
            layer: _tinted(random, [step for phrase in each for step in _varied(random, phrase)], colors.tint)
            for layer, each in phrases.items()
        }
        if random.random() < FREE_SHARE and "background" in layers:
            free = random_step(random, random.choice(FREE_BLOCKS))
            layers["background"].insert(random.randint(0, len(layers["background"])), free)
        made = without_idle_steps(join_layers(replace(style, ink=colors.ink, paper=colors.paper), layers))
        if is_valid(made):
            return made


def _phrases(random: Random, layer: str) -> list[Phrase]:
    """Phrases for a layer, each drawn by what follows the one before in its own style, or in all of them."""
    counted = grammar()
    out: list[Phrase] = []
    while len(out) < MAX_PHRASES:
        if out and random.random() < SAME_STYLE_SHARE:
            blocks = out[-1].next
        else:
            follows = counted.follows[layer, out[-1].blocks if out else LAYER_END]
            blocks = random.choices(list(follows), list(follows.values()))[0]
        if blocks == LAYER_END:
            break
        same = [phrase for phrase in counted.phrases[layer] if phrase.blocks == blocks]
        own = [phrase for phrase in same if out and phrase.origin is out[-1].origin]
        out.append(random.choice(own if own and random.random() < SAME_STYLE_SHARE else same))
    return out


def _varied(random: Random, phrase: Phrase) -> list[Step]:
    """The steps of a phrase with other values; a single one may take any that look well."""
    varied = [step_near(random, step, PHRASE_DEVIATION) for step in phrase.steps]
    if len(varied) > 1 or random.random() > 0.4:
        return varied
    step, parameters = phrase.steps[0], all_blocks()[phrase.steps[0].block].parameters
    values = varied[0].values | {
        name: random_value(random, parameters[name])
        for name, value in step.values.items()
        if parameters[name].control.is_drawn(value)
    }
    return [replace(step, values=values)]


def _tinted(random: Random, steps: Sequence[Step], hue: float) -> list[Step]:
    """The steps with the tints of the palette."""
    parameter = all_blocks()["colorize"].parameters["hue"]
    out = []
    for step in steps:
        if step.block == "colorize":
            tint = parameter.draw_near(random, round(hue), 0.1)
            saturation = min(step.values.get("saturation", 1.0), calm_saturation(tint))
            step = replace(step, values=step.values | {"hue": tint, "saturation": saturation})
        out.append(step)
    return out


def _open_layers(locks: Iterable[str]) -> list[str]:
    """The layers that may change. The base feeds both others, and is locked with either."""
    return [layer for layer in LAYERS if layer not in locks
            and not (layer == "base" and {"lines", "background"} & set(locks))]  # fmt: skip


def _is_kept(step: Step, locks: Iterable[str]) -> bool:
    return not step.block or ("colors" in locks and step.block in ("colorize", "hue", "saturation"))


def _told(step: Step) -> Step:
    """The step with those values written out that random styles may draw."""
    parameters = all_blocks()[step.block].parameters
    shown = {
        name: each.default for name, each in parameters.items() if getattr(each.control, "explore", None)
    }
    return replace(step, values=shown | step.values)


def _recolored(random: Random, style: Style, distance: float) -> Style:
    """The style with ink and paper turned together and a little by themselves; far off, a new palette."""
    if random.random() < 0.5 * (distance - 0.3):
        colors = palette(random, style)
        return replace(style, ink=colors.ink, paper=colors.paper)
    turn = random.gauss(0, 90 * distance)
    ink, paper = (
        shifted(color, random.gauss(0, 0.04 * distance), random.gauss(0, 0.05 * distance), turn)
        for color in (style.ink, style.paper)
    )
    if style.lines and style.ink != style.paper:
        ink, paper = (ink, paper) if is_pale(style.ink) and is_pale(style.paper) else readable(ink, paper)
    return replace(style, ink=ink, paper=paper)


def _altered(random: Random, layer: str, steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """The steps with one more, one less or another one in place of one."""
    change = random.choice(("add", "remove", "replace", "replace"))
    place = random.randint(0, len(steps)) if change == "add" or not steps else random.randrange(len(steps))
    single = [phrase.steps[0] for phrase in grammar().phrases[layer] if len(phrase.steps) == 1]
    new = step_near(random, random.choice(single), 0.3)
    if random.random() < 0.3:
        new = random_step(random, random.choice(sorted(all_blocks())))
    if change == "add" or not steps:
        return steps[:place] + (new,) + steps[place:]
    old = steps[place]
    if change == "remove" or new.block == old.block:
        return steps[:place] + steps[place + 1 :] if not (old.save or old.source) else steps
    return steps[:place] + (replace(new, save=old.save, source=old.source),) + steps[place + 1 :]


def _with_layer(random: Random, style: Style, other: Style, layer: str, locks: frozenset[str]) -> Style:
    """The style with a layer of another; a background may bring the base layer that it was made for."""
    names = [layer]
    if layer == "background" and "base" in _open_layers(locks) and random.random() < 0.5:
        names = ["base", layer]
    layers = {name: closed_layer(other, name) for name in names}
    changed = join_layers(style, layers)
    if "lines" not in (*names, *locks) and not is_valid(changed):
        # The lines have used pictures of the layers that are gone.
        changed = join_layers(style, layers | {"lines": closed_layer(style, "lines")})
    return changed


def _made(style: Style, how: str) -> Style:
    """The style, named after what it was made of, with the way it was made in its note."""
    before = (
        style.note[style.note.find(LINEAGE_PREFIX) :]
        if LINEAGE_PREFIX in style.note
        else f"{LINEAGE_PREFIX}{style.name}."
    )
    note = f"{before} Then {how}."
    if len(note) > MAX_LINEAGE_CHARACTERS:
        note = f"{LINEAGE_PREFIX}... {note[-MAX_LINEAGE_CHARACTERS:]}"
    root = style.name.partition("~")[0].replace(":", "-")
    return replace(style, name=f"{root}~{sha256(note.encode()).hexdigest()[:8]}", note=note)
