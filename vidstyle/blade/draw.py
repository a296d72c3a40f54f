"""Draws all filters of a bank in one picture, as in the paper's appendix."""

from __future__ import annotations

import numpy as np

from vidstyle.blade.bank import Bank

ZOOM = 8
"""Size of a coefficient in pixels."""
GAP = 4
NEGATIVE, ZERO, POSITIVE = np.array([[33, 102, 172], [247, 247, 247], [178, 24, 43]], np.float32)
"""Colours of the most negative, zero and most positive coefficients."""


def draw_bank(bank: Bank) -> np.ndarray:
    """The filters of all parts, H x W x 3 uint8 RGB.

    Orientations go down, coherences within strengths to the right, parts beside one another. The middle
    coefficient outshines the others, so each filter is scaled by its second largest.
    """
    parts = [_draw_part(bank, filters) for filters in bank.filters]
    gap = np.full((parts[0].shape[0], 4 * GAP, 3), 255, np.uint8)
    row = [part for drawn in parts for part in (drawn, gap)][:-1]
    return np.concatenate(row, axis=1)


def _draw_part(bank: Bank, filters: np.ndarray) -> np.ndarray:
    across = bank.bins.strengths * bank.bins.coherences
    step = bank.size * ZOOM + GAP
    page = np.full((bank.bins.orientations * step + GAP, across * step + GAP, 3), 255, np.uint8)
    for number, coefficients in enumerate(filters):
        top, left = GAP + number // across * step, GAP + number % across * step
        drawn = np.repeat(np.repeat(_colored(coefficients), ZOOM, axis=0), ZOOM, axis=1)
        page[top : top + drawn.shape[0], left : left + drawn.shape[1]] = drawn
    return page


def _colored(coefficients: np.ndarray) -> np.ndarray:
    largest = np.sort(np.abs(coefficients), axis=None)[-2]
    share = np.clip(coefficients / max(float(largest), 1e-12), -1, 1)[..., None]
    end = np.where(share < 0, NEGATIVE, POSITIVE)
    return (ZERO + np.abs(share) * (end - ZERO) + 0.5).astype(np.uint8)
