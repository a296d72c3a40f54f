"""Random styles, by the rules of the paper or by open rules, and variations of any style.

All functions are pure: the same arguments give the same style. The note of a style ends with its lineage,
after "Random:": the rules, the seed, and later changes with their seeds.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from hashlib import sha256
from random import Random

from vidstyle.blocks import all_blocks
from vidstyle.explore.colors import ensure_contrast, is_pale, palette, shift_color
from vidstyle.explore.composed.kept_parts import colors_origin
from vidstyle.explore.composed.open_style import open_style
from vidstyle.explore.composed.shipped_parts import single_steps, whole_layer
from vidstyle.explore.paper.paper_style import paper_style
from vidstyle.explore.paper.rules import DEFAULT_STEADY, STYLE_HEIGHT, Rules
from vidstyle.explore.random_steps import (
    is_valid,
    join_layers,
    random_step,
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
LINEAGE_PREFIX = "Random: "
MAX_LINEAGE_CHARACTERS = 900


def random_style(seed: int | str, rules: Rules = "open") -> Style:
    """Return a random style.

    Args:
        seed: any number or short text.
        rules: "paper" for section 6.2 of the paper; "open" for parts of the shipped styles with random
            palettes.

    >>> random_style(7) == random_style(7), random_style(7) == random_style(8)
    (True, False)
    """
    random = Random(f"{rules} {seed}")
    name = f"{rules}-{seed}"
    style = Style(name, f"{LINEAGE_PREFIX}{rules} rules, seed {seed}.", STYLE_HEIGHT, steady=DEFAULT_STEADY)
    return paper_style(random, style) if rules == "paper" else open_style(random, style)


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
    choices = [layer for layer in choices if other.layers[layer] not in ((), style.layers[layer])]
    for _ in range(MAX_ATTEMPTS if choices and "steps" not in locks else 0):
        layer = random.choice(choices)
        changed = join_layers(style, {layer: whole_layer(other, layer)})
        if layer == "background":
            changed = replace(changed, colors_from=colors_origin(other))
        if "colors" not in locks:
            ink = other.ink if layer == "lines" else style.ink
            paper = other.paper if layer == "background" or random.random() < 0.5 else style.paper
            ink, paper = ensure_contrast(ink, paper) if changed.lines else (ink, paper)
            changed = replace(changed, ink=ink, paper=paper)
        if is_valid(changed):
            used = without_idle_steps(changed) if "base" in _open_layers(locks) else changed
            return _with_lineage(used, f"{layer} of {other.name}, seed {seed}")
    return mutate(style, seed, locks=locks)


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
        ink, paper = palette(random, style)
        return replace(style, ink=ink, paper=paper)
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
    new = step_near(random, random.choice(single_steps(layer)), 0.3)
    if random.random() < 0.3:
        new = random_step(random, random.choice(sorted(all_blocks())))
    if change == "add" or not steps:
        return steps[:place] + (new,) + steps[place:]
    old = steps[place]
    if change == "remove" or new.block == old.block:
        return steps[:place] + steps[place + 1 :] if not (old.save or old.source) else steps
    return steps[:place] + (replace(new, save=old.save, source=old.source),) + steps[place + 1 :]


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
    name = f"{root}~{sha256(note.encode()).hexdigest()[:8]}"
    return replace(style, name=name, note=note, colors_from=colors_origin(style))
