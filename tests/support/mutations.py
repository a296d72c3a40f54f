"""Damaged and random files for tools/fuzz.py: films, pictures, style files, banks and subtitle files."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Iterable
from pathlib import Path
from random import Random
from typing import Any

import av
import numpy as np
import tomlkit
from media import frame_from_rgb, make_clip, moving_frames
from PIL import Image
from random_styles import Chance

from vidstyle.blade.bank import shipped_banks
from vidstyle.block import Control, Slider
from vidstyle.blocks import all_blocks
from vidstyle.style import LAYERS, table_from_style
from vidstyle.style.check import MAX_STEPS, STEP_KEYS
from vidstyle.style.model import FIELDS
from vidstyle.style.paths import steps_by_path

SIZE = (64, 48)
FILMS: dict[str, dict[str, Any]] = {
    "film.mp4": {"codec": "libx264", "audio_tracks": 1, "subtitles": ["eng"], "chapters": 2},
    "film.mov": {"codec": "prores_ks", "pix_fmt": "yuv422p10le", "rotation": 90},
    "film.mkv": {"codec": "libx265", "pix_fmt": "yuv420p10le", "audio_tracks": 2, "subtitles": ["eng"]},
    "film.webm": {"codec": "libvpx-vp9", "audio_tracks": 1},
    "film.avi": {"codec": "mpeg4"},
    "film.ts": {"codec": "mpeg2video", "audio_tracks": 1},
    "film.flv": {"codec": "flv", "audio_tracks": 1},
    "av1.mkv": {"codec": "libsvtav1", "options": {"svtav1-params": "lp=1"}},
    "film.nut": {"codec": "ffv1", "pix_fmt": "yuva420p"},
    "film.wmv": {"codec": "wmv2"},
    "film.y4m": {"codec": "rawvideo", "format": "yuv4mpegpipe"},
    "film.gif": {"codec": "gif", "pix_fmt": "rgb8"},
}
"""Arguments of `make_clip`: all containers and codecs."""

STILLS: dict[str, dict[str, Any]] = {
    "rgb.png": {},
    "rgba.png": {"mode": "RGBA"},
    "palette.png": {"mode": "P"},
    "deep.png": {"mode": "I;16"},
    "usual.jpg": {"exif": b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"},
    "progressive.jpg": {"progressive": True},
    "several.jpg": {"format": "MPO", "save_all": True, "frames": 2},
    "lossy.webp": {},
    "lossless.webp": {"lossless": True, "mode": "RGBA"},
    "moving.webp": {"save_all": True, "frames": 3},
    "still.gif": {},
    "still.bmp": {},
    "plain.tif": {},
    "packed.tif": {"compression": "tiff_lzw"},
    "pages.tif": {"save_all": True, "frames": 2, "compression": "tiff_adobe_deflate"},
    "still.ppm": {},
    "still.pgm": {"mode": "L"},
    "still.jp2": {},
    "still.sgi": {},
    "still.pcx": {},
    "still.avif": {},
    "still.qoi": {},
    "still.psd": {},
    "still.dpx": {"codec": "dpx", "pix_fmt": "gbrp10le"},
    "still.sun": {"codec": "sunrast", "pix_fmt": "bgr24"},
    "still.jls": {"codec": "jpegls", "pix_fmt": "rgb24"},
}
"""What Pillow is told, or the encoder of FFmpeg: every still format. No library here writes PSD."""

ODD_NUMBERS = (0, 1, 2, 0x7F, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
ODD_FLOATS = (math.nan, math.inf, -math.inf, 1e30, -1e30, 1e-40, -1.0, 255.0, 65504.0)
WORDS = (
    *("-->", "{\\i1}", "<i>", "</i>", "&#1114112;", "&amp;", "\\N", "♪", "- ", "\u200f", "e\u0301", "漢字"),
    *("[", "]]", '"', "'''", "=", "#", "nan", "inf", "1e400", "-0", "0x", "block", "from", "save", "\0"),
)
ASS_HEADER = (
    *("[Script Info]", "ScriptType: v4.00+", "[Events]"),
    "Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text",
)
STORY = [
    (1.0, 2.5, "Good morning."),
    (3.0, 4.0, "- Is it?\n- <i>It is.</i>"),
    (4.2, 5.0, "A longer line of a narrator who has much to say about the weather."),
    (5.5, 6.0, "[door slams]"),
]


def whole_files(folder: Path, kinds: Iterable[str]) -> dict[str, list[Path]]:
    """The films and pictures that are mutated; files of other kinds are made anew for each case."""
    folder.mkdir(exist_ok=True)
    makers = {"film": (FILMS, _film), "picture": (STILLS, _still)}
    return {
        kind: [make(folder / name, **options) for name, options in files.items()]
        for kind, (files, make) in makers.items()
        if kind in kinds
    }


def mutated(kind: str, seed: int, number: int, whole: dict[str, list[Path]]) -> tuple[str, bytes]:
    """A case: the ending of its file and what stands in it. The same arguments give the same case."""
    random = Random(f"{kind} {seed} {number}")
    if kind == "picture" and random.random() < 0.1:
        return ".npy", _array_bytes(_odd_array(random, (random.randint(1, 40), random.randint(1, 40), 3)))
    if kind in whole:
        path = random.choice(whole[kind])
        return path.suffix, damaged(random, path.read_bytes())
    return {"style": _style, "bank": _bank, "subtitle": _subtitle}[kind](random)


def damaged(random: Random, content: bytes) -> bytes:
    """With one to three faults: flipped bytes, a hole, a part lost or doubled, odd numbers in its header."""
    for _ in range(random.choice((1, 1, 2, 3))):
        content = random.choice((_flipped, _holed, _shortened, _doubled, _with_odd_header))(
            random, bytearray(content)
        )
    return bytes(content)


def _flipped(random: Random, content: bytearray) -> bytearray:
    for _ in range(random.choice((1, 3, 10, 50, 200)) if content else 0):
        content[random.randrange(len(content))] = random.randrange(256)
    return content


def _part(random: Random, content: bytearray) -> slice:
    start = random.randint(0, len(content))
    return slice(start, start + random.randint(0, max(1, len(content) // random.choice((2, 20, 200)))))


def _holed(random: Random, content: bytearray) -> bytearray:
    part = _part(random, content)
    length = len(content[part])
    content[part] = random.choice((bytes(length), b"\xff" * length, random.randbytes(length)))
    return content


def _shortened(random: Random, content: bytearray) -> bytearray:
    if random.random() < 0.5:
        return content[: random.randint(0, len(content))]
    del content[_part(random, content)]
    return content


def _doubled(random: Random, content: bytearray) -> bytearray:
    start = random.randint(0, len(content))
    content[start:start] = content[_part(random, content)] * random.choice((1, 1, 5))
    return content


def _with_odd_header(random: Random, content: bytearray) -> bytearray:
    for _ in range(random.randint(1, 8) if content else 0):
        # The header of a film may stand at its end.
        place = random.randrange(min(len(content), 400)) * random.choice((1, 1, -1))
        size = random.choice((1, 2, 4))
        number = random.choice(ODD_NUMBERS) & (256**size - 1)
        content[place : place + size or None] = number.to_bytes(size, random.choice(("big", "little")))
    return content


def _film(path: Path, **options: Any) -> Path:
    # Anew each time: the same film has the same bytes.
    make_clip.__wrapped__(path, size=SIZE, frames=10, **options)
    return path


def _still(
    path: Path, frames: int = 1, mode: str = "RGB", codec: str = "", pix_fmt: str = "", **options: Any
) -> Path:
    pictures = list(moving_frames(frames, SIZE))
    if codec:
        with av.open(str(path), "w", format="image2", options={"update": "1"}) as container:
            video = container.add_stream(codec, options={"strict": "-2"})
            video.width, video.height, video.pix_fmt = *SIZE, pix_fmt
            container.mux([*video.encode(frame_from_rgb(pictures[0], pix_fmt)), *video.encode(None)])
    elif path.suffix == ".psd":
        planes = np.moveaxis(pictures[0], 2, 0).tobytes()
        path.write_bytes(b"8BPS\0\1" + bytes(6) + b"\0\3\0\0\0\x30\0\0\0\x40\0\x08\0\3" + bytes(14) + planes)
    else:
        first, *rest = (Image.fromarray(picture) for picture in pictures)
        if mode == "I;16":
            first = Image.fromarray(pictures[0][..., 1].astype(np.uint16) * 257)
        if rest:
            options["append_images"] = rest
        (first if mode in ("RGB", "I;16") else first.convert(mode)).save(path, **options)
    return path


def _odd_array(random: Random, shape: tuple[int, ...]) -> np.ndarray:
    """Numbers of any type, some of them such as nobody expects."""
    numbers = np.random.default_rng(random.randrange(2**32))
    dtype = random.choice(("uint8", "uint16", "int32", "float16", "float32", "float64", "bool", "complex64"))
    array = np.asarray(numbers.uniform(-0.2, 1.2, shape)) * random.choice((1, 1, 1, 255, 1e30))
    for _ in range(random.choice((0, 1, 5)) if array.ndim and array.size else 0):
        array[tuple(random.randrange(side) for side in shape)] = random.choice(ODD_FLOATS)
    with np.errstate(all="ignore"):
        return array.astype(dtype)


def _array_bytes(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def _style(random: Random) -> tuple[str, bytes]:
    """A style file of up to 256 steps, with values at the ends of their ranges, beyond, of other types."""
    most = random.choice((1, 2, 2, 3, 8, MAX_STEPS // len(LAYERS)))
    chance = Chance(
        random.randrange(2**32), wild=True, learned=True, structure=True, max_steps=most, max_factor=math.inf
    )
    table = table_from_style(chance.style()) | random.choice(({}, {"height": random.uniform(16, 2000)}))
    share = random.choice((0, 0, 0.02, 0.3))
    for step in [table, *(step for layer in LAYERS for step in table.get(layer, []))]:
        parameters = all_blocks()[step["block"]].parameters if "block" in step else FIELDS
        step |= {
            name: _odd_value(random, parameters[name].control)
            for name in parameters
            if random.random() < share
        }
    values = {
        f"{path}.{name}": value
        for path, step in steps_by_path(table).items()
        for name, value in step.items()
        if name not in STEP_KEYS
    }
    table["variants"] = {"odd": {path: value for path, value in values.items() if random.random() < 0.02}}
    text = tomlkit.dumps(table)
    return ".toml", _edited(random, text) if random.random() < 0.2 else text.encode()


def _odd_value(random: Random, control: Control) -> Any:
    odd = [*ODD_FLOATS, *ODD_NUMBERS, 10**400, 2**63, "", "x" * 300, "source", "../x", "/", ".", True, [], {}]
    if isinstance(control, Slider):
        ends = control.low, control.high
        odd = [*ends, *ends, *ends, *ends, control.low - 1, math.nextafter(control.high, math.inf), *odd]
    return random.choice(odd)


def _edited(random: Random, text: str) -> bytes:
    """With characters, words and lines changed, doubled or left out; in one of several encodings."""
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


def _bank(random: Random) -> tuple[str, bytes]:
    """A bank with odd numbers in its arrays, with odd arrays, or damaged in its entries or as an archive."""
    with np.load(shipped_banks()["etf"]) as whole:
        entries = dict(whole)
    entries["filters"] *= np.float32(random.choice((1, 1, 10, 1e4, 1e30)))
    fault = random.choice(("weights", "numbers", "numbers", "array", "entry", "archive", "bomb"))
    name = random.choice(list(entries))
    if fault == "weights":
        part = _part(random, bytearray(entries["filters"].size))
        entries["filters"].reshape(-1)[part] = random.choice((0, -1e9, 1e9, 3e38))
    if fault == "numbers":
        entries[name] = _with_odd_numbers(random, entries[name])
    if fault == "array":
        entries[name] = _odd_array(
            random, tuple(random.choice((0, 1, 3, 24)) for _ in range(random.randint(0, 5)))
        )
    contents = {name: _array_bytes(array) for name, array in entries.items()}
    if fault == "entry":
        contents[name] = damaged(random, contents[name])
    if fault == "bomb":
        shape = random.choice(
            ("(99999999999,)", "(1,) * 9", "((" * 40, "[" * 3000, "(300000000, 1)", "(-1, 5)")
        )
        header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}}}\n".encode()
        contents[name] = (
            b"\x93NUMPY\1\0"
            + len(header).to_bytes(2, "little")
            + header
            + bytes(random.choice((0, 50 << 20)))
        )
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", random.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as file:
        for name, content in contents.items():
            # A fixed date: the same case has the same bytes.
            file.writestr(zipfile.ZipInfo(f"{name}.npy"), content, file.compression)
    content = archive.getvalue()
    return ".npz", damaged(random, content) if fault == "archive" else content


def _with_odd_numbers(random: Random, array: np.ndarray) -> np.ndarray:
    flat = array.reshape(-1)
    for _ in range(random.choice((1, 5))):
        number = random.choice(ODD_FLOATS if array.dtype.kind == "f" else ODD_NUMBERS)
        with np.errstate(all="ignore"):
            flat[random.randrange(len(flat))] = np.asarray(number).astype(array.dtype)
    return array


def _subtitle(random: Random) -> tuple[str, bytes]:
    """A subtitle file with odd times, words and lines."""
    suffix = random.choice((".srt", ".vtt", ".ass"))
    story = list(STORY)
    for _ in range(random.choice((0, 1, 4))):
        start = random.choice((0, 2, random.uniform(0, 9), 1e9, 10**40))
        word = random.choice((random.choice(WORDS), "mop", chr(random.randrange(0xD800)))) * random.choice(
            (1, 30, 2000)
        )
        story.insert(random.randrange(len(story)), (start, start + random.choice((0, 1, -3, 1e6)), word))
    return suffix, _edited(random, _subtitle_text(suffix, story * random.choice((1, 1, 1, 100))))


def _subtitle_text(suffix: str, story: list[tuple[float, float, str]]) -> str:
    if suffix == ".ass":
        lines = [
            f"Dialogue: 0,{_clock(start)},{_clock(end)},Default,Ann,0,0,0,,{text}"
            for start, end, text in story
        ]
        return "\n".join([*ASS_HEADER, *lines])
    blocks = [
        f"{number}\n{_clock(start)} --> {_clock(end)}\n{text}\n"
        for number, (start, end, text) in enumerate(story, 1)
    ]
    return ("WEBVTT\n\n" if suffix == ".vtt" else "") + "\n".join(blocks)


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(seconds, 60)
    return f"{int(minutes // 60):02d}:{int(minutes % 60):02d}:{seconds:06.3f}"
