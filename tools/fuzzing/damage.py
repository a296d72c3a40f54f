"""Damage bytes and text of any kind."""

from __future__ import annotations

import math
from random import Random

ODD_NUMBERS = (0, 1, 2, 0x7F, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
ODD_FLOATS = (math.nan, math.inf, -math.inf, 1e30, -1e30, 1e-40, -1.0, 255.0, 65504.0)
ODD_VALUES: tuple[object, ...] = (
    *ODD_FLOATS,
    *ODD_NUMBERS,
    10**400,
    2**63,
    "",
    "x" * 300,
    "source",
    "../x",
    "/",
    ".",
    True,
    [],
    {},
)
WORDS = (
    *("-->", "{\\i1}", "<i>", "</i>", "&#1114112;", "&amp;", "\\N", "♪", "- ", "\u200f", "e\u0301", "漢字"),
    *("[", "]]", '"', "'''", "=", "#", "nan", "inf", "1e400", "-0", "0x", "block", "from", "save", "\0"),
)


def damage(random: Random, content: bytes) -> bytes:
    """Apply one to three faults: changed bytes, holes, lost or repeated parts, odd numbers in the header."""
    for _ in range(random.choice((1, 1, 2, 3))):
        fault = random.choice((_flipped, _holed, _shortened, _doubled, _with_odd_header))
        content = bytes(fault(random, bytearray(content)))
    return content


def _flipped(random: Random, content: bytearray) -> bytearray:
    for _ in range(random.choice((1, 3, 10, 50, 200)) if content else 0):
        content[random.randrange(len(content))] = random.randrange(256)
    return content


def random_slice(random: Random, length: int) -> slice:
    """Return a random part of a sequence of this length, mostly a short one."""
    start = random.randint(0, length)
    return slice(start, start + random.randint(0, max(1, length // random.choice((2, 20, 200)))))


def _holed(random: Random, content: bytearray) -> bytearray:
    part = random_slice(random, len(content))
    length = len(content[part])
    content[part] = random.choice((bytes(length), b"\xff" * length, random.randbytes(length)))
    return content


def _shortened(random: Random, content: bytearray) -> bytearray:
    if random.random() < 0.5:
        return content[: random.randint(0, len(content))]
    del content[random_slice(random, len(content))]
    return content


def _doubled(random: Random, content: bytearray) -> bytearray:
    start = random.randint(0, len(content))
    content[start:start] = content[random_slice(random, len(content))] * random.choice((1, 1, 5))
    return content


def _with_odd_header(random: Random, content: bytearray) -> bytearray:
    for _ in range(random.randint(1, 8) if content else 0):
        # The header of a film may be at its end.
        place = random.randrange(min(len(content), 400)) * random.choice((1, 1, -1))
        size = random.choice((1, 2, 4))
        number = random.choice(ODD_NUMBERS) & (256**size - 1)
        content[place : place + size or None] = number.to_bytes(size, random.choice(("big", "little")))
    return content


def edit_text(random: Random, text: str) -> bytes:
    """Change, repeat or remove characters and lines, and encode the text in a random encoding."""
    for _ in range(random.choice((1, 3, 20))):
        parts = list(text) if random.random() < 0.5 else text.splitlines(keepends=True)
        place = random.randrange(len(parts) + 1)
        new = random.choice(
            (*WORDS, *parts[:20], str(random.choice(ODD_NUMBERS)), chr(random.randrange(0xD800)))
        )
        if random.random() < 0.1:
            new *= random.choice((10, 400, 2000))
        parts[place : place + random.randint(0, 3)] = [new] * random.choice((0, 1, 1, 2))
        text = "".join(parts)
    encoding = random.choice(("utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16", "latin-1"))
    return text.encode(encoding, "replace")
