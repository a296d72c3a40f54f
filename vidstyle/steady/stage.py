"""What a renderer does before and after its style so that a film is steady."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from vidstyle.picture import Encoding, Picture
from vidstyle.planes import alpha_in_depth, color_rows, store, yuv_from_rgb
from vidstyle.steady.carry import Mix, carried
from vidstyle.steady.motion import Carry, Motion

Levels = tuple[float, float]


class Steady:
    """Carries luma and chroma on before the style, and the result after it.

    The first takes away the noise that a style would turn into lines and steps that come and go; the
    second what comes and goes none the less. Call `before` and `after` in turn for each picture.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style makes marks that lie still on the page, which are not to be moved along.
    """

    def __init__(self, steady: float, is_fixed: bool, pool: Executor) -> None:
        self._motion = Motion(steady, is_fixed)
        self._pool = pool
        self._carry: Carry | None = None
        self._weights: np.ndarray | None = None
        self._source: Picture | None = None
        self._result: dict[str, np.ndarray] = {}

    def before(self, picture: Picture, time: float | None) -> Picture:
        """The picture that the style is to see: luma and chroma, of 16 bits, or of floats for floats and RGB.

        Args:
            time: presentation time in seconds; None for a picture that stands alone, which stays as it is.
        """
        self._carry, self._weights = None, None
        if time is None:
            return picture
        carry = self._motion.follow(picture, time)
        now = _with_planes(picture)
        old, encoding = self._source, steady_encoding(now.encoding)
        if carry is None or old is None or old.encoding != encoding:
            self._source = _in_encoding(now, encoding)
        else:
            self._carry = carry
            self._source = self._carried(now, old, carry)
        return self._source

    def after(self, picture: Picture) -> Picture:
        """The picture to be shown, of what the style has made of the last one."""
        carry, weights, old = self._carry, self._weights, self._result
        planes = dict(_named_planes(picture))
        gain = 1.0 if picture.encoding.depth == 0 else 2.0 ** (16 - picture.encoding.depth)
        kept = {name: plane.shape for name, plane in old.items()} == {
            name: plane.shape for name, plane in planes.items()
        }
        if carry is None or weights is None or not kept:
            self._result = {name: _scaled(plane, gain, 0) for name, plane in planes.items()}
            return picture
        for name, plane in planes.items():
            step = picture.encoding.step if name in ("blue", "red") else (1, 1)
            mix = Mix(carry.share_of_result, guide=weights, step=step)
            self._result[name], _ = carried(self._pool, plane, (gain, 0), old[name], carry.strong_flow, mix)
        return _with_codes(picture, self._result, 1 / gain)

    def _carried(self, now: Picture, old: Picture, carry: Carry) -> Picture:
        assert now.luma is not None and old.luma is not None
        encoding, new = now.encoding, old.encoding
        scale, white = _scale(encoding.luma_levels, new.luma_levels)
        mix = Mix(carry.share, carry.limit * white)
        luma, self._weights = carried(self._pool, now.luma, scale, old.luma, carry.flow, mix)
        chroma = None
        if now.chroma is not None and old.chroma is not None:
            scale, span = _scale(_ends(encoding), _ends(new))
            mix = Mix(carry.share, carry.limit * span, self._weights, encoding.step)
            blue, red = (
                carried(self._pool, plane, scale, before, carry.flow, mix)[0]
                for plane, before in zip(now.chroma, old.chroma, strict=True)
            )
            chroma = blue, red
        return Picture(new, luma=luma, chroma=chroma, alpha=alpha_in_depth(now, new.depth))


def steady_encoding(encoding: Encoding) -> Encoding:
    """How planes are carried on: with 16 bits, as most noise is less than a code of 8; floats stay floats."""
    return replace(encoding, depth=16 if encoding.depth else 0)


def _with_planes(picture: Picture) -> Picture:
    if picture.color is None:
        return picture
    encoding = picture.encoding.as_float()
    luma, blue, red = yuv_from_rgb(color_rows(picture, 0, picture.shape[0]), encoding)
    return Picture(encoding, luma=luma, chroma=(blue, red), alpha=alpha_in_depth(picture, 0))


def _in_encoding(picture: Picture, new: Encoding) -> Picture:
    """The picture as it is carried on where nothing is carried into it."""
    assert picture.luma is not None
    old = picture.encoding
    scale, _ = _scale(old.luma_levels, new.luma_levels)
    luma, chroma = _scaled(picture.luma, *scale), None
    if picture.chroma is not None:
        scale, _ = _scale(_ends(old), _ends(new))
        chroma = _scaled(picture.chroma[0], *scale), _scaled(picture.chroma[1], *scale)
    return Picture(new, luma=luma, chroma=chroma, alpha=alpha_in_depth(picture, new.depth))


def _ends(encoding: Encoding) -> Levels:
    neutral, span = encoding.chroma_levels
    return neutral, neutral + span


def _scale(old: Levels, new: Levels) -> tuple[Levels, float]:
    """Gain and offset from codes to codes, and how many new ones lie between black and white."""
    gain = (new[1] - new[0]) / (old[1] - old[0])
    return (gain, new[0] - gain * old[0]), new[1] - new[0]


def _scaled(plane: np.ndarray, gain: float, offset: float) -> np.ndarray:
    if plane.dtype == np.float32:
        return plane
    values = np.multiply(plane, np.float32(gain), dtype=np.float32)
    values += np.float32(offset + 0.5)
    return np.clip(values, 0, 65535, out=values).astype(np.uint16)


def _named_planes(picture: Picture) -> Iterable[tuple[str, np.ndarray]]:
    if picture.color is not None:
        yield from zip(("first", "second", "third"), np.moveaxis(picture.color, 2, 0), strict=True)
    if picture.luma is not None:
        yield "luma", picture.luma
    if picture.chroma is not None:
        yield from zip(("blue", "red"), picture.chroma, strict=True)


def _with_codes(picture: Picture, planes: dict[str, np.ndarray], gain: float) -> Picture:
    """The picture with what is carried on in place of its planes."""

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
