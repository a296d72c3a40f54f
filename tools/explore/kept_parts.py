"""Compute how often people kept random styles with the colours or the lines of each shipped style.

Usage: python -m tools.explore.kept_parts KEY.json MARKS.json... [--write]

`tools/explore/score.py` describes the files. Only styles by the open rules count. A part of few styles is
drawn to the mean of all, as if PRIOR_COUNT more styles had it.
"""

from __future__ import annotations

import argparse
import json
import re
import tomllib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import get_args

import numpy as np

from tools.explore.logistic_model import area_under_curve
from tools.explore.marks import MIN_KEPT_SHARE, Row, kept_share
from vidstyle.explore.composed.kept_parts import SHARES_FILE, Part, log_odds

PRIOR_COUNT = 4
PARTS = re.compile(r"Colours of ([a-z]+)(?::\w+)?(?:, lines of ([a-z]+))?")
"""How `open_style` names the parts in the note; without lines, only the colours."""

MarkedParts = dict[Part, str]
"""The shipped style of each part of a marked style; "" without lines."""


def main() -> None:
    """See the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("key", type=Path)
    parser.add_argument("marks", type=Path, nargs="+")
    parser.add_argument("--write", action="store_true", help=f"write {SHARES_FILE.name}")
    options = parser.parse_args()
    people = [json.loads(path.read_text(encoding="utf-8")) for path in options.marks]
    key = [each for each in json.loads(options.key.read_text(encoding="utf-8")) if each["rules"] == "open"]
    parts = [parts_of(each) for each in key]
    kept = np.array([kept_share(people, each["number"]) for each in key])
    pictures = np.array([each["picture"] for each in key])
    shares = {part: shares_of([each[part] for each in parts], kept) for part in get_args(Part)}
    print(f"{len(key)} styles on {len(set(pictures))} pictures, {kept.mean():.0%} of the marks are keep")
    for part in get_args(Part):
        scores = score_held_out([each[part] for each in parts], kept, pictures)
        area = area_under_curve(scores, kept >= MIN_KEPT_SHARE)
        print(f"{part}: AUC {area:.3f}, from other pictures; {shares[part]}")
    if options.write:
        SHARES_FILE.write_text(json.dumps(shares, indent=1) + "\n", encoding="utf-8")


def parts_of(row: Row) -> MarkedParts:
    """Return the parts of a row of KEY.json: as its "parts" say, or the note of its style."""
    if "parts" in row:
        return {part: row["parts"][part] for part in get_args(Part)}
    found = PARTS.search(tomllib.loads(row["style"])["note"])
    assert found is not None, f"{row['number']}: the note names no parts"
    return {"colors": found[1], "lines": found[2] or ""}


def shares_of(names: Sequence[str], kept: np.ndarray) -> dict[str, float]:
    """Return the share of marks that were "keep" by name, and of all as "mean".

    Args:
        names: of the part of each style; those without one count for the mean only.
        kept: the share of people who kept each style, 0..1.
    """
    mean, groups = float(kept.mean()), defaultdict[str, list[float]](list)
    for name, share in zip(names, kept, strict=True):
        groups[name].append(float(share))
    shares = {
        name: round((sum(group) + PRIOR_COUNT * mean) / (len(group) + PRIOR_COUNT), 3)
        for name, group in sorted(groups.items())
        if name
    }
    return {"mean": round(mean, 3), **shares}


def score_held_out(names: Sequence[str], kept: np.ndarray, pictures: np.ndarray) -> np.ndarray:
    """Return for each style the log-odds of its part in the styles of other pictures, less their mean."""
    scores = np.zeros(len(kept))
    for picture in set(pictures):
        here = pictures == picture
        others = [name for name, is_here in zip(names, here, strict=True) if not is_here]
        scores[here] = score_names(np.array(names)[here].tolist(), shares_of(others, kept[~here]))
    return scores


def score_names(names: Sequence[str], shares: Mapping[str, float]) -> list[float]:
    """Return the log-odds of the shares of parts relative to the mean share; 0 for unknown ones."""
    mean = log_odds(shares["mean"])
    return [log_odds(shares[name]) - mean if name in shares else 0.0 for name in names]


if __name__ == "__main__":
    main()
