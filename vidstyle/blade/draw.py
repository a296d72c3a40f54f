"""Draws all filters of a bank in one picture, as in the paper's figures S3 to S6."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import cv2
import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.bins import Bins

COEFFICIENT_PX = 8
"""Side of the square that shows a coefficient."""
GAP_PX = 4
LEFT_PX, TOP_PX, RIGHT_PX, FEATURE_NAME_PX = 150, 64, 90, 110
"""Space for names of rows and columns, for the scale, and for curvature and each feature in names of rows."""
NEGATIVE_COLOR, ZERO_COLOR, POSITIVE_COLOR = np.array(
    [[33, 102, 172], [247, 247, 247], [178, 24, 43]], np.float32
)
"""Colours of the most negative, zero and most positive coefficients."""
EMPTY_COLOR = (255, 220, 120)
"""Colour of the frame of filters without training samples."""


def draw_bank(bank: Bank) -> np.ndarray:
    """Draw the filters of all parts, H x W x 3 uint8 RGB.

    Columns are orientations; rows are strengths within coherences within curvatures within additional
    features. Parts follow one another, then the filters for chroma. All filters of a part share a scale,
    which ends at the largest coefficient that is not in the middle of a filter, as middle coefficients
    dominate. The weights of clipped differences follow each part, then a map of the constants of an affine
    bank. If the bank records the number of samples of each filter and its residual, maps of both follow. The
    second stage comes last.
    """
    pages = [page for stage in bank.stages for page in _pages(stage)]
    width = max(page.shape[1] for page in pages)
    none = (0, 0)
    return np.concatenate(
        [np.pad(page, (none, (0, width - page.shape[1]), none), constant_values=255) for page in pages]
    )


def _pages(bank: Bank) -> list[np.ndarray]:
    """Draw one stage."""
    samples = _per_bin(bank, "samples")
    residuals = bank.about.get("residuals", [])
    pages = []
    for number, filters in enumerate(bank.filters):
        names = bank.about.get("parts", [])
        title = names[number] if number < len(names) else f"part {number + 1}"
        pages.append(_draw_part(bank, filters, str(title), samples))
        for clip, level in enumerate(bank.clips):
            assert bank.clipped is not None
            clipped = bank.clipped[number, :, clip]
            pages.append(_draw_part(bank, clipped, f"{title}, differences clipped to {level:g}", samples))
        if number < len(residuals):
            pages.append(_draw_map(bank, np.asarray(residuals[number]), "residual, levels of 255", ".2f"))
        if bank.constants is not None:
            constants = 255 * bank.constants[number, :, 0].astype(np.float64)
            pages.append(_draw_map(bank, constants, "constant, levels of 255", ".1f"))
        if bank.chroma is not None:
            pages.append(_draw_part(bank, bank.chroma[number], f"{title}, chroma", samples))
    if samples is not None:
        pages.append(_draw_map(bank, samples, "samples", ",.0f", 0.25))
    return pages


def _per_bin(bank: Bank, name: str) -> np.ndarray | None:
    """Return the numbers that the bank records for each bin, or None."""
    numbers = np.asarray(bank.about.get(name, []), np.float64)
    return numbers if numbers.shape == (bank.bins.count,) else None


def _rows(bank: Bank) -> Iterator[tuple[int, str]]:
    """Yield the number of each row's bin within its orientation, and its name."""
    bins = bank.bins
    of_features = [[(each, number) for number in range(each.bins)] for each in bins.features]
    of_tensor = [*product(range(bins.curvatures), range(bins.coherences), range(bins.strengths))]
    for chosen, (curvature, coherence, strength) in product(product(*of_features), of_tensor):
        number = (strength * bins.coherences + coherence) * bins.curvatures + curvature
        for each, level in chosen:
            number = number * each.bins + level
        levels = _bin_text(strength, bins.strengths, bins.strength_range)
        clear = _bin_text(coherence, bins.coherences, bins.coherence_range)
        beside = [f"k {_curvature_text(bins, curvature)}"] if bins.curvatures > 1 else []
        beside += [f"{each.name} {_bin_text(level, each.bins, each.range)}" for each, level in chosen]
        yield number, "  ".join([f"s {levels}", f"c {clear}", *beside])


def _left(bank: Bank) -> int:
    """Return the left edge of the first column."""
    return LEFT_PX + FEATURE_NAME_PX * (len(bank.bins.features) + (bank.bins.curvatures > 1))


def _bin_text(number: int, count: int, ends: tuple[float, float]) -> str:
    """Return the range of a bin as text; the bins at the ends are open."""
    low, high = (ends[0] + (ends[1] - ends[0]) * each / count for each in (number, number + 1))
    if count == 1:
        return "all"
    if number == 0:
        return f"<{high:.3g}"
    return f">{low:.3g}" if number == count - 1 else f"{low:.3g}-{high:.3g}"


def _curvature_text(bins: Bins, number: int) -> str:
    """Return the range of a bin of curvature in radians per pixel; the bins at the ends are open."""
    low, high = bins.curvature_at(number), bins.curvature_at(number + 1)
    if number == 0:
        return f"<{high:.2g}"
    return f">{low:.2g}" if number == bins.curvatures - 1 else f"{low:.2g} to {high:.2g}"


def _page(bank: Bank, cell_height: int, title: str) -> np.ndarray:
    """Return a white page with the names of rows and columns."""
    bins, step = bank.bins, bank.size * COEFFICIENT_PX + GAP_PX
    height, left = TOP_PX + bins.count // bins.orientations * cell_height + GAP_PX, _left(bank)
    page = np.full((height, left + bins.orientations * step + RIGHT_PX, 3), 255, np.uint8)
    _write(page, title, left, 20, 0.55)
    for number in range(bins.orientations):
        _write(page, f"{180 * number / bins.orientations:g}", left + number * step + GAP_PX, TOP_PX - 12)
    _write(page, "orientation, degrees", left, TOP_PX - 28)
    for row, (_, name) in enumerate(_rows(bank)):
        _write(page, name, 6, TOP_PX + row * cell_height + cell_height // 2 + 4)
    return page


def _draw_part(bank: Bank, filters: np.ndarray, title: str, samples: np.ndarray | None) -> np.ndarray:
    bins, side, step = bank.bins, bank.size * COEFFICIENT_PX, bank.size * COEFFICIENT_PX + GAP_PX
    page, largest = _page(bank, step, title), _scale_end(filters)
    for row, (within, _) in enumerate(_rows(bank)):
        for column in range(bins.orientations):
            number = column * (bins.count // bins.orientations) + within
            top, left = TOP_PX + row * step, _left(bank) + column * step
            drawn = _color_numbers(filters[number] / largest)
            page[top : top + side, left : left + side] = drawn.repeat(COEFFICIENT_PX, axis=0).repeat(
                COEFFICIENT_PX, axis=1
            )
            if samples is not None and samples[number] == 0:
                cv2.rectangle(page, (left - 2, top - 2), (left + side + 1, top + side + 1), EMPTY_COLOR, 2)
    _draw_scale(page, largest)
    return page


def _scale_end(filters: np.ndarray) -> float:
    """Return the largest coefficient that is not in the middle of its filter."""
    beside = np.abs(filters)
    beside[:, filters.shape[1] // 2, filters.shape[2] // 2] = 0
    return max(float(beside.max()), 1e-12)


def _draw_scale(page: np.ndarray, largest: float) -> None:
    """Draw a bar of the colours at the right, with numbers."""
    left, height = page.shape[1] - RIGHT_PX + 16, min(160, page.shape[0] - TOP_PX - GAP_PX)
    page[TOP_PX : TOP_PX + height, left : left + 14] = _color_numbers(np.linspace(1, -1, height))[:, None]
    for share, text in ((0.0, f"{largest:.3g}"), (0.5, "0"), (1.0, f"-{largest:.3g}")):
        _write(page, text, left + 18, TOP_PX + int(share * height) + 4)


def _draw_map(bank: Bank, numbers: np.ndarray, title: str, form: str, power: float = 1) -> np.ndarray:
    """Draw a number for each bin, black for the maximum; a power below 1 spreads small numbers."""
    bins, step, height = bank.bins, bank.size * COEFFICIENT_PX + GAP_PX, 18
    ends = f"{title}: white {numbers.min():{form}}, black {numbers.max():{form}}"
    page = _page(bank, height, ends)
    shades = 255 - 255 * ((numbers - numbers.min()) / max(float(np.ptp(numbers)), 1e-12)) ** power
    for row, (within, _) in enumerate(_rows(bank)):
        for column in range(bins.orientations):
            shade = shades[column * (bins.count // bins.orientations) + within]
            top, left = TOP_PX + row * height, _left(bank) + column * step
            page[top : top + height - 2, left : left + step - GAP_PX] = int(shade)
    return page


def _write(page: np.ndarray, text: str, x: int, y: int, size: float = 0.4) -> None:
    cv2.putText(page, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, size, (40, 40, 40), 1, cv2.LINE_AA)


def _color_numbers(shares: np.ndarray) -> np.ndarray:
    """Map numbers from -1 to 1 to colours; numbers outside this range are clipped."""
    share = np.clip(shares, -1, 1)[..., None]
    end = np.where(share < 0, NEGATIVE_COLOR, POSITIVE_COLOR)
    return (ZERO_COLOR + np.abs(share) * (end - ZERO_COLOR) + 0.5).astype(np.uint8)
