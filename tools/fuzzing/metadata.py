"""Pictures with metadata: profiles, EXIF, XMP, gain maps and text, intact or damaged."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from functools import cache
from random import Random

from PIL import ImageCms

from tools.fuzzing.damage import WORDS, damage
from tools.fuzzing.formats import FAMILIES
from tools.fuzzing.structure import Part

XMP = """<?xpacket begin="" id="W5M0MpCehiHzreSzNTczkc9d"?><x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF
xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description xmlns:hdrgm="http://ns.adobe.com/hdr-gain-map/1.0/"
hdrgm:Version="1.0" hdrgm:GainMapMax="{value}" tiff:Orientation="{value}"/></rdf:RDF></x:xmpmeta>"""
ODD_ORIENTATION_CODES = (0, 9, 255, 65535)
Metadata = dict[str, bytes]
"""Content by kind: profile, exif, xmp, index (of the pictures in the file) and text."""


def add_metadata(random: Random, content: bytes, suffix: str) -> bytes:
    """Add metadata of one or more kinds to a picture; half of it is damaged."""
    family = FAMILIES[suffix]
    parts = family.read(content)
    for kind in random.sample(list(MAKERS), random.randint(1, len(MAKERS))):
        made = MAKERS[kind](random)
        if random.random() < 0.5:
            made = damage(random, made)
        for _ in range(random.choice((1, 1, 1, 1, 2, 50))):
            PLACERS[suffix](random, parts, kind, made)
    return family.write(parts)


@cache
def profile() -> bytes:
    """Return an ICC profile with a fixed date."""
    made = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    return made[:24] + bytes(12) + made[36:]


def _profile(random: Random) -> bytes:
    return profile() * random.choice((1, 1, 1, 200))


def _exif(random: Random) -> bytes:
    """Return a TIFF with an orientation, a resolution, a text, and pointers to itself or out of bounds."""
    order = random.choice("<>")
    orientation = random.choice((*range(1, 9), *range(1, 9), *ODD_ORIENTATION_CODES))
    entries = [
        (0x0112, random.choice((3, 3, 3, 4, 7, 99)), 1, orientation),
        (0x011A, 5, 1, random.choice((8, 60, 2**31))),
        (0x010E, 2, random.choice((4, 40, 2**32 - 1)), random.choice((8, 70, 2**32 - 1))),
        (0x8769, 4, 1, random.choice((8, 8, 60, 2**32 - 1))),
        (0x8825, 4, 1, random.choice((8, 60, 2**32 - 1))),
    ]
    random.shuffle(entries)
    entries = entries[: random.randint(1, 5)]
    fields = b"".join(
        struct.pack(f"{order}HHIH2x", tag, kind, count, value)
        if kind == 3
        else struct.pack(f"{order}HHII", tag, kind, count, value)
        for tag, kind, count, value in entries
    )
    head = struct.pack(f"{order}2sHIH", b"II" if order == "<" else b"MM", 42, 8, len(entries))
    return (
        head + fields + struct.pack(f"{order}I", random.choice((0, 0, 8, 2**32 - 1))) + random.randbytes(40)
    )


def _xmp(random: Random) -> bytes:
    value = random.choice((*WORDS, "1.5", "6", "x" * 70_000))
    return XMP.format(value=value).encode() * random.choice((1, 1, 3))


def _index(random: Random) -> bytes:
    """Return a multi-picture index of two pictures, the second of any size and offset."""
    order = random.choice("<>")
    size, offset = (random.choice((0, 100, 1000, 2**31, 2**32 - 1)) for _ in range(2))
    head = struct.pack(f"{order}2sHIH", b"II" if order == "<" else b"MM", 42, 8, 3)
    tags = [(0xB000, 7, 4, 0x30303130), (0xB001, 4, 1, random.choice((1, 2, 2**32 - 1))), (0xB002, 7, 32, 50)]
    pictures = struct.pack(f"{order}IIIHHIIIHH", 0x030000, 1000, 0, 0, 0, 0, size, offset, 0, 0)
    fields = b"".join(struct.pack(f"{order}HHII", *tag) for tag in tags)
    return b"MPF\0" + head + fields + bytes(4) + pictures


def _text(random: Random) -> bytes:
    return random.choice((*WORDS, "word", "x" * 100_000)).encode() * random.choice((1, 50))


MAKERS: dict[str, Callable[[Random], bytes]] = {
    "profile": _profile,
    "exif": _exif,
    "xmp": _xmp,
    "index": _index,
    "text": _text,
}


def _place_chunk(random: Random, parts: list[Part], kind: str, content: bytes) -> None:
    """PNG: insert a chunk before the pixels, rarely anywhere."""
    packed = zlib.compress(content)
    chunk = {
        "profile": Part(b"iCCP", b"name\0\0" + packed),
        "exif": Part(b"eXIf", content),
        "xmp": Part(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + content),
        "index": Part(random.choice((b"cICP", b"mDCV", b"cLLI", b"gAMA", b"pHYs", b"sBIT")), content[:24]),
        "text": random.choice(
            (
                Part(b"tEXt", b"Title\0" + content),
                Part(b"zTXt", b"Title\0\0" + packed),
                Part(b"acTL", bytes(8)),
            )
        ),
    }[kind]
    parts.insert(random.choice((2, 2, 2, random.randint(1, len(parts)))), chunk)


def _place_segment(random: Random, parts: list[Part], kind: str, content: bytes) -> None:
    """JPEG: insert segments; a profile may need several."""
    front = {
        "profile": b"",
        "exif": b"Exif\0\0",
        "xmp": b"http://ns.adobe.com/xap/1.0/\0",
        "index": b"",
        "text": b"",
    }[kind]
    marker = {"profile": b"\xff\xe2", "index": b"\xff\xe2", "text": b"\xff\xfe"}.get(kind, b"\xff\xe1")
    limit = 65_000
    pieces = [content[start : start + limit] for start in range(0, len(content), limit)] or [b""]
    if kind == "profile":
        pieces = [
            b"ICC_PROFILE\0" + bytes([number % 256, len(pieces) % 256]) + piece
            for number, piece in enumerate(pieces, 1)
        ]
    place = random.choice((1, 1, 1, random.randint(1, max(1, len(parts) - 1))))
    parts[place:place] = [Part(marker, front + piece) for piece in pieces]


def _place_riff_chunk(random: Random, parts: list[Part], kind: str, content: bytes) -> None:
    """WebP: insert a chunk after an extended header, whose flags list the metadata."""
    chunks = next((part.children for part in parts if part.children), None)
    if chunks is None:
        return
    if chunks[0].name != b"VP8X":
        chunks.insert(
            0, Part(b"VP8X", bytes([random.choice((0x2C, 0x2C, 0, 0xFF))]) + bytes(3) + b"\x3f\0\0\x2f\0\0")
        )
    name = {"profile": b"ICCP", "exif": b"EXIF", "xmp": b"XMP "}.get(
        kind, random.choice((b"note", b"note", b"ANIM"))
    )
    usual = 1 if kind == "profile" else len(chunks)
    place = random.choice((usual, usual, usual, random.randint(1, len(chunks))))
    chunks.insert(place, Part(name, content))


def _place_tag(random: Random, parts: list[Part], kind: str, content: bytes) -> None:
    """TIFF: add a tag, with its content after the pixels."""
    code = {"profile": 34675, "exif": 34665, "xmp": 700, "index": 330, "text": 270}[kind]
    order = "<" if parts[0].content[:2] == b"II" else ">"
    if kind == "exif" and random.random() < 0.5:
        orientation = random.choice((*range(1, 9), *ODD_ORIENTATION_CODES))
        parts.append(Part(struct.pack(f"{order}H", 274), struct.pack(f"{order}HIH2x", 3, 1, orientation)))
        return
    offset, count = len(parts[0].content), len(content)
    parts[0].content += content
    tag_type = {"exif": 4, "index": 4}.get(kind, random.choice((1, 2, 7)))
    count = 1 if tag_type == 4 else count
    parts.append(Part(struct.pack(f"{order}H", code), struct.pack(f"{order}HII", tag_type, count, offset)))


PLACERS: dict[str, Callable[[Random, list[Part], str, bytes], None]] = {
    ".png": _place_chunk,
    ".jpg": _place_segment,
    ".webp": _place_riff_chunk,
    ".tif": _place_tag,
}
"""Functions that insert metadata into a picture, by file ending."""
