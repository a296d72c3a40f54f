"""Compiled functions: they call each other, take several types, and need no writable folder."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vidstyle.cli.reporting import Reporting
from vidstyle.core import kernels
from vidstyle.core.kernels import compiled, user_cache


@compiled
def halve(value):
    return value / 2


@compiled(fastmath=True)
def halve_all(values, halves):
    for index in range(values.size):
        halves[index] = halve(values[index])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_kernel_calls_another_and_takes_several_types(dtype):
    values = np.arange(7, dtype=dtype)
    halves = np.empty(7)
    halve_all(values, halves)
    assert halves.tolist() == [0, 0.5, 1, 1.5, 2, 2.5, 3]


def test_a_kernel_runs_where_nothing_may_be_written(tmp_path):
    """Nowhere to write: neither the cache folder, nor beside the code, nor the home."""
    source = tmp_path / "somewhere.py"
    source.write_text(
        "from vidstyle.core.kernels import compiled\n"
        "@compiled\ndef double(number):\n    return 2 * number\n"
        "print(double(21))\n"
    )
    blocked = tmp_path / "a_file"
    blocked.write_text("")
    (tmp_path / "__pycache__").write_text("a file where numba would want a folder")
    environment = os.environ | {"XDG_CACHE_HOME": str(blocked), "HOME": str(blocked)}
    environment["PYTHONPATH"] = str(Path(__file__).parents[1])
    ran = subprocess.run([sys.executable, source], env=environment, capture_output=True, text=True)
    assert ran.stdout == "42\n", ran.stderr


def test_importing_kernels_imports_no_numba():
    check = "import sys, vidstyle.core.kernels; print('numba' in sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", check], capture_output=True, text=True, cwd=Path(__file__).parents[1]
    )
    assert ran.stdout == "False\n", ran.stderr


def test_the_cache_is_with_the_users_other_caches(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert user_cache() == tmp_path / "vidstyle"


def test_who_waits_at_a_terminal_is_told_that_it_compiles(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for terminal in (False, True):
        kernels._announce_compilation.cache_clear()
        with Reporting():
            monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal)
            kernels._announce_compilation()
            kernels._announce_compilation()
        assert capsys.readouterr().err.count("compiling for this processor") == terminal
