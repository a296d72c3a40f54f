"""Edits the text of a style file, preserving its comments.

tomlkit preserves the comments inside a table, but attaches those above a table to the previous one, so
that they are misplaced when a step is moved or removed. The text is therefore split into sections, one
for each step and variant with the comments above it, which tomlkit edits separately.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, MutableMapping
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any, cast

import tomlkit
from tomlkit.exceptions import TOMLKitError

from vidstyle.core.file_checks import parse_toml
from vidstyle.errors import log
from vidstyle.style.locate import HEADER_PATTERN
from vidstyle.style.model import FIELDS, LAYERS, Style


def new_text(table: dict[str, Any]) -> str:
    """Return the text of a style file that holds a table."""
    return tomlkit.dumps(table)


def edit_text(text: str, table: dict[str, Any], path: Path) -> str:
    """Return the text of a style file, edited to hold the table of another style.

    Where the layout of the file cannot be edited, such as steps in one line, the text is rewritten with a
    warning.
    """
    try:
        if parse_toml(text) == table:
            return text
        edited = _edit(text.replace("\r\n", "\n"), table)
        values = parse_toml(edited).items()
        if _same({key: value for key, value in values if value != getattr(Style, key, None)}, table):
            return edited.replace("\n", "\r\n") if "\r\n" in text else edited
    except (TOMLKitError, ValueError, RecursionError, _UnusualLayoutError):
        pass
    log.warning("%s: rewritten without its comments: its layout cannot be edited", path)
    return tomlkit.dumps(table)


class _UnusualLayoutError(Exception):
    """Steps or variants are not written as tables with headers."""


@dataclass(frozen=True)
class _Section:
    """A section of a style file: the fields (layer ""), one step, or one variant (layer "variants").

    Attributes:
        variant: the name of the variant, if it is one.
        body: the text from the comments above to the last key.
        tail: the comments and empty lines after it.
    """

    layer: str
    body: str
    tail: str
    variant: str = ""

    def parse(self) -> tuple[tomlkit.TOMLDocument, MutableMapping[str, Any]]:
        """Return the section as a document, and the table in it that holds its keys."""
        document = tomlkit.parse(self.body)
        if not self.layer:
            return document, document
        found = cast(Any, document[self.layer])[self.variant or 0]
        return document, cast(MutableMapping[str, Any], found)

    def edited(self, wanted: dict[str, Any]) -> _Section:
        """Return the section with these values and no others."""
        document, table = self.parse()
        for key in [key for key in table if key not in wanted]:
            del table[key]
        for key, value in wanted.items():
            if key not in table or not _same(table[key], value):
                table[key] = value
        return replace(self, body=document.as_string())


def _same(one: object, other: object) -> bool:
    """Return whether two values are equal, white space in texts aside."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    texts = isinstance(one, str) and isinstance(other, str)
    return one == other or (texts and str(one).split() == str(other).split())


def _edit(text: str, table: dict[str, Any]) -> str:
    fields, *sections = _split(text)
    nested = (*LAYERS, "variants")
    if not fields.parse()[1].keys().isdisjoint(nested):
        raise _UnusualLayoutError
    wanted = {key: value for key, value in table.items() if key not in nested}
    placed = [(-1.0, fields.edited(wanted | _defaults_to_restore(fields, wanted)))]
    for layer in LAYERS:
        placed += _place_steps(sections, layer, table.get(layer, []))
    placed += _place_variants(sections, table.get("variants", {}))
    return _join([section for _, section in sorted(placed, key=lambda pair: pair[0])])


def _defaults_to_restore(fields: _Section, wanted: dict[str, Any]) -> dict[str, Any]:
    """Return the defaults of fields that are in the file, and stay in it."""
    present = fields.parse()[1]
    keys = [key for key in ("note", *FIELDS) if key in present and key not in wanted]
    return {key: default for key in keys if (default := getattr(Style, key)) is not None}


def _place_steps(
    sections: list[_Section], layer: str, steps: list[dict[str, Any]]
) -> Iterator[tuple[float, _Section]]:
    """Yield the sections for the steps of a layer, each with its position among the sections of the file."""
    old = [number for number, section in enumerate(sections) if section.layer == layer]
    matches = _matches([sections[number].parse()[1] for number in old], steps)
    kept = {new: old[number] for new, number in matches.items()}
    place = min(kept.values(), default=len(sections)) - 0.5
    for number, step in enumerate(steps):
        place = kept.get(number, place)
        new = _Section(layer, "\n" + tomlkit.dumps({layer: [step]}), "\n")
        yield place, sections[kept[number]].edited(step) if number in kept else new


def _place_variants(
    sections: list[_Section], variants: dict[str, dict[str, Any]]
) -> Iterator[tuple[float, _Section]]:
    """Yield the same for the variants; new ones come last."""
    old = {section.variant: number for number, section in enumerate(sections) if section.variant}
    for name, values in variants.items():
        if name in old:
            yield old[name], sections[old[name]].edited(values)
        else:
            text = tomlkit.dumps({"variants": {name: values}})
            yield len(sections), _Section("variants", f"\n{text}", "\n", name)


def _matches(old: list[MutableMapping[str, Any]], new: list[dict[str, Any]]) -> dict[int, int]:
    """Return the old step of each new one, by the longest common runs of blocks."""
    before, after = ([str(step.get("block", "")) for step in steps] for steps in (old, new))
    runs = SequenceMatcher(None, before, after, autojunk=False).get_matching_blocks()
    return {run.b + offset: run.a + offset for run in runs for offset in range(run.size)}


def _split(text: str) -> list[_Section]:
    lines = re.findall(r"[^\n]*\n|[^\n]+", text)
    starts, heads = [0], [("", "")]
    for number, line in enumerate(lines):
        if header := HEADER_PATTERN.fullmatch(line.rstrip("\n")):
            while number - 1 > starts[-1] and lines[number - 1].startswith("#"):
                number -= 1
            starts.append(number)
            heads.append((header["layer"] or "variants", header["variant"] or ""))
    ends = [*starts[1:], len(lines)]
    return [_section(*head, lines[start:end]) for head, start, end in zip(heads, starts, ends, strict=True)]


def _section(layer: str, variant: str, lines: list[str]) -> _Section:
    keys = [number for number, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")]
    end = max(keys, default=-1) + 1
    return _Section(layer, "".join(lines[:end]), "".join(lines[end:]), variant)


def _join(sections: list[_Section]) -> str:
    text = ""
    for section in sections:
        text += "" if text.endswith("\n") else "\n"
        text += section.body.removeprefix("\n") if text.endswith("\n\n") else section.body
        text += section.tail
    return f"{text.strip()}\n"
