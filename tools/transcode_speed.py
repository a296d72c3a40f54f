"""How fast whole films are restyled: `python tools/transcode_speed.py FILM [--styles ink sketch]`.

Decoding, the style and encoding together, as `vidstyle render` does them. What it takes to begin is left
out: each figure is the difference between a long run and a short one.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from vidstyle.style import style_names


def main() -> None:
    """Print a table of frames a second for every style and every `steady`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("film", type=Path)
    parser.add_argument("--styles", nargs="+", default=style_names())
    parser.add_argument("--steady", nargs="+", type=float, default=[0, 0.5])
    parser.add_argument("--frames", nargs=2, type=int, default=[24, 120], metavar=("SHORT", "LONG"))
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--device", default="cpu")
    for line in table(parser.parse_args()):
        print(line, flush=True)


def table(options: argparse.Namespace) -> Iterator[str]:
    """The lines of the table, each as soon as it has been measured."""
    yield (
        "| style | "
        + " | ".join(f"fps, steady {steady:g}" for steady in options.steady)
        + " | the stage, ms |"
    )
    yield "|---|" + "---:|" * (len(options.steady) + 1)
    for style in options.styles:
        times = [seconds_per_frame(options, style, steady) for steady in options.steady]
        stage = f"{(times[-1] - times[0]) * 1e3:.1f}" if len(times) > 1 else "-"
        yield f"| {style} | " + " | ".join(f"{1 / each:.1f}" for each in times) + f" | {stage} |"


def seconds_per_frame(options: argparse.Namespace, style: str, steady: float) -> float:
    """The least of all repeats, so that what else the machine does counts little."""
    short, long = options.frames
    found = []
    for _ in range(options.repeats):
        spent = [elapsed(options, style, steady, frames) for frames in (short, long)]
        found.append((spent[1] - spent[0]) / (long - short))
    return max(min(found), 1e-6)


def elapsed(options: argparse.Namespace, style: str, steady: float, frames: int) -> float:
    """Seconds that a run in a program of its own says it has taken."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "vidstyle", "render", options.film, f"{folder}/out.mp4"]
        command += ["--style", style, "--steady", steady, "--frames", frames, "--device", options.device]
        words = [*map(str, command), "--audio", "none", "--progress", "none", "--json"]
        finished = subprocess.run(words, capture_output=True, text=True, check=False)
    if finished.returncode:
        sys.exit(finished.stderr.strip() or f"{style}: exit code {finished.returncode}")
    summary = json.loads(finished.stdout)
    if summary["frames"] < frames:
        sys.exit(
            f"{options.film}: has only {summary['frames']} frames; choose a longer film or fewer --frames"
        )
    return float(summary["elapsed"])


if __name__ == "__main__":
    main()
