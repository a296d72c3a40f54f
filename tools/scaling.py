"""Measure how rendering scales with cores, and predict its speed on more cores.

    python tools/scaling.py CLIP --styles plain ink comic oil > scaling.md
    python -m tools.performance scaling.md

Each number of cores is measured in a separate process with that CPU affinity, after a warm-up. The time of
the first quarter of the film is subtracted from the time of the film, so that opening and closing cancel out.
*Used* is processor time divided by wall-clock time. *Others* are cores used by other programs; of several
runs, the one with the fewest counts. *Busy* is the utilization of each core. *Switches* are voluntary and
involuntary context switches per frame.

*Predicted* simulates virtual cores with the processor times of all tasks, measured on one core. These times
are multiplied by the slowdown: the processor time of the film on all measured cores, divided by that on one.
On all measured cores, the prediction thus tests only when threads wait. A thread that waits for the GIL
continues after the time that this machine needs to wake a thread on another core. Films use large bands from
three cores on, a process for writing and faces from four on, and processes for restyling from eight on.
Compare predictions with the measured rows before you trust the virtual ones. Styles without steps have no
tasks to simulate. *Bound by* is the part whose removal speeds up the simulation most, with the new speed.

The last table has the processor time of a frame of 1920x1080, its part outside kernels, which is an upper
bound of the time with the GIL, and the minimum number of virtual cores for 30 and 60 frames per second. Needs
Linux.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # when run as a script

from tools.replay.film import Machine, predict_seconds  # noqa: E402
from tools.replay.film_job import FilmJob, FilmTimes, measure_film, record_film, short_frames  # noqa: E402
from tools.replay.machine import slowdown, wake_up_seconds  # noqa: E402
from tools.replay.record import Recording  # noqa: E402
from vidstyle.core.bands import MAX_SMALL_BAND_THREADS  # noqa: E402
from vidstyle.cpu.style_processes import MIN_PROCESS_THREADS  # noqa: E402

STYLES = ("plain", "ink", "comic", "impressionist", "oil", "watercolor")
VIRTUAL_CORE_COUNTS = (4, 8, 16, 32)
FULL_HD_SIZE, TARGET_RATES, MAX_CORES = (1920, 1080), (30, 60), 128
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
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)  # for the measuring processes
    cores = sorted(os.sched_getaffinity(0))
    wake_up = wake_up_seconds(cores)
    print(_row(COLUMNS), _row(["---", *["---:"] * (len(COLUMNS) - 1)]), sep="\n")
    for style in arguments.styles:
        _print_speeds(FilmJob(arguments.clip, style, arguments.frames, cores), arguments.rounds, wake_up)
    _print_needs(arguments, cores, wake_up)


def _print_speeds(job: FilmJob, rounds: int, wake_up: float) -> None:
    """Print the rows of a style, one for each number of cores."""
    numbers = sorted({*(2**n for n in range(8) if 2**n <= len(job.cores)), len(job.cores)})
    record = record_film(job, rounds)
    large = record_film(replace(job, large_bands=True), rounds)
    jobs = [FilmJob(job.clip, job.style, job.frames, job.cores[:number]) for number in numbers]
    runs = [[measure_film(each) for each in jobs] for _ in range(rounds)]
    machine, alone = Machine(slowdown(*_first_and_last(runs)), wake_up), 0.0
    for place, number in enumerate(numbers):
        run = min((each[place] for each in runs), key=lambda run: run.others)
        alone = alone or run.seconds
        speed = run.frames / run.seconds
        busy = " ".join(f"{100 * each / run.seconds:.0f}" for each in run.busy)
        cells: tuple[str, ...] = (f"{run.seconds:.2f}", f"{speed:.1f}", f"{alone / run.seconds:.2f}",
                 f"{run.processor / run.seconds:.2f}", f"{run.others:.2f}", busy,
                 f"{run.voluntary / run.frames:.0f}, {run.involuntary / run.frames:.0f}")  # fmt: skip
        if record.finished:
            predicted = frames_per_second(_recording_for(number, record, large), number, machine)
            cells += f"{predicted:.1f}", f"{100 * (predicted / speed - 1):+.0f}"
        print(_row([job.style, number, *cells, *[""] * (len(COLUMNS) - 2 - len(cells))]), flush=True)
    if not record.finished:
        return
    single = frames_per_second(record, 1, machine)
    for number in VIRTUAL_CORE_COUNTS:
        shown = _recording_for(number, record, large)
        speed = frames_per_second(shown, number, machine)
        cells = (
            "",
            "",
            f"{speed / single:.1f}",
            *[""] * 4,
            f"{speed:.0f}",
            "",
            find_bound(shown, number, machine),
        )
        print(_row([job.style, f"{number} virtual", *cells]))


def _first_and_last(runs: Sequence[Sequence[FilmTimes]]) -> tuple[list[FilmTimes], list[FilmTimes]]:
    """Return the measurements on one core and those on all cores."""
    return [each[0] for each in runs], [each[-1] for each in runs]


def _recording_for(cores: int, small: Recording, large: Recording) -> Recording:
    """Return the recording with the band size that films use on these cores."""
    return large if MAX_SMALL_BAND_THREADS < cores < MIN_PROCESS_THREADS else small


def frames_per_second(record: Recording, cores: int, machine: Machine) -> float:
    """Return the predicted rate of a film, measured as for a real film."""
    frames = len(record.reading)
    few = short_frames(frames)
    seconds = predict_seconds(record, cores, machine) - predict_seconds(record, cores, machine, few)
    return (frames - few) / seconds


def find_bound(record: Recording, cores: int, machine: Machine) -> str:
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
    heads = [f"cores for {FULL_HD_SIZE[1]}p{rate}" for rate in TARGET_RATES]
    print("", _row(["style", "ms", "of it Python", *heads]), _row(["---", *["---:"] * 4]), sep="\n")
    for style in arguments.styles:
        job = FilmJob(arguments.clip, style, max(arguments.frames // 2, 24), cores, FULL_HD_SIZE)
        record = record_film(job, 1)
        if not record.finished:
            continue
        frames = len(record.reading)
        parts = [f"{1000 * each / frames:.1f}" for each in (record.seconds, record.python_seconds)]
        runs = [[measure_film(replace(job, cores=cores[:each])) for each in sorted({1, len(cores)})]]
        machine = Machine(slowdown(*_first_and_last(runs)), wake_up)
        print(_row([style, *parts, *(min_cores(record, rate, machine) for rate in TARGET_RATES)]), flush=True)


def min_cores(record: Recording, rate: float, machine: Machine) -> str:
    """Return the minimum number of cores for this number of frames per second."""
    for number in range(1, MAX_CORES + 1):
        if frames_per_second(record, number, machine) >= rate:
            return str(number)
    return f"over {MAX_CORES}"


def _row(cells: Sequence[object]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


if __name__ == "__main__":
    main()
