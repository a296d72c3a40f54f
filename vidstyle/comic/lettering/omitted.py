"""Report of the subtitles that no panel shows."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, groupby

from vidstyle.comic.layout.storyboard import format_timecode
from vidstyle.comic.lettering.subtitle_lines import Line

MAX_SINGLE_TIMES = 24
"""Maximum number of subtitles that are listed one by one."""


def list_omitted(omitted: Sequence[Line], lines: Sequence[Line]) -> list[str]:
    """Return the start times of omitted subtitles.

    If there are many, those between two subtitles that are shown form one entry: first and last time, and
    their number.

    Args:
        omitted: the lines that no panel shows.
        lines: all lines.
    """
    lost = {time for line in omitted for time in line.times}
    if len(lost) <= MAX_SINGLE_TIMES:
        return [format_timecode(time) for time in sorted(lost)]
    known = lost.union(chain.from_iterable(line.times for line in lines))
    runs = [list(run) for is_lost, run in groupby(sorted(known), key=lost.__contains__) if is_lost]
    return [_format_run(run) for run in runs]


def _format_run(times: Sequence[float]) -> str:
    first, last = format_timecode(times[0]), format_timecode(times[-1])
    return first if len(times) == 1 else f"{first} to {last} ({len(times)})"
