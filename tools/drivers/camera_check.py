"""Test `vidstyle live` on real Video4Linux drivers: `python -m tools.drivers.camera_check`, as root.

It needs the kernel's test camera (`modprobe vivid n_devs=1 node_types=0x1`), a virtual one
(`modprobe v4l2loopback video_nr=9`) and a loopback sound card
(`modprobe snd-aloop pcm_substreams=2`). On machines without them, --runner gives a command that runs its last
argument where they are, with the same files, such as a script that boots a virtual machine:

    python -m tools.drivers.camera_check --runner 'bash boot.sh'
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

from tools.drivers.live_program import (
    CHROMA_LEVELS,
    DARK_LEVEL,
    FlashWriter,
    column_colors,
    run_live,
    run_to_end,
    size_options,
    wait_for_picture,
)
from tools.drivers.microphone_check import Microphones

ROOT = Path(__file__).resolve().parents[2]
DRIVER = Path("/sys/bus/platform/drivers/vivid")
ALL_PASSED = "all trials passed"
MAX_RECONNECT_SECONDS = 3.0
"""Maximum time from the return of a camera to its first picture."""


def main() -> None:
    """Run all trials here, or with the runner."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runner", help="a command that runs its last argument where the drivers are")
    parser.add_argument("--only", default="", help="run only trials whose names contain this text")
    parser.add_argument("--camera", default="/dev/video0")
    parser.add_argument("--virtual", default="/dev/video9")
    arguments = parser.parse_args()
    if arguments.runner:
        sys.exit(run_elsewhere(arguments))
    failed = 0
    for trials in (Cameras(arguments.camera, arguments.virtual), Microphones(arguments.virtual)):
        failed += sum(not run_trial(trial) for trial in trials.all() if arguments.only in trial.__qualname__)
    print(ALL_PASSED if not failed else f"{failed} trials failed", flush=True)
    sys.exit(failed > 0)


def run_elsewhere(arguments: argparse.Namespace) -> bool:
    """Run the trials with the runner, and return whether they failed; its exit code is ignored."""
    names = ("only", "camera", "virtual")
    options = shlex.join(f"--{name}={getattr(arguments, name)}" for name in names)
    here = f"cd {ROOT} && {shlex.quote(sys.executable)} -m tools.drivers.camera_check {options}"
    run = subprocess.run([*shlex.split(arguments.runner), here], stdout=subprocess.PIPE, text=True)
    print(run.stdout)
    return ALL_PASSED not in run.stdout


def run_trial(trial: Callable[[], str]) -> bool:
    """Run one trial, print its result, and return whether it passed."""
    began = time.monotonic()
    try:
        found, mark = trial(), "ok  "
    except (AssertionError, subprocess.TimeoutExpired, av.FFmpegError, OSError) as error:
        found, mark = f"{type(error).__name__}: {error}", "FAIL"
    print(f"{mark} {trial.__qualname__} ({time.monotonic() - began:.0f} s): {found}", flush=True)
    return mark != "FAIL"


class Cameras:
    """Trials of cameras; each returns a line about its result, and fails by an assertion."""

    def __init__(self, camera: str, virtual: str) -> None:
        self.camera, self.virtual = camera, virtual

    def all(self) -> tuple[Callable[[], str], ...]:
        """Return all trials in order."""
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
        """`--list` prints devices and modes."""
        run = run_to_end("--list", "--json")
        assert run.returncode == 0, run.stderr
        found = {each["path"]: each for each in json.loads(run.stdout)}
        camera, virtual = found[self.camera], found[self.virtual]
        assert camera["gives"] and virtual["takes"], found
        assert any(mode["format"] == "yuyv422" and mode["fps"] for mode in camera["modes"]), camera
        return f"{camera['name']} with {len(camera['modes'])} modes, {virtual['name']} is an output device"

    def missing(self) -> str:
        """A missing camera is a one-line error."""
        run = run_to_end("/dev/video77", "--to", "null")
        assert run.returncode == 6 and self.camera in run.stderr and len(run.stderr.splitlines()) == 1, (
            run.stderr
        )
        return run.stderr.strip()

    def colors(self) -> str:
        """Pictures read from the virtual camera, in each of its formats, have the colours of the camera."""
        wanted = column_colors(self.camera)
        worst = 0.0
        for pix_fmt in ("yuyv422", "nv12", "i420"):
            with run_live(
                self.camera, "--style", "plain", "--to", self.virtual, "--pix-fmt", pix_fmt
            ) as program:
                wait_for_picture(self.virtual, program)
                worst = max(worst, float(np.abs(column_colors(self.virtual) - wanted).max()))
        assert worst < 6, f"colours differ by {worst:.1f} of 255"
        return f"colours differ by {worst:.1f} of 255 at most"

    def latency(self) -> str:
        """Measure latency and dropped frames with a fast style."""
        run = run_to_end(
            self.camera, "--style", "plain", "--to", "null", "--frames", "40", "--json", *size_options()
        )
        assert run.returncode == 0, run.stderr
        told = json.loads(run.stdout)
        assert told["frames"] == 40 and 0 < told["latency_ms"]["median"] < 1000, told
        return f"{told['fps']} fps, {told['dropped']} dropped, latency {told['latency_ms']}"

    def busy(self) -> str:
        """A camera in use by another program is a one-line error."""
        with run_live(self.camera, "--style", "plain", "--to", self.virtual) as program:
            wait_for_picture(self.virtual, program)
            run = run_to_end(self.camera, "--to", "null", *size_options())
        assert run.returncode == 6 and "in use by another program" in run.stderr, run.stderr
        assert len(run.stderr.splitlines()) == 1, run.stderr
        return run.stderr.strip()

    def unplugged(self) -> str:
        """Unbind and bind the driver: the virtual camera stays, and live reconnects."""
        device = next(path.name for path in DRIVER.glob("vivid.*"))
        with run_live(self.camera, "--style", "plain", "--to", self.virtual) as program:
            wait_for_picture(self.virtual, program)
            (DRIVER / "unbind").write_text(device)
            program.expect("the last frame is repeated")
            held = column_colors(self.virtual)
            assert held.std() > 10, "the virtual camera shows nothing"
            time.sleep(2)
            (DRIVER / "bind").write_text(device)
            bound = time.monotonic()
            program.expect("back after")
            seconds = time.monotonic() - bound
            again = column_colors(self.virtual)
        assert np.abs(held - again).max() < 30, "the picture after the reconnect differs"
        assert seconds < MAX_RECONNECT_SECONDS, f"back only {seconds:.1f} s after its return"
        return f"held while away, back {seconds:.1f} s after its return"

    def silent(self) -> str:
        """A camera that stops sending pictures: a virtual one whose writer closes and reopens it."""
        writer = FlashWriter(self.virtual)
        with (
            tempfile.TemporaryDirectory() as folder,
            run_live(
                self.virtual, "--style", "plain", "--to", str(film := Path(folder, "film.mkv"))
            ) as program,
        ):
            program.expect_file(film)
            writer.end()
            program.expect("the last frame is repeated")
            time.sleep(3)
            writer = FlashWriter(self.virtual)
            program.expect("back after")
            seconds = time.monotonic() - writer.began
        writer.end()
        assert seconds < MAX_RECONNECT_SECONDS, f"back only {seconds:.1f} s after its return"
        return f"held while it is silent, back {seconds:.1f} s after its return"

    def compressed(self) -> str:
        """A virtual camera with JPEG pictures has the right colours."""
        writer = FlashWriter(self.virtual, "mjpeg")
        with tempfile.TemporaryDirectory() as folder:
            film = str(Path(folder, "film.mkv"))
            run = run_to_end(
                self.virtual, "--input-format", "mjpeg", "--style", "plain", "--to", film, "--frames", "8"
            )
            assert run.returncode == 0, run.stderr
            with av.open(film) as container:
                seen = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)][-1]
        writer.end()
        blue, red = (code - 128 for code in CHROMA_LEVELS)
        wanted = DARK_LEVEL + np.array([1.402 * red, -0.344 * blue - 0.714 * red, 1.772 * blue])
        worst = float(np.abs(seen.reshape(-1, 3).mean(axis=0) - wanted.clip(0, 255)).max())
        assert worst < 6, f"colours differ by {worst:.1f} of 255"
        return f"colours differ by {worst:.1f} of 255 at most"


if __name__ == "__main__":
    main()
