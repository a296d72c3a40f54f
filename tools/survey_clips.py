"""Render every film of a folder in the given styles, and compare each result with its source.

    python tools/survey_clips.py FOLDER [--style plain ...]

Each row has the number of frames, the maximum difference of timestamps in ms, the difference of the end in
ms, the size, and for each copied sound track whether its packets are identical.
"""

from __future__ import annotations

import argparse
import hashlib
import logging
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import av

from vidstyle.errors import VidstyleError
from vidstyle.pipeline.render import render
from vidstyle.style import style_names


@dataclass(frozen=True)
class FileFacts:
    """Properties of a file that a player shows."""

    times: list[float]
    end: float
    size: tuple[int, int]
    rotation: int
    sound: list[tuple[int, str, float]]


def read_facts(path: Path, stream: int | None = None) -> FileFacts:
    """Decode the pictures of the longest (or given) video stream and read all sound packets."""
    with av.open(str(path)) as container:
        videos = [each for each in container.streams.video if not each.disposition.value & 0x400]
        video = max(videos, key=lambda each: each.frames or (each.duration or 0))
        times, end, rotation = [], 0.0, 0
        digests = {each.index: hashlib.sha256() for each in container.streams.audio}
        firsts: dict[int, float] = {}
        counts = dict.fromkeys(digests, 0)
        for packet in container.demux(video, *container.streams.audio):
            if packet.stream.type == "audio":
                if packet.size:
                    digests[packet.stream.index].update(bytes(packet))
                    counts[packet.stream.index] += 1
                    firsts.setdefault(packet.stream.index, float((packet.pts or 0) * packet.time_base))
                continue
            try:
                frames = video.decode(packet)
            except av.error.FFmpegError:
                continue
            for frame in frames:
                assert frame.pts is not None and frame.time_base is not None
                times.append(float(frame.pts * frame.time_base))
                rotation = frame.rotation
                end = times[-1] + float((frame.duration or 0) * frame.time_base)
        sound = [(counts[key], digests[key].hexdigest(), firsts.get(key, 0.0)) for key in digests]
        return FileFacts(times, end, (video.width, video.height), rotation, sound)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--style", action="append", choices=style_names())
    parser.add_argument("--container", default=".mp4")
    options = parser.parse_args()
    logging.getLogger("vidstyle").setLevel(logging.ERROR)
    print("| clip | style | frames in/out | pts differ ms | end differs ms | size | sound | s |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted(options.folder.iterdir()):
            source = read_facts(path)
            for style in options.style or style_names():
                target = Path(folder) / f"out{options.container}"
                began = time.perf_counter()
                try:
                    render(path, target, style)
                except VidstyleError as error:
                    print(f"| {path.name} | {style} | {error} |")
                    continue
                elapsed = time.perf_counter() - began
                print(
                    f"| {path.name} | {style} | {_compare(source, read_facts(target))} | {elapsed:.1f} |",
                    flush=True,
                )
                target.unlink()


def _compare(source: FileFacts, result: FileFacts) -> str:
    differ = max((abs(a - b) for a, b in zip(source.times, result.times, strict=False)), default=0.0)
    upright = source.size[::-1] if source.rotation % 180 else source.size
    size = "x".join(map(str, result.size)) + ("" if result.size == upright else f" (not {upright})")
    pairs = zip(source.sound, result.sound, strict=False)
    sound = [
        "same" if mine[:2] == theirs[:2] else f"{theirs[0]} packets for {mine[0]}" for mine, theirs in pairs
    ]
    if len(source.sound) != len(result.sound):
        sound.append(f"{len(result.sound)} tracks for {len(source.sound)}")
    return (
        f"{len(source.times)}/{len(result.times)} | {differ * 1000:.2f} "
        f"| {abs(source.end - result.end) * 1000:.1f} | {size}{' turned' if result.rotation else ''} "
        f"| {', '.join(sound) or 'none'}"
    )


if __name__ == "__main__":
    main()
