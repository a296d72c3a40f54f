"""Puts GLSL files together, each once, so that errors can still be told by file and line."""

from __future__ import annotations

import re

from vidstyle.gpu.signature import read_source

TYPES = {1: "float", 2: "vec2", 3: "vec3", 4: "vec4"}
"""The GLSL type of so many numbers."""

_INCLUDE = re.compile(r'^#include "(?P<file>[^"]+)"$')
_CHANNELS = re.compile(r"\bchannels\b")
_PLACE = re.compile(r"\b0(?::(?P<colon>\d+)|\((?P<bracket>\d+)\))")


class Assembly:
    """A shader's text while it grows, and the files that it comes from.

    Attributes:
        lines: the text so far.
    """

    def __init__(self, version: int) -> None:
        self.lines = [f"#version {version}"]
        # Not told to the compiler by `#line`: some forget the file in some of their messages.
        self._places: dict[int, str] = {}
        self._included: set[tuple[str, int]] = set()

    @property
    def text(self) -> str:
        """The whole text."""
        return "\n".join(self.lines) + "\n"

    def add(self, *lines: str) -> None:
        """Append generated lines."""
        self.lines += lines

    def include(self, file: str, channels: int = 1) -> None:
        """Append a file, with what it includes itself, unless it is there already.

        Args:
            file: its path below shaders/.
            channels: what the word `channels` in it stands for; a file that uses it may come once for each.
        """
        source = read_source(file)
        if _CHANNELS.search(source) is None:
            channels = 0
        if (file, channels) not in self._included:
            self._included.add((file, channels))
            self._add_file(file, _CHANNELS.sub(TYPES.get(channels, ""), source), channels)

    def add_template(self, file: str, words: dict[str, str]) -> None:
        """Append a file with other words in the place of some of its own."""
        source = read_source(file)
        for word, other in words.items():
            source = re.sub(rf"\b{word}(?=_|\b)", other, source)
        self._add_file(file, source, 1)

    def name_places(self, message: str) -> str:
        """A compiler's message with our files and lines in it."""

        def named(match: re.Match[str]) -> str:
            line = int(match["colon"] or match["bracket"])
            return self._places.get(line, f"generated:{line}")

        return "\n".join(_PLACE.sub(named, line, count=1) for line in message.splitlines())

    def _add_file(self, file: str, source: str, channels: int) -> None:
        for line, text in enumerate(source.splitlines(), 1):
            if match := _INCLUDE.match(text):
                self.include(match["file"], channels or 1)
            else:
                self.lines.append(text)
                self._places[len(self.lines)] = f"shaders/{file}:{line}"
