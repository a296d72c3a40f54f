"""What the shipped styles are made of: phrases, and how often which one follows which.

A phrase is a run of steps of one layer that belongs together, because its steps use one another's saved
pictures: "blur a small copy, divide by it" is one, a posterization by itself another. A layer made of phrases
is valid in any order.
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
"""In a phrase, stands for the result of the base layer."""
BlockNames = tuple[str, ...]
"""The blocks of a phrase."""
LAYER_END: BlockNames = ()
"""What stands before the first phrase of a layer and after the last."""


@dataclass(frozen=True)
class Phrase:
    """Steps that belong together.

    Attributes:
        steps: their saved pictures are their own; `BASE_RESULT` and "source" are those of others.
        origin: the style that it comes from.
        next: the blocks of the phrase that follows it there.
    """

    steps: tuple[Step, ...]
    origin: Style
    next: BlockNames = LAYER_END

    @property
    def blocks(self) -> BlockNames:
        return tuple(step.block for step in self.steps)


@dataclass(frozen=True)
class Grammar:
    """What was counted in styles.

    Attributes:
        layers: how often which layers occur together.
        phrases: the phrases of each layer.
        follows: for each layer and the blocks of a phrase, how often which follow; `LAYER_END` begins and ends a
            layer.
    """

    layers: Counter[tuple[str, ...]]
    phrases: dict[str, list[Phrase]]
    follows: dict[tuple[str, BlockNames], Counter[BlockNames]]


def shipped_styles() -> list[Style]:
    """The styles that come with the program, by name."""
    return [load_style(path) for path in sorted(asset_folder("styles").glob("*.toml"))]


@cache
def grammar() -> Grammar:
    """That of the shipped styles."""
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
    """The phrases of a layer of a style. A base layer that the background does not start from has none."""
    unused = layer == "base" and any(step.source for step in style.background[:1])
    runs = [] if unused else list(_runs(tuple(closed_layer(style, layer))))
    followers = [tuple(step.block for step in run) for run in runs[1:]] + [LAYER_END]
    return [Phrase(run, style, after) for run, after in zip(runs, followers, strict=bool(runs))]


def closed_layer(style: Style, layer: str) -> Iterator[Step]:
    """The steps of a layer; what they take from other layers is the result of the base layer instead."""
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
    """The shortest runs of steps such that none uses what another saves."""
    first = 0
    for end in range(1, len(steps) + 1):
        saved = {step.save for step in steps[first:end]}
        used = {name for step in steps[end:] for name in names_used(step)}
        starts_anew = end < len(steps) and steps[end].source
        if not saved & used and not starts_anew:
            kept = {name for step in steps[first:end] for name in names_used(step)}
            yield tuple(
                replace(step, save=step.save if step.save in kept else "") for step in steps[first:end]
            )
            first = end
