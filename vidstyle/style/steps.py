"""The steps of a style file: checking them against the declarations of the blocks."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vidstyle.block import NAME_PATTERN, Asset, Block, Parameter, SavedRef
from vidstyle.blocks import all_blocks
from vidstyle.style.model import SOURCE, Step
from vidstyle.style.values import asset_path, nearest, read_values, shown

MAX_STEPS = 256
STEP_WORDS = ("block", "from", "save")
"""The keys of a step that are not parameters of its block."""


class StepReader:
    """Reads steps in the order in which they run, and knows what has been saved so far."""

    def __init__(self, folder: Path | None, mistakes: list[str]) -> None:
        self.folder = folder
        self.mistakes = mistakes
        self.saved = [SOURCE]
        self.implied: set[str] = set()
        self.count = 0

    def read_layer(self, layer: str, tables: object) -> tuple[Step, ...]:
        """The steps of a layer, or none where it is no list of them."""
        if not isinstance(tables, list | tuple) or not all(isinstance(table, Mapping) for table in tables):
            self.mistakes.append(f"{layer} is not a list of steps; write [[{layer}]] above each")
            return ()
        allowed = MAX_STEPS - self.count
        self.count += len(tables)
        if len(tables) > allowed:
            self.mistakes.append(f"{layer}: a style has at most {MAX_STEPS} steps")
            return ()
        return tuple(self.read_step(layer, number, table) for number, table in enumerate(tables, 1))

    def read_step(self, layer: str, number: int, table: Mapping[str, object]) -> Step:
        """One step, as far as it has no mistakes."""
        block, where = self.read_block(f"{layer} step {number}", table)
        source = self.read_name("from", table, where)
        if source:
            self.check_saved("from", source, where)
        values = self.read_parameters(block, table, where) if block else {}
        save = self.read_name("save", table, where)
        if save:
            self.keep(save, where)
        return Step(block.name if block else "", values, save, source)

    def read_block(self, step: str, table: Mapping[str, object]) -> tuple[Block | None, str]:
        """The block that a step names, and what mistakes in the step begin with."""
        name = table.get("block")
        if isinstance(name, str) and name in all_blocks():
            return all_blocks()[name], f"{step} ({name}): "
        if name is not None:
            hint = nearest(str(shown(name)), all_blocks())
            self.mistakes.append(f"{step}: {shown(name)} is not a block; {hint}")
        elif not {"from", "save"} & set(table):
            self.mistakes.append(f"{step}: block is missing; {nearest('', all_blocks())}")
        else:
            strange = [key for key in table if key not in STEP_WORDS]
            self.mistakes += [f"{step}: {shown(key)} needs a block, and the step has none" for key in strange]
        return None, f"{step}: "

    def read_parameters(self, block: Block, table: Mapping[str, object], where: str) -> dict[str, Any]:
        """The values given for a block, and a check of what those not given refer to."""
        for key in table:
            if key not in block.parameters and key not in STEP_WORDS:
                hint = nearest(str(key), block.parameters)
                self.mistakes.append(f"{where}{shown(key)} is not a parameter; {hint}")
        given = {name: parameter for name, parameter in block.parameters.items() if name in table}
        values = read_values(given, table, where, self.mistakes)
        for name, parameter in block.parameters.items():
            if name in values or name not in table:
                self.check_reference(parameter, values.get(name, parameter.default), where)
        if block.saves:
            self.implied.add(block.saves)
        return values

    def check_reference(self, parameter: Parameter, value: str, where: str) -> None:
        """Saved pictures and files must be there."""
        if isinstance(parameter.control, SavedRef) and value:
            self.check_saved(parameter.name, value, where)
        elif isinstance(parameter.control, Asset) and value and value not in parameter.control.shipped():
            try:
                asset_path(self.folder, value)
            except ValueError as error:
                self.mistakes.append(f"{where}{parameter.name}: {error}")

    def check_saved(self, key: str, name: str, where: str) -> None:
        """The name must be that of a picture saved before."""
        names = [*self.saved, *self.implied.difference(self.saved)]
        if name not in names:
            self.mistakes.append(f"{where}{key}: no step before it saves {name!r}; {nearest(name, names)}")

    def read_name(self, key: str, table: Mapping[str, object], where: str) -> str:
        """What `from` or `save` says, or nothing."""
        name = table.get(key, "")
        if key in table and not (isinstance(name, str) and re.fullmatch(NAME_PATTERN, name)):
            self.mistakes.append(f"{where}{key}: {shown(name)} is not a name of letters and digits")
            return ""
        return str(name)

    def keep(self, name: str, where: str) -> None:
        """Let later steps use the name."""
        if name == SOURCE:
            self.mistakes.append(f"{where}save: {SOURCE!r} is the untouched picture; choose another name")
        elif name in self.saved:
            self.mistakes.append(f"{where}save: an earlier step has saved {name!r}; choose another name")
        else:
            self.saved.append(name)
