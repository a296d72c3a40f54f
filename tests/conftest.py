"""Fixtures for all tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import moderngl
import pytest
from faults import Program

collect_ignore = ["gstreamer_pipeline.py"]
"""A program for the Python of GStreamer, which has modules that ours need not have."""


@pytest.fixture(scope="module")
def context() -> Iterator[moderngl.Context]:
    """An OpenGL context of its own, without a window."""
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
