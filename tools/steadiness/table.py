"""Format measurements of steadiness as Markdown tables."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tools.steadiness import (
    DISC_SCENE_FRAMES,
    GHOST_WEIGHT,
    MAX_QUIET_LEVELS,
    NOISE_LEVELS,
    SETTLING_FRAMES,
    STILL_SCENE_FRAMES,
    Steadiness,
)

SOURCE = "(the films themselves)"


def format_steadiness(
    measured: Mapping[str, Sequence[Steadiness]], steady: Sequence[float], source: Steadiness, films: str
) -> str:
    """Return a Markdown table with a row for each style and one for the source, and a legend.

    Args:
        measured: for each style its steadiness at each value of `steady`.
        source: steadiness of the films without a style.
        films: description of the clips, for the legend.
    """
    names = ("still scene", "warping error", "ratio to source", "quiet areas", "smear")
    lines = [["style", *(f"{name} at {value:g}" for name in names for value in steady), "ghost"]]
    lines += [["---", *("---:" for _ in lines[0][1:])]]
    lines += [[style, *_cells(each)] for style, each in measured.items()]
    lines += [[SOURCE, *_cells([source] * len(steady))]]
    rows = (f"| {' | '.join(line)} |" for line in lines)
    return "\n".join([*rows, "", *_legend(films)]) + "\n"


def format_mark_motion(
    styles: Sequence[str], clips: Sequence[str], columns: Sequence[Sequence[tuple[float, float]]]
) -> str:
    """Return a Markdown table: for each clip a column with the correlations of each style and of the source.

    Args:
        styles: names.
        clips: names.
        columns: for each clip the result of `compare_mark_motion`.
    """
    lines = [["style", *clips], ["---", *("---:" for _ in clips)]]
    for style, *pairs in zip([*styles, SOURCE], *columns, strict=True):
        lines += [[style, *(f"{page:.2f} \\| {along:.2f}" for page, along in pairs)]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def _cells(measured: Sequence[Steadiness]) -> list[str]:
    return [
        *(f"{each.still:.2f}" for each in measured),
        *(_format_known(1000 * each.warping) for each in measured),
        *(_format_known(each.ratio) for each in measured),
        *(_format_known(each.quiet) for each in measured),
        *(f"{each.smear:.2f}" for each in measured),
        f"{measured[0].ghost:.1f}",
    ]


def _format_known(number: float) -> str:
    return "-" if math.isnan(number) else f"{number:.2f}"


def _legend(films: str) -> list[str]:
    return [
        '"At" gives the value of `steady`; differences are in levels of 255.',
        "Still scene: mean difference between successive frames of a photograph with noise of "
        f"{NOISE_LEVELS} levels, frames {SETTLING_FRAMES + 1} to {STILL_SCENE_FRAMES}.",
        f"Warping error (Lai et al. 2018): in thousandths, and as a ratio to the source's own: {films}. "
        "Dots and strokes that stay on the page while the picture moves under them count as errors.",
        "Quiet areas: mean difference between successive frames where the source changes by at most "
        f"{MAX_QUIET_LEVELS} levels: fixed marks have no reason to change there.",
        "Smear: mean difference from the result at steady 0 around the edge of a disc that moves over a "
        f"photograph, {DISC_SCENE_FRAMES} frames; ghost: the same for frames into which the previous result "
        f"is mixed with weight {GHOST_WEIGHT:g}.",
    ]
