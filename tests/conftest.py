"""Fixtures for all tests, and the seed and the threads of a run."""

from __future__ import annotations

import gc
import os
import random
import signal
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

if "PYTEST_XDIST_WORKER" in os.environ:
    # Each of several processes keeps to one core, as do the programs that it starts: Mesa without threads of
    # its own, beside those that call it.
    os.environ |= {"LP_NUM_THREADS": "0", "NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
# Not as a program that was started in the background or by nohup has them, and gives them to its own.
for _number, _handler in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(_number) is signal.SIG_IGN:
        signal.signal(_number, _handler)
os.environ["XDG_CONFIG_HOME"] = os.devnull  # without the user's own styles
SEED = os.environ.setdefault("VIDSTYLE_TEST_SEED", f"{datetime.now(UTC):%Y%m%d}")
"""What random tests draw their cases from: the date, unless the variable says otherwise."""
SHARE = float(os.environ.get("VIDSTYLE_TEST_SHARE", "1"))
"""The share of the thorough tests that runs, others by each seed."""

gc.disable()  # until all tests are collected: they stay until the end, and none of them is garbage

import cv2  # noqa: E402
import moderngl  # noqa: E402
import pytest  # noqa: E402
from faults import Program  # noqa: E402

if "PYTEST_XDIST_WORKER" in os.environ:
    cv2.setNumThreads(1)

pytest_plugins = ["browser"]
collect_ignore = ["support", "export/gstreamer_pipeline.py"]
"""What tests share, and a program for the Python of GStreamer, whose modules ours need not have."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Draw a share of the thorough tests, and begin with those that wait, while others have work to do."""

    def is_left_out(item: pytest.Item) -> bool:
        is_thorough = item.get_closest_marker("thorough") is not None
        return is_thorough and random.Random(f"{SEED} {item.nodeid}").random() >= SHARE

    left_out = [item for item in items if is_left_out(item)]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item in items if not is_left_out(item)]
    items.sort(key=lambda item: item.path.parent.name != "live")


def pytest_collection_finish() -> None:
    """Let no garbage collection go through all tests again: it took a tenth of the time."""
    gc.freeze()
    gc.enable()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say how a failed run can be repeated: another day's has other random cases."""
    if terminalreporter.stats.get("failed"):
        terminalreporter.write_line(f"To repeat these cases, set VIDSTYLE_TEST_SEED={SEED}.")


@pytest.fixture(scope="module")
def context() -> Iterator[moderngl.Context]:
    """A separate OpenGL context without a window."""
    context = moderngl.create_context(standalone=True, backend="egl", libgl="libEGL.so.1")
    # What is dropped without being released comes into context.objects.
    context.gc_mode = "context_gc"
    yield context
    assert context.error == "GL_NO_ERROR"
    context.release()


@pytest.fixture
def program(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> Program:
    """`vidstyle render`, writing into this test's folder."""
    return Program(tmp_path, capfd)
