"""Pictures as planes, and their encoding: colour matrix, range, depth, chroma subsampling and siting."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from vidstyle.errors import InputError, UsageError

LUMA_WEIGHTS: dict[str, tuple[float, float]] = {
    "bt601": (0.299, 0.114),
    "bt709": (0.2126, 0.0722),
    "bt2020": (0.2627, 0.0593),
    "fcc": (0.30, 0.11),
    "smpte240m": (0.212, 0.087),
}
"""Weight of red and of blue in luma, by matrix (ITU-T H.273, table 4); green has the rest."""

SITINGS = {
    "left": (0.0, 0.5),
    "center": (0.5, 0.5),
    "topleft": (0.0, 0.0),
    "top": (0.5, 0.0),
    "bottomleft": (0.0, 1.0),
    "bottom": (0.5, 1.0),
}
"""Position of the first chroma sample of 4:2:0, in luma pixels right and down from the first."""

MAX_NEUTRAL_CHROMA = 1e-6
"""Chroma below this is rounding."""

RANGES = {"luma": (-0.5, 1.5), "chroma": (-0.75, 0.75), "color": (-1.0, 2.0)}
"""Limits of values between steps, by kind; operations that may exceed them are clipped (rules, Style safety).

There is room for the RGB of colours outside any display gamut, and for the overshoot of bicubic and Lanczos
resampling at sharp edges: next to ink on paper almost half of the step, beyond black and white."""
WIDE_RANGE = (-256.0, 256.0)
"""The same for differences of Gaussians, which go to 28 times black and white at their strongest."""


Transfer = Literal["sdr", "pq", "hlg"]
"""Transfer functions: gamma, and the two of HDR (ITU-R BT.2100)."""


@dataclass(frozen=True)
class Encoding:
    """Encoding of colours in the planes of a picture.

    Attributes:
        matrix: a key of LUMA_WEIGHTS.
        full_range: whether black and white are the ends of the number range (else 16..235 in 8 bit).
        depth: bits of an integer sample; 0 for float32 samples, luma 0..1 and chroma -0.5..0.5.
        subsampling: luma pixels for each chroma sample, across and down: (2, 2) is 4:2:0.
        siting: position of the first chroma sample, in luma pixels right and down from the first luma
            sample: a value of SITINGS, or that after rotating the picture.
        transfer: transfer function of the samples; styles work on SDR samples.
    """

    matrix: str = "bt709"
    full_range: bool = False
    depth: int = 8
    subsampling: tuple[int, int] = (2, 2)
    siting: tuple[float, float] = SITINGS["left"]
    transfer: Transfer = "sdr"

    @property
    def is_hdr(self) -> bool:
        """Whether the transfer function is one of HDR."""
        return self.transfer != "sdr"

    @property
    def dtype(self) -> type[np.generic]:
        """The NumPy type of one sample."""
        return np.float32 if self.depth == 0 else np.uint8 if self.depth <= 8 else np.uint16

    @property
    def luma_levels(self) -> tuple[float, float]:
        """The codes of black and of white."""
        if self.depth == 0:
            return 0.0, 1.0
        if self.full_range:
            return 0.0, float(2**self.depth - 1)
        unit = 2.0 ** (self.depth - 8)
        return 16 * unit, 235 * unit

    @property
    def chroma_levels(self) -> tuple[float, float]:
        """The code of neutral, and how many codes lie between -0.5 and 0.5."""
        if self.depth == 0:
            return 0.0, 1.0
        if self.full_range:
            return float(2 ** (self.depth - 1)), float(2**self.depth - 1)
        unit = 2.0 ** (self.depth - 8)
        return 128 * unit, 224 * unit

    @cached_property
    def weights(self) -> np.ndarray:
        """The weights of red, green and blue in luma; float32, of sum 1."""
        red, blue = LUMA_WEIGHTS[self.matrix]
        return np.array([red, 1 - red - blue, blue], np.float32)

    @cached_property
    def to_rgb(self) -> np.ndarray:
        """The 3 x 3 matrix from (luma, blue difference, red difference) to RGB; float32."""
        red, blue = LUMA_WEIGHTS[self.matrix]
        green = 1 - red - blue
        from_blue, from_red = 2 * (1 - blue), 2 * (1 - red)
        return np.array(
            [
                [1, 0, from_red],
                [1, -from_blue * blue / green, -from_red * red / green],
                [1, from_blue, 0],
            ],
            np.float32,
        )

    @cached_property
    def from_rgb(self) -> np.ndarray:
        """The inverse of `to_rgb`; float32."""
        return np.linalg.inv(self.to_rgb.astype(np.float64)).astype(np.float32)

    def yuv_from_color(self, color: tuple[float, float, float]) -> tuple[float, float, float]:
        """Luma, blue and red difference of one RGB colour; of a gray the last two are exactly 0."""
        luma, *chroma = (float(part) for part in self.from_rgb @ np.array(color, np.float32))
        blue, red = (0.0 if abs(part) <= MAX_NEUTRAL_CHROMA else part for part in chroma)
        return luma, blue, red

    def chroma_shape(self, height: int, width: int) -> tuple[int, int]:
        """Return the shape of the chroma planes for a luma plane of this size: rounded up.

        >>> Encoding().chroma_shape(361, 641)
        (181, 321)
        """
        across, down = self.subsampling
        return -(-height // down), -(-width // across)

    def has_grid_of(self, other: Encoding) -> bool:
        """Return whether chroma samples have the other's positions and matrix; codes may differ."""
        return (self.matrix, self.subsampling, self.siting) == (other.matrix, other.subsampling, other.siting)

    def as_float_at(self, old: tuple[int, int], new: tuple[int, int]) -> Encoding:
        """Return the encoding of float32 chroma planes resampled with a picture from one size to another.

        Resampling maps pixel areas, so that a siting off the centre of its area scales with the size.
        """
        growth = new[1] / old[1], new[0] / old[0]
        x, y = (
            (step - 1) / 2 + (offset - (step - 1) / 2) * grown
            for step, offset, grown in zip(self.subsampling, self.siting, growth, strict=True)
        )
        return replace(self.as_float(), subsampling=self.subsampling, siting=(x, y))

    def as_float(self) -> Encoding:
        """Return the same matrix with float32 samples at full chroma resolution."""
        return replace(self, depth=0, full_range=True, subsampling=(1, 1))


MASK_ENCODING = Encoding(full_range=True, subsampling=(1, 1))
"""Encoding of the samples of masks, as luma."""

BT709_WEIGHTS = Encoding("bt709").weights
"""Weights of red, green and blue in the luma of pictures without tags; float32."""


@dataclass(frozen=True)
class Picture:
    """A picture: either luma with or without chroma, or packed RGB.

    The arrays are views wherever possible and must not be written to.

    Attributes:
        encoding: what the samples mean; for RGB, its matrix is the one that luma is taken with.
        luma: H x W, or None for an RGB picture.
        chroma: blue and red difference at the encoding's step, or None for gray and RGB.
        color: H x W x 3 RGB, or None.
        alpha: H x W of the same type, full range, or None; no block touches it.
        masks: regions of the picture that a style reads, by name: H x W uint8, 255 inside; and the backdrop,
            H x W x 3 uint8 RGB.
    """

    encoding: Encoding
    luma: np.ndarray | None = None
    chroma: tuple[np.ndarray, np.ndarray] | None = None
    color: np.ndarray | None = None
    alpha: np.ndarray | None = None
    masks: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if (self.luma is None) == (self.color is None):
            raise ValueError("a picture has either luma or colour planes")
        if self.color is not None and self.chroma is not None:
            raise ValueError("an RGB picture has no chroma planes")

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels."""
        plane = self.color if self.luma is None else self.luma
        assert plane is not None
        return plane.shape[0], plane.shape[1]

    def map_planes(
        self, change: Callable[[np.ndarray, str], np.ndarray], encoding: Encoding | None = None
    ) -> Picture:
        """Return the picture with each plane replaced by `change(plane, kind)`.

        Args:
            change: is given the planes in the order of the attributes, and the attribute's name; a mask
                counts as "mask".
            encoding: of the result; None keeps the encoding of the picture.
        """

        def changed(plane: np.ndarray | None, kind: str) -> np.ndarray | None:
            return None if plane is None else change(plane, kind)

        luma = changed(self.luma, "luma")
        chroma = self.chroma and (change(self.chroma[0], "chroma"), change(self.chroma[1], "chroma"))
        color, alpha = changed(self.color, "color"), changed(self.alpha, "alpha")
        masks = {name: change(mask, "mask") for name, mask in self.masks.items()}
        return Picture(encoding or self.encoding, luma, chroma, color, alpha, masks)

    @classmethod
    def from_array(cls, array: np.ndarray) -> Picture:
        """Return a picture from an array, H x W, H x W x 3 or H x W x 4, in RGB order.

        Integers are full range (uint8 or uint16), floats 0..1, in either byte order. An array of a
        suitable type is not copied.

        Raises:
            UsageError: another shape or type, or masked pixels.
            InputError: floats that are NaN or outside -1..2, the range of RGB in `RANGES`.
        """
        if array.ndim not in (2, 3) or (array.ndim == 3 and array.shape[2] not in (3, 4)) or 0 in array.shape:
            raise UsageError(
                "picture", f"is an array of shape {array.shape}", "give H x W, H x W x 3 or H x W x 4"
            )
        depths = {"u1": 8, "u2": 16, "f4": 0, "f8": 0, "f2": 0}
        kind = array.dtype.kind + str(array.dtype.itemsize)
        if kind not in depths:
            raise UsageError("picture", f"is an array of {array.dtype}", "give uint8, uint16 or floats")
        if np.ma.is_masked(array):
            raise UsageError("picture", "has masked pixels", "give picture.filled(value)")
        # Kernels take plain arrays of this machine's byte order.
        array = np.asarray(array, array.dtype.newbyteorder("="))
        if array.dtype.kind == "f":
            array = _checked(array)
        encoding = Encoding("bt709", full_range=True, depth=depths[kind], subsampling=(1, 1))
        if array.ndim == 2:
            return cls(encoding, luma=array)
        return cls(encoding, color=array[..., :3], alpha=array[..., 3] if array.shape[2] == 4 else None)


def _checked(array: np.ndarray) -> np.ndarray:
    """Return the floats as float32."""
    low, high = RANGES["color"]
    if not (array.min() >= low and array.max() <= high):
        count = array.size - np.count_nonzero((array >= low) & (array <= high))
        reason = f"{count} of its {array.size} numbers are NaN or outside {low:g}..{high:g}"
        raise InputError("the picture of floats", reason, "0 is black and 1 is white")
    return array.astype(np.float32, copy=False)


@dataclass(frozen=True)
class PictureLayout:
    """The layout of a picture, without its samples: all that lowering a style depends on.

    Attributes:
        shape: height and width.
        planes: "gray", "chroma" (luma and chroma) or "color" (packed RGB).
    """

    encoding: Encoding
    shape: tuple[int, int]
    planes: Literal["gray", "chroma", "color"]

    @classmethod
    def of(cls, picture: Picture) -> PictureLayout:
        """Return the layout of a picture."""
        planes: Literal["gray", "chroma", "color"] = "gray" if picture.chroma is None else "chroma"
        return cls(picture.encoding, picture.shape, planes if picture.color is None else "color")
