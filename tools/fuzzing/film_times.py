"""Films whose timestamps jump by hours, or whose PIDs and codecs change midway."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from tools.fuzzing.damage import ODD_NUMBERS
from tools.fuzzing.formats import FAMILIES, FLV_TAGS
from tools.fuzzing.structure import Part, Syntax, part_lists

JUMP_HOURS = (0.01, 1, 12, 24, 24, 26.6, 100, 600, 100_000)
CLOCK_RATES = (1, 1000, 12_800, 15_360, 48_000, 90_000, 10**6)
TIMED = (".mp4", ".mov", ".mkv", ".webm", ".avi", ".ts", ".flv")
"""Endings of the films whose timestamps can be changed."""
PACKET_BYTES = 188
"""Size of an MPEG-TS packet."""
CLUSTER = b"\x1f\x43\xb6\x75"
TIMESTAMP, BLOCKS = b"\xe7", (b"\xa3", b"\xa0")
"""Elements of a Matroska cluster: its timestamp, and blocks with relative timestamps."""
TIME_FIELDS: dict[bytes, tuple[int, int, int]] = {
    **{b"stts": (12, 8, 4), b"ctts": (12, 8, 4), b"elst": (8, 4, 4), b"stss": (8, 4, 4)},
    **{b"mvhd": (12, 4, 4), b"mdhd": (12, 4, 4), b"tkhd": (20, 40, 4)},
    **{b"avih": (0, 60, 4), b"strh": (20, 4, 4)},
    **{b"\x08": (0, 3, 3), b"\x09": (0, 3, 3)},
    # Timestamp, SimpleBlock, Block, TimestampScale, Duration, DefaultDuration, BlockDuration, CueTime.
    **{TIMESTAMP: (0, 0, 0), b"\xa3": (1, 999, 2), b"\xa1": (1, 999, 2), b"\x2a\xd7\xb1": (0, 0, 0)},
    **{b"\x44\x89": (0, 0, 0), b"\x23\xe3\x83": (0, 0, 0), b"\x9b": (0, 0, 0), b"\xb3": (0, 0, 0)},
}
"""Layout of the timestamps in a part: offset of the first, distance between two, and bytes of each.

Zeros mean that the content is a single number of any length.
"""


def shift_times(random: Random, content: bytes, suffix: str) -> bytes:
    """Shift timestamps of a film by hours: one, several, or all after a random one."""
    if suffix == ".ts":
        return _jumping_packets(random, bytearray(content))
    family = FAMILIES[suffix]
    parts = family.read(content)
    if suffix in (".mkv", ".webm") and random.random() < 0.5:
        _split_cluster(random, parts)
    elif suffix in (".mp4", ".mov") and random.random() < 0.5:
        _split_durations(random, parts)
    else:
        _change_fields(random, parts, family)
    return family.write(parts)


def _jump(random: Random, clocks: tuple[int, ...] = CLOCK_RATES) -> int:
    """Return a random shift in ticks of one of the clocks."""
    ticks = int(random.choice(JUMP_HOURS) * 3600 * random.choice(clocks))
    return random.choice((1, 1, -1)) * ticks


def _named(parts: list[Part], *names: bytes) -> list[Part]:
    return [part for siblings in part_lists(parts) for part in siblings if part.name in names]


def _change_fields(random: Random, parts: list[Part], family: Syntax) -> None:
    timed = _named(parts, *TIME_FIELDS)
    start = random.randrange(max(1, len(timed)))
    jump = _jump(random)
    for part in timed[start : start + random.choice((1, 1, 3, len(timed)))]:
        first, step, width = TIME_FIELDS[part.name]
        places = range(first, len(part.content) - width + 1, step) if width else range(1)
        if places:
            _change_number(random, part, random.choice(places), width, jump, family)


def _change_number(random: Random, part: Part, place: int, width: int, jump: int, family: Syntax) -> None:
    before = int.from_bytes(part.content[place : place + width or None], family.order)
    number = random.choice((before + jump, before + jump, before + jump, random.choice(ODD_NUMBERS)))
    stored = width or 8
    changed = (number % 256**stored).to_bytes(stored, family.order)
    if family is FLV_TAGS and random.random() < 0.5:
        place, stored, changed = 3, 1, changed[:1]  # the highest byte is stored after the others
    part.content = part.content[:place] + changed + (part.content[place + stored :] if width else b"")


def _split_cluster(random: Random, parts: list[Part]) -> None:
    """Matroska: shift all blocks after a random one, sometimes only up to another one."""
    for siblings in part_lists(parts):
        found = [index for index, part in enumerate(siblings) if part.name == CLUSTER and part.children]
        if found:
            index = random.choice(found)
            children = siblings[index].children or []
            time = next((part for part in children if part.name == TIMESTAMP), Part(TIMESTAMP, b"\0"))
            blocks = [part for part in children if part.name in BLOCKS]
            first, last = sorted(random.randrange(len(blocks) + 1) for _ in range(2))
            last = random.choice((last, len(blocks)))
            later = Part(
                TIMESTAMP, ((int.from_bytes(time.content) + _jump(random, (1000,))) % 2**64).to_bytes(8)
            )
            split = [time, *blocks[:first]], [later, *blocks[first:last]], [time, *blocks[last:]]
            siblings[index : index + 1] = [Part(CLUSTER, b"", children) for children in split]
            return


def _split_durations(random: Random, parts: list[Part]) -> None:
    """MP4: make single frames or sound packets last hours, in the tables of durations or offsets."""
    lists = [part for part in _named(parts, b"stts", b"ctts") if len(part.content) >= 16]
    if not lists:
        return
    part = random.choice(lists)
    entries = list(_expanded(part.content))
    for _ in range(random.choice((1, 1, 3))):
        index = random.randrange(len(entries))
        entries[index] = (entries[index] + _jump(random)) % 2**32
    body = b"".join((1).to_bytes(4) + entry.to_bytes(4) for entry in entries)
    part.content = part.content[:4] + len(entries).to_bytes(4) + body


def _expanded(content: bytes) -> Iterator[int]:
    for place in range(8, len(content) - 7, 8):
        count, value = (int.from_bytes(content[place + start :][:4]) for start in (0, 4))
        yield from [value] * min(count, 1000)


def _jumping_packets(random: Random, content: bytearray) -> bytes:
    """MPEG-TS: shift clock references and timestamps of one packet, several, or all after a random one."""
    count = len(content) // PACKET_BYTES
    start, jump = random.randrange(count), int(random.choice(JUMP_HOURS) * 3600 * 90_000)
    changed = random.choice(((_add_to_clock, _add_to_times), (_add_to_clock,), (_add_to_times,)))
    for number in range(start, min(count, start + random.choice((1, 10, count)))):
        packet = memoryview(content)[number * PACKET_BYTES :][:PACKET_BYTES]
        for change in changed:
            change(packet, jump)
    return bytes(content)


def _add_to_clock(packet: memoryview, jump: int) -> None:
    """Shift the 33-bit clock reference in the adaptation field, if present."""
    if packet[3] & 0x20 and packet[4] > 6 and packet[5] & 0x10:
        clock = (int.from_bytes(packet[6:11]) >> 7) + jump
        packet[6:11] = ((clock % 2**33) << 7 | packet[10] & 0x7F).to_bytes(5)


def _add_to_times(packet: memoryview, jump: int) -> None:
    """Shift the presentation and decoding timestamps if a frame begins in the packet."""
    header = 4 + (packet[4] + 1 if packet[3] & 0x20 else 0)
    if packet[1] & 0x40 and bytes(packet[header : header + 3]) == b"\0\0\1" and header + 19 <= PACKET_BYTES:
        times = {2: (9,), 3: (9, 14)}.get(packet[header + 7] >> 6, ())
        for time in times:
            _add_to_time(packet[header + time :][:5], jump)


def _add_to_time(field: memoryview, jump: int) -> None:
    """Shift a timestamp: 33 bits in five bytes, with a marker bit after each of three parts."""
    time = field[0] >> 1 & 7
    for place in (1, 3):
        time = time << 15 | int.from_bytes(field[place : place + 2]) >> 1
    time = (time + jump) % 2**33
    field[0] = field[0] & 0xF0 | time >> 30 << 1 | 1
    for place, shift in ((1, 15), (3, 0)):
        field[place : place + 2] = ((time >> shift & 0x7FFF) << 1 | 1).to_bytes(2)


def concatenate(random: Random, contents: list[bytes]) -> bytes:
    """Concatenate films as `cat` does: PIDs, codecs and sizes change midway."""
    chosen = [random.choice(contents) for _ in range(random.choice((2, 2, 3)))]
    if random.random() < 0.3:
        cut = random.randrange(len(chosen[0]) // PACKET_BYTES + 1) * PACKET_BYTES
        chosen[0] = chosen[0][:cut]
    return b"".join(chosen)
