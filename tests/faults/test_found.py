"""What tools/fuzz.py has found: each file of tests/fixtures/found is used, or refused by an error of ours."""

from __future__ import annotations

import gc
import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from tools.fuzz import FOUND, save_finding
from tools.fuzzing.attempts import attempt
from tools.fuzzing.cases import KINDS, Case, make_file
from tools.fuzzing.originals import write_originals
from tools.fuzzing.processes import MAX_MEMORY_BYTES, BrokenPromiseError
from tools.fuzzing.worker import Worker
from vidstyle.errors import InputError, VidstyleError


@pytest.mark.parametrize("path", sorted(FOUND.iterdir()), ids=lambda path: path.name)
def test_what_was_found_is_used_or_refused(path: Path, tmp_path: Path) -> None:
    try:
        attempt(path, tmp_path)
    except VidstyleError as error:
        assert "\n" not in str(error)
    gc.collect()


def crash(*_: Path) -> None:
    os.abort()


def hang(*_: Path) -> None:
    threading.Event().wait()


def fail(*_: Path) -> None:
    raise KeyError("foreign")


def fill(*_: Path) -> None:
    bytearray(MAX_MEMORY_BYTES + 2**24)


def lose_frames(*_: Path) -> None:
    raise BrokenPromiseError("fewer frames: 1 of 2")


def refuse(*_: Path) -> None:
    raise InputError("file", "is damaged")


SLOW = pytest.mark.thorough


@pytest.mark.parametrize(
    ("trial", "outcome"),
    [
        (crash, "crash: exit code -6"),
        pytest.param(hang, "hang", marks=SLOW),
        pytest.param(fill, "memory", marks=SLOW),
        pytest.param(fail, "KeyError in test_found.py", marks=SLOW),
        pytest.param(lose_frames, "fewer frames: 1 of 2", marks=SLOW),
        pytest.param(refuse, "refused", marks=SLOW),
    ],
)
def test_what_a_file_does_is_noticed(trial: Callable[[Path, Path], None], outcome: str) -> None:
    worker = Worker({}, trial)
    try:
        assert worker.outcome(Case("style", 1, 1), seconds=0.2 if trial is hang else 60).startswith(outcome)
    finally:
        worker.close()


@pytest.mark.parametrize(
    "kind", [pytest.param("film", marks=SLOW), *(each for each in KINDS if each != "film")]
)
def test_a_seed_finds_the_same_again(kind: str, tmp_path: Path) -> None:
    whole = [write_originals(folder, [kind]) for folder in (tmp_path / "one", tmp_path / "other")]
    for number in range(20):
        assert make_file(kind, 7, number, whole[0]) == make_file(kind, 7, number, whole[1])


def test_a_find_is_kept_as_a_file(tmp_path: Path) -> None:
    save_finding(Case("page", 7, 3), "crash", {}, tmp_path)
    assert (tmp_path / "page-7-3.page.toml").read_bytes() == make_file("page", 7, 3, {})[1]
