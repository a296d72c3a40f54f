"""Reads a file as its parts (boxes, elements, chunks, segments, tags or packets), and writes changed ones.

Sizes and checksums are those of the changed parts, so that a change reaches the code behind the parser of the
container.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

Order = Literal["big", "little"]


@dataclass
class Part:
    """A part of a file.

    Attributes:
        name: type, identifier or tag as in the file; empty for bytes that are no part.
        content: without header; of a part with children, what precedes these.
        children: parts inside this one, or None.
        size: what the header says instead of the right size, or None.
    """

    name: bytes
    content: bytes
    children: list[Part] | None = None
    size: int | None = None


class Extent(NamedTuple):
    """Where a part lies in a file: its content from `begin` to `end`, the next part at `after`."""

    name: bytes
    begin: int
    end: int
    after: int


@dataclass(frozen=True)
class Family:
    """A family of formats with the same syntax.

    Attributes:
        extent: where the part at a place lies; None where there is none.
        head: the header for a name and a size of the content.
        tail: what follows a content: padding or a checksum of header and content.
        containers: names of parts with children, and how many bytes precede these.
        signature: bytes at the start of a file before its first part.
        order: of the bytes in numbers.
    """

    extent: Callable[[bytes, int], Extent | None]
    head: Callable[[bytes, int], bytes]
    tail: Callable[[bytes, bytes], bytes] = lambda head, content: b""
    containers: Mapping[bytes, int] = field(default_factory=dict)
    signature: int = 0
    order: Order = "big"

    def read(self, content: bytes) -> list[Part]:
        """The parts of a file; its signature is the first."""
        return [Part(b"", content[: self.signature]), *self._parts(content, self.signature)]

    def _parts(self, content: bytes, place: int) -> Iterator[Part]:
        while place < len(content):
            found = self.extent(content, place)
            if found is None or not place < found.after <= len(content):
                yield Part(b"", content[place:])
                return
            yield self._part(found.name, content[found.begin : found.end])
            place = found.after

    def _part(self, name: bytes, content: bytes) -> Part:
        lead = self.containers.get(name)
        if lead is None:
            return Part(name, content)
        return Part(name, content[:lead], list(self._parts(content, lead)))

    def write(self, parts: list[Part]) -> bytes:
        """The file of these parts."""
        return b"".join(map(self._written, parts))

    def _written(self, part: Part) -> bytes:
        content = part.content + self.write(part.children or [])
        if not part.name:
            return content
        head = self.head(part.name, len(content) if part.size is None else part.size)
        return head + content + self.tail(head, content)


def shelves(parts: list[Part]) -> Iterator[list[Part]]:
    """All lists of parts in a file: the outermost one and those of each part with children."""
    if parts:
        yield parts
    for part in parts:
        yield from shelves(part.children or [])
