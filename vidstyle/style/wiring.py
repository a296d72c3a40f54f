"""The wiring of a style: which pictures each step reads, and under which names it saves pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from vidstyle.block import Block, On
from vidstyle.blocks import all_blocks
from vidstyle.style.mask_declarations import BACKDROP, REGIONS
from vidstyle.style.model import SOURCE, Step, Style

START = "from"
"""The key of the picture that a step starts from; other keys are parameters of its block."""


@dataclass(frozen=True)
class StepWiring:
    """The pictures of one step, by their saved names.

    Attributes:
        block: the block of the step; None if the step only selects or saves a picture.
        reads: the saved pictures that the step reads, by `START` or the parameter that names them.
        saved_input: the name under which the step saves its input, or empty.
        saved_output: the name under which the step saves its output, or empty.
        on: the channels that it works on.
        muted: whether it is bypassed.
    """

    block: Block | None
    reads: Mapping[str, str]
    saved_input: str
    saved_output: str
    on: On
    muted: bool

    @property
    def pictures(self) -> dict[str, str]:
        """The saved pictures that parameters of the block read, by parameter."""
        return {key: name for key, name in self.reads.items() if key != START}

    @property
    def saves(self) -> tuple[str, ...]:
        """The names under which the step saves pictures."""
        return tuple(filter(None, (self.saved_input, self.saved_output)))


@dataclass(frozen=True)
class WiredStep:
    """A step among the others of its style.

    Attributes:
        layer, step: the step and its layer.
        wiring: the pictures of the step.
        start: the index of the step whose output it starts from, among the steps of all layers; None for
            the source picture.
        savers: the pictures that it can read, by name: the index of the step that saves each, or None for
            the source picture and its masks.
    """

    layer: str
    step: Step
    wiring: StepWiring
    start: int | None
    savers: Mapping[str, int | None]


def wiring_of(step: Step) -> StepWiring:
    """Return the pictures of a step; parameters that are not set read the picture of their default."""
    block = all_blocks().get(step.block)
    reads = {START: step.source}
    for name in block.saved_refs if block else ():
        reads[name] = str(step.values.get(name, block.parameters[name].default if block else ""))
    named = {key: name for key, name in reads.items() if name}
    on: On = (step.on or block.on) if block else "channels"
    return StepWiring(block, named, block.saves if block else "", step.save, on, step.mute)


def needs_cpu(style: Style) -> bool:
    """Return whether a style runs on the CPU only: it has a network."""
    if style.behind is not None and needs_cpu(style.behind):
        return True
    return any(
        step.wiring.block is not None and step.wiring.block.kind == "network" and not step.wiring.muted
        for step in wire_layers(style.layers)
    )


def wire_layers(layers: Mapping[str, tuple[Step, ...]], masks: Iterable[str] = ()) -> Iterator[WiredStep]:
    """Yield the steps of all layers in running order.

    A step without `from` starts from the previous step of its layer; the first from the end of the base
    layer. A name that no earlier step saves is not in `savers`; a step that starts from it has the source
    picture as `start`.

    Args:
        masks: the names of masks that the style declares.
    """
    savers: dict[str, int | None] = dict.fromkeys((SOURCE, *REGIONS, BACKDROP, *masks))
    ends: dict[str, int | None] = {}
    index = 0
    for layer, steps in layers.items():
        current = ends.get("base")
        for step in steps:
            wiring = wiring_of(step)
            if START in wiring.reads:
                current = savers.get(wiring.reads[START])
            yield WiredStep(layer, step, wiring, current, dict(savers))
            savers |= dict.fromkeys(wiring.saves, index)
            current, index = index, index + 1
        ends[layer] = current


def main_path(layers: Mapping[str, tuple[Step, ...]], masks: Iterable[str] = ()) -> frozenset[int]:
    """Return the indices of the steps whose picture becomes the result, among the steps of all layers.

    Other steps make masks and pictures that are blended in; `layers` and `masks` as for `wire_layers`.
    """
    wired = list(wire_layers(layers, masks))
    path: set[int] = set()
    ends = {each.layer: index for index, each in enumerate(wired)}
    if len(ends) > 1:
        ends.pop("base", None)  # it feeds the others
    for end in ends.values():
        at: int | None = end
        while at is not None and at not in path:
            path.add(at)
            at = wired[at].start
    return frozenset(path)


def rename_pictures(step: Step, names: Mapping[str, str]) -> Step:
    """Return the step with other names for the saved pictures that it reads."""
    renamed = {key: names[name] for key, name in wiring_of(step).reads.items() if name in names}
    source = renamed.pop(START, step.source)
    return replace(step, values=step.values | renamed, source=source)
