"""Trains banks from photographs, one in memory at a time, and measures their fidelity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.before.luma_steps import prepare
from vidstyle.blade.inference import BankRun
from vidstyle.blade.photographs import Photograph, chroma_of, luma_of
from vidstyle.blade.reference_filter import ReferenceFilter
from vidstyle.blade.regression import (
    NormalEquations,
    TrainingConfig,
    accumulate,
    as_filters,
    clipped_of,
    solve_weights,
    squared_errors,
)
from vidstyle.core.machine.cores import available_cores

SSIM_WINDOW_PX = 11
"""Side of the window of structural similarity, as in Wang et al. 2004."""

OnPicture = Callable[[str, int, int], None]
"""Called after each picture with the name of the phase, the number of completed pictures, and the total."""


@dataclass(frozen=True)
class TrainingReport:
    """The outcome of a training.

    Attributes:
        samples: number of pixels.
        empty: number of bins without pixels.
        residual: root mean squared error of each part on the samples, in levels of 255.
        clipped: share of the values that the filter makes black or white.
    """

    samples: int
    empty: int
    residual: tuple[float, ...]
    clipped: float = 0.0

    def __str__(self) -> str:
        residual = ", ".join(f"{part:.2f}" for part in self.residual)
        return f"{self.samples:,} samples, {self.empty} empty bins, residual {residual} levels of 255"


def train(
    config: TrainingConfig,
    reference: ReferenceFilter,
    photographs: Sequence[Photograph],
    on_picture: OnPicture = lambda *_: None,
) -> tuple[Bank, TrainingReport]:
    """Train a bank for luma.

    Raises:
        InputError: a picture cannot be read, or the reference filter fails.
        UsageError: the reference filter's settings are invalid.
    """
    sums = NormalEquations.empty(config)
    with ThreadPoolExecutor(available_cores()) as pool:
        for number, photograph in enumerate(photographs, 1):
            color = photograph.color()
            targets = reference.apply(color, photograph)
            sums.add(accumulate(config, luma_of(color), [luma_of(each) for each in targets], pool))
            on_picture("learning", number, len(photographs))
    weights = solve_weights(config, sums)
    mean = squared_errors(sums, weights) / np.maximum(sums.samples, 1)
    errors = 255 * np.sqrt(np.maximum(mean, 0))
    about = description(config, reference, photographs, sums, errors)
    clipped = clipped_of(config, weights)
    bank = Bank(
        config.bins, config.rho, as_filters(config, weights), about, clips=config.clips, clipped=clipped
    )
    return bank, report(sums, errors)


def description(
    config: TrainingConfig,
    reference: ReferenceFilter,
    photographs: Sequence[Photograph],
    sums: NormalEquations,
    errors: np.ndarray,
) -> dict[str, Any]:
    """Return what a bank says about its training; `errors` has levels of 255 for each part and bin."""
    return {
        "imitates": reference.name,
        "settings": dict(reference.settings),
        "parts": list(reference.parts),
        "smoothness": config.smoothness,
        "kinship": config.prior_samples,
        "long_side": photographs[0].long_side,
        "pictures": [[photograph.path.name, photograph.checksum] for photograph in photographs],
        "samples": sums.samples.tolist(),
        "residuals": errors.round(3).tolist(),
    }


def measure(
    run: BankRun,
    reference: ReferenceFilter,
    photographs: Sequence[Photograph],
    weights: Sequence[float] = (1.0,),
    identity: float = 0.0,
    on_picture: OnPicture = lambda *_: None,
) -> dict[str, float]:
    """Measure the fidelity of a bank on pictures that it was not trained on.

    Args:
        run: the use of the bank.
        weights, identity: weights of the reference's parts and of the picture in the target.

    Returns:
        Means of "psnr" (dB) and "mssim"; of "untouched psnr" and "untouched mssim" for the unfiltered
        pictures; and for a bank with chroma of "chroma psnr" and "untouched chroma psnr". "explained" is the
        share of the
        squared change of luma that the bank reproduces: 1 for a bank that equals the reference, 0 or less for
            a
        bank that is no better than no change.
    """
    rows = []
    errors = changes = 0.0
    for number, photograph in enumerate(photographs, 1):
        color = photograph.color()
        luma, parts = luma_of(color), reference.apply(color, photograph)
        given = run.mixed(color)
        prepared = prepare(luma_of(given), run.luma_steps)

        def mixed(planes: list[np.ndarray], plane: np.ndarray) -> np.ndarray:
            return np.tensordot(np.asarray(weights, np.float32), np.stack(planes), 1) + identity * plane

        target = mixed([luma_of(part) for part in parts], luma)
        result = run.whole(prepared)
        row = [psnr(result, target), mssim(result, target), psnr(luma, target), mssim(luma, target)]
        if run.bank.chroma is not None:
            planes = chroma_of(color)
            wanted = [
                mixed(list(each), plane) for plane, *each in zip(planes, *map(chroma_of, parts), strict=True)
            ]
            found = run.whole_chroma(prepared, chroma_of(given))
            row += [psnr(np.stack(each), np.stack(wanted)) for each in (found, planes)]
        rows.append(row)
        errors += float(np.square(result - target).mean())
        changes += float(np.square(luma - target).mean())
        on_picture("measuring", number, len(photographs))
    names = ("psnr", "mssim", "untouched psnr", "untouched mssim", "chroma psnr", "untouched chroma psnr")
    fidelity = dict(zip(names, np.mean(rows, axis=0), strict=False))
    fidelity["explained"] = 1 - errors / changes if changes else 1.0
    return {name: round(float(value), 4) for name, value in fidelity.items()}


def psnr(result: np.ndarray, target: np.ndarray) -> float:
    """Return the peak signal-to-noise ratio in dB, for values whose peak is 1."""
    error = float(np.mean(np.square(result.astype(np.float64) - target)))
    return float("inf") if error == 0 else -10 * np.log10(error)


def mssim(result: np.ndarray, target: np.ndarray) -> float:
    """Return the mean structural similarity, Gaussian window of 1.5 px, without borders; Wang et al. 2004."""

    def blurred(values: np.ndarray) -> np.ndarray:
        return cv2.GaussianBlur(values, (SSIM_WINDOW_PX,) * 2, 1.5, borderType=cv2.BORDER_REPLICATE)

    one, two = result.astype(np.float64), target.astype(np.float64)
    mean_one, mean_two = blurred(one), blurred(two)
    variance_one = blurred(one * one) - mean_one**2
    variance_two = blurred(two * two) - mean_two**2
    covariance = blurred(one * two) - mean_one * mean_two
    low, high = 0.01**2, 0.03**2
    similarity = (2 * mean_one * mean_two + low) * (2 * covariance + high)
    similarity /= (mean_one**2 + mean_two**2 + low) * (variance_one + variance_two + high)
    inside = similarity[
        SSIM_WINDOW_PX // 2 : -(SSIM_WINDOW_PX // 2), SSIM_WINDOW_PX // 2 : -(SSIM_WINDOW_PX // 2)
    ]
    return float((inside if inside.size else similarity).mean())


def report(sums: NormalEquations, errors: np.ndarray) -> TrainingReport:
    """Summarize a training; `errors` has levels of 255 for each part and bin."""
    total = max(int(sums.samples.sum()), 1)
    levels = tuple(float(np.sqrt(part)) for part in (errors**2 * sums.samples).sum(axis=1) / total)
    return TrainingReport(int(sums.samples.sum()), int((sums.samples == 0).sum()), levels)
