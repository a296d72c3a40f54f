"""From photographs and a teacher to a bank: any number of pictures, one in memory at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.fidelity import mssim, psnr
from vidstyle.blade.learn import Sums, TrainingConfig, look_at, residuals, solve
from vidstyle.blade.photographs import Photograph, checksums, luma_of
from vidstyle.blade.reference_filter import ReferenceFilter
from vidstyle.blade.run import BankRun

OnPicture = Callable[[str, int, int], None]
"""Told after each picture: what is being done, how many are done, and how many there are."""


@dataclass(frozen=True)
class Report:
    """What came of a training.

    Attributes:
        samples: pixels learned from.
        empty: bins that no pixel fell into.
        residual: root of the mean squared error of each part on the samples, in levels of 255.
    """

    samples: int
    empty: int
    residual: tuple[float, ...]

    def __str__(self) -> str:
        residual = ", ".join(f"{part:.2f}" for part in self.residual)
        return f"{self.samples:,} samples, {self.empty} empty bins, residual {residual} levels of 255"


def train(
    lesson: TrainingConfig,
    teacher: ReferenceFilter,
    photographs: Sequence[Photograph],
    on_picture: OnPicture = lambda *_: None,
) -> tuple[Bank, Report]:
    """Learn a bank.

    Raises:
        InputError: a picture cannot be read, or the teacher fails.
        UsageError: the teacher cannot be asked so.
    """
    sums = Sums.empty(lesson)
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for number, photograph in enumerate(photographs, 1):
            color = photograph.color()
            sums.add(look_at(lesson, luma_of(color), teacher.teach(color, photograph), pool))
            on_picture("learning", number, len(photographs))
    filters = solve(lesson, sums)
    about = {
        "imitates": teacher.imitates,
        "settings": dict(teacher.settings),
        "parts": list(teacher.parts),
        "smoothness": lesson.smoothness,
        "kinship": lesson.kinship,
        "long_side": photographs[0].long_side,
        "pictures": [list(pair) for pair in checksums(list(photographs))],
        "samples": int(sums.samples.sum()),
    }
    return Bank(lesson.bins, lesson.rho, filters, about), _report(lesson, sums, filters)


def measure(
    run: BankRun,
    teacher: ReferenceFilter,
    photographs: Sequence[Photograph],
    weights: Sequence[float] = (1.0,),
    identity: float = 0.0,
    on_picture: OnPicture = lambda *_: None,
) -> dict[str, float]:
    """How close a bank comes to its teacher on pictures that it has not learned from.

    Args:
        run: the bank as it is to be used.
        weights, identity: how the teacher's parts and the picture itself are added up.

    Returns:
        the means of "psnr" (dB) and "mssim", and of "untouched psnr" and "untouched mssim": those of the
        pictures themselves.
    """
    rows = []
    for number, photograph in enumerate(photographs, 1):
        color = photograph.color()
        luma, parts = luma_of(color), teacher.teach(color, photograph)
        target = np.tensordot(np.asarray(weights, np.float32), np.stack(parts), 1) + identity * luma
        result = run.run(luma)
        rows.append((psnr(result, target), mssim(result, target), psnr(luma, target), mssim(luma, target)))
        on_picture("measuring", number, len(photographs))
    names = ("psnr", "mssim", "untouched psnr", "untouched mssim")
    return {name: round(float(mean), 4) for name, mean in zip(names, np.mean(rows, axis=0), strict=True)}


def _report(lesson: TrainingConfig, sums: Sums, filters: np.ndarray) -> Report:
    errors = np.nan_to_num(residuals(lesson, sums, filters)) * sums.samples
    mean = errors.sum(axis=1) / max(int(sums.samples.sum()), 1)
    levels = tuple(255 * float(np.sqrt(max(part, 0))) for part in mean)
    return Report(int(sums.samples.sum()), int((sums.samples == 0).sum()), levels)
