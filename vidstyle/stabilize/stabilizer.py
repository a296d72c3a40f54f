"""Temporal stabilization before and after a style, on the CPU."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from vidstyle.core.bands import BandWorkers, in_bands
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.core.planes import alpha_in_depth, color_rows, yuv_from_rgb
from vidstyle.stabilize.blend import Rows, result_rows, source_rows
from vidstyle.stabilize.motion import FramePair, MotionEstimator, Warp
from vidstyle.stabilize.travel import DriftFollower
from vidstyle.stabilize.warp import in_segments, moves_of

BAND_RADIUS_ROWS = 24
"""Radius for `in_bands`: makes bands much higher than the rows read around them, so that few rows are
computed twice."""

Planes = dict[str, np.ndarray]
"""Planes by name: "luma", "blue" and "red", or "first", "second" and "third" of RGB."""


@dataclass(frozen=True)
class Stabilized:
    """A stabilized picture for the style, and what `Stabilizer.after` needs for its result.

    Attributes:
        warp: warp of the previous frame, or None if it was not blended.
        weights: weights of the previous frame at each pixel, H x W uint8; see `source_rows`.
    """

    picture: Picture
    warp: Warp | None = None
    weights: np.ndarray | None = None


@dataclass(eq=False)
class PreviousFrame:
    """The memory of the previous frame: its planes and, of a source, their encoding."""

    planes: Planes = field(default_factory=dict)
    encoding: Encoding | None = None


class Stabilizer:
    """Blends the input of a style, and then its result, with the previous frame's.

    The first blend removes noise that a style would turn into flickering lines and steps; the second removes
    the remaining flicker. `follow`, `before` and `after` each take the frames in their order; different
    frames may be in different methods at the same time.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style draws marks fixed to the page, which are not warped, and are blended only
            where nothing moves.
        follows: whether the style draws marks that move with the film.

    Attributes:
        source: what `before` keeps.
        result: what `after` keeps.
        marks: follows the marks; it takes the frames in their order, like the methods. None if none move.
    """

    def __init__(self, steady: float, is_fixed: bool, follows: bool = False) -> None:
        self._motion = MotionEstimator(steady, is_fixed, follows)
        self.source = PreviousFrame()
        self.result = PreviousFrame()
        self.marks = DriftFollower() if follows else None

    def change_strength(self, steady: float, is_fixed: bool) -> None:
        """Use other values from the next picture on."""
        self._motion.change_strength(steady, is_fixed)

    def follow(self, picture: Picture, time: float, scene_cut: bool) -> FramePair | None:
        """Return the frame with the previous one; see `MotionEstimator.follow`."""
        return self._motion.follow(picture, time, scene_cut)

    def memory(self) -> list[np.ndarray]:
        """Return all arrays that are kept of the previous frame."""
        drift = self.marks.memory() if self.marks else []
        return [*self._motion.memory(), *self.source.planes.values(), *self.result.planes.values(), *drift]

    def before(
        self, picture: Picture, warp: Warp | None, workers: BandWorkers, needs_chroma: bool = True
    ) -> Stabilized:
        """Return the stabilized input of the style: luma and chroma in `stabilized_encoding`.

        Args:
            picture: the next frame of a film.
            warp: the warp of the pair that `follow` returned; None for none.
            needs_chroma: whether the style reads chroma; otherwise the result has none.
        """
        now = with_planes(picture)
        shown = now if needs_chroma else replace(now, chroma=None)
        encoding, planes = stabilized_encoding(now.encoding), dict(_named_planes(shown))
        # A style that fades in or out may read chroma in one frame and not in the next; luma continues.
        known = {name: self.source.planes[name] for name in planes.keys() & self.source.planes.keys()}
        if encoding != self.source.encoding or not _same_shapes(
            {name: planes[name] for name in known}, known
        ):
            warp = None
        weights = None
        if warp is None:
            for name, plane in planes.items():
                (gain, offset), _ = code_scale(name, now.encoding, encoding)
                planes[name] = _scale(plane, gain, offset, encoding.depth == 0)
        else:
            planes, weights = self._blend(planes, now.encoding, encoding, warp, workers)
        self.source.encoding, self.source.planes = encoding, planes
        chroma = (planes["blue"], planes["red"]) if "blue" in planes else None
        alpha = alpha_in_depth(now, encoding.depth)
        stable = Picture(encoding, planes["luma"], chroma, alpha=alpha, masks=now.masks)
        return Stabilized(stable, warp, weights)

    def _blend(
        self, now: Planes, old: Encoding, new: Encoding, warp: Warp, workers: BandWorkers
    ) -> tuple[Planes, np.ndarray]:
        """Return the planes of the source, blended with the previous ones, and the weights of luma."""
        out = {name: np.empty(plane.shape, new.dtype) for name, plane in now.items()}
        guide = np.empty(now["luma"].shape, np.uint8)
        jobs, moves = {}, cache(partial(moves_of, warp.flow, dtype=np.dtype(new.dtype)))
        for name, plane in now.items():
            (scale, span), step = code_scale(name, old, new), plane_step(name, old)
            if name not in self.source.planes:
                out[name] = _scale(plane, *scale, new.depth == 0)
                continue
            luma, other = (guide, None) if name == "luma" else (None, guide)
            jobs[name] = source_rows(
                plane, scale, self.source.planes[name], moves(plane.shape[1], step), warp.weight,
                warp.limit * span, other, step, out[name], luma,
            )  # fmt: skip
        _run(jobs, now["luma"].shape, old, workers)
        return out, guide

    def after(self, result: Picture, stabilized: Stabilized, workers: BandWorkers) -> Picture:
        """Stabilize the result of the style."""
        warp, weights, encoding = stabilized.warp, stabilized.weights, result.encoding
        old = self.result.planes
        planes, gain, floats = dict(_named_planes(result)), result_gain(encoding), encoding.depth == 0
        if warp is None or weights is None or not _same_shapes(planes, old):
            self.result.planes = {name: _scale(each, gain, 0, floats) for name, each in planes.items()}
            return result
        shown = result.map_planes(lambda plane, kind: plane if kind == "alpha" else np.empty_like(plane))
        codes, jobs = dict(_named_planes(shown)), {}
        # Planes of the same size share moves.
        dtype = np.dtype(np.float32 if floats else np.uint16)
        moves = cache(partial(moves_of, warp.result_flow, dtype=dtype))
        parts_of = cache(partial(in_segments, warp.result_guide))
        new = self.result.planes = {name: np.empty(plane.shape, dtype) for name, plane in planes.items()}
        for name, plane in planes.items():
            step, width = plane_step(name, encoding), plane.shape[1]
            jobs[name] = result_rows(
                plane, gain, old[name], moves(width, step), parts_of(width), warp.result_weight, weights,
                step, new[name], codes[name],
            )  # fmt: skip
        _run(jobs, result.shape, encoding, workers)
        return shown


def _run(jobs: Mapping[str, Rows], shape: tuple[int, int], encoding: Encoding, workers: BandWorkers) -> None:
    """Compute the rows of all planes band by band, luma first."""

    def run(top: int, bottom: int) -> None:
        for name, rows in jobs.items():
            _, down = plane_step(name, encoding)
            rows(top // down, -(-bottom // down))

    if workers.count == 1:
        run(0, shape[0])  # as fast as bands, with fewer calls of kernels that give up the GIL
    else:
        in_bands(workers, shape, BAND_RADIUS_ROWS, run)


def stabilized_encoding(encoding: Encoding) -> Encoding:
    """Return the encoding of blended planes: 16 bits, as most noise is smaller than an 8-bit code.

    Float and 16-bit sources are stored as floats, so that planes which a style does not change are never
    mistaken for planes of the source.
    """
    if 0 < encoding.depth < 16:
        return replace(encoding, depth=16)
    return replace(encoding, depth=0, full_range=True)


def stabilized_layout(picture: Picture) -> PictureLayout:
    """Return the layout of the input of a style for such a picture in a stabilized film."""
    layout = PictureLayout.of(picture)
    encoding = stabilized_encoding(planes_encoding(picture))
    return PictureLayout(encoding, layout.shape, "gray" if layout.planes == "gray" else "chroma")


def result_gain(encoding: Encoding) -> float:
    """Return the size of a code of the result in units of its stored form: the codes fill 16 bits."""
    return 2.0 ** (16 - encoding.depth) if encoding.depth else 1.0


def planes_encoding(picture: Picture) -> Encoding:
    """Return the encoding of the result of `with_planes`."""
    return picture.encoding if picture.color is None else picture.encoding.as_float()


def with_planes(picture: Picture) -> Picture:
    """Return the picture as luma and chroma; RGB becomes floats."""
    if picture.color is None:
        return picture
    encoding = planes_encoding(picture)
    luma, *chroma = yuv_from_rgb(color_rows(picture, 0, picture.shape[0]), encoding)
    return Picture(
        encoding, luma, (chroma[0], chroma[1]), alpha=alpha_in_depth(picture, 0), masks=picture.masks
    )


def plane_step(name: str, encoding: Encoding) -> tuple[int, int]:
    """Return the pixels per sample of a plane, across and down."""
    return encoding.subsampling if name in ("blue", "red") else (1, 1)


def code_scale(name: str, old: Encoding, new: Encoding) -> tuple[tuple[float, float], float]:
    """Return gain and offset from old to new codes of a plane, and the new codes between black and white."""
    (zero, span), (new_zero, new_span) = (
        (each.luma_levels[0], each.luma_levels[1] - each.luma_levels[0])
        if name == "luma"
        else each.chroma_levels
        for each in (old, new)
    )
    gain = new_span / span
    return (gain, new_zero - gain * zero), new_span


def _same_shapes(planes: Planes, old: Planes) -> bool:
    return [each.shape for each in planes.values()] == [each.shape for each in old.values()]


def _scale(plane: np.ndarray, gain: float, offset: float, floats: bool) -> np.ndarray:
    # In C order, independent of the plane's: the next picture accesses samples by their index.
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
