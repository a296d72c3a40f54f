"""Undamaged films and pictures: all containers, codecs and still formats."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, cast

import av
import numpy as np
from av import VideoStream
from faults import remux
from media import frame_from_rgb, make_clip, moving_frames
from PIL import Image

from tools.fuzzing.metadata import profile

PICTURE_SIZE = (64, 48)
EXIF = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"
"""Metadata that rotates a picture by 90 degrees."""
FILMS: dict[str, dict[str, Any]] = {
    "film.mp4": {"codec": "libx264", "audio_tracks": 1, "subtitles": ["eng"], "chapters": 2},
    "film.mov": {"codec": "prores_ks", "pix_fmt": "yuv422p10le", "rotation": 90},
    "film.mkv": {"codec": "libx265", "pix_fmt": "yuv420p10le", "audio_tracks": 2, "subtitles": ["eng"]},
    "film.webm": {"codec": "libvpx-vp9", "audio_tracks": 1},
    "film.avi": {"codec": "mpeg4"},
    "film.ts": {"codec": "mpeg2video", "audio_tracks": 1},
    "h264.ts": {"codec": "libx264"},
    "other-pids.ts": {
        "codec": "libx264",
        "remuxed": {"mpegts_start_pid": "512", "mpegts_pmt_start_pid": "480"},
    },
    "wide.ts": {"codec": "mpeg2video", "size": (80, 48), "remuxed": {"mpegts_start_pid": "700"}},
    "fragments.mp4": {"codec": "libx264", "remuxed": {"movflags": "frag_keyframe+empty_moov"}},
    "film.flv": {"codec": "flv", "audio_tracks": 1},
    "av1.mkv": {"codec": "libsvtav1", "options": {"svtav1-params": "lp=1"}},
    "film.nut": {"codec": "ffv1", "pix_fmt": "yuva420p"},
    "film.wmv": {"codec": "wmv2"},
    "film.y4m": {"codec": "rawvideo", "format": "yuv4mpegpipe"},
    "film.gif": {"codec": "gif", "pix_fmt": "rgb8"},
}
"""Arguments of `make_clip`; `remuxed` has muxer options of a remuxed copy."""

STILLS: dict[str, dict[str, Any]] = {
    "rgb.png": {},
    "rgba.png": {"mode": "RGBA"},
    "palette.png": {"mode": "P"},
    "deep.png": {"mode": "I;16"},
    "usual.jpg": {"exif": EXIF},
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
    "profile.avif": {"icc_profile": profile(), "exif": EXIF},
    "still.qoi": {},
    "still.psd": {},
    "still.dpx": {"codec": "dpx", "pix_fmt": "gbrp10le"},
    "still.sun": {"codec": "sunrast", "pix_fmt": "bgr24"},
    "still.jls": {"codec": "jpegls", "pix_fmt": "rgb24"},
}
"""Arguments of Pillow, or an encoder of FFmpeg. Neither writes PSD."""


def write_originals(folder: Path, kinds: Iterable[str]) -> dict[str, list[Path]]:
    """Write the films and pictures of these kinds and return their paths; other kinds need no originals."""
    folder.mkdir(exist_ok=True)
    makers: dict[str, tuple[dict[str, dict[str, Any]], Callable[..., Path]]] = {
        "film": (FILMS, _film),
        "picture": (STILLS, _still),
    }
    return {
        kind: [make(folder / name, **options) for name, options in files.items()]
        for kind, (files, make) in makers.items()
        if kind in kinds
    }


def _film(path: Path, remuxed: dict[str, Any] | None = None, **options: Any) -> Path:
    # Without the cache of `make_clip`: a film has the same bytes in each folder.
    inspect.unwrap(make_clip)(path, **{"size": PICTURE_SIZE, "frames": 10} | options)
    if remuxed is not None:
        copy = path.rename(path.with_name(f"copied-{path.name}"))
        remux(copy, path, fflags="+bitexact", **remuxed)
        copy.unlink()
    return path


def _still(
    path: Path, frames: int = 1, mode: str = "RGB", codec: str = "", pix_fmt: str = "", **options: Any
) -> Path:
    pictures = list(moving_frames(frames, PICTURE_SIZE))
    if codec:
        with av.open(str(path), "w", format="image2", options={"update": "1"}) as container:
            video = cast(VideoStream, container.add_stream(codec, options={"strict": "-2"}))
            video.width, video.height, video.pix_fmt = *PICTURE_SIZE, pix_fmt
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
