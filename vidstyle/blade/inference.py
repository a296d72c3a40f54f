"""Inference of a bank on the CPU: select and apply one filter at each pixel.

Paper, section 5.1, equation 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.choice import choice_radius, choose_filters
from vidstyle.blade.simd import filter_pixel_block, pack_filters
from vidstyle.core.kernels import CACHE_LINE_FLOATS, aligned_parts, compiled, round_up
from vidstyle.core.picture import RANGES, WIDE_RANGE
from vidstyle.core.resample import resample, scaled_shape

RESAMPLING_METHOD = "smooth"
"""Method for reducing a picture for a bank and enlarging its result; banks are trained with it."""

ROWS_AT_ONCE = 3
"""Rows of pixels that are filtered together if each pixel has its own filter."""


@dataclass(frozen=True)
class BankRun:
    """One use of a bank: identity * luma + the weighted sum of the bank's parts.

    Attributes:
        weights: one per part.
        identity: weight of the picture itself.
        rho: standard deviation of the structure tensor's window in pixels; None for the bank's.
        passes: number of passes, each on the result of the previous one.
        reselect: whether filters are selected in each pass; otherwise the first selection is used in all
            passes.
        scale: working size relative to the picture, 0..1; the result is enlarged again.
        is_wide: whether the result may far exceed black and white.
    """

    bank: Bank
    weights: tuple[float, ...] = (1.0,)
    identity: float = 0.0
    rho: float | None = None
    passes: int = 1
    reselect: bool = True
    scale: float = 1.0
    is_wide: bool = False

    @property
    def limits(self) -> tuple[float, float]:
        """The range that the result of each pass is clipped to."""
        return WIDE_RANGE if self.is_wide else RANGES["luma"]

    @property
    def window(self) -> float:
        """Standard deviation of the structure tensor's window, in pixels."""
        return self.bank.rho if self.rho is None else self.rho

    @property
    def radius(self) -> int:
        """Number of pixels on each side that a pixel of the result depends on, at the working size."""
        of_pass, of_selection = self.bank.size // 2, choice_radius(self.bank.bins, self.window)
        if self.reselect:
            return self.passes * max(of_pass, of_selection)
        return (self.passes - 1) * of_pass + max(of_pass, of_selection)

    @property
    def work(self) -> int:
        """Approximate number of multiplications per pixel at the working size."""
        selection = 12 * choice_radius(self.bank.bins, self.window) + 50
        selection *= 1 + len(self.bank.bins.features)
        planes = 1 if self.bank.chroma is None else 3
        return planes * self.passes * self.bank.size**2 + selection * (self.passes if self.reselect else 1)

    def shape_at_scale(self, shape: tuple[int, int]) -> tuple[int, int]:
        """Return the working height and width for a picture of this size."""
        return scaled_shape(shape, self.scale)

    @cached_property
    def filters(self) -> np.ndarray:
        """The filters of a pass: bins x size x size float32."""
        return self._filters_of(self.bank)

    def _filters_of(self, bank: Bank) -> np.ndarray:
        filters = bank.combined(self.weights)
        middle = bank.size // 2
        filters[:, middle, middle] += np.float32(self.identity)
        return filters

    @cached_property
    def _packed(self) -> np.ndarray:
        return pack_filters(self.filters)

    @cached_property
    def _packed_for_chroma(self) -> np.ndarray:
        return pack_filters(self._filters_of(self.bank.of_chroma))

    @cached_property
    def _constants(self) -> list[np.ndarray | None]:
        """The constants of each bin for luma and both chroma planes; None if the bank has none."""
        constants = self.bank.combined_constants(self.weights)
        return [None] * 3 if constants is None else list(np.ascontiguousarray(constants.T))

    def run(
        self,
        luma: np.ndarray,
        margin: tuple[int, int] = (0, 0),
        top: int = 0,
        out: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return the result at the size of the picture, undefined in the margin; or `out`.

        Args:
            luma: H x W float32; beyond its border the border is repeated.
            margin: numbers of first and last rows that are only read.
            top: the number of luma's first row in the whole picture.
            out: rows without the margin, for the result; used if they fill whole cache lines.
        """
        return self._passes(luma, (), margin, top, out)[0]

    def run_chroma(
        self,
        luma: np.ndarray,
        chroma: tuple[np.ndarray, ...],
        margin: tuple[int, int] = (0, 0),
        top: int = 0,
    ) -> tuple[np.ndarray, ...]:
        """Return the chroma planes, with filters selected by luma; arguments as in `run`."""
        return tuple(self._passes(luma, chroma, margin, top)[1:])

    def _passes(
        self,
        luma: np.ndarray,
        chroma: tuple[np.ndarray, ...],
        margin: tuple[int, int],
        top: int,
        out: np.ndarray | None = None,
    ) -> list[np.ndarray]:
        """Return luma and the chroma planes; luma is undefined if chroma is requested."""
        step = self.radius // self.passes if self.reselect else self.bank.size // 2
        bins, size = self.bank.bins, self.bank.size
        selected: np.ndarray | None = None
        for left in range(self.passes - 1, -1, -1):
            # Later passes read rows around the needed ones.
            rows = max(0, margin[0] - left * step), max(0, margin[1] - left * step)
            if selected is None or self.reselect:
                selected = choose_filters(luma, bins, self.window, rows, top)
            place = rows, bins.pitch, top
            chroma = tuple(
                apply_filters(
                    each,
                    selected,
                    self._packed_for_chroma,
                    size,
                    RANGES["chroma"],
                    *place,
                    constants=constants,
                )
                for each, constants in zip(chroma, self._constants[1:], strict=False)
            )
            if not chroma or (left and self.reselect):
                last = None if left else out
                luma = apply_filters(
                    luma, selected, self._packed, size, self.limits, *place, last, self._constants[0]
                )
        return [luma, *chroma]

    def whole(self, luma: np.ndarray) -> np.ndarray:
        """Return the result for a picture, including the reduction and enlargement, as in a style."""
        return resample(self.run(self._reduced(luma)), (luma.shape[0], luma.shape[1]), RESAMPLING_METHOD)

    def whole_chroma(self, luma: np.ndarray, chroma: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return the chroma planes of the size of luma, including the reduction and enlargement."""
        shape = luma.shape[0], luma.shape[1]
        filtered = self.run_chroma(self._reduced(luma), tuple(map(self._reduced, chroma)))
        return [resample(each, shape, RESAMPLING_METHOD) for each in filtered]

    def _reduced(self, plane: np.ndarray) -> np.ndarray:
        return resample(plane, self.shape_at_scale((plane.shape[0], plane.shape[1])), RESAMPLING_METHOD)


def apply_filters(
    luma: np.ndarray,
    selected: np.ndarray,
    packed: np.ndarray,
    size: int,
    limits: tuple[float, float],
    margin: tuple[int, int] = (0, 0),
    step: int = 1,
    top: int = 0,
    out: np.ndarray | None = None,
    constants: np.ndarray | None = None,
) -> np.ndarray:
    """Filter each pixel with the filter selected for it.

    Args:
        luma: H x W float32; beyond its border the border is repeated.
        selected: from `choose_filters`.
        packed: from `pack_filters`.
        size: rows and columns of a filter.
        limits: the range that the result is clipped to.
        margin: numbers of first and last rows that are not needed.
        step: side of the squares of pixels that share a filter.
        top: as in `select_filters`.
        out: float32, rows without the margin.
        constants: one for each filter, to add to its result before clipping.

    Returns:
        `out` if it consists of whole cache lines and squares; otherwise H x W float32, undefined in the
        margin.
    """
    (height, width), lead = luma.shape, top % step
    columns = round_up(width, CACHE_LINE_FLOATS)
    rows = (margin[0] + lead) // step, -(-(height - margin[1] + lead) // step)
    together = 1 if step > 1 else min(ROWS_AT_ONCE, rows[1] - rows[0])
    shape = size + together * step - 1, columns + round_up(size, CACHE_LINE_FLOATS) + CACHE_LINE_FLOATS
    kept, again = aligned_parts(shape, (shape[0] * shape[1] + CACHE_LINE_FLOATS,))
    # Pixels that start within a cache line read rows that also start within one.
    around = kept, again[CACHE_LINE_FLOATS // 2 : -CACHE_LINE_FLOATS // 2].reshape(shape)
    low, high = limits if constants is None else WIDE_RANGE
    ends = np.float32(low), np.float32(high)
    if (
        out is None
        or width % CACHE_LINE_FLOATS
        or any((row + lead) % step for row in (margin[0], height - margin[1]))
    ):
        out, first = np.empty((len(selected) * step, columns), np.float32), 0
        result = out[lead : lead + height, :width]
    else:
        result, first = out, rows[0]
    chosen = _widened(selected, columns // step)
    sides = (0,) * size, (0,) * step, (0,) * together
    _apply(np.ascontiguousarray(luma), chosen, packed, sides, (*rows, lead, first), ends, around, out)
    if constants is not None:
        needed = slice(margin[0], height - margin[1])
        inside = result if result is out else result[needed]
        _add_constants(inside, selected[needed], constants, np.float32(limits[0]), np.float32(limits[1]))
    return result


def _widened(selected: np.ndarray, columns: int) -> np.ndarray:
    """Return the indices with this number of columns: the base array of `selected`, or a copy."""
    if selected.base is not None and selected.base.shape == (len(selected), columns):
        return selected.base
    return np.pad(selected, ((0, 0), (0, columns - selected.shape[1]))).astype(np.int32)


@compiled(fastmath=True)
def _add_constants(out, selected, constants, low, high):  # type: ignore[no-untyped-def]
    """Add the constant of each pixel's filter, and clip; a constant belongs to one pixel, not to a square."""
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            out[row, x] = min(max(out[row, x] + constants[selected[row, x]], low), high)


@compiled(fastmath=True)
def _apply(luma, selected, filters, sides, place, ends, around, out):  # type: ignore[no-untyped-def]
    """Filter the squares, several rows at a time; the last rows may be filtered twice.

    Args:
        sides: as in `filter_pixel_block`.
        place: the first row of squares, the row after the last, rows of the first square above luma, and the
            row of squares at the start of `out`.
        ends: ends of the range that the result is clipped to.
        around: rows of luma with their border, stored twice.
    """
    (top, bottom, lead, first), (low, high), (kept, again) = place, ends, around
    radius, step, together = len(sides[0]) // 2, len(sides[1]), len(sides[2])
    count, last = kept.shape[0], luma.shape[0] - 1
    begun = top * step - lead - radius
    for next_row in range(top, bottom, together):
        row = min(next_row, bottom - together)
        end = row * step - lead - radius + count
        for each in range(begun, end):
            _repeat_border(luma[min(max(each, 0), last)], radius, kept[each % count], again[each % count])
        begun, oldest = end, end % count
        chosen, filtered = selected[row:], out[(row - first) * step :]
        for column in range(0, out.shape[1], 16):
            filter_pixel_block(filters, chosen, kept, oldest, column, sides, low, high, filtered)
            filter_pixel_block(filters, chosen, again, oldest, column + 8, sides, low, high, filtered)


@compiled(fastmath=True, noalias=True)
def _repeat_border(row, radius, out, again):  # type: ignore[no-untyped-def]
    """Extend a row by `radius` copies of its first and last numbers, and store it twice."""
    inside, inside_again, end = out[radius:], again[radius:], radius + row.size
    for x in range(radius):
        out[x], again[x] = row[0], row[0]
    for x in range(row.size):
        inside[x], inside_again[x] = row[x], row[x]
    for x in range(end, out.size):
        out[x], again[x] = row[row.size - 1], row[row.size - 1]
