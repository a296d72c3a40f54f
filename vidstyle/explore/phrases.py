"""The grammar of the shipped styles: phrases, and how often one follows another.

A phrase is a run of steps in one layer that share saved pictures: "blur a small copy, divide by it" is one
phrase, a single posterization another. Phrases can be combined in any order.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

from vidstyle.assets import asset_folder
from vidstyle.style import LAYERS, SOURCE, Step, Style, load_style
from vidstyle.style.wiring import START, wiring_of

BASE_RESULT = "@base"
"""Placeholder in a phrase for the result of the base layer."""
BlockNames = tuple[str, ...]
"""The blocks of a phrase."""
LAYER_END: BlockNames = ()
"""Marks the beginning and the end of a layer."""


@dataclass(frozen=True)
class Phrase:
    """Steps that depend on each other.

    Attributes:
        steps: the steps; they read only their own saved pictures, `BASE_RESULT` and "source".
        origin: the style that contains it.
        next: the blocks of the phrase that follows it in that style.
    """

    steps: tuple[Step, ...]
    origin: Style
    next: BlockNames = LAYER_END

    @property
    def blocks(self) -> BlockNames:
        return tuple(step.block for step in self.steps)


@dataclass(frozen=True)
class Grammar:
    """Statistics of styles.

    Attributes:
        layers: counts of combinations of layers.
        phrases: the phrases of each layer.
        follows: counts of successors, by layer and blocks of a phrase; `LAYER_END` marks both ends.
    """

    layers: Counter[tuple[str, ...]]
    phrases: dict[str, list[Phrase]]
    follows: dict[tuple[str, BlockNames], Counter[BlockNames]]


def shipped_styles() -> list[Style]:
    """Return the styles that come with the program, sorted by name."""
    return [load_style(path) for path in sorted(asset_folder("styles").glob("*.toml"))]


@cache
def grammar() -> Grammar:
    """Return the grammar of the shipped styles."""
    counted = Grammar(Counter(), defaultdict(list), defaultdict(Counter))
    for style in shipped_styles():
        layers = {layer: phrases_of(style, layer) for layer in LAYERS}
        counted.layers[tuple(layer for layer in LAYERS if layers[layer])] += 1
        for layer, phrases in layers.items():
            counted.phrases[layer] += phrases
            for before, after in pairwise(
                [LAYER_END, *(phrase.blocks for phrase in phrases), LAYER_END] * bool(phrases)
            ):
                counted.follows[layer, before][after] += 1
    return counted


def phrases_of(style: Style, layer: str) -> list[Phrase]:
    """Return the phrases of a layer; none for a base layer that the background does not start from."""
    unused = layer == "base" and any(step.source for step in style.background[:1])
    runs = [] if unused else list(_runs(tuple(closed_layer(style, layer))))
    followers = [tuple(step.block for step in run) for run in runs[1:]] + [LAYER_END]
    return [Phrase(run, style, after) for run, after in zip(runs, followers, strict=bool(runs))]


def closed_layer(style: Style, layer: str) -> Iterator[Step]:
    """Yield the steps of a layer with pictures of other layers replaced by the result of the base layer."""
    steps = style.layers[layer]
    own = {step.save for step in steps}
    for step in steps:
        values = dict(step.values)
        wiring = wiring_of(step)
        outside = {key for key, name in wiring.reads.items() if name != SOURCE and name not in own}
        source = BASE_RESULT if START in outside else step.source
        for name in outside - {START}:
            assert wiring.block is not None
            if wiring.block.saved_refs[name].on == "chroma":
                values.pop(name, None)
            else:
                values[name] = BASE_RESULT
        yield replace(step, values=values, source=source)


def names_used(step: Step) -> set[str]:
    """Return the saved pictures that a step reads."""
    return set(wiring_of(step).reads.values()) - {SOURCE, BASE_RESULT}


def _runs(steps: Sequence[Step]) -> Iterator[tuple[Step, ...]]:
    """Split steps into the shortest runs that share no saved pictures."""
    first = 0
    for end in range(1, len(steps) + 1):
        saved = {step.save for step in steps[first:end]}
        used = {name for step in steps[end:] for name in names_used(step)}
        restarts = end < len(steps) and steps[end].source
        if not saved & used and not restarts:
            kept = {name for step in steps[first:end] for name in names_used(step)}
            yield tuple(
                replace(step, save=step.save if step.save in kept else "") for step in steps[first:end]
            )
            first = end
