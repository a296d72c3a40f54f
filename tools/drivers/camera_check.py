"""Tries `vidstyle live` on real Video4Linux drivers: `python tools/drivers/camera_check.py`, as root.

It needs the kernel's test camera (`modprobe vivid n_devs=1 node_types=0x1`), a virtual one
(`modprobe v4l2loopback video_nr=9`) and a card that hears what it plays
(`modprobe snd-aloop pcm_substreams=2`). Where this machine has none, --runner names a command that runs its
last argument on one that has, with the same files, such as a script that boots a virtual machine:

    python tools/drivers/camera_check.py --runner 'bash boot.sh'
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
from live_program import CHROMA, DARK, Flashing, columns, finished, sized, started, wait_for_picture
from microphone_check import Microphones

ROOT = Path(__file__).resolve().parents[2]
DRIVER = Path("/sys/bus/platform/drivers/vivid")
PASSED = "all that was tried went well"
BACK_SECONDS = 3.0
"""How soon after its return a camera is to be seen again."""


def main() -> None:
    """Try everything here, or where the runner leads."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runner", help="a command that runs its last argument where the drivers are")
    parser.add_argument("--only", default="", help="the trials whose names have this in them")
    parser.add_argument("--camera", default="/dev/video0")
    parser.add_argument("--virtual", default="/dev/video9")
    arguments = parser.parse_args()
    if arguments.runner:
        sys.exit(run_elsewhere(arguments))
    failed = 0
    for trials in (Cameras(arguments.camera, arguments.virtual), Microphones(arguments.virtual)):
        failed += sum(not attempt(trial) for trial in trials.all() if arguments.only in trial.__qualname__)
    print(PASSED if not failed else f"{failed} trials failed", flush=True)
    sys.exit(failed > 0)


def run_elsewhere(arguments: argparse.Namespace) -> bool:
    """Whether it failed there; the runner need not pass exit codes on."""
    names = ("only", "camera", "virtual")
    options = shlex.join(f"--{name}={getattr(arguments, name)}" for name in names)
    here = f"cd {ROOT} && {shlex.quote(sys.executable)} tools/drivers/camera_check.py {options}"
    run = subprocess.run([*shlex.split(arguments.runner), here], stdout=subprocess.PIPE, text=True)
    print(run.stdout)
    return PASSED not in run.stdout


def attempt(trial: Callable[[], str]) -> bool:
    """Run one, and say how it went."""
    began = time.monotonic()
    try:
        found, mark = trial(), "ok  "
    except (AssertionError, subprocess.TimeoutExpired, av.FFmpegError, OSError) as error:
        found, mark = f"{type(error).__name__}: {error}", "FAIL"
    print(f"{mark} {trial.__qualname__} ({time.monotonic() - began:.0f} s): {found}", flush=True)
    return mark != "FAIL"


class Cameras:
    """The trials; each returns what it found, and fails by an assertion."""

    def __init__(self, camera: str, virtual: str) -> None:
        self.camera, self.virtual = camera, virtual

    def all(self) -> tuple[Callable[[], str], ...]:
        """In their order."""
        return (
            self.lists,
            self.missing,
            self.colors,
            self.latency,
            self.busy,
            self.unplugged,
            self.silent,
            self.compressed,
        )

    def lists(self) -> str:
        """Devices and modes."""
        run = finished("--list", "--json")
        assert run.returncode == 0, run.stderr
        found = {each["path"]: each for each in json.loads(run.stdout)}
        camera, virtual = found[self.camera], found[self.virtual]
        assert camera["gives"] and virtual["takes"], found
        assert any(mode["format"] == "yuyv422" and mode["fps"] for mode in camera["modes"]), camera
        return f"{camera['name']} with {len(camera['modes'])} modes, {virtual['name']} is an output device"

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
            program.expect("the last frame is repeated")
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

    def silent(self) -> str:
        """A camera whose driver says nothing: a virtual one that nobody writes to, until somebody does."""
        writer = Flashing(self.virtual)
        with (
            tempfile.TemporaryDirectory() as folder,
            started(
                self.virtual, "--style", "plain", "--to", str(film := Path(folder, "film.mkv"))
            ) as program,
        ):
            program.expect_file(film)
            writer.end()
            program.expect("the last frame is repeated")
            time.sleep(3)
            writer = Flashing(self.virtual)
            program.expect("back after")
            seconds = time.monotonic() - writer.began
        writer.end()
        assert seconds < BACK_SECONDS, f"back only {seconds:.1f} s after its return"
        return f"held while it is silent, back {seconds:.1f} s after its return"

    def compressed(self) -> str:
        """A camera that gives JPEG pictures: a virtual one into which they are written; colours are right."""
        writer = Flashing(self.virtual, "mjpeg")
        with tempfile.TemporaryDirectory() as folder:
            film = str(Path(folder, "film.mkv"))
            run = finished(
                self.virtual, "--input-format", "mjpeg", "--style", "plain", "--to", film, "--frames", "8"
            )
            assert run.returncode == 0, run.stderr
            with av.open(film) as container:
                seen = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)][-1]
        writer.end()
        blue, red = (code - 128 for code in CHROMA)
        wanted = DARK + np.array([1.402 * red, -0.344 * blue - 0.714 * red, 1.772 * blue])
        worst = float(np.abs(seen.reshape(-1, 3).mean(axis=0) - wanted.clip(0, 255)).max())
        assert worst < 6, f"colours differ by {worst:.1f} of 255"
        return f"colours differ by {worst:.1f} of 255 at most"


if __name__ == "__main__":
    main()
