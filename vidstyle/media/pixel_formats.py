"""Memory layouts of FFmpeg's pixel formats."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from av.video.format import VideoFormat

REORDERED_FORMATS = {
    name: planar
    for planar, names in {
        "yuv420p": "nv12 nv21",
        "yuv422p": "nv16 yuyv422 yvyu422 uyvy422",
        "yuv444p": "nv24 nv42 vuyx",
        "yuv420p10le": "p010le",
        "yuv420p12le": "p012le",
        "yuv420p16le": "p016le",
        "yuv422p10le": "p210le y210le",
        "yuv422p12le": "p212le y212le",
        "yuv422p16le": "p216le y216le",
        "yuv444p10le": "p410le xv30le",
        "yuv444p12le": "p412le xv36le",
        "yuv444p16le": "p416le xv48le",
        "yuva444p": "vuya ayuv uyva",
        "yuva444p16le": "ayuv64le",
        "rgb24": "bgr24 rgb0 bgr0 0rgb 0bgr rgb8 "
        "bgr8 rgb4_byte bgr4_byte rgb565le rgb555le bgr565le bgr555le",
        "gbrp10le": "x2rgb10le x2bgr10le",
        "rgba": "bgra argb abgr pal8",
        "rgb48le": "bgr48le rgb48be bgr48be",
        "rgba64le": "bgra64le rgba64be bgra64be",
        "gray": "monow monob",
    }.items()
    for name in names.split()
}
"""Formats that are reordered without loss before use, and the format they are converted to."""


@dataclass(frozen=True)
class PlaneLayout:
    """One pixel format.

    Attributes:
        name: FFmpeg's name.
        reordered_as: the format to convert to first, or "".
        kind: "luma" (with or without chroma planes), "packed" RGB or "planar" RGB.
        planes: number of colour planes, without alpha.
        depth: bits per sample.
        subsampling: luma pixels per chroma sample, horizontally and vertically.
        alpha: whether there is an alpha channel.
        full_range: the range if the format implies it; None: given by the tags.
        big_endian: byte order of two-byte samples.
    """

    name: str
    reordered_as: str
    kind: str
    planes: int
    depth: int
    subsampling: tuple[int, int]
    alpha: bool
    full_range: bool | None
    big_endian: bool


@lru_cache(maxsize=256)
def layout_of(name: str) -> PlaneLayout | None:
    """Return the layout of a pixel format, or None for an unsupported one (Bayer, XYZ, float)."""
    format = VideoFormat(name, 64, 64)
    if name in REORDERED_FORMATS:
        inner = layout_of(REORDERED_FORMATS[name])
        assert inner is not None
        return PlaneLayout(**(vars(inner) | {"name": name, "reordered_as": REORDERED_FORMATS[name]}))
    components = [part for part in format.components if not part.is_alpha]
    depth = components[0].bits if components else 0
    if not 8 <= depth <= 16 or _is_foreign(name, format):
        return None
    single = format.is_rgb or len(components) == 1
    subsampling = (1, 1) if single else (64 // format.chroma_width(64), 64 // format.chroma_height(64))
    return PlaneLayout(
        name=name,
        reordered_as="",
        kind="luma" if not format.is_rgb else "planar" if format.is_planar else "packed",
        planes=len(components),
        depth=depth,
        subsampling=subsampling,
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


def format_name(depth: int, subsampling: tuple[int, int], *, rgb: bool, chroma: bool, alpha: bool) -> str:
    """Return the FFmpeg format for such planes.

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
        digits = {(2, 2): 420, (2, 1): 422, (1, 1): 444, (1, 2): 440, (4, 1): 411, (4, 4): 410}
        found = f"yuv{'a' * alpha}{digits.get(subsampling, 0)}p" + (f"{depth}le" if depth > 8 else "")
    try:
        VideoFormat(found, 64, 64)
    except ValueError:
        raise ValueError(f"no pixel format for {depth} bits, subsampling {subsampling}: {found}") from None
    return found
