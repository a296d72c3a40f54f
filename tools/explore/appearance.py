"""Fit how much each number of an appearance counts to shipped styles, and report how well it works.

Usage: python -m tools.explore.appearance FOLDER [--write]

FOLDER holds photographs. Three of four, by name, serve to fit, the others to test. Which distance is usual
comes from all four ways to divide them.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.explore.composed.shipped_parts import shipped_styles
from vidstyle.explore.matching.appearance import MODEL_FILE, appearance_distance, appearance_of
from vidstyle.explore.matching.like import known_styles
from vidstyle.gallery.preview import read_still
from vidstyle.gallery.style_samples import restyle_picture

AXIS_COUNT, SHRINKAGE_RATIO = 24, 0.1
"""Number of axes that are kept, and the share by which correlations within a style are reduced."""
PART_COUNT = 4
"""Number of parts of the photographs, of which each in turn is not fitted to."""


def main() -> None:
    """See the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true", help=f"write {MODEL_FILE.name}")
    options = parser.parse_args()
    files = sorted(path for path in options.folder.iterdir() if path.suffix.lower() in (".jpg", ".png"))
    looks = np.stack([describe_looks(file) for file in files], axis=1)
    parts = [np.arange(len(files)) % PART_COUNT == number for number in range(PART_COUNT)]
    usual = float(np.mean([fit_axes(looks[:, ~part], looks[:, part])["usual"] for part in parts]))
    given, others = looks[:, ~parts[-1]], looks[:, parts[-1]]
    model = {
        name: round_numbers(value) for name, value in (fit_axes(given, others) | {"usual": usual}).items()
    }
    if options.write:
        MODEL_FILE.write_text(json.dumps(model) + "\n", encoding="utf-8")
    for what, part in (("fitted to", given), ("tested on", others)):
        print(f"{what} {part.shape[1]} photographs: {measure_recall(part):.1%} are among the first three")


def fit_axes(looks: np.ndarray, others: np.ndarray) -> dict[str, Any]:
    """Return what `appearance_distance` needs, from the looks of styles, styles x photographs x numbers.

    Linear discriminants (Fisher 1936): the axes along which styles differ most by what photographs of one
    style do. An axis counts the more, the larger that ratio.
    """
    means = looks.mean(axis=1)
    own = (looks - means[:, None]).reshape(-1, looks.shape[2])
    within = own.T @ own / (len(own) - len(looks))
    within += SHRINKAGE_RATIO * (np.diag(np.diag(within)) - within) + 1e-9 * np.eye(len(within))
    white = np.linalg.inv(np.linalg.cholesky(within))
    ratios, axes = np.linalg.eigh(white @ np.cov(means.T) @ white.T)
    ratios, axes = ratios[: -AXIS_COUNT - 1 : -1], axes[:, : -AXIS_COUNT - 1 : -1]
    axes = np.sqrt(ratios / (1 + ratios))[:, None] * (axes.T @ white)
    placed = others @ axes.T
    pairs = [np.linalg.norm(placed[:, one] - placed[:, other], axis=1)
             for one in range(others.shape[1]) for other in range(one)]  # fmt: skip
    return {"axes": axes.tolist(), "usual": float(np.median(pairs))}


def describe_looks(file: Path) -> np.ndarray:
    """Return the looks of a photograph in each known style."""
    picture = read_still(file)
    with ThreadPoolExecutor() as pool:
        return np.array(
            list(pool.map(lambda style: appearance_of(restyle_picture(picture, style)), known_styles()))
        )


def round_numbers(value: object) -> object:
    """Return a number, or a list of them, with four significant digits."""
    return [round_numbers(each) for each in value] if isinstance(value, list) else float(f"{value:.4g}")


def measure_recall(looks: np.ndarray) -> float:
    """Return how often a style, given its picture of one photograph, is among the nearest three on another.

    The distances come from the model in the file.
    """
    names = [style.name for style in known_styles()]
    shipped = [names.index(style.name) for style in shipped_styles()]
    hits = []
    for given, drawn in np.ndindex(looks.shape[1], looks.shape[1]):
        for style in shipped if given != drawn else []:
            far = [appearance_distance(looks[style, given], each) for each in looks[:, drawn]]
            hits.append(sum(each < far[style] for each in far) < 3)
    return float(np.mean(hits))


if __name__ == "__main__":
    main()
