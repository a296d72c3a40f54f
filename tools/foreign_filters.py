"""Train banks on filters of other programs, and print their fidelity, messages and times.

`nice python tools/foreign_filters.py --images DIR` holds out half of the pictures and needs the program
`ffmpeg`. `--only NAME` selects filters, `--program` another version of vidstyle, and `-- OPTIONS` passes
options to `vidstyle train`.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from scipy import ndimage

if TYPE_CHECKING:
    from vidstyle.blade.reference_filter import ReferenceFilter

FFMPEG_COMMAND = "ffmpeg -loglevel error -y -i {in} -vf %s {out}"
TIMED_SIZE = (720, 1280)


def dim(picture: np.ndarray) -> np.ndarray:
    """Multiply by 0.7."""
    return np.round(picture * 0.7).astype(np.uint8)


def negative(picture: np.ndarray) -> np.ndarray:
    """Invert."""
    return 255 - picture


def gamma(picture: np.ndarray) -> np.ndarray:
    """Apply a tone curve: the square root."""
    return np.round(255 * np.sqrt(picture / 255)).astype(np.uint8)


def sepia(picture: np.ndarray) -> np.ndarray:
    """Mix the channels into brown."""
    mix = np.array([[0.393, 0.769, 0.189], [0.349, 0.686, 0.168], [0.272, 0.534, 0.131]], np.float32)
    return np.clip(picture @ mix.T, 0, 255).round().astype(np.uint8)


def gaussian(picture: np.ndarray) -> np.ndarray:
    """Blur with a Gaussian of 1.5 px."""
    return cv2.GaussianBlur(picture, (0, 0), 1.5)


def median(picture: np.ndarray) -> np.ndarray:
    """Take the median of 5 x 5 pixels."""
    return cv2.medianBlur(picture, 5)


def box(picture: np.ndarray) -> np.ndarray:
    """Take the mean of 9 x 9 pixels."""
    return ndimage.uniform_filter(picture, (9, 9, 1))


def laplacian_sharpening(picture: np.ndarray) -> np.ndarray:
    """Subtract the Laplacian of Gaussian."""
    planes = [each - 2 * ndimage.gaussian_laplace(each, 1) for each in cv2.split(picture.astype(np.float32))]
    return np.clip(cv2.merge(planes), 0, 255).round().astype(np.uint8)


def bilateral(picture: np.ndarray) -> np.ndarray:
    """Smooth by distance and colour."""
    return cv2.bilateralFilter(picture, 9, 30, 3)


def guided(picture: np.ndarray) -> np.ndarray:
    """Smooth with the picture itself as a guide."""
    return cv2.ximgproc.guidedFilter(picture, picture, 4, 0.02 * 255**2)


def sobel(picture: np.ndarray) -> np.ndarray:
    """Draw the magnitude of the gradient."""
    gray = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY).astype(np.float32)
    magnitude = np.hypot(cv2.Sobel(gray, cv2.CV_32F, 1, 0), cv2.Sobel(gray, cv2.CV_32F, 0, 1))
    return cv2.cvtColor(np.clip(magnitude, 0, 255).astype(np.uint8), cv2.COLOR_GRAY2RGB)


def morphological_gradient(picture: np.ndarray) -> np.ndarray:
    """Draw the range of 3 x 3 pixels."""
    return ndimage.morphological_gradient(picture, (3, 3, 1))


def laplacian(picture: np.ndarray) -> np.ndarray:
    """Draw the magnitude of the Laplacian."""
    return cv2.convertScaleAbs(cv2.Laplacian(picture, cv2.CV_16S, ksize=3))


def kuwahara(picture: np.ndarray) -> np.ndarray:
    """Take the mean of the quarter of 7 x 7 pixels with the least variance."""
    values = np.pad(picture.astype(np.float32), ((3, 3), (3, 3), (0, 0)), "edge")
    windows = np.lib.stride_tricks.sliding_window_view(values, (4, 4), (0, 1))
    mean, variance = windows.mean(axis=(3, 4)), windows.var(axis=(3, 4)).sum(axis=2)
    height, width = picture.shape[:2]
    quarters = [np.s_[top : top + height, left : left + width] for top in (0, 3) for left in (0, 3)]
    best = np.argmin([variance[each] for each in quarters], axis=0)
    return np.choose(best[..., None], [mean[each] for each in quarters]).round().astype(np.uint8)


def oil(picture: np.ndarray) -> np.ndarray:
    """Paint in oil."""
    return cv2.xphoto.oilPainting(picture, 4, 1)


def pencil(picture: np.ndarray) -> np.ndarray:
    """Draw with coloured pencils."""
    return cv2.pencilSketch(picture, sigma_s=60, sigma_r=0.07, shade_factor=0.02)[1]


MODULE_PREFIX = "foreign_filters:"
FILTERS: dict[str, dict[str, str]] = {
    "tone": {
        "x 0.7": f"{MODULE_PREFIX}dim",
        "negative": f"{MODULE_PREFIX}negative",
        "square root": f"{MODULE_PREFIX}gamma",
        "sepia": f"{MODULE_PREFIX}sepia",
    },
    "blur": {
        "cv2.GaussianBlur 1.5": f"{MODULE_PREFIX}gaussian",
        "cv2.medianBlur 5": f"{MODULE_PREFIX}median",
        "scipy uniform_filter 9": f"{MODULE_PREFIX}box",
        "ffmpeg avgblur 3": FFMPEG_COMMAND % "avgblur=sizeX=3",
    },
    "sharpen": {
        "ffmpeg cas=1": FFMPEG_COMMAND % "cas=1",
        "ffmpeg unsharp": FFMPEG_COMMAND % "unsharp=7:7:1.5",
        "scipy gaussian_laplace": f"{MODULE_PREFIX}laplacian_sharpening",
        "cv2.detailEnhance": "cv2:detailEnhance",
    },
    "edge-preserving": {
        "cv2.bilateralFilter": f"{MODULE_PREFIX}bilateral",
        "cv2 guidedFilter": f"{MODULE_PREFIX}guided",
        "ffmpeg nlmeans": FFMPEG_COMMAND % "nlmeans=s=8",
        "cv2.edgePreservingFilter": "cv2:edgePreservingFilter",
    },
    "edges": {
        "Sobel magnitude": f"{MODULE_PREFIX}sobel",
        "scipy morphological_gradient": f"{MODULE_PREFIX}morphological_gradient",
        "ffmpeg kirsch": FFMPEG_COMMAND % "kirsch",
        "Laplacian magnitude": f"{MODULE_PREFIX}laplacian",
    },
    "painterly": {
        "cv2.stylization": "cv2:stylization",
        "cv2.pencilSketch": f"{MODULE_PREFIX}pencil",
        "Kuwahara 7": f"{MODULE_PREFIX}kuwahara",
        "cv2.xphoto.oilPainting 4, 1": f"{MODULE_PREFIX}oil",
    },
}
"""Filters by kind: functions, or commands with {in} and {out}."""


def main() -> None:
    """Train the banks and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", type=Path, required=True)
    parser.add_argument("--only", action="append", help="a kind, or the beginning of a name")
    parser.add_argument("--program", type=Path, default=Path(sys.executable).with_name("vidstyle"))
    parser.add_argument("--banks", type=Path, help="keep the banks in this folder")
    parser.add_argument("--timed", action="store_true", help="also time the filters and banks at 1280x720")
    parser.add_argument("options", nargs="*")
    arguments = parser.parse_args()
    columns = ["kind", "filter", "explained", "PSNR", "untouched", "MSSIM", "untouched", "training"]
    columns += ["filter, 720p", "bank, 720p"] if arguments.timed else []
    print(f"| {' | '.join([*columns, 'message'])} |")
    print("|---" * (len(columns) + 1) + "|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        banks = arguments.banks or Path(folder)
        banks.mkdir(exist_ok=True)
        for kind, filters in FILTERS.items():
            for name, source in filters.items():
                if not arguments.only or any(
                    each == kind or name.startswith(each) for each in arguments.only
                ):
                    bank = banks / f"{name.replace(' ', '-')}.npz"
                    print(f"| {kind} | {name} | {train_row(arguments, source, bank)} |", flush=True)


def train_row(arguments: argparse.Namespace, source: str, bank: Path) -> str:
    """Train one bank and return its cells of the table."""
    count = sum(each.is_file() for each in arguments.images.iterdir())
    options = ["--hold-out", str(count // 2), *arguments.options]
    begun = time.monotonic()
    run = train_bank(arguments.program, bank, arguments.images, source, options)
    seconds = time.monotonic() - begun
    if run.returncode:
        return run.stderr.strip()
    from vidstyle.blade.bank_file import load_bank

    fidelity = load_bank(bank).about["fidelity"]
    shown_words = ("layouts", "stage", "the filter", "not local")
    lines = (line.partition(": ")[2] for line in run.stderr.splitlines())
    messages = "; ".join(line for line in lines if any(word in line for word in shown_words))
    timed = f" | {time_filters(source, bank)}" if arguments.timed else ""
    return (
        f"{fidelity['explained']:.1%} | {fidelity['psnr']:.1f} dB | {fidelity['untouched psnr']:.1f} dB | "
        f"{fidelity['mssim']:.3f} | {fidelity['untouched mssim']:.3f} | {seconds:.0f} s{timed} | {messages}"
    )


def train_bank(
    program: Path, bank: Path, images: Path, source: str, options: Sequence[str]
) -> subprocess.CompletedProcess[str]:
    """Run `vidstyle train` on a filter: a function, or a command with {in} and {out}."""
    how = "--command" if "{in}" in source else "--function"
    words = [
        str(program),
        "train",
        str(bank),
        "--images",
        str(images),
        how,
        source,
        "-y",
        "--progress",
        "none",
        *options,
    ]
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(words, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": path})


def make_reference(source: str) -> ReferenceFilter:
    """Return the reference filter of a function or command."""
    from vidstyle.blade.program_filter import reference_by_command
    from vidstyle.blade.reference_filter import reference_by_function

    return reference_by_command(source) if "{in}" in source else reference_by_function(source)


def time_filters(source: str, bank: Path) -> str:
    """Return the processor time of a filter, and of its bank for luma, at 1280 x 720, in milliseconds."""
    from vidstyle.blade.bank_file import load_bank
    from vidstyle.blade.before.luma_steps import prepare
    from vidstyle.blade.inference import BankRun
    from vidstyle.blade.photographs import Photograph

    noise = np.random.default_rng(1).random(TIMED_SIZE, np.float32)
    luma = cv2.GaussianBlur(noise, (0, 0), 3)
    color = np.repeat(luma[..., None], 3, axis=2)
    reference, run, photograph = make_reference(source), BankRun(load_bank(bank)), Photograph(Path("timed"))
    reference_ms = _best_ms(lambda: reference.apply(color, photograph))
    bank_ms = _best_ms(lambda: run.whole(prepare(luma, run.luma_steps)))
    return f"{reference_ms:.0f} ms | {bank_ms:.1f} ms"


def _best_ms(call: Callable[[], object]) -> float:
    call()
    return min(_processor_ms(call) for _ in range(3))


def _processor_ms(call: Callable[[], object]) -> float:
    """Return the processor time of a call and of the programs that it runs, in milliseconds."""

    def used() -> float:
        own = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return sum(each.ru_utime + each.ru_stime for each in own)

    begun = used()
    call()
    return 1000 * (used() - begun)


if __name__ == "__main__":
    main()
