"""Benchmarks of blocks and styles on this machine."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Literal

from vidstyle.bench.subjects import Subject, film_picture_at, subjects
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.errors import DeviceError, log
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.device.devices import Device, choose
from vidstyle.gpu.timing import FRAME_RATE, GpuTimes, median_time, time_style
from vidstyle.regions.mask_renderer import MaskRenderer
from vidstyle.style import Style

PictureSize = tuple[int, int]
"""Width and height."""


@dataclass(frozen=True)
class Timed:
    """The measurements of one style or block at one size.

    Attributes:
        size: of the pictures.
        cpu: median seconds for a frame on the CPU.
        gpu: the same on the GPU, for each form.
    """

    subject: Subject
    size: PictureSize
    cpu: float
    gpu: tuple[GpuTimes, ...]


@dataclass(frozen=True)
class Bench:
    """A benchmark to run.

    Attributes:
        sizes: of the pictures.
        subjects: the styles.
        device: the GPU, or None for the CPU only.
        forms: how passes run on the GPU.
        seconds: about how long each measurement takes.
    """

    sizes: Sequence[PictureSize]
    subjects: Sequence[Subject]
    device: Device | None
    forms: Sequence[Form]
    seconds: float

    def run(self) -> Iterator[Timed]:
        """The measurements, one after another.

        Raises:
            DeviceError: the GPU fails.
            StyleError: a style cannot be used.
        """
        for size in self.sizes:
            picture = film_picture_at(*size)
            for subject in self.subjects:
                yield self._time(subject, size, picture)

    def _time(self, subject: Subject, size: PictureSize, picture: Picture) -> Timed:
        cpu = time_on_cpu(subject.style, picture, self.seconds)
        if (device := self.device) is None:
            return Timed(subject, size, cpu, ())
        gpu = (time_style(subject.style, picture, device, form, self.seconds) for form in self.forms)
        return Timed(subject, size, cpu, tuple(gpu))


def set_up(
    sizes: Sequence[PictureSize],
    styles: Sequence[str] = (),
    blocks: Sequence[str] = (),
    device: str = "auto",
    form: Literal["best", "compute", "fragment", "both"] = "best",
    seconds: float = 1.0,
) -> Bench:
    """Check the options of a benchmark; logs the device.

    Args:
        styles: names or paths; with no `blocks` either, every style and every block.
        device: "auto", "cpu", "gpu" or "gpu:N"; the CPU is measured whichever it is.
        form: "best" is the default of the device.

    Raises:
        UsageError: no such device or block.
        StyleError: a style is not there or has mistakes.
        DeviceError: there is no such device, or it has no compute passes.
    """
    wanted, chosen = subjects(styles, blocks), choose(device)
    if chosen.notice:
        log.info(chosen.notice)
    forms = _forms(chosen.device, form) if chosen.device else ()
    return Bench(sizes, wanted, chosen.device, forms, seconds)


def time_on_cpu(style: Style, picture: Picture, seconds: float) -> float:
    """The median time of a frame on the CPU, in seconds."""
    numbers = count()
    with MaskRenderer(style, lambda: CpuRenderer(style)) as renderer:
        return median_time(lambda: renderer.run(picture, next(numbers) / FRAME_RATE), seconds)


def _forms(device: Device, form: Literal["best", "compute", "fragment", "both"]) -> Sequence[Form]:
    choices: dict[str, Sequence[Form]] = {
        "best": [device.form],
        "compute": ["compute"],
        "fragment": ["fragment"],
        "both": ["compute", "fragment"],
    }
    if "compute" in choices[form] and device.form != "compute":
        raise DeviceError(str(device), "has no compute shaders (OpenGL 4.3)", "use --form fragment")
    return choices[form]
