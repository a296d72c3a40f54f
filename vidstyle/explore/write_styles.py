"""`vidstyle explore` without a page: write random styles as files, with a sheet of their results."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np

from vidstyle.errors import InputError, UsageError
from vidstyle.explore.candidates import Found, RandomStyle, search
from vidstyle.explore.crops.full_size import MAX_SIDE_PX
from vidstyle.explore.measure import Original
from vidstyle.explore.paper.rules import Rules
from vidstyle.explore.score import Judge, reasons, verdict
from vidstyle.gallery.preview import preview_page, read_still
from vidstyle.gallery.style_samples import StyleSample, encode_picture, samples_of, sheet_of_samples
from vidstyle.media.read.reader import ReadOptions
from vidstyle.media.resize import reduce_picture
from vidstyle.media.write.atomic import atomic_file, check_folder
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.style import save_style

PAGE_FILE, SHEET_FILE, TABLE_FILE = "sheet.html", "sheet.png", "styles.json"
MAX_DRAWN_SIDE_PX = 640
"""Maximum longer side at which styles are rendered for the sheet."""


def explore_to_folder(
    source: str | Path,
    folder: Path,
    count: int,
    seed: int,
    rules: Rules = "open",
    tries: int | None = None,
    judge: Path | None = None,
    read: ReadOptions | None = None,
    overwrite: bool = False,
    on_step: ProgressCallback = ignore_progress,
    stop: Event | None = None,
) -> Found:
    """Write random styles that pass the quality gates on a picture.

    The folder gets a style file for each seed, a page and a sheet of the results, best first, and a table
    with scores, metrics and the reasons for rejections.

    Args:
        source: a picture, or a film from which one picture is used.
        folder: a new or empty folder.
        count, seed, rules, tries, stop: see `search`.
        judge: a model that scores pictures.
        overwrite: whether the folder may contain files; files with the same names are replaced.

    Raises:
        UsageError: the folder is a file, or is not empty.
        InputError: the source or the model cannot be read, or no style passes.
        OutputError: a file cannot be written.
    """
    check_folder(folder)
    if folder.exists() and not folder.is_dir():
        raise UsageError(folder, "is a file", "name a folder")
    if not overwrite and folder.is_dir() and any(folder.iterdir()):
        raise UsageError(folder, "is not empty", "add -y to write into it, or choose another folder")
    scorer = Judge(judge) if judge else None
    picture = read_still(source, read, MAX_SIDE_PX)
    found = search(Original(picture), seed, count, rules, tries, scorer, on_step, stop)
    if not found.chosen:
        raise InputError(source, f"no style passed of {found.tried} candidates", "choose another picture")
    folder.mkdir(exist_ok=True)
    for candidate in found.chosen:
        save_style(candidate.style, folder / f"{candidate.style.name}.toml")
    facts = {"input": Path(source).name, "seed": seed, "rules": rules, "judge": judge and judge.name}
    _write(folder / TABLE_FILE, (json.dumps(facts | _table(found, rules), indent=1) + "\n").encode())
    _write_sheets(folder, Path(source).name, picture, found.chosen, on_step)
    return found


def _table(found: Found, rules: Rules) -> dict[str, Any]:
    passed = found.faults[""]
    return {
        "tried": found.tried,
        "passed": passed,
        "discarded": {reason: number for reason, number in found.faults.most_common() if reason},
        "styles": [_row(candidate, rules) for candidate in found.chosen],
    }


def _row(candidate: RandomStyle, rules: Rules) -> dict[str, Any]:
    assert candidate.full_size is not None
    measures = candidate.measures._asdict() | candidate.full_size._asdict()
    parts = sorted(reasons(candidate.full_size, rules).items(), key=lambda part: -abs(part[1]))
    return {
        "name": candidate.style.name,
        "file": f"{candidate.style.name}.toml",
        "score": round(candidate.score, 4),
        "steadiness": round(candidate.steadiness, 3),
        "verdict": verdict(candidate.full_size, rules),
        "reasons": {name: round(part, 2) for name, part in parts},
        "measures": {
            name: round(value, 4) if isinstance(value, float) else value for name, value in measures.items()
        },
    }


def _write_sheets(
    folder: Path,
    name: str,
    picture: np.ndarray,
    candidates: Sequence[RandomStyle],
    on_step: ProgressCallback,
) -> None:
    samples: list[StyleSample] = []
    shown = reduce_picture(picture, MAX_DRAWN_SIDE_PX)
    for sample in samples_of(shown, [candidate.style for candidate in candidates], picture):
        samples.append(sample)
        on_step("drawing the sheet", len(samples), len(candidates))
    _write(folder / PAGE_FILE, preview_page(name, "INPUT", samples, ".toml").encode("utf-8"))
    sheet = sheet_of_samples(
        [(each.style.name, reduce_picture(each.picture, MAX_DRAWN_SIDE_PX // 2)) for each in samples]
    )
    _write(folder / SHEET_FILE, encode_picture(sheet, ".png"))


def _write(path: Path, content: bytes) -> None:
    with atomic_file(path, None, overwrite=True) as write:
        write(content)
