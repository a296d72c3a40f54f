"""Precision and recall of the defects that the comic recognizes: damage, blur and dissolves.

    python tools/comic_defects.py FILM... --seed 41 --count 6

Makes short clips of the films with known defects (FFmpeg with libx264 is needed) and compares what the
analysis marks with the truth:

- damaged: bytes of an H.264 stream are changed; a frame is damaged if it differs from the undamaged one;
  every second clip is scaled and encoded again, so that no decoder reports anything;
- dissolve: parts of two films are joined by a cross-fade of known duration;
- blurred: intervals are blurred along one direction, or by averaging frames that move.

Frames with a doubtful truth (a faint difference, the ends of a cross-fade) are not counted. "any" is the
share of the frames with this defect that have any mark, and are never printed.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import tempfile
from bisect import bisect_left
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.film import FilmFile
from vidstyle.media.read.sampler import FilmSampler
from vidstyle.regions.faces import FaceFinder

_CLIP_SECONDS = 8.0
_CLIP_WIDTH, _CLIP_HEIGHT, _RECODED_WIDTH = 640, 360, 480
_ENCODING = ("-c:v", "libx264", "-preset", "ultrafast", "-crf", "20", "-g", "48", "-an")
_MIN_DIFFERENT_LEVELS, _MAX_SAME_SHARE, _MIN_DIFFERENT_SHARE = 24, 0.0005, 0.006
"""A pixel differs by these levels; with a share between the other two a frame is not counted."""
_BLUR_INTERVAL_SECONDS = 1.2
_MATCH_SECONDS = 0.012

Truth = Callable[[float], bool | None]
"""Whether the frame at a time in seconds has the defect; None if that is doubtful."""
MARKS: dict[str, Callable[[Candidate], bool]] = {
    "damaged": lambda each: each.damaged,
    "blurred": lambda each: each.blurred,
    "dissolve": lambda each: each.in_transition,
}


class Clip(NamedTuple):
    """A clip with one kind of defect."""

    path: Path
    defect: str
    truth: Truth


def main() -> None:
    """Make clips, analyse them and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("films", nargs="+", type=Path)
    parser.add_argument("--seed", type=int, default=41)
    parser.add_argument("--count", type=int, default=2, help="clips of each kind")
    parser.add_argument("--kinds", nargs="+", choices=MARKS, default=list(MARKS))
    parser.add_argument("--keep", type=Path, help="folder for the clips; those already there are used")
    parser.add_argument("--list", action="store_true", help="list the frames that are wrong")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        clips = list(_clips(options.films, folder, random.Random(options.seed), options.count))
        _report([clip for clip in clips if clip.defect in options.kinds], options.list)


def _clips(films: Sequence[Path], folder: Path, chance: random.Random, count: int) -> list[Clip]:
    made = []
    for number in range(count):
        made.append(_damaged(chance.choice(films), folder / f"damaged{number}", chance, number % 2 == 1))
        made.append(_dissolved(chance.sample(films, 2), folder / f"dissolve{number}.mp4", chance))
        made.append(_blurred(chance.choice(films), folder / f"blurred{number}", chance, number % 2 == 1))
    return made


def _damaged(film: Path, stem: Path, chance: random.Random, is_recoded: bool) -> Clip:
    clean, broken = stem.with_name(stem.name + "-clean.ts"), stem.with_suffix(".ts")
    _encode(film, clean, _start(film, chance), _fit())
    content = bytearray(clean.read_bytes())
    for _ in range(16):
        place = chance.randrange(len(content) // 8, len(content) * 9 // 10)
        for offset in range(chance.randrange(4, 60)):
            content[place + offset] = chance.randrange(256)
    broken.write_bytes(content)
    if is_recoded:
        scaled = f"scale={_RECODED_WIDTH}:-2"
        copies = [path.with_suffix(".mp4") for path in (clean, broken)]
        for source, copy in zip((clean, broken), copies, strict=True):
            _ffmpeg("-i", source, "-vf", scaled, "-fps_mode", "passthrough", *_ENCODING, copy)
        clean, broken = copies
    return Clip(broken, "damaged", _truth_by_difference(clean, broken))


def _truth_by_difference(clean: Path, broken: Path) -> Truth:
    shares = dict[float, float]()
    usual = dict(_lumas(clean))
    times = sorted(usual)
    for time, luma in _lumas(broken):
        near = min(times[max(0, bisect_left(times, time) - 1) :][:2], key=lambda each: abs(each - time))
        if abs(near - time) <= _MATCH_SECONDS and usual[near].shape == luma.shape:
            change = cv2.absdiff(usual[near], luma)
            shares[time] = float(np.mean(change > _MIN_DIFFERENT_LEVELS))

    def is_different(time: float) -> bool | None:
        share = shares.get(time)
        if share is None or _MAX_SAME_SHARE <= share < _MIN_DIFFERENT_SHARE:
            return None
        return share >= _MIN_DIFFERENT_SHARE

    return is_different


def _lumas(path: Path) -> list[tuple[float, np.ndarray]]:
    with FilmSampler(path) as sampler:
        return [
            (float(each.time), cv2.GaussianBlur(each.stored_luma(), (0, 0), 1.5)) for each in sampler.frames()
        ]


def _dissolved(films: Sequence[Path], path: Path, chance: random.Random) -> Clip:
    parts = [path.with_name(f"{path.stem}-{number}.mp4") for number in range(2)]
    for film, part in zip(films, parts, strict=True):
        _encode(film, part, _start(film, chance), f"{_fit()},trim=duration={chance.uniform(2.5, 4):.3f}")
    duration = chance.choice([0.5, 0.8, 1.2, 1.6])
    with FilmSampler(parts[0]) as sampler:
        first = float(sampler.seconds) - duration - 0.1
    mixed = f"[0:v]settb=1/24[a];[1:v]settb=1/24[b];[a][b]xfade=duration={duration}:offset={first:.3f}"
    _ffmpeg("-i", parts[0], "-i", parts[1], "-filter_complex", mixed, *_ENCODING, path)

    def is_mixed(time: float) -> bool | None:
        share = (time - first) / duration
        if 0.12 <= share <= 0.88:
            return True
        return False if share < -0.1 or share > 1.1 else None

    return Clip(path, "dissolve", is_mixed)


def _blurred(film: Path, stem: Path, chance: random.Random, is_averaged: bool) -> Clip:
    phase, clean, path = chance.random(), stem.with_name(stem.name + "-clean.mp4"), stem.with_suffix(".mp4")
    enabled = f"lt(mod(t/{_BLUR_INTERVAL_SECONDS}+{phase:.3f},1),0.4)"
    start, angle = _start(film, chance), chance.randrange(180)
    change = "tmix=frames=8" if is_averaged else f"dblur=angle={angle}:radius={chance.choice([8, 12, 18])}"
    _encode(film, clean, start, _fit())
    _encode(film, path, start, f"{_fit()},{change}:enable='{enabled}'")
    differs = _truth_by_difference(clean, path)

    def is_blurred(time: float) -> bool | None:
        share = (time / _BLUR_INTERVAL_SECONDS + phase) % 1
        # A still scene is not blurred by averaging.
        return False if 0.45 < share < 0.95 else (differs(time) or None) if 0.05 < share < 0.35 else None

    return Clip(path, "blurred", is_blurred)


def _fit() -> str:
    return (
        f"fps=24,scale={_CLIP_WIDTH}:{_CLIP_HEIGHT}:force_original_aspect_ratio=increase,crop={_CLIP_WIDTH}:{_CLIP_HEIGHT},"
        "setsar=1,format=yuv420p"
    )


def _start(film: Path, chance: random.Random, seconds: float = _CLIP_SECONDS) -> float:
    with FilmSampler(film) as sampler:
        return chance.uniform(0, max(0.0, float(sampler.seconds) - seconds))


def _encode(film: Path, path: Path, start: float, filters: str) -> None:
    source = ("-ss", f"{start:.3f}", "-i", film, "-t", _CLIP_SECONDS)
    _ffmpeg(*source, "-map", "0:v:0", "-vf", filters, *_ENCODING, path)


def _ffmpeg(*words: object) -> None:
    path = Path(str(words[-1]))
    if not path.exists():
        subprocess.run(["ffmpeg", "-v", "fatal", "-y", *map(str, words)], check=True)


class _Judged(NamedTuple):
    """A frame with a known truth."""

    clip: Clip
    candidate: Candidate
    has_defect: bool


def _judge(clip: Clip) -> list[_Judged]:
    """Analyse a clip; return its frames, without those whose truth is doubtful."""
    with FilmFile(clip.path, FaceFinder(None)) as film:
        found = [(each, clip.truth(each.time)) for each in film.survey().candidates]
    return [_Judged(clip, each, truth) for each, truth in found if truth is not None]


def _report(clips: Sequence[Clip], is_listed: bool) -> None:
    judged = [each for clip in clips for each in _judge(clip)]
    print(f"{len(judged)} frames of {len(clips)} clips\n")
    print("| defect | frames | precision | recall | any |\n|---|--:|--:|--:|--:|")
    for defect, mark in MARKS.items():
        with_it = [each for each in judged if each.has_defect and each.clip.defect == defect]
        without = [each for each in judged if not each.has_defect]
        true = [each for each in with_it if mark(each.candidate)]
        false = [each for each in without if mark(each.candidate)]
        shares = (
            len(true) / max(1, len(true) + len(false)),
            len(true) / max(1, len(with_it)),
            sum(each.candidate.is_flawed for each in with_it) / max(1, len(with_it)),
        )
        print(f"| {defect} | {len(with_it)} | {' | '.join(f'{share:.2f}' for share in shares)} |")
        for each in [*false, *(each for each in with_it if each not in true)] if is_listed else ():
            kind = "missed" if each.has_defect else "false"
            print(f"{each.clip.path.name} {each.candidate.time:.2f} s: {kind}")


if __name__ == "__main__":
    main()
