"""Reads style files from untrusted sources, and writes them preserving their comments.

tomlkit preserves the comments inside a table, but attaches those above a table to the previous one, so
that they are misplaced when a step is moved or removed. The text is therefore split into sections, one
for each step and variant with the comments above it, which tomlkit edits separately.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, MutableMapping
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any, cast

import tomlkit
from tomlkit.exceptions import TOMLKitError

from vidstyle.core.regular_file import read_regular_file
from vidstyle.errors import OutputError, StyleError, log
from vidstyle.style.check import style_from_table
from vidstyle.style.locate import HEADER, mended_word, with_lines
from vidstyle.style.model import FIELDS, LAYERS, Style, table_from_style
from vidstyle.style.values import MAX_MISTAKES

MAX_FILE = 64 * 1024
"""The largest style file, in bytes."""

MAX_DOTS = 1000
"""The most dots in a line: tomllib takes quadratic time for dotted keys."""


def read_style_file(path: Path) -> Style:
    """The style in a file.

    Raises:
        StyleError: the file cannot be read, or the style in it has mistakes.
    """
    return style_from_text(read_style_text(path), path, path.absolute().parent)


def style_from_text(text: str, path: Path, folder: Path | None) -> Style:
    """The style in the text of a file.

    Args:
        path: the file, whose name is the style's if it has none.
        folder: the folder to which its paths are relative; None allows no paths.

    Raises:
        StyleError: the style has mistakes.
    """
    table, words = _parse(path, text)
    try:
        style = style_from_table(table, path, path.stem, folder)
    except StyleError as error:
        raise StyleError(path, words + with_lines(error.mistakes, text)) from None
    if words:
        raise StyleError(path, words)
    return style


def style_text(style: Style, like: Path | None = None) -> str:
    """The style as a style file; with the comments and the order of another one, where that is given.

    Raises:
        StyleError: the other file cannot be read.
    """
    table = _written_shortly(table_from_style(style))
    return tomlkit.dumps(table) if like is None else _edited_text(read_style_text(like), table, like)


def save_style(style: Style, path: str | Path, like: str | None = None) -> None:
    """Write a style to a file. An existing style file is edited: its comments and order are preserved.

    Args:
        like: the text of another style file, whose comments and order are taken instead.

    Raises:
        StyleError: the style has mistakes, or the existing file is not a style.
        OutputError: the file cannot be written.
    """
    path = Path(path)
    table = _written_shortly(table_from_style(style))
    style_from_table(table, style.name, folder=path.absolute().parent)
    if like is not None:
        text = _edited_text(like, table, path)
    else:
        text = _edit_file(path, table) if path.exists() else tomlkit.dumps(table)
    partial = path.resolve().with_name(f"{path.name}.partial")
    try:
        partial.write_text(text, encoding="utf-8", newline="")
        os.replace(partial, path.resolve())
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OutputError(path, f"cannot be written: {error.strerror}") from None


def _written_shortly(value: Any) -> Any:
    """The value, or table of values, with whole numbers as people write them: 55 for 55.0."""
    if isinstance(value, dict):
        return {key: _written_shortly(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_written_shortly(each) for each in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _edit_file(path: Path, table: dict[str, Any]) -> str:
    text = read_style_text(path)
    present, words = _parse(path, text)
    if words:
        raise StyleError(path, words)
    if repr(present.get("format")) != repr(table["format"]):
        raise StyleError(path, ["is there, and is not a style; choose another name"])
    return _edited_text(text, table, path)


def read_style_text(path: Path) -> str:
    """The text of a style file.

    Raises:
        StyleError: it cannot be read, is too large, or is no UTF-8.
    """
    try:
        content = read_regular_file(path, MAX_FILE)
    except OSError as error:
        raise StyleError(path, [f"cannot be read: {error.strerror}"]) from None
    except ValueError as error:
        raise StyleError(path, [str(error)]) from None
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise StyleError(path, [f"line {line} is not UTF-8 text"]) from None


def _parse(path: Path, text: str) -> tuple[dict[str, Any], list[str]]:
    """The content of a file, and what is wrong about values that lack quotes, which are taken as meant."""
    for number, line in enumerate(text.split("\n"), 1):
        if line.count(".") > MAX_DOTS:
            raise StyleError(path, [f"line {number} is nested too deeply for a style"])
    if text.lstrip().startswith("{"):
        raise StyleError(path, ['is JSON; a style is TOML, such as block = "sobel" below [[lines]]'])
    words: list[str] = []
    while True:
        try:
            return tomllib.loads(text), words
        except RecursionError:
            raise StyleError(path, ["is nested too deeply for a style"]) from None
        except ValueError as error:
            mended = mended_word(text, str(error)) if len(words) < MAX_MISTAKES else None
            if mended is None:
                raise StyleError(path, [*words, f"is not TOML: {error}"]) from None
            text = mended[0]
            words.append(mended[1])


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
        """The section as a document, and the table in it that holds its keys."""
        document = tomlkit.parse(self.body)
        if not self.layer:
            return document, document
        found = cast(Any, document[self.layer])[self.variant or 0]
        return document, cast(MutableMapping[str, Any], found)

    def edited(self, wanted: dict[str, Any]) -> _Section:
        """The section with these values and no others."""
        document, table = self.parse()
        for key in [key for key in table if key not in wanted]:
            del table[key]
        for key, value in wanted.items():
            if key not in table or not _same(table[key], value):
                table[key] = value
        return replace(self, body=document.as_string())


def _edited_text(text: str, table: dict[str, Any], path: Path) -> str:
    """The text of a style file, edited to hold the table of another style.

    Where the layout of the file cannot be edited, such as steps in one line, the text is rewritten with a
    warning.
    """
    if tomllib.loads(text) == table:
        return text
    try:
        edited = _edit(text.replace("\r\n", "\n"), table)
        values = tomllib.loads(edited).items()
        if _same({key: value for key, value in values if value != getattr(Style, key, None)}, table):
            return edited.replace("\n", "\r\n") if "\r\n" in text else edited
    except (TOMLKitError, tomllib.TOMLDecodeError, RecursionError, _UnusualLayoutError):
        pass
    log.warning("%s: rewritten without its comments: its layout cannot be edited", path)
    return tomlkit.dumps(table)


def _same(one: object, other: object) -> bool:
    """Whether two values are equal, white space in texts aside."""
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
    """The defaults of fields that are in the file, and stay in it."""
    present = fields.parse()[1]
    keys = [key for key in ("note", *FIELDS) if key in present and key not in wanted]
    return {key: default for key in keys if (default := getattr(Style, key)) is not None}


def _place_steps(
    sections: list[_Section], layer: str, steps: list[dict[str, Any]]
) -> Iterator[tuple[float, _Section]]:
    """The sections for the steps of a layer, each with its position among the sections of the file."""
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
    """The same for the variants; new ones come last."""
    old = {section.variant: number for number, section in enumerate(sections) if section.variant}
    for name, values in variants.items():
        if name in old:
            yield old[name], sections[old[name]].edited(values)
        else:
            text = tomlkit.dumps({"variants": {name: values}})
            yield len(sections), _Section("variants", f"\n{text}", "\n", name)


def _matches(old: list[MutableMapping[str, Any]], new: list[dict[str, Any]]) -> dict[int, int]:
    """The old step of each new one, by the longest common runs of blocks."""
    before, after = ([str(step.get("block", "")) for step in steps] for steps in (old, new))
    runs = SequenceMatcher(None, before, after, autojunk=False).get_matching_blocks()
    return {run.b + offset: run.a + offset for run in runs for offset in range(run.size)}


def _split(text: str) -> list[_Section]:
    lines = re.findall(r"[^\n]*\n|[^\n]+", text)
    starts, heads = [0], [("", "")]
    for number, line in enumerate(lines):
        if header := HEADER.fullmatch(line.rstrip("\n")):
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
