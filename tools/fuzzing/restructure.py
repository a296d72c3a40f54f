"""Damage to the structure of a file: parts that are moved, doubled, removed, resized, renamed or swapped."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from random import Random
from typing import NamedTuple

from tools.fuzzing.damage import ODD_NUMBERS, damaged
from tools.fuzzing.structure import Family, Part, shelves

MAX_BYTES = 2**20
"""A file that has grown beyond this is not changed further."""


class Place(NamedTuple):
    """One of the parts in a list of parts."""

    shelf: list[Part]
    index: int

    @property
    def part(self) -> Part:
        """The part there."""
        return self.shelf[self.index]


def restructured(random: Random, content: bytes, family: Family, donor: bytes) -> bytes:
    """Apply one to five faults to the structure of a file.

    Args:
        random: where chance comes from.
        content: of the file.
        family: how the file is read.
        donor: another file of the family, parts of which may replace those of the file.
    """
    parts, others = family.read(content), family.read(donor)
    for _ in range(random.choice((1, 1, 2, 5))):
        if parts and len(family.write(parts)) < MAX_BYTES:
            random.choice(FAULTS)(random, _random_place(random, parts), parts, others, family)
    return family.write(parts)


def _random_place(random: Random, parts: list[Part]) -> Place:
    """A part at any depth: each list of parts is as likely as another, so that short ones are not missed."""
    shelf = random.choice(list(shelves(parts)))
    return Place(shelf, random.randrange(len(shelf)))


def _remove(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    del place.shelf[place.index : place.index + random.choice((1, 1, 1, 3))]


def _double(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    target = random.choice((place, _random_place(random, parts)))
    copies = [deepcopy(place.part) for _ in range(random.choice((1, 1, 5, 100)))]
    if len(family.write(copies)) < MAX_BYTES:
        target.shelf[target.index : target.index] = copies


def _move(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    part = place.shelf.pop(place.index)
    if parts:
        target = _random_place(random, parts)
        target.shelf.insert(target.index, deepcopy(part))


def _swap(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    other = random.choice((_random_place(random, parts), Place(place.shelf, len(place.shelf) - 1)))
    first, second = deepcopy(place.part), deepcopy(other.part)
    place.shelf[place.index], other.shelf[other.index] = second, first


def _take(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    """Take over a part of another file, of the same name where it has one."""
    same = [part for shelf in shelves(others) for part in shelf if part.name == place.part.name]
    part = random.choice(same) if same and random.random() < 0.7 else _random_place(random, others).part
    place.shelf[place.index : place.index + random.choice((0, 1))] = [deepcopy(part)]


def _resize(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    size = len(place.part.content)
    place.part.size = random.choice((*ODD_NUMBERS, size - 1, size + 1, 2 * size, size + 1000))


def _rename(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    place.part.name = random.choice(
        (_random_place(random, parts).part.name, _random_place(random, others).part.name)
    )


def _cut(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    """Shorten or damage the content; the size in the header follows."""
    content = place.part.content
    place.part.content = random.choice((content[: random.randint(0, len(content))], damaged(random, content)))


def _set_numbers(random: Random, place: Place, parts: list[Part], others: list[Part], family: Family) -> None:
    """Put odd numbers where a part has numbers: at even places near its start."""
    content = bytearray(place.part.content)
    for _ in range(random.choice((1, 1, 4)) if content else 0):
        start, width = random.randrange(0, min(len(content), 64), 2), random.choice((2, 4, 4, 8))
        number = random.choice((*ODD_NUMBERS, random.getrandbits(64))) % 256**width
        content[start : start + width] = number.to_bytes(width, family.order)
    place.part.content = bytes(content)


Fault = Callable[[Random, Place, list[Part], list[Part], Family], None]
FAULTS: tuple[Fault, ...] = (
    *(_remove, _double, _move, _swap, _take, _resize, _rename, _cut),
    *(_set_numbers, _set_numbers),
)
