"""The cache of compiled kernels is executed, so only intact files of this user are loaded."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from covering import DAY

from vidstyle.core.kernels import object_files
from vidstyle.core.machine.user_cache import exposure_of, user_cache

ROOT = Path(__file__).parents[2]

DAMAGE = """
import logging, os, random, sys
from pathlib import Path
import numpy as np
from vidstyle.core.color.deferred_color import _mix
from vidstyle.core.kernels import library, object_files
from vidstyle.core.kernels.channels import _repeat_rows
from vidstyle.core.kernels.declare import types_of

logging.basicConfig(format="notice: %(message)s", stream=sys.stdout)
seed, count = map(int, sys.argv[1:])
random.seed(seed)
color, matrix = np.float32([[0, 0.25, 0.5, 0, 0.5, 1]]), np.eye(4, dtype=np.float32)[[2, 1, 0]]
WANTED = [[0.5, 0.25, 0, 1, 0.5, 0]]

def mixed():
    library._ordered.clear()
    library._engine.cache_clear()
    out = np.empty_like(color)
    arguments = color, matrix, out
    assert not library.entry(_mix, types_of(arguments))(arguments)
    return out.tolist()

def flip(content):
    place = random.randrange(len(content))
    return content[:place] + bytes([content[place] ^ 1 << random.randrange(8)]) + content[place + 1:]

def zero(content):
    place, size = random.randrange(len(content)), random.randrange(1, 200)
    return (content[:place] + bytes(size) + content[place + size:])[:len(content)]

def cut(content):
    return content[:random.randrange(len(content))]

def noise(content):
    return random.randbytes(random.randrange(2 * len(content)))

def of_an_earlier_version(content):
    return content[50:]

def appended(content):
    return content + b"0"

def of_another_kernel(content):
    return next(path for path in FILE.parent.glob("*.o") if "_repeat_rows" in path.name).read_bytes()

def as_folder(path):
    path.mkdir()

def as_full_folder(path):
    (path / "folder").mkdir(parents=True)

def as_pipe(path):
    os.mkfifo(path)

def as_link_to_zeros(path):
    path.symlink_to("/dev/zero")

def as_link_to_nothing(path):
    path.symlink_to("nothing")

def as_link_to_a_good_file(path):
    path.symlink_to(GOOD_COPY)

def as_huge_file(path):
    with open(path, "wb") as file:
        file.truncate(1 << 33)

def as_unreadable_file(path):
    path.write_bytes(b"")
    path.chmod(0)

def as_file_that_others_may_write_to(path):
    path.write_bytes(GOOD)
    path.chmod(0o666)

CONTENTS = flip, zero, cut, noise, of_an_earlier_version, appended, of_another_kernel
FILES = (as_folder, as_pipe, as_link_to_zeros, as_link_to_nothing, as_link_to_a_good_file, as_huge_file,
         as_unreadable_file, as_file_that_others_may_write_to, as_full_folder)

out = np.empty((1, 3), np.float32)
arguments = np.ones((1, 1), np.float32), out
library.entry(_repeat_rows, types_of(arguments))(arguments)
assert mixed() == WANTED, mixed()
[FILE] = (path for path in Path(os.environ["XDG_CACHE_HOME"], "vidstyle/kernels").glob("*_mix_*.o"))
GOOD = FILE.read_bytes()
GOOD_COPY = FILE.with_name("copy")
GOOD_COPY.write_bytes(GOOD)
for number in range(count):
    FILE.unlink()
    if number < count - len(FILES):
        case = CONTENTS[number % len(CONTENTS)]
        content = case(GOOD)
        FILE.write_bytes(content)
        is_damaged = content != GOOD
    else:
        case = FILES[number - count]
        case(FILE)
        is_damaged = True
    print(case.__name__, flush=True)
    assert mixed() == WANTED, mixed()
    if is_damaged and case is not as_full_folder:
        assert object_files.load(FILE.stem), case
print("done")
"""


def run(
    script: str, *arguments: object, folder: Path = ROOT, **environment: str
) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", script, *map(str, arguments)]
    return subprocess.run(command, env=os.environ | environment, capture_output=True, text=True, cwd=folder)


@pytest.mark.skipif(os.name != "posix", reason="makes pipes and links")
@pytest.mark.parametrize("count", [24, pytest.param(200, marks=pytest.mark.thorough)])
def test_damaged_and_foreign_files_are_compiled_again_and_replaced(count, tmp_path):
    """Run in a separate process, as a signal would end it."""
    ran = run(DAMAGE, DAY, count, XDG_CACHE_HOME=str(tmp_path))
    lines = ran.stdout.splitlines()
    assert (ran.returncode, lines[-1:]) == (0, ["done"]), ran.stdout + ran.stderr
    assert len(lines) == count + 2
    assert [line for line in lines if "notice" in line] == [
        f"notice: {tmp_path}/vidstyle/kernels has damaged or foreign files; these kernels are compiled again"
    ]


@pytest.fixture
def cache(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A cache folder that others may enter; those of pytest are closed, so that nobody can write to them."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        Path(folder).chmod(0o755)
        monkeypatch.setenv("XDG_CACHE_HOME", folder)
        monkeypatch.setattr(object_files, "_reported", set())
        yield Path(folder)
        object_files._trusted.cache_clear()


@pytest.mark.skipif(os.name != "posix", reason="about owners and modes of files")
def test_a_cache_that_others_may_write_to_is_not_loaded(cache, caplog):
    folder = cache / "vidstyle" / "kernels"
    object_files.store("kernel", b"code")
    assert object_files.load("kernel") == b"code"
    assert stat.S_IMODE(folder.stat().st_mode) == stat.S_IMODE(folder.parent.stat().st_mode) == 0o700
    folder.parent.chmod(0o755)
    for each, mode in ((folder, 0o770), (folder, 0o1707), (folder.parent, 0o775), (cache, 0o757)):
        before = stat.S_IMODE(each.stat().st_mode)
        each.chmod(mode)
        object_files._trusted.cache_clear()
        object_files._reported.clear()
        caplog.clear()
        assert object_files.load("kernel") is None
        assert object_files.load("kernel") is None
        reason = f"{each} is writable by other users"
        assert [record.getMessage() for record in caplog.records] == [
            f"{reason}: kernels are not loaded from {folder}, but compiled in each run; {object_files.REMEDY}"
        ]
        assert f"not used, as {reason}" in object_files.cache_state()
        object_files.store("kernel", b"other code")  # to a temporary folder
        assert object_files.load("kernel") == b"other code"
        (object_files._folder() / "kernel.o").unlink()
        each.chmod(before)
    object_files._trusted.cache_clear()
    assert object_files.load("kernel") == b"code"


@pytest.mark.skipif(os.name != "posix", reason="about owners and modes of files")
def test_a_folder_of_another_user_is_exposed(cache):
    if os.geteuid() == 0:
        folder = cache / "kernels"
        folder.mkdir(0o700)
        os.chown(folder, 65534, 65534)
    else:
        folder = Path("/usr")
    assert exposure_of(folder) == f"{folder} belongs to another user"
    link = cache / "link"
    link.symlink_to(folder)
    assert exposure_of(link) == f"{link} belongs to another user"


@pytest.mark.skipif(os.name != "posix", reason="about owners and modes of files")
def test_a_sticky_folder_above_the_cache_keeps_it(cache):
    """As /tmp does: others add files there, but cannot replace ours."""
    cache.chmod(0o1777)
    assert not exposure_of(cache / "vidstyle" / "kernels")
    (cache / "vidstyle").mkdir(0o755)
    assert not exposure_of(cache / "vidstyle" / "kernels")


def test_a_cache_that_cannot_be_written_is_reported_once(cache, caplog):
    (cache / "vidstyle").write_text("a file in place of the folder")
    for _ in range(2):
        object_files.store("kernel", b"code")
        assert object_files.load("kernel") is None
    [notice] = (record.getMessage() for record in caplog.records)
    assert notice.startswith(f"{cache / 'vidstyle' / 'kernels'} cannot be written (")
    assert notice.endswith(f": kernels are compiled again in each run; {object_files.REMEDY}")
    assert "not writable" in object_files.cache_state()


def test_the_state_of_the_cache_counts_sound_and_damaged_files(cache):
    folder = cache / "vidstyle" / "kernels"
    assert object_files.cache_state() == f"{folder} (0 kernels)"
    object_files.store("one", b"code")
    object_files.store("other", b"code")
    assert object_files.cache_state() == f"{folder} (2 kernels)"
    (folder / "other.o").replace(folder / "foreign.o")
    assert object_files.cache_state() == f"{folder} (1 kernels, 1 damaged or of other versions)"


def test_a_user_without_a_home_gets_a_temporary_cache(tmp_path):
    """A number without an entry in the list of users, as `docker run --user 1234` has, and no HOME."""
    script = """
import os, sys
os.path.expanduser = lambda path: path  # what it does there
import logging
logging.basicConfig(format="%(message)s", stream=sys.stdout)
from vidstyle.core.machine.user_cache import user_cache
print(user_cache() == user_cache(), user_cache().is_dir(), user_cache())
"""
    environment = {"XDG_CACHE_HOME": "relative", "LOCALAPPDATA": "", "PYTHONPATH": str(ROOT)}
    ran = run(script, folder=tmp_path, **environment)
    notice, facts = ran.stdout.splitlines()
    assert notice.startswith("this user has no home folder") and "XDG_CACHE_HOME" in notice
    same, exists, folder = facts.split(maxsplit=2)
    assert (same, exists, Path(folder).exists()) == ("True", "True", False), ran.stderr
    assert not list(tmp_path.iterdir())


def test_a_relative_path_in_the_environment_is_ignored(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    assert user_cache().is_relative_to(tmp_path)
