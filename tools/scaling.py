"""Measures how a film scales with cores, and predicts its time on more cores.

    python tools/scaling.py CLIP --styles plain ink comic oil > scaling.md
    python -m tools.performance scaling.md

Each number of cores is measured in a process of its own with that CPU affinity, after a short film has
loaded all that is needed. *Used* is processor time divided by time. *Busy* is the share of the time in which
each core had work, also of other programs. *Switches* are voluntary and involuntary context switches per
frame. *Predicted* is the replay: the processor times of all tasks, measured on one core, on virtual cores.
It is within 10 % on one core, but 20 to 50 % too low on four: compare it with the measured rows before you
believe the virtual ones. Styles without steps have no tasks to replay.

The last table has the processor time of a frame of 1920x1080, the part outside kernels, which is at most the
time with Python's lock, and the fewest virtual cores for 30 and 60 frames a second. Needs Linux.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))  # also if it is run as a file

from tools.replay.film import predicted_seconds  # noqa: E402
from tools.replay.record import Recording, recording  # noqa: E402

STYLES = ("plain", "ink", "comic", "impressionist", "oil", "watercolor")
WARM_UP_FRAMES = 6
VIRTUAL_CORES = (8, 16, 32)
HD, RATES, MAX_CORES = (1920, 1080), (30, 60), 128
COLUMNS = ("style", "cores", "s", "frames/s", "speed-up", "used", "busy, %", "switches", "predicted, s")


def main() -> None:
    """Measure and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clip")
    parser.add_argument("--styles", nargs="+", default=STYLES)
    parser.add_argument("--frames", type=int, default=144)
    parser.add_argument("--rounds", type=int, default=3, help="the median of so many runs counts")
    parser.add_argument("--job", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.job:
        print(json.dumps(_run_job(arguments.clip, json.loads(arguments.job))))
        return
    cores = sorted(os.sched_getaffinity(0))
    numbers = sorted({*(2**n for n in range(8) if 2**n <= len(cores)), len(cores)})
    print(_row(COLUMNS), _row(["---", *["---:"] * (len(COLUMNS) - 1)]), sep="\n")
    for style in arguments.styles:
        _measure(arguments, style, [cores[:number] for number in numbers])
    _print_needs(arguments, cores[:1])


def _measure(arguments: argparse.Namespace, style: str, choices: Sequence[list[int]]) -> None:
    """Print the rows of a style, all numbers of cores in turn."""
    jobs = [{"style": style, "frames": arguments.frames, "cores": cores} for cores in choices]
    record = _recording(arguments.clip, jobs[0])
    rounds = [[_started(arguments.clip, job) for job in jobs] for _ in range(arguments.rounds)]
    alone = 0.0
    for place, cores in enumerate(choices):
        runs = sorted((each[place] for each in rounds), key=lambda run: run["seconds"])
        run, frames = runs[len(runs) // 2], arguments.frames
        alone = alone or run["seconds"]
        switches = f"{run['voluntary'] / frames:.0f}, {run['involuntary'] / frames:.0f}"
        cells = (f"{run['seconds']:.2f}", f"{frames / run['seconds']:.1f}", f"{alone / run['seconds']:.2f}",
                 f"{run['processor'] / run['seconds']:.2f}", " ".join(f"{each:.0f}" for each in run["busy"]),
                 switches, f"{predicted_seconds(record, len(cores)):.2f}")  # fmt: skip
        print(_row([style, len(cores), *cells]), flush=True)
    if not record.finished:
        return
    single = predicted_seconds(record, 1)
    for number in VIRTUAL_CORES:
        seconds = predicted_seconds(record, number)
        speed_up = f"{single / seconds:.1f}"
        frames_per_second = f"{len(record.finished) / seconds:.0f}"
        print(
            _row([style, f"{number} virtual", "", frames_per_second, speed_up, "", "", "", f"{seconds:.2f}"])
        )


def _print_needs(arguments: argparse.Namespace, core: list[int]) -> None:
    heads = [f"cores for {HD[1]}p{rate}" for rate in RATES]
    print("", _row(["style", "ms", "of it Python", *heads]), _row(["---", *["---:"] * 4]), sep="\n")
    for style in arguments.styles:
        job = {"style": style, "frames": max(arguments.frames // 2, 24), "cores": core, "size": HD}
        record = _recording(arguments.clip, job)
        if not record.finished:
            continue
        frames = len(record.reading)
        parts = [f"{1000 * each / frames:.1f}" for each in (record.seconds, record.python_seconds)]
        print(_row([style, *parts, *(cores_for(record, rate) for rate in RATES)]), flush=True)


def cores_for(record: Recording, rate: float) -> str:
    """Return the fewest cores with this number of frames per second, start excluded."""
    frames = len(record.reading)
    for number in range(1, MAX_CORES + 1):
        if frames / predicted_seconds(record, number) >= rate:
            return str(number)
    return f"over {MAX_CORES}"


def _recording(clip: str, job: dict[str, Any]) -> Recording:
    return Recording(**_started(clip, {**job, "record": True}))


def _started(clip: str, job: dict[str, Any]) -> dict[str, Any]:
    """Run a job in a process of its own."""
    command = [sys.executable, __file__, clip, "--job", json.dumps(job)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout.splitlines()[-1])  # type: ignore[no-any-return]


def _run_job(clip: str, job: dict[str, Any]) -> dict[str, Any]:
    """Render on some cores; return the times of the film, or of all its tasks."""
    os.sched_setaffinity(0, job["cores"])  # before the program counts them
    from vidstyle.media.options import ReadOptions, WriteOptions
    from vidstyle.pipeline.render import render

    read = ReadOptions(size=tuple(job["size"]) if "size" in job else None)
    with tempfile.TemporaryDirectory() as folder:

        def run(frames: int) -> None:
            write = WriteOptions(preset="veryfast", crf=20, overwrite=True)
            target = f"{folder}/out.mp4"
            render(clip, target, job["style"], read=read, write=write, device="cpu", frames=frames)

        if job.get("record"):
            with recording() as made:
                run(WARM_UP_FRAMES)
                made.clear()
                run(job["frames"])
            return vars(made)
        run(WARM_UP_FRAMES)
        return _timed(lambda: run(job["frames"]), job["cores"])


def _timed(run: Any, cores: list[int]) -> dict[str, Any]:
    import resource

    before, busy, began = resource.getrusage(resource.RUSAGE_SELF), _core_times(cores), time.perf_counter()
    run()
    seconds, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_SELF)
    shares = [
        100 * (1 - (idle - old_idle) / max(total - old_total, 1))
        for (total, idle), (old_total, old_idle) in zip(_core_times(cores), busy, strict=True)
    ]
    return {
        "seconds": seconds,
        "processor": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        "voluntary": after.ru_nvcsw - before.ru_nvcsw,
        "involuntary": after.ru_nivcsw - before.ru_nivcsw,
        "busy": shares,
    }


def _core_times(cores: Sequence[int]) -> list[tuple[int, int]]:
    """Return the whole time and the idle time of each core since the start of the machine."""
    lines = (line.split() for line in Path("/proc/stat").read_text(encoding="ascii").splitlines())
    times = {line[0]: [*map(int, line[1:9])] for line in lines if line and line[0].startswith("cpu")}
    return [(sum(times[f"cpu{core}"]), sum(times[f"cpu{core}"][3:5])) for core in cores]


def _row(cells: Sequence[object]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


if __name__ == "__main__":
    main()
