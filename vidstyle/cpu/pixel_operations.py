"""Operations that compute each pixel of a node from the same pixel of its inputs."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from vidstyle.core.codes import IDENTITY_MIX_WEIGHTS, Chroma
from vidstyle.core.color.deferred_color import Mixed, Printed
from vidstyle.core.kernels import compiled, gray_rgb
from vidstyle.core.planes import luma_from_rgb, rgb_from_yuv, yuv_from_rgb
from vidstyle.cpu.tints import Tints
from vidstyle.style.nodes import Node, encoding_of

Value = Any
"""float32: luma, N x W; RGB, N x W x 3, `Mixed` or `Printed`; or blue and red difference, two of N x W or
`Tints`."""

DEFERRED_COLORS = Mixed, Printed
"""A tuple, as a union would be built at each call of `isinstance`."""
TAKES_DEFERRED = ("luma_from_rgb", "inked_color", "inked_chroma")
"""Operations that accept deferred values: `Mixed`, `Printed` and `Tints`."""


def per_pixel(node: Node, shape: tuple[int, int], inputs: dict[str, Value], out: Value | None) -> Value:
    """Compute each pixel from the same pixel of the inputs, in `out` if the operation supports it."""
    values = node.values
    match node.op:
        case "luma_from_rgb" if isinstance(inputs["color"], Mixed):
            return inputs["color"].luma(encoding_of(node.matrix).from_rgb[0], out)
        case "luma_from_rgb":
            return luma_from_rgb(at_every_pixel(inputs["color"]), encoding_of(node.matrix), out)
        case "chroma_from_rgb":
            return yuv_from_rgb(inputs["color"], encoding_of(node.matrix))[1:]
        case "rgb_from_yuv":
            return rgb_from_yuv(inputs["luma"], inputs["chroma"], encoding_of(node.matrix))
        case "rgb_from_gray":
            return gray_rgb(inputs["luma"])
        case "constant_luma":
            return _constant(shape, values["level"])
        case "constant_chroma":
            return Tints((), (), values["tint"])
        case "color_matrix":
            rows = [values[channel] for channel in ("red", "green", "blue")]
            return Mixed(inputs["color"], np.array(rows, np.float32))
        case "on_paper":
            return Printed(inputs["color"], values["paper"])
        case "inked_luma":
            return _mixed(values["ink"], inputs["under"], inputs["lines"])
        case "inked_chroma" if isinstance(inputs["under"], Tints):
            return inputs["under"].inked(values["ink"], inputs["lines"])
        case "inked_chroma":
            pairs = zip(values["ink"], inputs["under"], strict=True)
            return tuple(_mixed(ink, plane, inputs["lines"]) for ink, plane in pairs)
        case "inked_color":
            under = inputs["under"]
            under = under if isinstance(under, Printed) else Printed(at_every_pixel(under))
            return under.inked(values["ink"], at_every_pixel(inputs["lines"]))
    raise ValueError(f"{node.op} is not computed pixel by pixel")


@lru_cache(maxsize=4)
def _constant(shape: tuple[int, int], level: float) -> np.ndarray:
    """Return constant luma, shared by all bands of a height; read-only."""
    plane = np.full(shape, level, np.float32)
    plane.setflags(write=False)
    return plane


def planes_of(chroma: Chroma | Tints) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Return chroma as planes and weights for their sums, for `store_chroma`."""
    return (chroma.planes, chroma.mix) if isinstance(chroma, Tints) else (chroma, IDENTITY_MIX_WEIGHTS)


def at_every_pixel(value: Value, out: Value | None = None) -> Value:
    """Return the value as planes, in `out` if possible."""
    if isinstance(value, DEFERRED_COLORS):
        return value.whole(out)
    return value.chroma() if isinstance(value, Tints) else value


def _mixed(ink: float, under: np.ndarray, lines: np.ndarray) -> np.ndarray:
    out = np.empty(under.shape, np.float32)
    _lay_ink(np.float32(ink), under, lines, out)
    return out


@compiled
def _lay_ink(ink, under, lines, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            out[row, x] = (under[row, x] - ink) * lines[row, x] + ink
