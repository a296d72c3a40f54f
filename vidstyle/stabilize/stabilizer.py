"""Temporal stabilization before and after a style, on the CPU."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.planes import alpha_in_depth, color_rows, store, yuv_from_rgb
from vidstyle.stabilize.blend import BlendOptions, warp_and_blend
from vidstyle.stabilize.motion import MotionEstimator, Warp

Levels = tuple[float, float]


@dataclass(frozen=True)
class Stabilized:
    """A stabilized picture for the style, and what `Stabilizer.after` needs for its result.

    Attributes:
        warp: that of the picture before, or None where none was blended in.
        weights: of the picture before at each pixel, H x W float32, 0..1.
    """

    picture: Picture
    warp: Warp | None = None
    weights: np.ndarray | None = None


class Stabilizer:
    """Blends luma and chroma with the picture before, and the result of the style with the result before.

    The first removes noise that a style would turn into flickering lines and steps; the second removes the
    flicker that remains.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style makes marks that lie still on the page, which are not to be warped.
    """

    def __init__(self, steady: float, is_fixed: bool, pool: Executor) -> None:
        self._motion = MotionEstimator(steady, is_fixed)
        self._pool = pool
        self._source: Picture | None = None
        self._result: dict[str, np.ndarray] = {}

    def change_strength(self, steady: float, is_fixed: bool) -> None:
        """Use other values from the next picture on."""
        self._motion.change_strength(steady, is_fixed)

    def before(self, picture: Picture, time: float | None, scene_cut: bool) -> Stabilized:
        """The picture that the style is to see: luma and chroma in `stabilized_encoding`.

        Args:
            time: presentation time in seconds; None for a picture that stands alone, which stays as it is.
            scene_cut: whether a scene begins with it.
        """
        if time is None:
            return Stabilized(picture)
        warp = self._motion.estimate(picture, time, scene_cut)
        now, old = with_planes(picture), self._source
        encoding = stabilized_encoding(now.encoding)
        if warp is None or old is None or old.encoding != encoding:
            stabilized = Stabilized(_in_encoding(now, encoding))
        else:
            stabilized = self._blended(now, old, warp)
        self._source = stabilized.picture
        return stabilized

    def after(self, result: Picture, stabilized: Stabilized) -> Picture:
        """The picture to be shown, from the result of the style; to be called in the pictures' order."""
        warp, weights, old = stabilized.warp, stabilized.weights, self._result
        planes = dict(_named_planes(result))
        gain, floats = result_gain(result.encoding), result.encoding.depth == 0
        fits = [each.shape for each in planes.values()] == [each.shape for each in old.values()]
        if warp is None or weights is None or not fits:
            self._result = {name: _scaled(plane, gain, 0, floats) for name, plane in planes.items()}
            return result
        for name, plane in planes.items():
            step = result.encoding.step if name in ("blue", "red") else (1, 1)
            blend = BlendOptions(warp.result_weight, guide=weights, step=step)
            self._result[name], _ = warp_and_blend(
                self._pool, plane, (gain, 0), old[name], warp.strong_flow, blend
            )
        return _with_codes(result, self._result, 1 / gain)

    def _blended(self, now: Picture, old: Picture, warp: Warp) -> Stabilized:
        assert now.luma is not None and old.luma is not None
        encoding, new = now.encoding, old.encoding
        scale, white = code_scale(encoding.luma_levels, new.luma_levels)
        blend = BlendOptions(warp.weight, warp.limit * white)
        luma, weights = warp_and_blend(self._pool, now.luma, scale, old.luma, warp.flow, blend)
        chroma = None
        if now.chroma is not None and old.chroma is not None:
            scale, span = code_scale(chroma_ends(encoding), chroma_ends(new))
            blend = BlendOptions(warp.weight, warp.limit * span, weights, encoding.step)
            blue, red = (
                warp_and_blend(self._pool, plane, scale, before, warp.flow, blend)[0]
                for plane, before in zip(now.chroma, old.chroma, strict=True)
            )
            chroma = blue, red
        alpha = alpha_in_depth(now, new.depth)
        return Stabilized(Picture(new, luma=luma, chroma=chroma, alpha=alpha), warp, weights)


def stabilized_encoding(encoding: Encoding) -> Encoding:
    """How blended planes are stored: with 16 bits, as most noise is less than a code of 8.

    Floats, and what has 16 bits itself, as floats: so planes that a style leaves alone are never taken for
    the source's own.
    """
    if 0 < encoding.depth < 16:
        return replace(encoding, depth=16)
    return replace(encoding, depth=0, full_range=True)


def result_gain(encoding: Encoding) -> float:
    """How many units of its stored form a code of the result is: the codes fill 16 bits."""
    return 2.0 ** (16 - encoding.depth) if encoding.depth else 1.0


def with_planes(picture: Picture) -> Picture:
    """The picture as luma and chroma; RGB becomes floats."""
    if picture.color is None:
        return picture
    encoding = picture.encoding.as_float()
    luma, blue, red = yuv_from_rgb(color_rows(picture, 0, picture.shape[0]), encoding)
    return Picture(encoding, luma=luma, chroma=(blue, red), alpha=alpha_in_depth(picture, 0))


def _in_encoding(picture: Picture, new: Encoding) -> Picture:
    """The picture in another encoding, without blending."""
    assert picture.luma is not None
    old, floats = picture.encoding, new.depth == 0
    scale, _ = code_scale(old.luma_levels, new.luma_levels)
    luma, chroma = _scaled(picture.luma, *scale, floats), None
    if picture.chroma is not None:
        scale, _ = code_scale(chroma_ends(old), chroma_ends(new))
        chroma = _scaled(picture.chroma[0], *scale, floats), _scaled(picture.chroma[1], *scale, floats)
    return Picture(new, luma=luma, chroma=chroma, alpha=alpha_in_depth(picture, new.depth))


def chroma_ends(encoding: Encoding) -> Levels:
    """The codes of 0 and 1 in a chroma plane."""
    neutral, span = encoding.chroma_levels
    return neutral, neutral + span


def code_scale(old: Levels, new: Levels) -> tuple[Levels, float]:
    """Gain and offset from codes to codes, and how many new ones lie between black and white."""
    gain = (new[1] - new[0]) / (old[1] - old[0])
    return (gain, new[0] - gain * old[0]), new[1] - new[0]


def _scaled(plane: np.ndarray, gain: float, offset: float, floats: bool) -> np.ndarray:
    # In rows, whatever the order of the plane: the next picture looks for samples by their number.
    values = np.multiply(plane, np.float32(gain), dtype=np.float32, order="C")
    values += np.float32(offset if floats else offset + 0.5)
    return values if floats else np.clip(values, 0, 65535, out=values).astype(np.uint16)


def _named_planes(picture: Picture) -> Iterable[tuple[str, np.ndarray]]:
    if picture.color is not None:
        yield from zip(("first", "second", "third"), np.moveaxis(picture.color, 2, 0), strict=True)
    if picture.luma is not None:
        yield "luma", picture.luma
    if picture.chroma is not None:
        yield from zip(("blue", "red"), picture.chroma, strict=True)


def _with_codes(picture: Picture, planes: dict[str, np.ndarray], gain: float) -> Picture:
    """The picture with blended planes in place of its own."""

    def codes(plane: np.ndarray, out: np.ndarray) -> np.ndarray:
        store(plane, 0, gain, picture.encoding.depth, out)
        return out

    if picture.color is not None:
        color = np.empty_like(picture.color)
        for plane, channel in zip(planes.values(), np.moveaxis(color, 2, 0), strict=True):
            codes(plane, channel)
        return replace(picture, color=color)
    new = {
        name: codes(plane, np.empty(plane.shape, picture.encoding.dtype)) for name, plane in planes.items()
    }
    chroma = (new["blue"], new["red"]) if picture.chroma is not None else None
    return replace(picture, luma=new["luma"], chroma=chroma)
