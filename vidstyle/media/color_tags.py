"""Colour tags of streams (code points of ITU-T H.273) and the encodings that they signal."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from vidstyle.core.picture import SITINGS, Encoding, Transfer
from vidstyle.errors import InputError

UNSPECIFIED_CODE = 2
"""The H.273 code for unspecified primaries, transfer or matrix."""
LIMITED_RANGE, FULL_RANGE = 1, 2
"""FFmpeg's codes of limited and full range; 0 is unspecified."""
PQ_CODE, HLG_CODE = 16, 18
"""HDR transfer functions: SMPTE ST 2084 and ARIB STD-B67."""
HDR_TRANSFERS: dict[int, Transfer] = {PQ_CODE: "pq", HLG_CODE: "hlg"}
BT2020_PRIMARIES_CODE, BT2020_MATRIX_CODE = 9, 9

MATRIX_NAMES = {1: "bt709", 4: "fcc", 5: "bt601", 6: "bt601", 7: "smpte240m", 9: "bt2020"}
"""The supported matrices by H.273 code."""
UNSUPPORTED_MATRICES = {
    **{8: "YCgCo", 10: "BT.2020 constant luminance", 11: "YDzDx", 12: "chromaticity-derived"},
    **{13: "chromaticity-derived constant luminance", 14: "ICtCp", 15: "IPT-C2", 16: "YCgCo-Re"},
    17: "YCgCo-Ro",
}
DEFINED_MATRICES = frozenset({0, UNSPECIFIED_CODE, *MATRIX_NAMES, *UNSUPPORTED_MATRICES})
"""The matrices that H.273 defines; 0 is RGB."""
MIN_HD_HEIGHT, MIN_HD_WIDTH = 720, 1280
"""Untagged video of at least this height or this width is treated as BT.709, as in players."""
JPEG_CODECS = frozenset({"mjpeg", "jpegls", "webp", "amv", "mjpegb", "ljpeg"})
"""Codecs whose specification demands BT.601 at every size."""
CENTERED_CODECS = JPEG_CODECS | {"jpeg2000"}
"""Codecs whose 4:2:0 chroma is centred between luma samples, as in JPEG (JFIF); others are left-sited."""


@dataclass(frozen=True)
class ColorTags:
    """H.273 codes of primaries, transfer and matrix, and FFmpeg's code of the range.

    These are the numbers that av's `color_primaries`, `color_trc`, `colorspace` and `color_range` take.
    """

    primaries: int = UNSPECIFIED_CODE
    transfer: int = UNSPECIFIED_CODE
    matrix: int = UNSPECIFIED_CODE
    range: int = 0

    @classmethod
    def of(cls, tagged: Any) -> ColorTags:
        """Return the tags of an av.VideoFrame or an av codec context."""
        codes = (tagged.color_primaries, tagged.color_trc, tagged.colorspace, tagged.color_range)
        return cls(*(int(code) for code in codes))

    @property
    def is_hdr(self) -> bool:
        """Whether the transfer function is an HDR one; ten bits alone are not HDR."""
        return self.transfer in HDR_TRANSFERS

    def put_on(self, tagged: Any) -> None:
        """Set the tags of an av.VideoFrame or an av codec context."""
        tagged.color_primaries, tagged.color_trc = self.primaries, self.transfer
        tagged.colorspace, tagged.color_range = self.matrix, self.range

    def completed(self, encoding: Encoding, height: int) -> ColorTags:
        """Fill in unspecified tags from the encoding.

        >>> ColorTags().completed(Encoding("bt601"), 576)
        ColorTags(primaries=5, transfer=6, matrix=5, range=1)
        """
        usual = default_tags(encoding, height)
        said = {name: code for name, code in vars(self).items() if code not in (0, UNSPECIFIED_CODE)}
        return replace(usual, **said | {"range": usual.range})


def clear_reserved_matrix(frame: Any) -> None:
    """Make the matrix of an av.VideoFrame unspecified if its code is reserved, as in damaged files.

    swscale fails for such frames with an error that does not name the reason.
    """
    if int(frame.colorspace) not in DEFINED_MATRICES:
        frame.colorspace = UNSPECIFIED_CODE


def default_tags(encoding: Encoding, height: int = 0) -> ColorTags:
    """Return the usual tags of a matrix; for BT.601 the height distinguishes 625 from 525 lines."""
    seen_range = FULL_RANGE if encoding.full_range else LIMITED_RANGE
    if encoding.matrix == "bt2020":
        transfer = next((code for code, name in HDR_TRANSFERS.items() if name == encoding.transfer), 14)
        return ColorTags(BT2020_PRIMARIES_CODE, transfer, BT2020_MATRIX_CODE, seen_range)
    if encoding.matrix == "bt601":
        system = 5 if height in (288, 576) else 6
        return ColorTags(system, 6, system, seen_range)
    code = {"bt709": 1, "fcc": 4, "smpte240m": 7}[encoding.matrix]
    return ColorTags(code, code, code, seen_range)


def matrix_from_tags(subject: object, tags: ColorTags, codec: str, height: int, width: int) -> str:
    """Return the matrix, a key of LUMA_WEIGHTS: as tagged, else by codec or the size of the stored picture.

    Raises:
        InputError: an unsupported matrix; `subject` names the source.
    """
    if tags.matrix in UNSUPPORTED_MATRICES:
        name = UNSUPPORTED_MATRICES[tags.matrix]
        raise InputError(subject, f"its colours are coded with {name}", "convert it to BT.709 first")
    if tags.matrix in MATRIX_NAMES:
        return MATRIX_NAMES[tags.matrix]
    if codec in JPEG_CODECS:
        return "bt601"
    return "bt709" if height >= MIN_HD_HEIGHT or width >= MIN_HD_WIDTH else "bt601"


def siting_from_codec(codec: str, tags: ColorTags, subsampling: tuple[int, int]) -> tuple[float, float]:
    """Return the position of the first chroma sample by codec and tags, as PyAV does not expose it.

    BT.2020 with PQ or HLG is top-left sited (ITU-R BT.2100, H.265 table E.1 note).
    """
    if codec in CENTERED_CODECS:
        return (subsampling[0] - 1) / 2, (subsampling[1] - 1) / 2
    if tags.is_hdr and tags.primaries == BT2020_PRIMARIES_CODE and subsampling == (2, 2):
        return SITINGS["topleft"]
    return 0.0, (subsampling[1] - 1) / 2
