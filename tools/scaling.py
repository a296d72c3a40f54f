"""Measures how a film scales with cores, and predicts its time on more cores.

    python tools/scaling.py CLIP --styles plain ink comic oil > scaling.md
    python -m tools.performance scaling.md

Each number of cores is measured in a process of its own with that CPU affinity, after a short film has
loaded all that is needed: as the difference of a film and its first quarter, so that opening and closing
cancel. *Used* is processor time divided by time. *Others* are cores that other programs used meanwhile: of
several runs, the one with the least counts. *Busy* is the share of the time in which each core had work.
*Switches* are voluntary and involuntary context switches per frame.

*Predicted* is the replay: the processor times of all tasks, measured on one core, on virtual cores. They are
longer by the factor by which tasks take longer while all measured cores have the same tasks. A thread that
waits for Python's lock continues after the time that this machine needs to wake a thread on another core.
From three cores on, bands are large; from four on, a process takes writing off; from eight on, pictures are
restyled in processes, too. Compare it with the measured rows before you believe the virtual ones. Styles
without steps have no tasks to replay. *Bound by* is the part without which the replay gains most frames per
second, and their number then.

The last table has the processor time of a frame of 1920x1080, the part outside kernels, which is at most the
time with Python's lock, and the fewest virtual cores for 30 and 60 frames a second. Needs Linux.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # also if it is run as a file

from tools.replay.film import Machine, predicted_seconds  # noqa: E402
from tools.replay.film_job import FilmJob, film_times, recorded, short_frames  # noqa: E402
from tools.replay.machine import wake_up_seconds  # noqa: E402
from tools.replay.record import Recording  # noqa: E402
from vidstyle.core.bands import MAX_SMALL_BAND_THREADS  # noqa: E402
from vidstyle.cpu.style_processes import MIN_PROCESS_THREADS  # noqa: E402

STYLES = ("plain", "ink", "comic", "impressionist", "oil", "watercolor")
VIRTUAL_CORES = (4, 8, 16, 32)
HD, RATES, MAX_CORES = (1920, 1080), (30, 60), 128
COLUMNS = (
    *("style", "cores", "s", "frames/s", "speed-up", "used", "others", "busy, %", "switches"),
    *("predicted frames/s", "off, %", "bound by"),
)


def main() -> None:
    """Measure and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clip")
    parser.add_argument("--styles", nargs="+", default=STYLES)
    parser.add_argument("--frames", type=int, default=144)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)  # for processes that measure a film
    cores = sorted(os.sched_getaffinity(0))
    wake_up = wake_up_seconds(cores)
    print(_row(COLUMNS), _row(["---", *["---:"] * (len(COLUMNS) - 1)]), sep="\n")
    for style in arguments.styles:
        _print_speeds(FilmJob(arguments.clip, style, arguments.frames, cores), arguments.rounds, wake_up)
    _print_needs(arguments, cores, wake_up)


def _print_speeds(job: FilmJob, rounds: int, wake_up: float) -> None:
    """Print the rows of a style, all numbers of cores in turn."""
    numbers = sorted({*(2**n for n in range(8) if 2**n <= len(job.cores)), len(job.cores)})
    record, slowdown = recorded(job, rounds)
    large, _ = recorded(replace(job, cores=job.cores[:1], large_bands=True), rounds)
    jobs = [FilmJob(job.clip, job.style, job.frames, job.cores[:number]) for number in numbers]
    runs = [[film_times(each) for each in jobs] for _ in range(rounds)]
    machine, alone = Machine(slowdown, wake_up), 0.0
    for place, number in enumerate(numbers):
        run = min((each[place] for each in runs), key=lambda run: run.others)
        alone = alone or run.seconds
        speed = run.frames / run.seconds
        busy = " ".join(f"{100 * each / run.seconds:.0f}" for each in run.busy)
        cells = (f"{run.seconds:.2f}", f"{speed:.1f}", f"{alone / run.seconds:.2f}",
                 f"{run.processor / run.seconds:.2f}", f"{run.others:.2f}", busy,
                 f"{run.voluntary / run.frames:.0f}, {run.involuntary / run.frames:.0f}")  # fmt: skip
        if record.finished:
            predicted = frames_per_second(_recording_for(number, record, large), number, machine)
            cells += f"{predicted:.1f}", f"{100 * (predicted / speed - 1):+.0f}"
        print(_row([job.style, number, *cells, *[""] * (len(COLUMNS) - 2 - len(cells))]), flush=True)
    if not record.finished:
        return
    single = frames_per_second(record, 1, machine)
    for number in VIRTUAL_CORES:
        shown = _recording_for(number, record, large)
        speed = frames_per_second(shown, number, machine)
        cells = (
            "",
            "",
            f"{speed / single:.1f}",
            *[""] * 4,
            f"{speed:.0f}",
            "",
            bound(shown, number, machine),
        )
        print(_row([job.style, f"{number} virtual", *cells]))


def _recording_for(cores: int, small: Recording, large: Recording) -> Recording:
    """Return the recording with the bands that a film has on these cores."""
    return large if MAX_SMALL_BAND_THREADS < cores < MIN_PROCESS_THREADS else small


def frames_per_second(record: Recording, cores: int, machine: Machine) -> float:
    """Return the predicted rate of a film, measured as for a real film."""
    frames = len(record.reading)
    few = short_frames(frames)
    seconds = predicted_seconds(record, cores, machine) - predicted_seconds(record, cores, machine, few)
    return (frames - few) / seconds


def bound(record: Recording, cores: int, machine: Machine) -> str:
    """Return which part of a film limits its rate on some cores, and the rate without it."""
    parts = {
        "Python's lock": (record.without("lock"), machine),
        "the time to pass on Python's lock": (record, replace(machine, wake_up_seconds=0)),
        "the order of frames": (record.without("order"), machine),
        "reading": (record.without("reading"), machine),
        "writing": (record.without("writing"), machine),
    }
    speeds = {name: frames_per_second(each, cores, on) for name, (each, on) in parts.items()}
    most = max(speeds, key=lambda name: speeds[name])
    return f"{most} ({speeds[most]:.0f} without)"


def _print_needs(arguments: argparse.Namespace, cores: Sequence[int], wake_up: float) -> None:
    heads = [f"cores for {HD[1]}p{rate}" for rate in RATES]
    print("", _row(["style", "ms", "of it Python", *heads]), _row(["---", *["---:"] * 4]), sep="\n")
    for style in arguments.styles:
        record, slowdown = recorded(
            FilmJob(arguments.clip, style, max(arguments.frames // 2, 24), cores, HD), 1
        )
        if not record.finished:
            continue
        frames = len(record.reading)
        parts = [f"{1000 * each / frames:.1f}" for each in (record.seconds, record.python_seconds)]
        machine = Machine(slowdown, wake_up)
        print(_row([style, *parts, *(cores_for(record, rate, machine) for rate in RATES)]), flush=True)


def cores_for(record: Recording, rate: float, machine: Machine) -> str:
    """Return the fewest cores with this number of frames per second, start excluded."""
    for number in range(1, MAX_CORES + 1):
        if frames_per_second(record, number, machine) >= rate:
            return str(number)
    return f"over {MAX_CORES}"


def _row(cells: Sequence[object]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


if __name__ == "__main__":
    main()
