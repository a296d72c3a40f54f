"""Parse a file into parts (boxes, elements, chunks, segments, tags or packets), and write changed parts.

Sizes and checksums are updated, so that changes reach the code behind the parser of the container.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, Protocol

Order = Literal["big", "little"]


@dataclass
class Part:
    """A part of a file.

    Attributes:
        name: type, identifier or tag as in the file; empty for bytes outside of parts.
        content: bytes after the header; in a part with children, the bytes before them.
        children: parts inside this one, or None.
        size: a wrong size for the header, or None.
    """

    name: bytes
    content: bytes
    children: list[Part] | None = None
    size: int | None = None


class Extent(NamedTuple):
    """Position of a part in a file: content from `begin` to `end`; the next part starts at `after`."""

    name: bytes
    begin: int
    end: int
    after: int


class Syntax(Protocol):
    """How to read and write the parts of a file."""

    @property
    def order(self) -> Order:
        """Byte order of numbers."""
        ...

    def read(self, content: bytes) -> list[Part]:
        """Return the parts of a file."""
        ...

    def write(self, parts: list[Part]) -> bytes:
        """Return a file with these parts."""
        ...


@dataclass(frozen=True)
class Family:
    """The syntax shared by a family of formats.

    Attributes:
        extent: returns the extent of the part at a position; None if there is no part.
        head: returns the header for a name and a content size.
        tail: returns the bytes after a content: padding or a checksum.
        containers: names of parts with children, and the number of bytes before the children.
        signature: number of bytes before the first part.
        order: byte order of numbers.
    """

    extent: Callable[[bytes, int], Extent | None]
    head: Callable[[bytes, int], bytes]
    tail: Callable[[bytes, bytes], bytes] = lambda head, content: b""
    containers: Mapping[bytes, int] = field(default_factory=dict)
    signature: int = 0
    order: Order = "big"

    def read(self, content: bytes) -> list[Part]:
        """Return the parts of a file; the first one is its signature."""
        return [Part(b"", content[: self.signature]), *self._parse_parts(content, self.signature)]

    def _parse_parts(self, content: bytes, place: int) -> Iterator[Part]:
        while place < len(content):
            found = self.extent(content, place)
            if found is None or not place < found.after <= len(content):
                yield Part(b"", content[place:])
                return
            yield self._parse_part(found.name, content[found.begin : found.end])
            place = found.after

    def _parse_part(self, name: bytes, content: bytes) -> Part:
        lead = self.containers.get(name)
        if lead is None:
            return Part(name, content)
        return Part(name, content[:lead], list(self._parse_parts(content, lead)))

    def write(self, parts: list[Part]) -> bytes:
        """Return a file with these parts."""
        return b"".join(map(self._write_part, parts))

    def _write_part(self, part: Part) -> bytes:
        content = part.content + self.write(part.children or [])
        if not part.name:
            return content
        head = self.head(part.name, len(content) if part.size is None else part.size)
        return head + content + self.tail(head, content)


def part_lists(parts: list[Part]) -> Iterator[list[Part]]:
    """Yield all lists of parts in a file: the outermost one, and the children of each part."""
    if parts:
        yield parts
    for part in parts:
        yield from part_lists(part.children or [])
