"""How the pixel formats of FFmpeg lie in memory, seen as ours."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from av.video.format import VideoFormat

SHUFFLED = {
    "nv12": "yuv420p",
    "nv21": "yuv420p",
    "nv16": "yuv422p",
    "nv24": "yuv444p",
    "nv42": "yuv444p",
    "p010le": "yuv420p10le",
    "p012le": "yuv420p12le",
    "p016le": "yuv420p16le",
    "p210le": "yuv422p10le",
    "p212le": "yuv422p12le",
    "p216le": "yuv422p16le",
    "p410le": "yuv444p10le",
    "p412le": "yuv444p12le",
    "p416le": "yuv444p16le",
    "yuyv422": "yuv422p",
    "yvyu422": "yuv422p",
    "uyvy422": "yuv422p",
    "y210le": "yuv422p10le",
    "y212le": "yuv422p12le",
    "y216le": "yuv422p16le",
    "xv30le": "yuv444p10le",
    "xv36le": "yuv444p12le",
    "xv48le": "yuv444p16le",
    "vuyx": "yuv444p",
    "vuya": "yuva444p",
    "ayuv": "yuva444p",
    "uyva": "yuva444p",
    "ayuv64le": "yuva444p16le",
    "bgr24": "rgb24",
    "rgb0": "rgb24",
    "bgr0": "rgb24",
    "0rgb": "rgb24",
    "0bgr": "rgb24",
    "rgb8": "rgb24",
    "bgr8": "rgb24",
    "rgb4_byte": "rgb24",
    "bgr4_byte": "rgb24",
    "rgb565le": "rgb24",
    "rgb555le": "rgb24",
    "bgr565le": "rgb24",
    "bgr555le": "rgb24",
    "x2rgb10le": "gbrp10le",
    "x2bgr10le": "gbrp10le",
    "bgra": "rgba",
    "argb": "rgba",
    "abgr": "rgba",
    "pal8": "rgba",
    "bgr48le": "rgb48le",
    "rgb48be": "rgb48le",
    "bgr48be": "rgb48le",
    "bgra64le": "rgba64le",
    "rgba64be": "rgba64le",
    "bgra64be": "rgba64le",
    "monow": "gray",
    "monob": "gray",
}
"""Formats whose bytes are put in another order before use, losing nothing, and the format they get."""


@dataclass(frozen=True)
class PlaneLayout:
    """One pixel format.

    Attributes:
        name: FFmpeg's name.
        shuffled: the format to put it into first, or "".
        kind: "luma" (with or without chroma planes), "packed" RGB or "planar" RGB.
        planes: how many colour planes there are, alpha not counted.
        depth: bits of a sample.
        step: luma pixels for each chroma sample, across and down.
        alpha: whether there is an alpha channel.
        full_range: whether the format itself says so; None: the tags say.
        big_endian: whether samples of two bytes have the high one first.
    """

    name: str
    shuffled: str
    kind: str
    planes: int
    depth: int
    step: tuple[int, int]
    alpha: bool
    full_range: bool | None
    big_endian: bool


@lru_cache(maxsize=256)
def layout_of(name: str) -> PlaneLayout | None:
    """The layout of a pixel format, or None for one that we do not read (Bayer, XYZ, floats)."""
    format = VideoFormat(name, 64, 64)
    if name in SHUFFLED:
        inner = layout_of(SHUFFLED[name])
        assert inner is not None
        return PlaneLayout(**(vars(inner) | {"name": name, "shuffled": SHUFFLED[name]}))
    components = [part for part in format.components if not part.is_alpha]
    depth = components[0].bits if components else 0
    if not 8 <= depth <= 16 or _is_foreign(name, format):
        return None
    single = format.is_rgb or len(components) == 1
    step = (1, 1) if single else (64 // format.chroma_width(64), 64 // format.chroma_height(64))
    return PlaneLayout(
        name=name,
        shuffled="",
        kind="luma" if not format.is_rgb else "planar" if format.is_planar else "packed",
        planes=len(components),
        depth=depth,
        step=step,
        alpha=len(components) < len(format.components),
        full_range=True if format.is_rgb or name.startswith("yuvj") else None,
        big_endian=format.is_big_endian,
    )


def _is_foreign(name: str, format: VideoFormat) -> bool:
    packed = len(format.components) > 1 and not format.is_planar
    known_packed = ("rgb24", "rgba", "rgb48le", "rgba64le", "ya8", "ya16le", "ya16be")
    semi_planar = format.is_planar and len({part.plane for part in format.components}) < len(
        format.components
    )
    return (packed and name not in known_packed) or semi_planar or format.is_bayer or "msb" in name


def format_name(depth: int, step: tuple[int, int], *, rgb: bool, chroma: bool, alpha: bool) -> str:
    """The FFmpeg format that holds such planes.

    Raises:
        ValueError: FFmpeg has none.

    >>> format_name(10, (2, 2), rgb=False, chroma=True, alpha=False)
    'yuv420p10le'
    """
    if rgb:
        names = {8: ("rgb24", "rgba"), 16: ("rgb48le", "rgba64le")}
        found = names[depth][alpha] if depth in names else f"gbr{'a' * alpha}p{depth}le"
    elif not chroma:
        stem = "ya" if alpha else "gray"
        found = stem + (f"{depth}le" if depth > 8 else "8" * alpha)
    else:
        sampling = {(2, 2): 420, (2, 1): 422, (1, 1): 444, (1, 2): 440, (4, 1): 411, (4, 4): 410}.get(step, 0)
        found = f"yuv{'a' * alpha}{sampling}p" + (f"{depth}le" if depth > 8 else "")
    try:
        VideoFormat(found, 64, 64)
    except ValueError:
        raise ValueError(f"no pixel format for {depth} bits at chroma step {step}: {found}") from None
    return found
