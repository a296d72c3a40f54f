"""The figures of steadiness as a table for people."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tools.steadiness import DISC_FRAMES, GHOST, NOISE, QUIET, SETTLING, STILL_FRAMES, Figures

SOURCE = "(the films themselves)"


def markdown(
    figures: Mapping[str, Sequence[Figures]], steady: Sequence[float], untouched: Figures, films: str
) -> str:
    """A Markdown table.

    Args:
        figures: for each style those at each value of `steady`.
        untouched: those of the films themselves.
        films: which clips, for the legend.
    """
    names = ("still", "warping error", "of source's", "quiet", "smear")
    lines = [["style", *(f"{name}, {value:g}" for name in names for value in steady), "ghost"]]
    lines += [["---", *("---:" for _ in lines[0][1:])]]
    lines += [[style, *_cells(each)] for style, each in figures.items()]
    lines += [[SOURCE, *_cells([untouched] * len(steady))]]
    rows = (f"| {' | '.join(line)} |" for line in lines)
    return "\n".join([*rows, "", *_legend(films)]) + "\n"


def markdown_of_following(
    styles: Sequence[str], clips: Sequence[str], columns: Sequence[Sequence[tuple[float, float]]]
) -> str:
    """A Markdown table: for each clip, a column, the two correlations of each style and of the clip."""
    lines = [["style", *clips], ["---", *("---:" for _ in clips)]]
    for style, *pairs in zip([*styles, SOURCE], *columns, strict=True):
        lines += [[style, *(f"{page:.2f} \\| {along:.2f}" for page, along in pairs)]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def _cells(figures: Sequence[Figures]) -> list[str]:
    return [
        *(f"{each.still:.2f}" for each in figures),
        *(_known(1000 * each.warping) for each in figures),
        *(_known(each.ratio) for each in figures),
        *(_known(each.quiet) for each in figures),
        *(f"{each.smear:.2f}" for each in figures),
        f"{figures[0].ghost:.1f}",
    ]


def _known(number: float) -> str:
    return "-" if math.isnan(number) else f"{number:.2f}"


def _legend(films: str) -> list[str]:
    return [
        "Behind each comma stands `steady`; differences are in levels of 255.",
        f"Still: mean difference of successive frames of a photograph under noise of {NOISE} levels, "
        f"frames {SETTLING + 1} to {STILL_FRAMES}.",
        f"Warping error (Lai et al. 2018), in thousandths, and how many times the source's it is: {films}. "
        "Dots and strokes that stay on the page while the picture moves under them count as change.",
        f"Quiet: mean difference of successive frames where the film's own is at most {QUIET} levels: marks "
        "that lie still have no reason to change there.",
        "Smear: mean difference from the film at steady 0 around the edge of a disc that moves over a "
        f"photograph, {DISC_FRAMES} frames; ghost: that with {GHOST:g} of the last result mixed in.",
    ]
