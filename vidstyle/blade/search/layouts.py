"""The layouts of bins from which `vidstyle train --bins auto` chooses."""

from __future__ import annotations

from typing import NamedTuple

from vidstyle.blade.bins import Bins, Feature

WIDE_COHERENCE_RANGE = (0.1, 0.9)
TONES = Feature("mean", 32, 0.3)
"""The value of the pixel itself, nearly: with affine filters, a tone curve of 32 straight pieces."""


class Layout(NamedTuple):
    """Bins, and limits of clipped differences in levels of 255."""

    bins: Bins
    clips: tuple[float, ...] = ()


AUTOMATIC_LAYOUTS = (
    Layout(Bins(16, 5, 3)),
    Layout(Bins(2, 1, 1, features=(TONES,))),
    Layout(Bins(8, 24, 3, (0.0, 24.0), WIDE_COHERENCE_RANGE)),
    Layout(Bins(8, 20, 4, (0.0, 40.0), WIDE_COHERENCE_RANGE)),
    Layout(
        Bins(8, 6, 2, (0.0, 40.0), WIDE_COHERENCE_RANGE, features=(Feature("strength", 8, 4.0, (0.0, 40.0)),))
    ),
    Layout(Bins(6, 8, 2, (0.0, 30.0), WIDE_COHERENCE_RANGE, features=(Feature("mean", 10, 0.3),))),
    Layout(Bins(8, 4, 1, (0.0, 40.0), features=(Feature("strength", 30, 0.5, (0.0, 90.0)),))),
    Layout(Bins(2, 9, 1, (0.0, 40.0), features=(Feature("difference", 9, 2.0),)), (8.0, 32.0)),
    Layout(Bins(4, 8, 1, (0.0, 40.0), features=(Feature("difference", 9, 3.0, (-40.0, 40.0)),)), (8.0, 32.0)),
    Layout(
        Bins(2, 1, 1, features=(Feature("strength", 12, 0.5, (0.0, 60.0)), Feature("difference", 9, 1.0))),
        (8.0, 32.0),
    ),
    Layout(
        Bins(
            4, 6, 2, (0.0, 40.0), WIDE_COHERENCE_RANGE, features=(Feature("strength", 8, 4.0, (0.0, 40.0)),)
        ),
        (8.0, 32.0),
    ),
    Layout(
        Bins(2, 1, 1, features=(Feature("strength", 16, 0.5, (0.0, 40.0)), Feature("mean", 10, 0.3))),
        (1.0, 4.0, 16.0),
    ),
)
"""Layouts of up to 1024 filters, simpler ones first.

Without clips: the best of 25 layouts for 15 filters of other programs on 12 photographs
(tools/foreign_filters.py): finer bins of weak gradients, structure at a second scale, the tone, and the
gradient of the pixel itself. With clips: the best of 9 layouts for ten of these filters, by the error on the
held-out half of 12 photographs.
"""


def layout_text(bins: Bins, clips: tuple[float, ...] = ()) -> str:
    """Return the bins and clips as text.

    >>> layout_text(*AUTOMATIC_LAYOUTS[4])
    '8 x 6 x 2 bins of orientation, strength (0 to 40) and coherence x 8 of strength@4'
    """
    low, high = bins.strength_range
    numbers = f"{bins.orientations} x {bins.strengths} x {bins.coherences}"
    text = f"{numbers} bins of orientation, strength ({low:g} to {high:g}) and coherence"
    others = [f" x {each.bins} of {each.name}@{each.rho:g}" for each in bins.features]
    curvatures = f" x {bins.curvatures} of curvature" if bins.curvatures > 1 else ""
    limits = f"; differences also clipped to {', '.join(f'{each:g}' for each in clips)}" if clips else ""
    return text + curvatures + "".join(others) + limits
