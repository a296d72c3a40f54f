"""Reads GLSL files: the functions that they define, and their parameters.

Names and types of the parameters suffice to call a function, so that shaders are not declared again in
Python.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import Literal

from vidstyle.assets import asset_folder

_FUNCTION_PATTERN = re.compile(
    r"^(?P<type>\w+) (?P<name>\w+)\((?P<parameters>[^)]*)\)\s*\{(?P<body>[^}]*)", re.MULTILINE
)
_PARAMETER_PATTERN = re.compile(r"^(?P<type>\w+) (?P<name>\w+)(?:\[(?P<count>\d+)\])?$")
_COMMENT_PATTERN = re.compile(r"//[^\n]*")
_LINE_PATTERN = re.compile(r"return \w+_along\(at, ivec2\((?P<across>[01]), (?P<down>[01])\)")


@dataclass(frozen=True)
class ShaderParameter:
    """A parameter of a GLSL function; `count` is above 0 for an array."""

    type: str
    name: str
    count: int = 0


@dataclass(frozen=True)
class Signature:
    """A GLSL function: its file, its return type and its parameters.

    Attributes:
        line: the direction in which a filter reads its picture, (1, 0) or (0, 1); None for all directions.
        prepares: whether the file has a function with the suffix `_prepare`, which all invocations of a
            compute group call together before the first pixel.
    """

    file: str
    type: str
    name: str
    parameters: tuple[ShaderParameter, ...]
    line: tuple[int, int] | None = None
    prepares: bool = False


TRIANGLE_SHADER = "frame/triangle.glsl"
"""The vertex shader of a triangle that covers the whole target."""


@cache
def read_source(file: str) -> str:
    """Return the text of a file in shaders/.

    Raises:
        FileNotFoundError: the file does not exist.
    """
    return (asset_folder("shaders") / file).read_text(encoding="utf-8")


@cache
def signatures(file: str) -> dict[str, Signature]:
    """Return the functions that a file defines, by name, in the order of the file.

    >>> [parameter.name for parameter in signatures("frame/color.glsl")["rgb_from_gray"].parameters]
    ['luma']
    """
    text = _COMMENT_PATTERN.sub("", read_source(file))
    found = (_signature(file, match) for match in _FUNCTION_PATTERN.finditer(text))
    return {signature.name: signature for signature in found}


@cache
def functions_of_block(name: str) -> tuple[Signature, ...]:
    """Return the functions that a step of a block calls in order: all named `name_...`, then `name`."""
    found = signatures(f"blocks/{name}.glsl")
    before = [signature for other, signature in found.items() if other.startswith(f"{name}_")]
    return (*before, found[name])


def _signature(file: str, match: re.Match[str]) -> Signature:
    texts = [text.strip() for text in match["parameters"].split(",")]
    parameters = tuple(_parameter(file, text) for text in texts if text)
    line = _LINE_PATTERN.search(match["body"])
    return Signature(
        file,
        match["type"],
        match["name"],
        parameters,
        line=(int(line["across"]), int(line["down"])) if line else None,
        prepares=re.search(rf"\bvoid {match['name']}_prepare\(", match.string) is not None,
    )


def _parameter(file: str, text: str) -> ShaderParameter:
    match = _PARAMETER_PATTERN.match(" ".join(text.split()))
    if match is None:
        raise ValueError(f"{file}: cannot read the parameter {text!r}")
    return ShaderParameter(match["type"], match["name"], int(match["count"] or 0))


Form = Literal["compute", "fragment", "es"]
"""How a pass runs: as a compute shader (OpenGL 4.3), a fragment shader (3.3), or a fragment shader of OpenGL
ES 3.0, which is WebGL 2."""

_FORM_HEADERS: dict[Form, tuple[str, ...]] = {
    "compute": ("#version 430",),
    "fragment": ("#version 330",),
    # OpenGL ES has a default precision only for int and float, and for float not in fragment shaders.
    "es": (
        "#version 300 es",
        *(f"precision highp {name};" for name in ("float", "int", "sampler2D", "sampler2DArray")),
    ),
}

VALUE_TYPES = {1: "float", 2: "vec2", 3: "vec3", 4: "vec4"}
"""The GLSL type of a value by its number of components."""

_INCLUDE_PATTERN = re.compile(r'^#include "(?P<file>[^"]+)"$')
_CHANNELS_PATTERN = re.compile(r"\bchannels\b")
_PLACE_PATTERN = re.compile(r"\b0(?::(?P<colon>\d+)|\((?P<bracket>\d+)\))")


@cache
def _has_channels(source: str) -> bool:
    return _CHANNELS_PATTERN.search(source) is not None


@cache
def _with_channels(source: str, channels: int) -> str:
    return _CHANNELS_PATTERN.sub(VALUE_TYPES.get(channels, ""), source)


@cache
def _with_words(source: str, words: tuple[tuple[str, str], ...]) -> str:
    """Replace some words of a text."""
    for word, other in words:
        source = re.sub(rf"\b{word}(?=_|\b)", other, source)
    return source


class Assembly:
    """The source of a shader under construction, and the files that it comes from.

    Args:
        form: form of the pass.

    Attributes:
        is_compute: whether it is a compute shader.
        lines: the text so far.
    """

    def __init__(self, form: Form) -> None:
        self.is_compute = form == "compute"
        self.lines = list(_FORM_HEADERS[form])
        # Without `#line`, as some compilers omit the file in some of their messages.
        self._places: list[tuple[int, str, int]] = []
        self._included: set[tuple[str, int]] = set()

    @property
    def text(self) -> str:
        """The complete text."""
        return "\n".join(self.lines) + "\n"

    def add(self, *lines: str) -> None:
        """Append generated lines."""
        self.lines += lines

    def add_once(self, line: str) -> None:
        """Append a generated line unless it already exists."""
        if line not in self.lines:
            self.lines.append(line)

    def include(self, file: str, channels: int = 1) -> None:
        """Append a file and the files that it includes, unless they already exist.

        Args:
            file: its path in shaders/.
            channels: the number of channels that the word `channels` in it stands for; a file that uses this
                word can be included once per number.
        """
        if not _has_channels(read_source(file)):
            channels = 0
        if (file, channels) not in self._included:
            self._included.add((file, channels))
            self._add_file(file, _with_channels(read_source(file), channels), channels)

    def add_template(self, file: str, words: dict[str, str]) -> None:
        """Append a file, with some of its words replaced."""
        self._add_file(file, _with_words(read_source(file), tuple(words.items())), 1)

    def name_places(self, message: str) -> str:
        """Insert files and lines of the shader sources into a compiler's message."""

        def named(match: re.Match[str]) -> str:
            line = int(match["colon"] or match["bracket"])
            before, file, first = next((each for each in self._places[::-1] if each[0] < line), (0, "", 0))
            return f"shaders/{file}:{first + line - 1 - before}" if file else f"generated:{line}"

        return "\n".join(_PLACE_PATTERN.sub(named, line, count=1) for line in message.splitlines())

    def _add_file(self, file: str, source: str, channels: int) -> None:
        for first, lines, included in _parts(source):
            self._places.append((len(self.lines), file, first))
            self.lines += lines
            self._places.append((len(self.lines), "", 0))
            if included:
                self.include(included, channels or 1)


@cache
def _parts(source: str) -> list[tuple[int, list[str], str]]:
    """Return runs of lines: number of the first line, the lines, and the file included after them, or ""."""
    parts: list[tuple[int, list[str], str]] = [(1, [], "")]
    for number, line in enumerate(source.splitlines(), 1):
        if match := _INCLUDE_PATTERN.match(line):
            parts[-1] = (*parts[-1][:2], match["file"])
            parts.append((number + 1, [], ""))
        else:
            parts[-1][1].append(line)
    return parts
