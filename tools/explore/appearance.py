"""Fits how much each number of an appearance counts, to shipped styles, and says how well it works.

Usage: python -m tools.explore.appearance FOLDER [--write]

FOLDER holds photographs. Each second one, by name, serves to fit, the others to test.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from vidstyle.explore.appearance import MODEL, appearance_of, distance, fitted_model
from vidstyle.explore.like import known_styles
from vidstyle.explore.phrases import shipped_styles
from vidstyle.gallery.preview import read_still
from vidstyle.gallery.style_samples import restyled


def main() -> None:
    """See the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true", help=f"write {MODEL.name}")
    options = parser.parse_args()
    files = sorted(path for path in options.folder.iterdir() if path.suffix.lower() in (".jpg", ".png"))
    looks = np.stack([looks_of(file) for file in files], axis=1)
    model = {name: rounded(value) for name, value in fitted_model(looks[:, ::2]).items()}
    if options.write:
        MODEL.write_text(json.dumps(model) + "\n", encoding="utf-8")
    for what, part in (("fitted to", looks[:, ::2]), ("tested on", looks[:, 1::2])):
        print(f"{what} {part.shape[1]} photographs: {found(part):.1%} are among the first three")


def looks_of(file: Path) -> np.ndarray:
    """The looks of a photograph in each known style."""
    picture = read_still(file)
    with ThreadPoolExecutor() as pool:
        return np.array(list(pool.map(lambda style: appearance_of(restyled(picture, style)), known_styles())))


def rounded(value: object) -> object:
    """A number or a list of them with four significant digits."""
    return [rounded(each) for each in value] if isinstance(value, list) else float(f"{value:.4g}")


def found(looks: np.ndarray) -> float:
    """How often a style, given its picture of one photograph, is among the nearest three on another.

    By the model that is written.
    """
    names = [style.name for style in known_styles()]
    shipped = [names.index(style.name) for style in shipped_styles()]
    hits = []
    for given, drawn in np.ndindex(looks.shape[1], looks.shape[1]):
        for style in shipped if given != drawn else []:
            far = [distance(looks[style, given], each) for each in looks[:, drawn]]
            hits.append(sum(each < far[style] for each in far) < 3)
    return float(np.mean(hits))


if __name__ == "__main__":
    main()
