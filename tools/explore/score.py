"""Fits the score of `vidstyle explore` to shipped styles and random ones, and says how well it parts them.

Usage: python -m tools.explore.score FOLDER [--count N] [--write]

FOLDER holds photographs. Each second one, by name, serves to fit the score, the others to test it.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from vidstyle.explore.gates import fault
from vidstyle.explore.generate import random_style
from vidstyle.explore.measure import Original, PictureMetrics
from vidstyle.explore.phrases import shipped_styles
from vidstyle.explore.score import MODEL_FILE, log_odds
from vidstyle.gallery.preview import read_still
from vidstyle.style import load_style

HIDDEN, DECAY, STEPS = 48, 1e-3, 1200
"""Units of the hidden layer, what squared weights add to the loss, and steps of the descent."""
RATE, MEAN_DECAY, SQUARE_DECAY = 0.01, 0.9, 0.999
"""Of Adam: Kingma and Ba 2015."""
SEED = "score"


def main() -> None:
    """See the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=60, help="random styles for each photograph")
    parser.add_argument("--write", action="store_true", help=f"write {MODEL_FILE.name}")
    options = parser.parse_args()
    files = sorted(path for path in options.folder.iterdir() if path.suffix.lower() in (".jpg", ".png"))
    good, random = zip(*(rows_of(file, options.count) for file in files), strict=True)
    model = fitted(np.concatenate(good[::2]), np.concatenate(random[::2]))
    for what, part in (("fitted on", slice(0, None, 2)), ("tested on", slice(1, None, 2))):
        shipped = [rows[: len(shipped_styles())] for rows in good[part]]
        passed = [rows[[not fault(PictureMetrics(*row)) for row in rows]] for rows in random[part]]
        share = sum(map(len, passed)) / sum(map(len, random[part]))
        areas = area(model, shipped, random[part]), area(model, shipped, passed)
        print(f"{what} {len(shipped)} photographs: AUC {areas[0]:.3f} against random styles, {areas[1]:.3f}")
        print(f"  against the {share:.0%} of them that pass the gates")
    if options.write:
        rounded = {
            name: np.vectorize(lambda x: float(f"{x:.4g}"))(each).tolist() for name, each in model.items()
        }
        MODEL_FILE.write_text(
            json.dumps({"measures": PictureMetrics._fields, **rounded}) + "\n", encoding="utf-8"
        )


def rows_of(file: Path, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The measures of a photograph in the shipped styles, then their variants; and in random ones."""
    original = Original(read_still(file))
    shipped = shipped_styles()
    variants = [load_style(f"{style.name}:{name}") for style in shipped for name in style.variants]
    random = [random_style(f"{SEED}-{file.stem}-{number}") for number in range(count)]
    with ThreadPoolExecutor() as pool:
        rows = list(
            pool.map(lambda style: original.measure(original.render(style)), shipped + variants + random)
        )
    return np.array(rows[:-count]), np.array(rows[-count:])


def fitted(good: np.ndarray, other: np.ndarray) -> dict[str, np.ndarray]:
    """The model of `log_odds` that tells good pictures from others, both as rows of measures.

    Cross entropy, both of equal weight in all, by Adam over all rows at once.
    """
    rows = np.concatenate([good, other])
    middle, spread = rows.mean(0), rows.std(0)
    inputs = np.hstack([(rows - middle) / spread, np.ones((len(rows), 1))])
    wanted = np.repeat([1.0, 0.0], [len(good), len(other)])
    shares = np.repeat([0.5 / len(good), 0.5 / len(other)], [len(good), len(other)])
    random = np.random.default_rng(0)
    start = random.normal(0, 1, (inputs.shape[1], HIDDEN)), random.normal(0, 1, HIDDEN + 1)
    weights = [each / np.sqrt(len(each)) for each in start]
    means, squares = ([np.zeros_like(each) for each in weights] for _ in range(2))
    for step in range(1, STEPS + 1):
        hidden = np.tanh(inputs @ weights[0])
        ends = np.hstack([hidden, np.ones((len(rows), 1))])
        wrong = shares * (1 / (1 + np.exp(-ends @ weights[1])) - wanted)
        slopes = inputs.T @ (np.outer(wrong, weights[1][:-1]) * (1 - hidden * hidden)), wrong @ ends
        for each, slope, mean, square in zip(weights, slopes, means, squares, strict=True):
            slope = slope + DECAY * each
            mean += (1 - MEAN_DECAY) * (slope - mean)
            square += (1 - SQUARE_DECAY) * (slope * slope - square)
            scale = np.sqrt(square / (1 - SQUARE_DECAY**step)) + 1e-8
            each -= RATE * (1 - step / (STEPS + 1)) * mean / (1 - MEAN_DECAY**step) / scale
    return {"middle": middle, "spread": spread, "hidden": weights[0], "output": weights[1]}


def area(model: dict[str, np.ndarray], good: list[np.ndarray], other: list[np.ndarray]) -> float:
    """The area under the curve of ROC: how often a good one has a higher score than another."""
    one, two = (log_odds(np.concatenate(rows), model) for rows in (good, other))
    return float(np.mean(one[:, None] > two[None]))


if __name__ == "__main__":
    main()
