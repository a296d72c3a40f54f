"""Reads and writes cue files: TOML with the cues of a film."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, get_args

from vidstyle.core.file_checks import parse_toml, read_toml_text
from vidstyle.cues.cue_list import Cue, CueList, Curve, Transition
from vidstyle.cues.times import parse_time_code, seconds_text
from vidstyle.errors import InputError, StyleError, UsageError, join_names, suggest
from vidstyle.style import Style, load_style, set_values

FORMAT_VERSION = 1
MAX_FILE_BYTES = 1 << 20
MAX_CUES = 10_000
MAX_SECONDS = 10**7
"""Maximum time in a cue file: a third of a year."""

CueTable = Mapping[str, Any]
"""A cue with the keys of a cue file, see `_CUE_KEYS`."""

_FILE_KEYS = ("format", "rate", "scenes", "cue")
_CUE_KEYS = ("time", "scene", "style", "values", "transition", "seconds", "curve")


def read_cue_file(path: Path) -> CueList:
    """Read a cue file.

    Raises:
        InputError: it cannot be read, or has mistakes: all of them are named.
    """
    try:
        text = read_toml_text(path, MAX_FILE_BYTES)
    except ValueError as error:
        raise InputError(path, str(error)) from None
    return read_cue_text(text, path)


def read_cue_text(text: str, path: Path, opened: Sequence[Style] = ()) -> CueList:
    """Read the text of a cue file.

    Args:
        path: of the file, for style files and errors.
        opened: styles that replace those of the same names.

    Raises:
        InputError: it has mistakes: all of them are named.
    """
    try:
        return _Reader(path, parse_toml(text), {style.name: style for style in opened}).cue_list()
    except UsageError as error:
        raise InputError(path, error.reason) from None
    except ValueError as error:
        raise InputError(path, str(error)) from None


def scene_cues(styles: Iterable[str | None]) -> list[CueTable]:
    """Return a cue for each scene with a style; None: as in the scene before."""
    return [{"scene": number, "style": style} for number, style in enumerate(styles, 1) if style is not None]


def read_cue_tables(path: Path, scenes: Sequence[Fraction], folder: Path) -> list[CueTable]:
    """Return the cues of a file as tables for another file with other scenes of the same film.

    Args:
        folder: of the other file, to which style files are relative.

    Raises:
        InputError: as `read_cue_file`.
    """
    cues = read_cue_file(path).cues
    tables = parse_toml(read_toml_text(path, MAX_FILE_BYTES))["cue"]
    places = {seconds_text(start): {"scene": number} for number, start in enumerate(scenes, 1)}
    return [
        places.get(seconds_text(cue.time), {"time": float(cue.time)})
        | {key: each[key] for key in _CUE_KEYS if key in each and key not in ("time", "scene")}
        | ({"style": _moved_style(path, each["style"], folder)} if "style" in each else {})
        for cue, each in zip(cues, tables, strict=True)
    ]


def _moved_style(file: Path, name: str, folder: Path) -> str:
    """Return the name of a style for a cue file in another folder."""
    is_moved = style_place(file, name) != name and file.parent.resolve() != folder.resolve()
    return str(file.parent.resolve() / name) if is_moved else name


def cue_file_text(scenes: Sequence[Fraction], rate: Fraction | None, cues: Iterable[CueTable]) -> str:
    """Return the text of a cue file.

    Args:
        scenes: the beginnings of the scenes, in seconds.
        rate: frames per second of the film, for time codes.
        cues: the cues, with the keys of the file.
    """
    return "\n".join(_lines(scenes, rate, cues)) + "\n"


def _lines(scenes: Sequence[Fraction], rate: Fraction | None, cues: Iterable[CueTable]) -> Iterator[str]:
    yield "# The styles of a film over time: vidstyle render FILM OUTPUT --cues THIS-FILE"
    yield f"format = {FORMAT_VERSION}"
    if rate is not None:
        yield f"rate = {seconds_text(rate)}  # frames per second, for time codes such as 00:01:02:12"
    yield f"scenes = [{', '.join(map(seconds_text, scenes))}]  # where they begin, in seconds"
    for cue in cues:
        yield from ("", "[[cue]]", *(f"{key} = {_toml(value)}" for key, value in cue.items()))


def _toml(value: Any) -> str:
    """Return a value as TOML; JSON's strings, numbers and switches are the same."""
    if not isinstance(value, dict):
        return json.dumps(value, ensure_ascii=False)
    pairs = (f"{json.dumps(key)} = {_toml(each)}" for key, each in _flat(value))
    return f"{{ {', '.join(pairs)} }}"


@dataclass
class _Reader:
    """Reads the table of a cue file; see `read_cue_text`."""

    path: Path
    table: Mapping[str, Any]
    opened: Mapping[str, Style]

    def cue_list(self) -> CueList:
        """Return the cues; raises ValueError with all mistakes."""
        mistakes = [*_unknown(self.table, _FILE_KEYS)]
        if (version := self.table.get("format")) != FORMAT_VERSION:
            raise ValueError(f"has format {version!r}; this version of vidstyle reads {FORMAT_VERSION}")
        tables = self.table.get("cue")
        if not isinstance(tables, list) or not tables or not all(isinstance(each, dict) for each in tables):
            raise ValueError("has no cues; begin each one with a line [[cue]]")
        if len(tables) > MAX_CUES:
            raise ValueError(f"has {len(tables)} cues; {MAX_CUES} are possible")
        cues: list[Cue] = []
        for number, each in enumerate(tables, 1):
            try:
                cues.append(self._cue(each, cues[-1].style if cues else None))
            except (ValueError, StyleError) as error:
                mistakes.append(f"cue {number}: {getattr(error, 'reason', error)}")
        if mistakes:
            raise ValueError("; ".join(mistakes[:8]))
        return CueList(tuple(cues))

    def _cue(self, table: Mapping[str, Any], before: Style | None) -> Cue:
        """Return a cue; raises ValueError with its first mistake. `before`: style of the previous cue."""
        for mistake in _unknown(table, _CUE_KEYS):
            raise ValueError(mistake)
        seconds = _number(table.get("seconds", 0), "seconds", 0, MAX_SECONDS)
        transition: Transition = _choice(
            table, "transition", get_args(Transition), "fade" if seconds else "cut"
        )
        if (transition == "cut") != (seconds == 0):
            raise ValueError(f"a {transition} {'needs' if seconds == 0 else 'takes no'} seconds")
        curve: Curve = _choice(table, "curve", get_args(Curve), "hold")
        return Cue(self._time(table), self._style(table, before), transition, seconds, curve)

    def _time(self, table: Mapping[str, Any]) -> Fraction:
        if ("time" in table) == ("scene" in table):
            raise ValueError("needs time or scene, and not both")
        if "time" not in table:
            return self._scene(table["scene"])
        if not isinstance(time := table["time"], str):
            return _number(time, "time", 0, MAX_SECONDS)
        return parse_time_code(time, self._rate())

    def _rate(self) -> Fraction | None:
        rate = self.table.get("rate")
        return None if rate is None else _number(rate, "rate", 1, 1000)

    def _scene(self, number: object) -> Fraction:
        scenes = self.table.get("scenes")
        if not isinstance(scenes, list):
            raise ValueError("names a scene, but the file has no list of scenes; write time = SECONDS")
        if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= len(scenes):
            raise ValueError(f"there is no scene {number!r}; the list of scenes has {len(scenes)}")
        return _number(scenes[number - 1], f"scene {number}", 0, MAX_SECONDS)

    def _style(self, table: Mapping[str, Any], before: Style | None) -> Style:
        """Return the style of a cue, by default the previous one with further values."""
        name, values = table.get("style"), table.get("values", {})
        if not isinstance(values, dict):
            raise ValueError('values is not a table such as { "posterize.levels" = 5 }')
        if name is None and before is None:
            raise ValueError("needs a style")
        if name is not None and not isinstance(name, str):
            raise ValueError(f"style = {name!r} is not a name")
        style = before if name is None else self.opened.get(name) or load_style(style_place(self.path, name))
        assert style is not None
        return set_values(style, dict(_flat(values))) if values else style


def style_place(file: Path, name: str) -> str:
    """Return the name of a style in a cue file, or the path of a style file, which is relative to it."""
    return str(file.parent / name) if "/" in name or name.partition(":")[0].endswith(".toml") else name


def _flat(values: Mapping[str, Any], front: str = "") -> Iterator[tuple[str, Any]]:
    """Yield values by their paths: TOML reads the key posterize.levels without quotes as two nested ones."""
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{front}{key}.")
        else:
            yield front + key, value


def _unknown(table: Mapping[str, Any], keys: Sequence[str]) -> Iterator[str]:
    for key in table:
        if key not in keys:
            yield f"there is no key {key!r}; {suggest(key, keys)}"


def _choice(table: Mapping[str, Any], key: str, options: tuple[str, ...], default: str) -> Any:
    if (value := table.get(key, default)) not in options:
        raise ValueError(f"{key} = {value!r} is not one of {join_names(options)}")
    return value


def _number(value: object, name: str, low: int, high: int) -> Fraction:
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if not is_number or not low <= value <= high:  # type: ignore[operator]
        raise ValueError(f"{name} = {value!r} is not a number from {low} to {high}")
    return Fraction(str(value))
