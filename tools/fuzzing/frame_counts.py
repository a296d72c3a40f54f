"""How many frames FFmpeg finds in a film, where it is installed."""

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
from tools.fuzzing.processes import SECONDS, BrokenPromiseError

FILM_ENDINGS = {Path(name).suffix for name in FILMS}
FIELDS = "packet=stream_index,pos:stream=index,nb_read_frames:stream_disposition=attached_pic"


def check_frames(path: Path, frames: int) -> None:
    """Compare the frames of a film that was made without a complaint with those that FFmpeg finds.

    Raises:
        BrokenPromiseError: FFmpeg finds more.
    """
    if path.suffix in FILM_ENDINGS and frames < (wanted := ffmpeg_frames(path)):
        raise BrokenPromiseError(f"fewer frames: {frames} of {wanted} with exit code 0")


def check_refusal(path: Path) -> None:
    """Try a film that was refused with the FFmpeg of PyAV: what another release decodes is no measure here.

    Raises:
        BrokenPromiseError: it decodes frames.
    """
    if path.suffix in FILM_ENDINGS and (found := _decoded_frames(path)):
        raise BrokenPromiseError(f"refused film: FFmpeg decodes {found} frames")


def _decoded_frames(path: Path) -> int:
    counts = Counter[int]()
    with suppress(av.FFmpegError), av.open(str(path), metadata_errors="replace") as container:
        films = container.streams.video  # of none, `demux` would give all packets
        for packet in container.demux(*films) if films else ():
            with suppress(av.FFmpegError):
                counts[packet.stream_index] += len(packet.decode())
    return max(counts.values(), default=0)


def ffmpeg_frames(path: Path) -> int:
    """The frames of the longest video track, and of those that end before it begins or follow it.

    The order is that of the bytes in the file: times may repeat where one recording follows another.
    """
    found = _probed(path)
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


def _probed(path: Path) -> dict[str, Any]:
    """What ffprobe says of the video tracks; nothing where it is missing, fails or hangs."""
    command = [_ffprobe(), "-v", "quiet", "-count_frames", "-select_streams", "v"]
    command += ["-show_entries", FIELDS, "-of", "json", f"file:{path.absolute()}"]
    try:
        run = subprocess.run(command, capture_output=True, timeout=SECONDS) if _ffprobe() else None
        return json.loads(run.stdout) if run else {}
    except (subprocess.TimeoutExpired, ValueError):
        return {}


@cache
def _ffprobe() -> str:
    return shutil.which("ffprobe") or ""
