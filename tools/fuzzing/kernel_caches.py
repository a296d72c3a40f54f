"""Damaged caches of compiled kernels: the result must be that of an undamaged one."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path
from random import Random

import numpy as np

from tools.fuzzing.damage import damaged
from tools.fuzzing.processes import BrokenPromiseError, run_apart

PROGRAM = """
import sys, numpy as np, vidstyle
picture = (np.arange(48 * 64 * 3) % 251).astype(np.uint8).reshape(48, 64, 3)
style = {"format": 1, "background": [{"block": "posterize"}]}
np.save(sys.argv[1], vidstyle.stylize(picture, style, device="cpu"))
"""
"""Few and small kernels: a cache that is found to be damaged is made again in a second."""


def try_cache(path: Path, folder: Path) -> None:
    """Damage a copy of a good cache as the file says, and compare what the program makes with it.

    Raises:
        BrokenPromiseError: the result differs, or there is none.
    """
    random, home = Random(path.read_bytes()), folder / "cache"
    shutil.copytree(right_cache(), home)
    spoil(random, sorted(each for each in home.rglob("*") if each.is_file()))
    if not np.array_equal(_result(home, folder), _result_of_right_cache()):
        raise BrokenPromiseError("wrong picture")


def _result(home: Path, folder: Path) -> np.ndarray:
    target = folder / "result.npy"
    ended = run_apart(["-c", PROGRAM, target], XDG_CACHE_HOME=str(home))
    if ended.exit_code:
        raise BrokenPromiseError(f"exit {ended.exit_code}: {(ended.lines or ['nothing said'])[-1]}")
    return np.load(target)


@cache
def right_cache() -> Path:
    """A cache that the program has filled; made once in each process."""
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    _result(folder / "cache", folder)
    return folder / "cache"


@cache
def _result_of_right_cache() -> np.ndarray:
    return _result(right_cache(), right_cache().parent)


def spoil(random: Random, files: list[Path]) -> None:
    """Damage one to all of the files: their bytes, or whose content they have."""
    for file in random.sample(files, random.choice((1, 1, len(files)))):
        content = file.read_bytes()
        fault = random.choice(("bytes", "bytes", "bytes", "cut", "other", "folder", "lost", "link"))
        if fault == "bytes":
            file.write_bytes(damaged(random, content))
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
