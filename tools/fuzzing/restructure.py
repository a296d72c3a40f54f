"""Damage the structure of a file: move, repeat, remove, resize, rename or swap its parts."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from random import Random
from typing import NamedTuple

from tools.fuzzing.damage import ODD_NUMBERS, damage
from tools.fuzzing.structure import Part, Syntax, part_lists

MAX_BYTES = 2**20
"""Larger files are not changed further."""


class Place(NamedTuple):
    """The position of a part in a list of parts."""

    siblings: list[Part]
    position: int

    @property
    def part(self) -> Part:
        """The part at this position."""
        return self.siblings[self.position]


def restructure(random: Random, content: bytes, family: Syntax, donor: bytes) -> bytes:
    """Apply one to five faults to the structure of a file.

    Args:
        random: source of random numbers.
        content: content of the file.
        family: syntax of the file.
        donor: another file with the same syntax, whose parts may replace parts of the file.
    """
    parts, others = family.read(content), family.read(donor)
    for _ in range(random.choice((1, 1, 2, 5))):
        if parts and len(family.write(parts)) < MAX_BYTES:
            random.choice(FAULTS)(random, _random_place(random, parts), parts, others, family)
    return family.write(parts)


def _random_place(random: Random, parts: list[Part]) -> Place:
    """Return a random part at any depth; all lists of parts are equally likely, however short."""
    siblings = random.choice(list(part_lists(parts)))
    return Place(siblings, random.randrange(len(siblings)))


def _remove(random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax) -> None:
    del place.siblings[place.position : place.position + random.choice((1, 1, 1, 3))]


def _double(random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax) -> None:
    target = random.choice((place, _random_place(random, parts)))
    copies = [deepcopy(place.part) for _ in range(random.choice((1, 1, 5, 100)))]
    if len(family.write(copies)) < MAX_BYTES:
        target.siblings[target.position : target.position] = copies


def _move(random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax) -> None:
    part = place.siblings.pop(place.position)
    if parts:
        target = _random_place(random, parts)
        target.siblings.insert(target.position, deepcopy(part))


def _swap(random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax) -> None:
    other = random.choice((_random_place(random, parts), Place(place.siblings, len(place.siblings) - 1)))
    first, second = deepcopy(place.part), deepcopy(other.part)
    place.siblings[place.position], other.siblings[other.position] = second, first


def _insert_from_donor(
    random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax
) -> None:
    """Insert a part of another file, mostly one with the same name."""
    same = [part for siblings in part_lists(others) for part in siblings if part.name == place.part.name]
    part = random.choice(same) if same and random.random() < 0.7 else _random_place(random, others).part
    place.siblings[place.position : place.position + random.choice((0, 1))] = [deepcopy(part)]


def _resize(random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax) -> None:
    size = len(place.part.content)
    place.part.size = random.choice((*ODD_NUMBERS, size - 1, size + 1, 2 * size, size + 1000))


def _rename(random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax) -> None:
    place.part.name = random.choice(
        (_random_place(random, parts).part.name, _random_place(random, others).part.name)
    )


def _cut(random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax) -> None:
    """Shorten or damage the content, and update the size in the header."""
    content = place.part.content
    place.part.content = random.choice((content[: random.randint(0, len(content))], damage(random, content)))


def _set_numbers(random: Random, place: Place, parts: list[Part], others: list[Part], family: Syntax) -> None:
    """Overwrite numbers with odd ones, at even offsets near the start of a part."""
    content = bytearray(place.part.content)
    for _ in range(random.choice((1, 1, 4)) if content else 0):
        start, width = random.randrange(0, min(len(content), 64), 2), random.choice((2, 4, 4, 8))
        number = random.choice((*ODD_NUMBERS, random.getrandbits(64))) % 256**width
        content[start : start + width] = number.to_bytes(width, family.order)
    place.part.content = bytes(content)


Fault = Callable[[Random, Place, list[Part], list[Part], Syntax], None]
FAULTS: tuple[Fault, ...] = (
    *(_remove, _double, _move, _swap, _insert_from_donor, _resize, _rename, _cut),
    *(_set_numbers, _set_numbers),
)
