"""Random styles with any blocks and values, for tests of properties of all styles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.block import Asset, Block, Choice, Color, SavedRef, Switch
from vidstyle.blocks import all_blocks
from vidstyle.style import LAYERS, Step, Style

STRUCTURE = ("structure_tensor", "kuwahara", "lic", "strokes", "palette", "glyphs", "line_screen")
"""Blocks that depend on edge directions or choose one of a few options, where rounding may decide."""
MAX_FACTOR = 1.6
"""Maximum growth of the working size per step: larger pictures would dominate the run time."""


def is_learned(block: Block) -> bool:
    """Return whether a block runs a bank, directly or in one of its steps."""
    if block.kind == "recipe":
        return any(is_learned(part) for part, _ in block.function())
    return block.kind == "learned"


class Chance:
    """Draws random styles: any blocks and values, saved pictures and references to them, in any layer.

    Args:
        wild: whether values use full ranges instead of the ranges for good-looking random styles.
        learned: whether to include learned blocks.
        structure: whether to include the blocks of `STRUCTURE`.
        max_steps: maximum number of steps in a layer.
        max_factor: maximum factor of blocks that change the size.
    """

    def __init__(
        self,
        seed: int,
        wild: bool,
        learned: bool = False,
        structure: bool = False,
        max_steps: int = 3,
        max_factor: float = MAX_FACTOR,
    ) -> None:
        self._random = np.random.default_rng(seed)
        self._wild, self._max_steps, self._max_factor = wild, max_steps, max_factor
        self._blocks = [
            block
            for name, block in all_blocks().items()
            if (learned or not is_learned(block)) and (structure or name not in STRUCTURE)
        ]
        self._saved = ["source"]

    def style(self) -> Style:
        counts = dict(zip(LAYERS, self._random.integers(0, self._max_steps + 1, 3), strict=True))
        layers = {layer: tuple(self._step() for _ in range(count)) for layer, count in counts.items()}
        colors = {"ink": self._color(), "paper": self._color()} if self._happens(0.6) else {}
        return Style("chance", **colors, **layers)

    def _happens(self, probability: float) -> bool:
        return bool(self._random.random() < probability)

    def _one_of(self, things: Any) -> Any:
        return things[self._random.integers(len(things))]

    def _color(self) -> str:
        return f"#{self._random.integers(1 << 24):06x}"

    def _step(self) -> Step:
        block = self._one_of(self._blocks)
        source = self._one_of(self._saved) if self._happens(0.25) else ""
        values = {name: self._value(block, name) for name in block.parameters}
        if block.saves and block.saves not in self._saved:
            self._saved.append(block.saves)
        save = f"picture_{len(self._saved)}" if self._happens(0.3) else ""
        self._saved += [save] if save else []
        return Step(block.name, values, save, source)

    def _value(self, block: Block, name: str) -> Any:
        parameter = block.parameters[name]
        control = parameter.control
        if isinstance(control, SavedRef):
            return "" if control.optional and self._happens(0.5) else self._one_of(self._saved)
        if isinstance(control, Switch):
            return self._happens(0.5)
        if isinstance(control, Choice):
            return self._one_of(control.options)
        if isinstance(control, Color):
            return self._color()
        if isinstance(control, Asset):
            return parameter.default
        ends = (control.low, control.high) if self._wild else control.explore
        if ends is None:
            return parameter.default
        high = min(ends[1], self._max_factor) if block.kind == "resize" else ends[1]
        value = float(self._random.uniform(ends[0], high))
        return round(value) if parameter.is_integer else value


def random_style(seed: int, folder: Path) -> Style:
    """Return a random style that seems to be loaded from a file in a folder."""
    drawn = Chance(seed, wild=True, learned=True, structure=True, max_steps=4).style()
    return replace(drawn, name=str(seed), note=("", "Made by chance.")[seed % 2], folder=folder)


def add_comments(path: Path) -> None:
    """Add comments above the steps of a style and at the end of each line."""
    lines = path.read_text(encoding="utf-8").splitlines()
    commented = [f"{'# above' if line.startswith('[[') else ''}\n{line} # beside" for line in lines if line]
    path.write_text("\n".join(commented), encoding="utf-8")
