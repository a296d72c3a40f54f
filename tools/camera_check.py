"""Tries `vidstyle live` on real Video4Linux drivers: `python tools/camera_check.py`, as root.

It needs the kernel's test camera (`modprobe vivid n_devs=1 node_types=0x1`) and a virtual one
(`modprobe v4l2loopback video_nr=9`). Where this machine has neither, --runner names a command that runs its
last argument on one that has, with the same files, such as a script that boots a virtual machine:

    python tools/camera_check.py --runner 'bash boot.sh'
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import av
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
DRIVER = Path("/sys/bus/platform/drivers/vivid")
PASSED = "all that was tried went well"
LONG = 120.0
"""Seconds that anything may take: an emulated machine is slow."""
BACK_SECONDS = 3.0
"""How soon after its return a camera is to be seen again."""
SIZE = (320, 180)


def main() -> None:
    """Try everything here, or where the runner leads."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runner", help="a command that runs its last argument where the drivers are")
    parser.add_argument("--camera", default="/dev/video0")
    parser.add_argument("--virtual", default="/dev/video9")
    arguments = parser.parse_args()
    if arguments.runner:
        sys.exit(run_elsewhere(arguments.runner, arguments.camera, arguments.virtual))
    check = Check(arguments.camera, arguments.virtual)
    for trial in (check.lists, check.missing, check.colors, check.latency, check.busy, check.unplugged):
        check.attempt(trial)
    print(PASSED if not check.failed else f"{check.failed} trials failed", flush=True)
    sys.exit(check.failed > 0)


def run_elsewhere(runner: str, camera: str, virtual: str) -> bool:
    """Whether it failed there; the runner need not pass exit codes on."""
    python = shlex.quote(sys.executable)
    here = f"cd {ROOT} && {python} tools/camera_check.py --camera {camera} --virtual {virtual}"
    run = subprocess.run([*shlex.split(runner), here], stdout=subprocess.PIPE, text=True)
    print(run.stdout)
    return PASSED not in run.stdout


class Check:
    """The trials; each returns what it found, and fails by an assertion."""

    def __init__(self, camera: str, virtual: str) -> None:
        self.camera, self.virtual = camera, virtual
        self.failed = 0

    def attempt(self, trial: Callable[[], str]) -> None:
        """Run one and say how it went."""
        began = time.monotonic()
        try:
            found, mark = trial(), "ok  "
        except (AssertionError, subprocess.TimeoutExpired, av.FFmpegError, OSError) as error:
            found, mark = f"{type(error).__name__}: {error}", "FAIL"
            self.failed += 1
        print(f"{mark} {trial.__name__} ({time.monotonic() - began:.0f} s): {found}", flush=True)

    def lists(self) -> str:
        """Devices and modes."""
        run = finished("--list", "--json")
        assert run.returncode == 0, run.stderr
        found = {each["path"]: each for each in json.loads(run.stdout)}
        camera, virtual = found[self.camera], found[self.virtual]
        assert camera["gives"] and virtual["takes"], found
        assert any(mode["format"] == "yuyv422" and mode["fps"] for mode in camera["modes"]), camera
        return f"{camera['name']} with {len(camera['modes'])} modes, {virtual['name']} takes pictures"

    def missing(self) -> str:
        """A camera that is not there."""
        run = finished("/dev/video77", "--to", "null")
        assert run.returncode == 6 and self.camera in run.stderr and len(run.stderr.splitlines()) == 1, (
            run.stderr
        )
        return run.stderr.strip()

    def colors(self) -> str:
        """What is read back from the virtual camera, in each of its formats, has the camera's own colours."""
        wanted = columns(self.camera)
        worst = 0.0
        for pix_fmt in ("yuyv422", "nv12", "i420"):
            with started(
                self.camera, "--style", "plain", "--to", self.virtual, "--pix-fmt", pix_fmt
            ) as program:
                wait_for_picture(self.virtual, program)
                worst = max(worst, float(np.abs(columns(self.virtual) - wanted).max()))
        assert worst < 6, f"colours differ by {worst:.1f} of 255"
        return f"colours differ by {worst:.1f} of 255 at most"

    def latency(self) -> str:
        """A light style; what it counts."""
        run = finished(self.camera, "--style", "plain", "--to", "null", "--frames", "40", "--json", *sized())
        assert run.returncode == 0, run.stderr
        told = json.loads(run.stdout)
        assert told["frames"] == 40 and 0 < told["latency_ms"]["median"] < 1000, told
        return f"{told['fps']} fps, {told['dropped']} dropped, latency {told['latency_ms']}"

    def busy(self) -> str:
        """A camera that another program has."""
        with started(self.camera, "--style", "plain", "--to", self.virtual) as program:
            wait_for_picture(self.virtual, program)
            run = finished(self.camera, "--to", "null", *sized())
        assert run.returncode == 6 and "in use by another program" in run.stderr, run.stderr
        assert len(run.stderr.splitlines()) == 1, run.stderr
        return run.stderr.strip()

    def unplugged(self) -> str:
        """The driver is unbound and bound again: the virtual camera stays, and the picture comes back."""
        device = next(path.name for path in DRIVER.glob("vivid.*"))
        with started(self.camera, "--style", "plain", "--to", self.virtual) as program:
            wait_for_picture(self.virtual, program)
            (DRIVER / "unbind").write_text(device)
            program.expect("the last picture is held")
            held = columns(self.virtual)
            assert held.std() > 10, "the virtual camera shows nothing"
            time.sleep(2)
            (DRIVER / "bind").write_text(device)
            bound = time.monotonic()
            program.expect("back after")
            seconds = time.monotonic() - bound
            again = columns(self.virtual)
        assert np.abs(held - again).max() < 30, "the picture that came back is another"
        assert seconds < BACK_SECONDS, f"back only {seconds:.1f} s after its return"
        return f"held while away, back {seconds:.1f} s after its return"


class Program:
    """`vidstyle live` while it runs."""

    def __init__(self, *arguments: str) -> None:
        self._process = subprocess.Popen(command(*arguments), stderr=subprocess.PIPE, text=True)
        self.lines: list[str] = []
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self.lines.append(line.strip())

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self._process.poll() is not None

    def expect(self, words: str) -> None:
        """Wait until it says so."""
        deadline = time.monotonic() + LONG
        while not any(words in line for line in self.lines):
            assert time.monotonic() < deadline and not self.over, f"{words!r} was not said: {self.lines}"
            time.sleep(0.02)

    def end(self) -> None:
        """Stop it."""
        self._process.terminate()
        self._process.wait(LONG)
        self._thread.join(LONG)


@contextmanager
def started(*arguments: str) -> Iterator[Program]:
    """The program while it runs."""
    program = Program(*arguments, *sized())
    try:
        yield program
    finally:
        program.end()


def finished(*arguments: str) -> subprocess.CompletedProcess[str]:
    """A run of the program that ends by itself."""
    return subprocess.run(command(*arguments), capture_output=True, text=True, timeout=LONG)


def command(*arguments: str) -> list[str]:
    """What starts it."""
    return [sys.executable, "-m", "vidstyle", "live", *arguments, "--no-keys", "--device", "cpu"]


def sized() -> list[str]:
    """Small pictures, for machines that emulate a processor."""
    return ["--size", "{}x{}".format(*SIZE), "--fps", "10"]


def wait_for_picture(path: str, program: Program) -> None:
    """Wait until a virtual camera shows something."""
    deadline = time.monotonic() + LONG
    while True:
        assert time.monotonic() < deadline and not program.over, f"nothing is written: {program.lines}"
        try:
            columns(path)
            return
        except (av.FFmpegError, OSError):
            time.sleep(0.3)


def columns(path: str) -> np.ndarray:
    """The mean colour of the columns of a camera's picture, away from the text on it: N x 3, 0..255."""
    with av.open(path, format="v4l2", options={"video_size": "{}x{}".format(*SIZE)}) as container:
        frames = container.decode(video=0)
        for _ in range(3):
            frame = next(frames)
        picture = frame.to_ndarray(format="rgb24", src_colorspace="ITU601").astype(float)
    lower = picture[picture.shape[0] * 2 // 3 :]
    middle = [lower[:, int(place * lower.shape[1])] for place in (np.arange(8) + 0.5) / 8]
    return np.array([np.median(column, axis=0) for column in middle])


if __name__ == "__main__":
    main()
