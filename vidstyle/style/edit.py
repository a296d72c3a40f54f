"""Changes the text of a style file to hold another style, and keeps what people wrote around it.

tomlkit keeps the comments inside a table, but hands those above a table to the one before it, so
that they go astray when a step is moved or taken out. Therefore the text is first cut into parts,
one for each step and variant with the comments above it, and tomlkit edits the parts.
"""

from __future__ import annotations

import logging
import re
import tomllib
from collections.abc import Iterator, MutableMapping
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any, cast

import tomlkit
from tomlkit.exceptions import TOMLKitError

from vidstyle.style.model import FIELDS, LAYERS, Style
from vidstyle.style.variants import VARIANT_PATTERN

log = logging.getLogger("vidstyle")

_VARIANT = rf"variants\s*\.\s*[\"']?(?P<variant>{VARIANT_PATTERN})[\"']?"
_HEADER = re.compile(rf"\s*(\[\[\s*(?P<layer>{'|'.join(LAYERS)})\s*\]\]|\[\s*{_VARIANT}\s*\])\s*(#.*)?")


class _UnusualLayoutError(Exception):
    """Steps or variants are not written under headers."""


@dataclass(frozen=True)
class _Part:
    """A piece of a style file: the fields (layer ""), one step, or one variant (layer "variants").

    Attributes:
        variant: the name of the variant, if it is one.
        body: from the comments above to the last key.
        tail: the comments and empty lines after it.
    """

    layer: str
    body: str
    tail: str
    variant: str = ""

    def parse(self) -> tuple[tomlkit.TOMLDocument, MutableMapping[str, Any]]:
        """The part as a document, and the table in it that holds its keys."""
        document = tomlkit.parse(self.body)
        if not self.layer:
            return document, document
        found = cast(Any, document[self.layer])[self.variant or 0]
        return document, cast(MutableMapping[str, Any], found)

    def edited(self, wanted: dict[str, Any]) -> _Part:
        """The part with the values that are wanted, and no others."""
        document, table = self.parse()
        for key in [key for key in table if key not in wanted]:
            del table[key]
        for key, value in wanted.items():
            if key not in table or not _same(table[key], value):
                table[key] = value
        return replace(self, body=document.as_string())


def edited_text(text: str, table: dict[str, Any], path: Path) -> str:
    """The text of a style file, edited to hold the table of another style.

    Where the file is laid out in a way that cannot be edited, such as steps in one line, the text is
    written anew and a warning says so.
    """
    if tomllib.loads(text) == table:
        return text
    try:
        edited = _edit(text.replace("\r\n", "\n"), table)
        if _same(_without_defaults(tomllib.loads(edited)), table):
            return edited.replace("\n", "\r\n") if "\r\n" in text else edited
    except (TOMLKitError, tomllib.TOMLDecodeError, RecursionError, _UnusualLayoutError):
        pass
    log.warning("%s: written anew without its comments: its layout cannot be edited", path)
    return tomlkit.dumps(table)


def _same(one: object, other: object) -> bool:
    """Whether two values mean the same; how a text is broken into lines does not count."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    texts = isinstance(one, str) and isinstance(other, str)
    return one == other or (texts and str(one).split() == str(other).split())


def _without_defaults(table: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if value != getattr(Style, key, None)}


def _edit(text: str, table: dict[str, Any]) -> str:
    fields, *parts = _cut(text)
    nested = (*LAYERS, "variants")
    if not fields.parse()[1].keys().isdisjoint(nested):
        raise _UnusualLayoutError
    wanted = {key: value for key, value in table.items() if key not in nested}
    placed = [(-1.0, fields.edited(wanted | _defaults_to_restore(fields, wanted)))]
    for layer in LAYERS:
        placed += _place_steps(parts, layer, table.get(layer, []))
    placed += _place_variants(parts, table.get("variants", {}))
    return _join([part for _, part in sorted(placed, key=lambda pair: pair[0])])


def _defaults_to_restore(fields: _Part, wanted: dict[str, Any]) -> dict[str, Any]:
    """A field that is written out stays written out, even if it goes back to its default."""
    present = fields.parse()[1]
    keys = [key for key in ("note", *FIELDS) if key in present and key not in wanted]
    return {key: default for key in keys if (default := getattr(Style, key)) is not None}


def _place_steps(
    parts: list[_Part], layer: str, steps: list[dict[str, Any]]
) -> Iterator[tuple[float, _Part]]:
    """The parts for the steps of a layer, each with its place among the parts of the file."""
    old = [number for number, part in enumerate(parts) if part.layer == layer]
    matches = _matches([parts[number].parse()[1] for number in old], steps)
    kept = {new: old[number] for new, number in matches.items()}
    place = min(kept.values(), default=len(parts)) - 0.5
    for number, step in enumerate(steps):
        place = kept.get(number, place)
        yield place, parts[kept[number]].edited(step) if number in kept else _new_part(layer, step)


def _place_variants(parts: list[_Part], variants: dict[str, dict[str, Any]]) -> Iterator[tuple[float, _Part]]:
    """The same for the variants; those that are new stand at the end."""
    old = {part.variant: number for number, part in enumerate(parts) if part.variant}
    for name, values in variants.items():
        if name in old:
            yield old[name], parts[old[name]].edited(values)
        else:
            text = tomlkit.dumps({"variants": {name: values}})
            yield len(parts), _Part("variants", f"\n{text}", "\n", name)


def _new_part(layer: str, step: dict[str, Any]) -> _Part:
    return _Part(layer, "\n" + tomlkit.dumps({layer: [step]}), "\n")


def _matches(old: list[MutableMapping[str, Any]], new: list[dict[str, Any]]) -> dict[int, int]:
    """Which new step is which old one: the longest runs of the same blocks."""
    before, after = ([str(step.get("block", "")) for step in steps] for steps in (old, new))
    runs = SequenceMatcher(None, before, after, autojunk=False).get_matching_blocks()
    return {run.b + offset: run.a + offset for run in runs for offset in range(run.size)}


def _cut(text: str) -> list[_Part]:
    lines = re.findall(r"[^\n]*\n|[^\n]+", text)
    starts, heads = [0], [("", "")]
    for number, line in enumerate(lines):
        if header := _HEADER.fullmatch(line.rstrip("\n")):
            while number - 1 > starts[-1] and lines[number - 1].startswith("#"):
                number -= 1
            starts.append(number)
            heads.append((header["layer"] or "variants", header["variant"] or ""))
    ends = [*starts[1:], len(lines)]
    return [_part(*head, lines[start:end]) for head, start, end in zip(heads, starts, ends, strict=True)]


def _part(layer: str, variant: str, lines: list[str]) -> _Part:
    keys = [number for number, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")]
    end = max(keys, default=-1) + 1
    return _Part(layer, "".join(lines[:end]), "".join(lines[end:]), variant)


def _join(parts: list[_Part]) -> str:
    text = ""
    for part in parts:
        text += "" if text.endswith("\n") else "\n"
        text += part.body.removeprefix("\n") if text.endswith("\n\n") else part.body
        text += part.tail
    return f"{text.strip()}\n"
