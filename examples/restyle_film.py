"""Restyles the first ten seconds of a film: python restyle_film.py in.mp4 out.mp4."""

import sys

import vidstyle

source, target = sys.argv[1:]
summary = vidstyle.render(
    source,
    target,
    "ink:blue",
    read=vidstyle.ReadOptions(end=10),
    write=vidstyle.WriteOptions(crf=20, overwrite=True),
    on_progress=lambda progress: print(f"{progress.frames} frames", end="\r", file=sys.stderr),
)
print(f"{summary.target}: {summary.frames} frames in {summary.elapsed:.1f} s")
