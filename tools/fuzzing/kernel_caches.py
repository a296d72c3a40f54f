"""Damage caches of compiled kernels: the result must not change."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path
from random import Random

import numpy as np

from tools.fuzzing.damage import damage
from tools.fuzzing.processes import BrokenPromiseError, run_apart

PROGRAM = """
import sys, numpy as np, vidstyle
picture = (np.arange(48 * 64 * 3) % 251).astype(np.uint8).reshape(48, 64, 3)
style = {"format": 1, "background": [{"block": "posterize"}]}
np.save(sys.argv[1], vidstyle.stylize(picture, style, device="cpu"))
"""
"""A program with few and small kernels, so that a damaged cache is rebuilt in a second."""


def try_cache(path: Path, folder: Path) -> None:
    """Damage a copy of a good cache with the seed in the file, and compare the program's result.

    Raises:
        BrokenPromiseError: the result differs, or the program fails.
    """
    random, home = Random(path.read_bytes()), folder / "cache"
    shutil.copytree(fill_cache(), home)
    damage_files(random, sorted(each for each in home.rglob("*") if each.is_file()))
    if not np.array_equal(_result(home, folder), _result_of_right_cache()):
        raise BrokenPromiseError("wrong picture")


def _result(home: Path, folder: Path) -> np.ndarray:
    target = folder / "result.npy"
    ended = run_apart(["-c", PROGRAM, target], XDG_CACHE_HOME=str(home))
    if ended.exit_code:
        raise BrokenPromiseError(f"exit {ended.exit_code}: {(ended.lines or ['no message'])[-1]}")
    return np.load(target)


@cache
def fill_cache() -> Path:
    """Return a cache that the program has filled; it is made once per process."""
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    _result(folder / "cache", folder)
    return folder / "cache"


@cache
def _result_of_right_cache() -> np.ndarray:
    return _result(fill_cache(), fill_cache().parent)


def damage_files(random: Random, files: list[Path]) -> None:
    """Damage one or all of the files: change, cut or exchange their content, or replace them."""
    for file in random.sample(files, random.choice((1, 1, len(files)))):
        content = file.read_bytes()
        fault = random.choice(("bytes", "bytes", "bytes", "cut", "other", "folder", "lost", "link"))
        if fault == "bytes":
            file.write_bytes(damage(random, content))
        elif fault == "cut":
            file.write_bytes(content[: random.randrange(len(content) + 1)])
        elif fault == "other":
            file.write_bytes(random.choice([each for each in files if each.is_file()] or [file]).read_bytes())
        else:
            file.unlink()
            if fault == "folder":
                file.mkdir()
            elif fault == "link":
                file.symlink_to(random.choice((file, Path("/dev/zero"), *files)))
