"""Fixtures for all tests."""

from __future__ import annotations

from pathlib import Path

import pytest
from faults import Program

collect_ignore = ["gstreamer_pipeline.py"]
"""A program for the Python of GStreamer, which has modules that ours need not have."""


@pytest.fixture
def program(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> Program:
    """`vidstyle render`, writing into this test's folder."""
    return Program(tmp_path, capfd)
