"""Steps around the filters of the paper, so that they suit pictures in any light.

None of them counts as a filter of the paper. Tuned on ten photographs whose styles people had marked, such as
portraits in coloured and in dim light, a crowd, boats at dusk, and planks.
"""

from __future__ import annotations

from dataclasses import replace

from vidstyle.explore.random_steps import scale_factor
from vidstyle.style import SOURCE, Step

RANGE_BLOCK, RANGE_PERCENTILES = "equalize", {"low": 0.0, "high": 99.5}
"""The first filter of each style: section 4.2 D usually places a histogram operator first, as XDoG of a hazy,
too bright or too dark picture is almost entirely white. Black stays unchanged, so that night has detail."""
AROUND_FACTOR, WIDE_FACTOR = 1 / 12, 1 / 4
"""Reductions at which the brightness around each pixel is measured, and then that of wide surroundings."""
WIDE_DEVIATION_PX, AROUND_DEVIATION_PX = 6.0, 2.0
NEAR_TIME, NEAR_PASS_COUNT = 12.0, 3
"""Smoothing up to edges of the brightness near each pixel, as in the shipped style `cartoon`."""
SHADOW_LIFT, EVEN_LIGHT_SHARE = 1.2, 0.6
"""Light on shadows: dark hair, boats and rooms became black shapes, and faces in dim light mud, otherwise."""
EVEN_SHARE = 0.65
"""Share of the brightness around that is removed before lines are drawn, as in the shipped style `comic`. A
threshold turns dark hair, fur and hulls into black shapes otherwise, which people rejected."""
EDGE_FACTOR, CLUTTER_FACTOR, CLUTTER_DEVIATION_PX = 1 / 3, 1 / 4, 8.0
"""Reductions and blur that measure how many edges there are: foliage and wood get fewer lines, not worms."""
STRONG_FACTOR = 4.0
"""Inverse of the difference of a colour from gray, relative to luma, from which it counts as strong. Of
styles that multiplied all colours, people kept one in six, half as many as of others: skin became orange."""


def lit() -> list[Step]:
    """Return steps that lighten shadows, and stretch the contrast."""
    light = {"near": "near", "wide": "wide", "lift": SHADOW_LIFT, "even": EVEN_LIGHT_SHARE}
    return [
        Step("to_gray"),
        _reduced(AROUND_FACTOR),
        Step("tvf", {"flow": "variation", "time": NEAR_TIME, "passes": NEAR_PASS_COUNT}, save="near"),
        _reduced(WIDE_FACTOR),
        Step("gaussian", {"sigma": WIDE_DEVIATION_PX}, save="wide"),
        Step("local_exposure", light, source=SOURCE),
        Step(RANGE_BLOCK, dict(RANGE_PERCENTILES)),
    ]


def moderated(saturation: Step, picture: str) -> list[Step]:
    """Return steps that apply a saturation to weak colours, and less to strong ones.

    Args:
        picture: the saved picture that they change.
    """
    difference = {"other": "tones", "mode": "difference", "opacity": 1.0}
    unchanged = {"other": picture, "mode": "normal", "opacity": 1.0, "mask": "strong"}
    return [
        Step("to_gray", save="tones", source=picture),
        Step("blend", difference, source=picture),
        Step("blend", difference | {"mode": "divide"}),
        Step("to_gray"),
        Step("brightness", {"factor": STRONG_FACTOR}, save="strong"),
        replace(saturation, source=picture),
        Step("blend", unchanged),
    ]


def evened() -> list[Step]:
    """Return steps that remove most of the brightness around each pixel, for lines also in shadows."""
    mixing = {"other": "around", "mode": "grain_extract", "opacity": EVEN_SHARE}
    return [
        Step("to_gray", save="gray"),
        _reduced(EDGE_FACTOR),
        Step("sobel", {"gain": 1.0}),
        _reduced(CLUTTER_FACTOR),
        Step("gaussian", {"sigma": CLUTTER_DEVIATION_PX}, save="clutter"),
        replace(_reduced(AROUND_FACTOR), source="gray"),
        Step("gaussian", {"sigma": AROUND_DEVIATION_PX}, save="around"),
        Step("blend", mixing, source="gray"),
    ]


def thinned() -> Step:
    """Return the step between lines and their threshold that removes faint ones where there are many."""
    return Step("blend", {"other": "clutter", "mode": "add", "opacity": 1.0})


def _reduced(factor: float) -> Step:
    return Step("scale", {"factor": scale_factor(factor)})
