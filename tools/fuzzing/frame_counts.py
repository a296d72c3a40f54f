"""Count the frames that FFmpeg decodes from a film, if it is installed."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections import Counter, defaultdict
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import av

from tools.fuzzing.originals import FILMS
from tools.fuzzing.processes import MAX_PROCESSOR_SECONDS, BrokenPromiseError

FILM_ENDINGS = {Path(name).suffix for name in FILMS}
FIELDS = "packet=stream_index,pos:stream=index,nb_read_frames:stream_disposition=attached_pic"


def check_frames(path: Path, frames: int) -> None:
    """Check that a film rendered with exit code 0 has all frames that FFmpeg decodes.

    Args:
        path: the source.
        frames: number of rendered frames.

    Raises:
        BrokenPromiseError: FFmpeg decodes more.
    """
    if path.suffix in FILM_ENDINGS and frames < (wanted := count_ffmpeg_frames(path)):
        raise BrokenPromiseError(f"fewer frames: {frames} of {wanted} with exit code 0")


def check_refusal(path: Path) -> None:
    """Check that the FFmpeg of PyAV cannot decode a refused film; other releases may differ.

    Raises:
        BrokenPromiseError: FFmpeg decodes frames.
    """
    if path.suffix in FILM_ENDINGS and (found := _count_decoded_frames(path)):
        raise BrokenPromiseError(f"refused film: FFmpeg decodes {found} frames")


def _count_decoded_frames(path: Path) -> int:
    counts = Counter[int]()
    with suppress(av.FFmpegError), av.open(str(path), metadata_errors="replace") as container:
        films = container.streams.video  # without arguments, `demux` yields all packets
        for packet in container.demux(*films) if films else ():
            with suppress(av.FFmpegError):
                counts[packet.stream_index] += len(packet.decode())
    return max(counts.values(), default=0)


def count_ffmpeg_frames(path: Path) -> int:
    """Count the frames of the longest video track and of tracks entirely before or after it.

    The order is the order of bytes in the file, as timestamps may repeat in joined recordings.
    """
    found = _probe(path)
    tracks = [each for each in found.get("streams", []) if not each["disposition"]["attached_pic"]]
    counts = {each["index"]: int(each.get("nb_read_frames", 0)) for each in tracks}
    places = defaultdict[int, list[int]](lambda: [0])
    for packet in found.get("packets", []):
        places[packet["stream_index"]].append(int(packet.get("pos", 0)))
    extents = {index: (min(places[index][1:], default=0), max(places[index])) for index in counts}
    longest = max(counts, key=lambda index: counts[index], default=None)
    if longest is None:
        return 0
    begin, end = extents[longest]
    others = (index for index, (first, last) in extents.items() if last < begin or first > end)
    return counts[longest] + sum(counts[index] for index in others)


def _probe(path: Path) -> dict[str, Any]:
    """Return the output of ffprobe for the video tracks; empty if it is missing, fails or hangs."""
    command = [_ffprobe(), "-v", "quiet", "-count_frames", "-select_streams", "v"]
    command += ["-show_entries", FIELDS, "-of", "json", f"file:{path.absolute()}"]
    try:
        run = (
            subprocess.run(command, capture_output=True, timeout=MAX_PROCESSOR_SECONDS)
            if _ffprobe()
            else None
        )
        return json.loads(run.stdout) if run else {}
    except (subprocess.TimeoutExpired, ValueError):
        return {}


@cache
def _ffprobe() -> str:
    return shutil.which("ffprobe") or ""
