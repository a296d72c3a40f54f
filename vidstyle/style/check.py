"""Checks the content of a style file against the declarations of the blocks, and makes a Style of it.

Styles come from untrusted sources: every value is checked here before it is used.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from vidstyle.block import NAME_PATTERN, Asset, Block, Parameter
from vidstyle.block.search import suggest_block
from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError, suggest
from vidstyle.style.knobs import read_knobs, read_labels
from vidstyle.style.mask_declarations import REGIONS, read_masks
from vidstyle.style.model import FIELDS, KINDS, LAYERS, SOURCE, STEP_KEYS, Step, Style
from vidstyle.style.values import MAX_MISTAKES, asset_path, read_values, to_text
from vidstyle.style.variants import read_variants, table_of_variant
from vidstyle.style.wiring import wire_layers

FORMAT_VERSION = 1
MAX_STEPS = 256
MAX_FILES = 4
"""Maximum number of files and folders that a style reads: each may take 130 MiB of memory."""
TEXTS = {"name": 100, "note": 1000, "aliases": 4000, "replaces": 100, "colors_from": 100}
"""The fields that hold text, and the maximum number of characters of each."""
NOT_BEHIND = (
    *("format", "kinds", "aliases", "knobs", "labels", "variants", "masks", "behind", "steady", "focus"),
)
"""Fields of a style that do not belong in `behind`."""


def style_from_table(
    table: Mapping[str, object], subject: object, name: str = "", folder: Path | None = None
) -> Style:
    """Return the style in the table of a style file.

    Args:
        table: the content of the file.
        subject: names the style in errors.
        name: its name if the table has none.
        folder: the folder to which its paths are relative; None allows no paths.

    Raises:
        StyleError: names all mistakes.
    """
    mistakes: list[str] = []
    if _is_known_format(table, mistakes):
        style = _read_style(table, name, folder, mistakes)
        # Paths are only meaningful in valid steps.
        if "knobs" in table and not mistakes:
            style = replace(style, knobs=read_knobs(style, table["knobs"], mistakes))
        if "labels" in table and not mistakes:
            style = replace(style, labels=read_labels(style, table["labels"], mistakes))
        if "variants" in table and not mistakes:
            style = _read_variants(style, table["variants"], mistakes)
    if mistakes:
        rest = len(mistakes) - MAX_MISTAKES
        mistakes[MAX_MISTAKES:] = [f"and {rest} more mistakes"] if rest > 0 else []
        raise StyleError(subject, mistakes)
    return style


def _is_known_format(table: Mapping[str, object], mistakes: list[str]) -> bool:
    version = table.get("format")
    if version is None:
        mistakes.append(f"format is missing; a style file says format = {FORMAT_VERSION}")
        return True
    if isinstance(version, int) and not isinstance(version, bool) and version == FORMAT_VERSION:
        return True
    mistakes.append(f"format {to_text(version)} is unknown; this vidstyle reads format {FORMAT_VERSION}")
    return False


def _read_style(table: Mapping[str, object], name: str, folder: Path | None, mistakes: list[str]) -> Style:
    known = ("format", *TEXTS, "kinds", "knobs", "labels", *FIELDS, "masks", *LAYERS, "behind", "variants")
    for key in table:
        if key not in known:
            mistakes.append(f"{to_text(key)} is not a field of a style; {suggest(str(key), known)}")
    texts: dict[str, Any] = {"name": name}
    texts |= {key: _read_text(key, table[key], mistakes) for key in TEXTS if key in table}
    kinds = _read_kinds(table.get("kinds", []), mistakes)
    fields = read_values(FIELDS, table, "", mistakes)
    masks = read_masks(table.get("masks", {}), folder, mistakes)
    reader = StepReader(folder, mistakes)
    layers: dict[str, Any] = {layer: reader.read_layer(layer, table.get(layer, [])) for layer in LAYERS}
    mistakes += _wiring_mistakes(layers, masks)
    known = (*REGIONS, *masks)
    wrong = [key for key in ("only", "keep") if fields.get(key, "") not in ("", *known)]
    mistakes += [f"{key}: {fields[key]!r} is not a mask; {suggest(fields[key], known)}" for key in wrong]
    behind = _read_behind(table["behind"], folder, mistakes) if "behind" in table else None
    return Style(folder=folder, masks=masks, behind=behind, kinds=kinds, **texts, **fields, **layers)


def _read_kinds(given: object, mistakes: list[str]) -> tuple[str, ...]:
    """Return the kinds of looks that a style file names."""
    if not isinstance(given, list):
        mistakes.append(f'kinds is not a list; write kinds = ["{next(iter(KINDS))}"]')
        return ()
    wrong = [kind for kind in given if kind not in tuple(KINDS)]
    mistakes += [
        f"kinds: {to_text(kind)} is not a kind of look; {suggest(str(kind), KINDS)}" for kind in wrong
    ]
    return tuple(dict.fromkeys(kind for kind in given if kind in tuple(KINDS)))


def _read_behind(given: object, folder: Path | None, mistakes: list[str]) -> Style | None:
    """Return the style of everything except people, which is a table like a style."""
    if not isinstance(given, Mapping):
        mistakes.append(f"behind: {to_text(given)} is not a table like a style")
        return None
    found = [f"{to_text(key)} has no effect there; remove it" for key in NOT_BEHIND if key in given]
    style = _read_style({key: given[key] for key in given if key not in NOT_BEHIND}, "", folder, found)
    mistakes += [f"behind: {mistake}" for mistake in found]
    return style


def _wiring_mistakes(layers: Mapping[str, tuple[Step, ...]], masks: Iterable[str]) -> Iterator[str]:
    """Yield pictures that are read but not saved before, and names that are saved twice."""
    taken = {SOURCE, *masks}
    counts = Counter[str]()
    for wired in wire_layers(layers, masks):
        counts[wired.layer] += 1
        where = _place_of(wired.layer, counts[wired.layer], wired.step.block)
        for key, name in wired.wiring.reads.items():
            if name not in wired.savers:
                yield f"{where}{key}: no step before it saves {name!r}; {suggest(name, wired.savers)}"
        save = wired.wiring.saved_output
        if save == SOURCE:
            yield f"{where}save: {SOURCE!r} is the untouched picture; choose another name"
        elif save in masks:
            yield f"{where}save: {save!r} is a mask; choose another name"
        elif save in taken:
            yield f"{where}save: an earlier step has saved {save!r}; choose another name"
        taken |= {save} - {""}


def _place_of(layer: str, number: int, block: str = "") -> str:
    """Return the prefix of messages about a step."""
    return f"{layer} step {number}{f' ({block})' if block else ''}: "


def _read_variants(style: Style, given: object, mistakes: list[str]) -> Style:
    """Return the style with its variants, each of which must be a valid style."""
    style = replace(style, variants=read_variants(style, given, mistakes))
    for variant in style.variants:
        found: list[str] = []
        _read_style(table_of_variant(style, variant), style.name, style.folder, found)
        mistakes += [f"variants.{variant}: {mistake}" for mistake in found]
    return style


def _read_text(key: str, value: object, mistakes: list[str]) -> str:
    """Return the text on one line, without control characters."""
    text = " ".join(value.split()) if isinstance(value, str) else "\n"
    if len(text) > TEXTS[key] or not text.isprintable():
        mistakes.append(f"{key}: {to_text(value)} is not a text of at most {TEXTS[key]} characters")
    return text


class StepReader:
    """Reads steps in running order; how they are wired is checked afterwards."""

    def __init__(self, folder: Path | None, mistakes: list[str]) -> None:
        self.folder = folder
        self.mistakes = mistakes
        self.files: set[str] = set()
        self.count = 0

    def read_layer(self, layer: str, tables: object) -> tuple[Step, ...]:
        """Return the steps of a layer; none if it is not a list of steps."""
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
        """One step; invalid parts of it are left out."""
        block = self.read_block(_place_of(layer, number), table)
        where = _place_of(layer, number, block.name if block else "")
        source = self.read_name("from", table, where)
        values = self.read_parameters(block, table, where) if block else {}
        save = self.read_name("save", table, where)
        mute = table.get("mute", False)
        if not isinstance(mute, bool):
            self.mistakes.append(f"{where}mute: {to_text(mute)} is not true or false")
        return Step(block.name if block else "", values, save, source, mute=mute is True)

    def read_block(self, where: str, table: Mapping[str, object]) -> Block | None:
        """Return the block that a step names."""
        name = table.get("block")
        if isinstance(name, str) and name in all_blocks():
            return all_blocks()[name]
        if name is not None:
            hint = suggest_block(to_text(name), all_blocks())
            self.mistakes.append(f"{where}{to_text(name)} is not a block; {hint}")
        elif not {"from", "save"} & set(table):
            self.mistakes.append(f"{where}block is missing; {suggest_block('', all_blocks())}")
        else:
            unknown = [key for key in table if key not in STEP_KEYS]
            self.mistakes += [
                f"{where}{to_text(key)} needs a block, and the step has none" for key in unknown
            ]
        return None

    def read_parameters(self, block: Block, table: Mapping[str, object], where: str) -> dict[str, Any]:
        """Return the values for a block."""
        for key in table:
            if key not in block.parameters and key not in STEP_KEYS:
                hint = suggest(str(key), block.parameters)
                self.mistakes.append(f"{where}{to_text(key)} is not a parameter; {hint}")
        values = read_values(block.parameters, table, where, self.mistakes)
        for name, parameter in block.parameters.items():
            self.check_file(parameter, values.get(name, parameter.default), where)
        return values

    def check_file(self, parameter: Parameter, value: str, where: str) -> None:
        """Check that the file that a value names exists."""
        control = parameter.control
        if isinstance(control, Asset) and control.own_file(value):
            self.files.add(value)
            try:
                asset_path(self.folder, value)
                if len(self.files) > MAX_FILES:
                    raise ValueError(f"{value!r} is one too many: a style reads at most {MAX_FILES} files")
            except ValueError as error:
                names = control.shipped()
                hint = f"; {suggest(value, names)}" if names else ""
                self.mistakes.append(f"{where}{parameter.name}: {error}{hint}")

    def read_name(self, key: str, table: Mapping[str, object], where: str) -> str:
        """Return the name under `from` or `save`, or an empty one."""
        name = table.get(key, "")
        if key in table and not (isinstance(name, str) and re.fullmatch(NAME_PATTERN, name)):
            self.mistakes.append(f"{where}{key}: {to_text(name)} is not a name of letters and digits")
            return ""
        return str(name)
