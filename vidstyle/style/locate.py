"""Locates mistakes in the text of a style file."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator

from vidstyle.style.model import LAYERS
from vidstyle.style.variants import VARIANT_PATTERN

_VARIANT_KEY_PATTERN = rf"variants\s*\.\s*[\"']?(?P<variant>{VARIANT_PATTERN})[\"']?"
HEADER_PATTERN = re.compile(
    rf"\s*(\[\[\s*(?P<layer>{'|'.join(LAYERS)})\s*\]\]|\[\s*{_VARIANT_KEY_PATTERN}\s*\])\s*(#.*)?"
)
"""The line above a step or a variant."""

_KEY_PATTERN = re.compile(r"\s*[\"']?(?P<key>[^\"'=#\[\]\s]+)[\"']?\s*=.*")
_SECTION_PATTERN = re.compile(rf"((?:{'|'.join(LAYERS)}) step \d+|variants\.{VARIANT_PATTERN})( \(\w+\))?:")
_BARE_WORD = re.compile(r"\s*(?P<key>[\w.\"'-]+)\s*=\s*(?P<word>#?[\w-]+)\s*(#.*)?")
_TRUTH_WORDS = {"yes": "true", "on": "true", "true": "true", "no": "false", "off": "false", "false": "false"}


def with_lines(mistakes: Iterable[str], text: str) -> list[str]:
    """Return the mistakes with the numbers of their lines in front, where they are known, in this order."""
    places = list(_places(text))
    numbered = sorted(((_line_of(each, places), each) for each in mistakes), key=lambda pair: pair[0])
    return [f"line {number}: {mistake}" if number else mistake for number, mistake in numbered]


def correct_word(text: str, error: str) -> tuple[str, str] | None:
    """Return the text with quotes added to a value, or with `yes` as `true`, and the mistake.

    Args:
        text: no TOML.
        error: what tomllib says about it.

    >>> correct_word("invert = yes", "Invalid value (at line 1, column 10)")
    ('invert = true', 'line 1: yes is not a value; write invert = true')
    """
    place = re.search(r"at line (\d+)", error)
    lines = text.split("\n")
    number = int(place[1]) if place else 0
    found = _BARE_WORD.fullmatch(lines[number - 1].rstrip("\r")) if number else None
    if found is None:
        return None
    word = found["word"]
    right = f"{found['key']} = " + _TRUTH_WORDS.get(word.lower(), f'"{word}"')
    if lines[number - 1] == right:
        return None
    lines[number - 1] = right
    return "\n".join(lines), f"line {number}: {word} is not a value; write {right}"


def _places(text: str) -> Iterator[tuple[str, str, int]]:
    """Section, key and line number of all headers, whose key is empty, and values."""
    section, counts = "", Counter[str]()
    for number, line in enumerate(text.split("\n"), 1):
        if header := HEADER_PATTERN.fullmatch(line.rstrip("\r")):
            layer = header["layer"]
            counts[layer] += 1
            section = f"{layer} step {counts[layer]}" if layer else f"variants.{header['variant']}"
            yield section, "", number
        elif value := _KEY_PATTERN.fullmatch(line):
            yield section, value["key"], number


def _line_of(mistake: str, places: Iterable[tuple[str, str, int]]) -> int:
    """Return the line of the value that is named first, or else of the header; 0 if it is not known."""
    found = _SECTION_PATTERN.match(mistake)
    section, rest = (found[1], mistake[found.end() :]) if found else ("", mistake)
    inside = [(key, number) for each, key, number in places if each == section]
    named = [
        (hit.start(), number)
        for key, number in inside
        if key and (hit := re.search(rf"(?<![\w.]){re.escape(key)}(?![\w.])", rest))
    ]
    if named:
        return min(named)[1]
    return inside[0][1] if section and inside else 0
