"""Compiled functions: their arguments, their object files, and what the first use of a style compiles."""

from __future__ import annotations

import ctypes
import math
import os
import subprocess
import sys
import threading
from concurrent.futures import Future
from contextlib import ExitStack, nullcontext
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from covering import of_the_day
from pictures import VIDEO, codes
from waiting import LONG

from vidstyle.cli.terminal.reporting import Reporting
from vidstyle.core.kernels import Compiled, cached, compiled, dry_run, library
from vidstyle.core.kernels.arguments import ADDRESSES, MIN_UNLOCKED_NUMBERS
from vidstyle.core.kernels.compiler_pool import CompilerPool
from vidstyle.core.kernels.declare import OTHER_TYPES, SUCCEEDED, types_of
from vidstyle.core.machine.user_cache import user_cache
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.style import load_style, style_names


@compiled
def halve(value):
    return value / 2


@compiled(fastmath=True)
def halve_all(values, halves):
    for index in range(values.size):
        halves[index] = halve(values[index])


@compiled
def double(value):
    return value * 2


@compiled
def each_by(formula, values, out):
    for index in range(values.size):
        out[index] = formula(values[index])


@compiled
def mix(planes, factors, is_negative, shift, rows, out):
    """Takes one of each kind."""
    first, (second, third) = planes
    for row in range(rows[0], rows[1]):
        for x in range(out.shape[1]):
            total = first[row, x] * factors[0] + second[row, x, 1] * factors[1] + third[x]
            out[row, x] = shift - total if is_negative else shift + total


@compiled
def take_memory(size):
    line = np.empty(size, np.uint8)
    line[0] = 1


@compiled
def refuse(number):
    if number < 0:
        raise ValueError


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_kernel_calls_another_and_takes_several_types(dtype):
    values = np.arange(7, dtype=dtype)
    halves = np.empty(7)
    halve_all(values, halves)
    assert halves.tolist() == [0, 0.5, 1, 1.5, 2, 2.5, 3]


def test_a_kernel_takes_another_as_an_argument():
    values, out = np.arange(3.0), np.empty(3)
    for formula, wanted in ((halve, [0, 0.5, 1]), (double, [0, 2, 4]), (halve, [0, 0.5, 1])):
        each_by(formula, values, out)
        assert out.tolist() == wanted


@pytest.mark.parametrize("is_negative", [False, True])
def test_a_kernel_takes_arrays_tuples_and_numbers(is_negative):
    """Whether arrays are contiguous, reversed or parts of others."""
    draw = np.random.default_rng(1).random
    first, second = draw((9, 24))[::2, ::-3], draw((5, 8, 3)).astype(np.float32)
    planes = first, (second, draw(8))
    for out in (np.zeros((5, 8), np.float32), np.zeros((5, 16), np.float32)[:, ::2]):
        wanted = out.copy()
        for call, result in ((mix, out), (mix.function, wanted)):
            call(planes, (2.5, np.float32(0.3)), is_negative, 1, (1, 4), result)
        np.testing.assert_allclose(out, wanted, rtol=1e-6)
        assert out[2].any() and not out[0].any()


class Rows(np.ndarray):
    """Arrays of a subclass, as other libraries return them."""


def test_a_kernel_called_with_many_types_in_turn_runs_for_each():
    values = [np.arange(12, dtype=dtype).reshape(12)[::step] for dtype in "fdihHb" for step in (1, 2)]
    for array in [
        *values,
        *values[::-1],
        values[0].view(Rows),
        values[0].astype(np.dtype("f", metadata={"a": 1})),
    ]:
        halves = np.empty(array.size)
        halve_all(array, halves)
        assert halves.tolist() == [value / 2 for value in array.tolist()]


def test_other_types_are_refused_by_machine_code():
    rows = np.ones((2, 3), np.float32)
    arguments = (rows, (np.ones((2, 3, 2)), rows[0])), (2, np.float32(0.5)), False, 0.25, (0, 2), rows.copy()
    run = library.entry(mix, types_of(arguments))
    assert run(arguments) == SUCCEEDED
    others = {
        0: ((rows, (np.ones((2, 3)), rows[0])), (rows, (np.ones((2, 3, 2), int), rows[0])), (rows, rows[0])),
        1: ((2.0, np.float32(0.5)), (2, 0.5), (True, np.float32(0.5))),
        2: (0, None),
        3: (1, np.float32(1)),
        4: ((0, 2, 0), [0, 2], np.arange(2)),
        5: (rows[:, ::2], rows.astype(">f4"), rows.astype(np.float64)),
    }
    for place, replacements in others.items():
        for each in replacements:
            assert run((*arguments[:place], each, *arguments[place + 1 :])) == OTHER_TYPES, (place, each)
    assert run(arguments[:-1]) == OTHER_TYPES


def test_pythons_lock_is_released_for_large_arrays_only():
    calls = []
    save = ctypes.CFUNCTYPE(ctypes.c_void_p)(lambda: calls.append("save") or 77)
    restore = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(calls.append)
    for size in (1, MIN_UNLOCKED_NUMBERS // 2, MIN_UNLOCKED_NUMBERS // 2 + 1):
        arguments = np.ones(size, np.float32), np.empty(size, np.float32)
        run = library.entry(halve_all, types_of(arguments))
        for name, function in (("PyEval_SaveThread", save), ("PyEval_RestoreThread", restore)):
            run.args[0][ADDRESSES[name]] = ctypes.cast(function, ctypes.c_void_p).value
        assert run(arguments) == SUCCEEDED and arguments[1][-1] == 0.5
    assert calls == ["save", 77]


def test_what_a_kernel_cannot_take_is_named():
    with pytest.raises(TypeError, match="take_memory takes arrays, numbers, kernels and tuples, not str"):
        take_memory("much")


def test_a_kernel_makes_no_arrays():
    with pytest.raises(TypeError, match=r"take_memory cannot be compiled: [\s\S]*np.empty"):
        take_memory(1)


def test_a_kernel_that_raises_an_error_is_no_success():
    refuse(1)
    with pytest.raises(RuntimeError, match="refuse raised an error"):
        refuse(-1)


def test_object_files_are_loaded_without_the_compiler(tmp_path):
    check = (
        "import sys, numpy as np\n"
        "from vidstyle.core.color.deferred_color import Mixed\n"
        "color = np.ones((1, 1, 3), np.float32)\n"
        "mixed = Mixed(color, np.eye(3, 4, dtype=np.float32)).whole()\n"
        "print(mixed.tolist(), 'numba' in sys.modules)\n"
    )
    for _ in range(2):
        ran = subprocess.run(
            [sys.executable, "-c", check], env=os.environ | {"XDG_CACHE_HOME": str(tmp_path)},
            capture_output=True, text=True, cwd=Path(__file__).parents[2],
        )  # fmt: skip
        assert ran.stdout == "[[[1.0, 1.0, 1.0]]] False\n", ran.stderr
        assert len(list(tmp_path.glob("vidstyle/kernels/_mix_*.o"))) == 1


def test_what_another_program_has_stored_meanwhile_is_not_compiled_again():
    """Several programs that begin at the same time order the same kernels."""
    stored, orders = {"first": b"stored"}, {name: Future() for name in ("first", "second")}
    pool = CompilerPool(stored.get, stored.__setitem__)
    for name, code in orders.items():
        pool.take(name, (double, (int,)), code)
    assert orders["first"].result(LONG) == b"stored"
    assert orders["second"].result(LONG) == stored["second"] != b"stored"


def test_where_no_process_can_be_started_kernels_are_compiled_here(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "embedding-program"))
    values, halves = np.arange(3, dtype=np.int16), np.empty(3)
    halve_all(values, halves)
    assert halves.tolist() == [0, 0.5, 1]


@pytest.mark.parametrize("name", of_the_day(style_names(), 3))
def test_a_rehearsal_calls_every_kernel_that_two_frames_of_a_style_need(name, monkeypatch):
    """So that all of them are compiled together at its first use."""
    picture, called, rehearsals = codes(VIDEO, 72, 128), set(), []
    carry_out = Compiled.__call__

    def noted(kernel, *arguments):
        called.add((kernel, types_of(arguments)))
        return carry_out(kernel, *arguments)

    def rehearsing(_, rehearsal):
        rehearsals.append(rehearsal)
        return nullcontext()

    with CpuRenderer(load_style(name)) as renderer, monkeypatch.context() as patch:
        patch.setattr(Compiled, "__call__", noted)
        patch.setattr("vidstyle.cpu.renderer.rehearsing", rehearsing)
        renderer.run(picture, 0.0)
        renderer.run(picture.map_planes(lambda plane, _: plane & 0xFE), 0.04)
    with dry_run() as rehearsed, np.errstate(all="ignore"):
        for rehearsal in rehearsals:  # none where a style has no steps
            rehearsal()
    # Results that an earlier test left in a cache are not computed by the renderer.
    missing = called - set(rehearsed)
    assert not missing


def test_frames_in_flight_are_rehearsed_once():
    rehearsed, one, other = [], object(), object()
    with ExitStack() as stack:
        for name, owner in (("first", one), ("other", other), ("second", one)):
            stack.enter_context(library.rehearsing(owner, partial(rehearsed.append, name)))
        library._needed_soon()
        assert len(rehearsed) == 2 and "other" in rehearsed
    library._needed_soon()
    assert len(rehearsed) == 2


def test_a_rehearsal_within_a_remembered_computation_does_not_wait_for_it():
    rehearsed = []

    @cached(maxsize=1)
    def drawn():
        if not rehearsed:  # a kernel is missing here, and the rehearsal comes by again
            rehearsed.append(True)
            with dry_run():
                drawn()
        return np.ones(1)

    computing = threading.Thread(target=drawn, daemon=True)
    computing.start()
    computing.join(LONG)
    assert not computing.is_alive()


def test_what_is_remembered_takes_no_more_than_it_may():
    made = []

    @cached(maxsize=8, most_bytes=3000)
    def zeros(number: int, size: int) -> np.ndarray:
        made.append(number)
        return np.zeros(size, np.uint8)

    for number in (1, 2, 3, 1, 4, 2, 1):  # 2 was used longest ago when 4 comes
        zeros(number, 1000)
    assert made == [1, 2, 3, 4, 2]
    zeros(5, 9000)  # alone it is more, and nothing else is kept
    zeros(5, 9000)
    zeros(1, 1000)
    assert made == [1, 2, 3, 4, 2, 5, 1]


def test_a_kernel_runs_where_nothing_may_be_written(tmp_path):
    """No writable folder: neither the cache folder, nor the package, nor the home folder."""
    source = tmp_path / "somewhere.py"
    source.write_text(
        "from vidstyle.core.kernels import compiled\n"
        "import numpy as np\n"
        "@compiled\ndef double(numbers):\n    numbers[0] *= 2\n"
        "number = np.array([21])\n"
        "double(number)\n"
        "print(number[0])\n"
    )
    blocked = tmp_path / "a_file"
    blocked.write_text("")
    (tmp_path / "__pycache__").write_text("a file where numba would want a folder")
    environment = os.environ | {"XDG_CACHE_HOME": str(blocked), "HOME": str(blocked)}
    environment["PYTHONPATH"] = str(Path(__file__).parents[2])
    ran = subprocess.run([sys.executable, source], env=environment, capture_output=True, text=True)
    assert ran.stdout == "42\n", ran.stderr


def test_what_is_compiled_is_what_was_imported(tmp_path):
    """From the working folder, although another module of that name is further on in the path."""
    for name, factor in (("here", 2), ("elsewhere", 3)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "times.py").write_text(
            "from vidstyle.core.kernels import compiled\n"
            f"@compiled\ndef multiply(numbers):\n    numbers[0] *= {factor}\n"
        )
    use = "import numpy, times; number = numpy.array([21]); times.multiply(number); print(number[0])"
    path = os.pathsep.join([str(tmp_path / "elsewhere"), str(Path(__file__).parents[2])])
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": path}
    command = [sys.executable, "-c", use]
    ran = subprocess.run(command, env=environment, cwd=tmp_path / "here", capture_output=True, text=True)
    assert ran.stdout == "42\n", ran.stderr


def test_importing_kernels_imports_no_numba():
    check = "import sys, vidstyle.core.kernels; print('numba' in sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", check], capture_output=True, text=True, cwd=Path(__file__).parents[2]
    )
    assert ran.stdout == "False\n", ran.stderr


def test_the_cache_is_with_the_users_other_caches(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert user_cache() == tmp_path / "vidstyle"


@pytest.mark.parametrize("terminal", [False, True])
def test_who_waits_is_told_once_that_a_style_is_being_prepared(
    terminal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Soon at a terminal, later in a log."""
    monkeypatch.setattr(library, "PAUSE_SECONDS", math.inf)
    monkeypatch.setattr(library._Wait, "began", 0)  # long ago
    library.announce.cache_clear()
    code: Future[bytes] = Future()
    with Reporting():
        monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
        library.announce(only_on_terminal=True)
        assert bool(capsys.readouterr().err) == terminal
        threading.Timer(0.05, code.set_result, [b"code"]).start()
        assert library._delivered(code) == b"code"
    assert capsys.readouterr().err.count("vidstyle: preparing this style, once") == (not terminal)


def test_progress_as_json_holds_no_announcement(capsys: pytest.CaptureFixture[str]) -> None:
    library.announce.cache_clear()
    with Reporting(["--progress", "json"]):
        library.announce(only_on_terminal=False)
    assert not capsys.readouterr().err


def test_waits_with_a_pause_between_them_are_two(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kernel that takes a moment, long after others, is not announced."""
    announced: list[bool] = []
    monkeypatch.setattr(library, "announce", announced.append)
    for ended in (-math.inf, math.inf):
        monkeypatch.setattr(library._Wait, "began", -1000)
        monkeypatch.setattr(library._Wait, "ended", ended)
        code: Future[bytes] = Future()
        threading.Timer(0.05, code.set_result, [b"code"]).start()
        library._delivered(code)
        assert announced == ([] if ended < 0 else [True, False])
