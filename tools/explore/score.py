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
from vidstyle.explore.measure import Measures, Original
from vidstyle.explore.phrases import shipped_styles
from vidstyle.explore.score import MODEL, fitted_weights, products
from vidstyle.gallery.preview import read_still
from vidstyle.style import load_style

DECAY = 20.0
SEED = "score"


def main() -> None:
    """See the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=60, help="random styles for each photograph")
    parser.add_argument("--write", action="store_true", help=f"write {MODEL.name}")
    options = parser.parse_args()
    files = sorted(path for path in options.folder.iterdir() if path.suffix.lower() in (".jpg", ".png"))
    good, random = zip(*(rows_of(file, options.count) for file in files), strict=True)
    model = fitted_weights(np.concatenate(good[::2]), np.concatenate(random[::2]), DECAY)
    for what, part in (("fitted on", slice(0, None, 2)), ("tested on", slice(1, None, 2))):
        shipped = [rows[: len(shipped_styles())] for rows in good[part]]
        passed = [rows[[not fault(Measures(*row)) for row in rows]] for rows in random[part]]
        share = sum(map(len, passed)) / sum(map(len, random[part]))
        areas = area(model, shipped, random[part]), area(model, shipped, passed)
        print(f"{what} {len(shipped)} photographs: AUC {areas[0]:.3f} against random styles, {areas[1]:.3f}")
        print(f"  against the {share:.0%} of them that pass the gates")
    if options.write:
        rounded = {name: [float(f"{value:.4g}") for value in values] for name, values in model.items()}
        MODEL.write_text(json.dumps({"measures": Measures._fields, **rounded}) + "\n", encoding="utf-8")


def rows_of(file: Path, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The measures of a photograph in the shipped styles, then their variants; and in random ones."""
    original = Original(read_still(file))
    shipped = shipped_styles()
    variants = [load_style(f"{style.name}:{name}") for style in shipped for name in style.variants]
    random = [random_style(f"{SEED}-{file.stem}-{number}") for number in range(count)]
    with ThreadPoolExecutor() as pool:
        rows = list(
            pool.map(lambda style: original.measures(original.drawn(style)), shipped + variants + random)
        )
    return np.array(rows[:-count]), np.array(rows[-count:])


def area(model: dict[str, list[float]], good: list[np.ndarray], other: list[np.ndarray]) -> float:
    """The area under the curve of ROC: how often a good one has a higher score than another."""
    middle, spread = np.array(model["middle"]), np.array(model["spread"])
    one, two = (
        products((np.concatenate(rows) - middle) / spread) @ model["weights"] for rows in (good, other)
    )
    return float(np.mean(one[:, None] > two[None]))


if __name__ == "__main__":
    main()
