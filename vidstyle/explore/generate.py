"""Random styles, by the rules of the paper or by open rules, and variations of any style.

All functions are pure: the same arguments give the same style. The note of a style ends with its lineage,
after "Random:": the rules, the seed, and later changes with their seeds.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from hashlib import sha256
from random import Random

from vidstyle.blocks import all_blocks
from vidstyle.explore.colors import calm_saturation, ensure_contrast, is_pale, palette, shift_color
from vidstyle.explore.paper.paper_style import paper_style
from vidstyle.explore.paper.rules import DEFAULT_STEADY, STYLE_HEIGHT, Rules
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
from vidstyle.style import LAYERS, Step, Style

LOCKS = ("lines", "background", "colors", "steps")
"""Parts that a variation can keep: a layer with the base; ink, paper and tints; the list of steps."""

MAX_ATTEMPTS = 24
"""Number of attempts at a valid change of steps; after that, only values change."""
MAX_PHRASES = 9
"""Maximum number of phrases in a layer."""
SAME_STYLE_SHARE = 0.6
"""Probability that a phrase is followed by one of the same style."""
PHRASE_DEVIATION = 0.2
"""Variation of the values of a phrase."""
FREE_BLOCKS = ("brightness", "colorize", "equalize", "etf", "halftone", "hue", "luma_posterize", "tvf")
"""Blocks that can be inserted anywhere in a background."""
FREE_SHARE = 0.25
"""Share of styles with such a block."""
LINEAGE_PREFIX = "Random: "
MAX_LINEAGE_CHARACTERS = 900


def random_style(seed: int | str, rules: Rules = "open") -> Style:
    """Return a random style.

    Args:
        seed: any number or short text.
        rules: "paper" for section 6.2 of the paper; "open" for recombined phrases of the shipped styles with
            random palettes.

    >>> random_style(7) == random_style(7), random_style(7) == random_style(8)
    (True, False)
    """
    random = Random(f"{rules} {seed}")
    name = f"{rules}-{seed}"
    style = Style(name, f"{LINEAGE_PREFIX}{rules} rules, seed {seed}.", STYLE_HEIGHT, steady=DEFAULT_STEADY)
    return paper_style(random, style) if rules == "paper" else _open_style(random, style)


def mutate(style: Style, seed: int | str, distance: float = 0.4, locks: Iterable[str] = ()) -> Style:
    """Return the style with different values.

    Args:
        distance: amount of change, from 0 (none) to 1.
        locks: of `LOCKS`.
    """
    random, locks = Random(f"mutate {seed}"), frozenset(locks)
    spread = 0.7 * distance
    layers = {
        layer: tuple(
            step if _is_kept(step, locks) else step_near(random, step, spread, _randomizable(step))
            for step in steps
        )
        if layer in _open_layers(locks)
        else steps
        for layer, steps in style.layers.items()
    }
    changed = with_fitting_sizes(with_layers(style, layers), _open_layers(locks))
    if "colors" not in locks:
        changed = _recolor(random, changed, distance)
    return _with_lineage(changed, f"other values, distance {distance:g}, seed {seed}")


def alter(style: Style, seed: int | str, locks: Iterable[str] = ()) -> Style:
    """Return the style with one step changed, added or removed; with different values if steps are locked."""
    random, locks = Random(f"alter {seed}"), frozenset(locks)
    layers = [layer for layer in _open_layers(locks) if style.layers[layer] or layer != "base"]
    for _ in range(MAX_ATTEMPTS if layers and "steps" not in locks else 0):
        layer = random.choice(layers)
        steps = _alter_steps(random, layer, style.layers[layer])
        changed = with_fitting_sizes(with_layers(style, {layer: steps}), _open_layers(locks))
        if steps != style.layers[layer] and is_valid(changed):
            return _with_lineage(changed, f"one step changed, seed {seed}")
    return mutate(style, seed, locks=locks)


def cross(style: Style, other: Style, seed: int | str, locks: Iterable[str] = ()) -> Style:
    """Return the style with a layer of another style and the matching colour."""
    random, locks = Random(f"cross {seed}"), frozenset(locks)
    choices = [layer for layer in ("lines", "background") if layer in _open_layers(locks)]
    choices = [layer for layer in choices if other.layers[layer] != style.layers[layer]]
    for _ in range(MAX_ATTEMPTS if choices and "steps" not in locks else 0):
        layer = random.choice(choices)
        changed = _with_layer(random, style, other, layer, locks)
        if "colors" not in locks:
            ink = other.ink if layer == "lines" else style.ink
            paper = other.paper if layer == "background" or random.random() < 0.5 else style.paper
            ink, paper = ensure_contrast(ink, paper) if changed.lines else (ink, paper)
            changed = replace(changed, ink=ink, paper=paper)
        if is_valid(changed):
            return _with_lineage(changed, f"{layer} of {other.name}, seed {seed}")
    return mutate(style, seed, locks=locks)


def _open_style(random: Random, style: Style) -> Style:
    counted = grammar()
    while True:
        present = random.choices(list(counted.layers), list(counted.layers.values()))[0]
        phrases = {layer: _phrases(random, layer) for layer in present}
        colors = palette(random, phrases["lines"][-1].origin if "lines" in phrases else None)
        layers = {
            layer: _tint(random, [step for phrase in each for step in _vary(random, phrase)], colors.tint)
            for layer, each in phrases.items()
        }
        if random.random() < FREE_SHARE and "background" in layers:
            free = random_step(random, random.choice(FREE_BLOCKS))
            layers["background"].insert(random.randint(0, len(layers["background"])), free)
        made = without_idle_steps(join_layers(replace(style, ink=colors.ink, paper=colors.paper), layers))
        if is_valid(made):
            return made


def _phrases(random: Random, layer: str) -> list[Phrase]:
    """Return random phrases for a layer; each follows the previous one as in its style or in all styles."""
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


def _vary(random: Random, phrase: Phrase) -> list[Step]:
    """Return the steps of a phrase with varied values; a single step may take any recommended value."""
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


def _tint(random: Random, steps: Sequence[Step], hue: float) -> list[Step]:
    """Return the steps with the tint of the palette."""
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
    """Return the unlocked layers. The base is the input of the others and is locked with either."""
    return [layer for layer in LAYERS if layer not in locks
            and not (layer == "base" and {"lines", "background"} & set(locks))]  # fmt: skip


def _is_kept(step: Step, locks: Iterable[str]) -> bool:
    return not step.block or ("colors" in locks and step.block in ("colorize", "hue", "saturation"))


def _randomizable(step: Step) -> Iterable[str]:
    """Return the names of the step's values and of those that random styles set."""
    parameters = all_blocks()[step.block].parameters
    shown = [name for name, each in parameters.items() if getattr(each.control, "explore", None)]
    return dict.fromkeys([*shown, *step.values])


def _recolor(random: Random, style: Style, distance: float) -> Style:
    """Rotate the hues of ink and paper together, with small separate changes, or draw a new palette."""
    if random.random() < 0.5 * (distance - 0.3):
        colors = palette(random, style)
        return replace(style, ink=colors.ink, paper=colors.paper)
    turn = random.gauss(0, 90 * distance)
    ink, paper = (
        shift_color(color, random.gauss(0, 0.04 * distance), random.gauss(0, 0.05 * distance), turn)
        for color in (style.ink, style.paper)
    )
    if style.lines and style.ink != style.paper:
        ink, paper = (
            (ink, paper) if is_pale(style.ink) and is_pale(style.paper) else ensure_contrast(ink, paper)
        )
    return replace(style, ink=ink, paper=paper)


def _alter_steps(random: Random, layer: str, steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """Add, remove or replace one step."""
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
    """Return the style with a layer of another; a background may include its base layer."""
    names = [layer]
    if layer == "background" and "base" in _open_layers(locks) and random.random() < 0.5:
        names = ["base", layer]
    layers = {name: closed_layer(other, name) for name in names}
    changed = join_layers(style, layers)
    if "lines" not in (*names, *locks) and not is_valid(changed):
        # The lines read pictures of the replaced layers.
        changed = join_layers(style, layers | {"lines": closed_layer(style, "lines")})
    return changed


def _with_lineage(style: Style, how: str) -> Style:
    """Return the style with its lineage in name and note."""
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
