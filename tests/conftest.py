"""Fixtures for all tests."""

from __future__ import annotations

from pathlib import Path

import pytest
from faults import Program


@pytest.fixture
def program(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> Program:
    """`vidstyle render`, writing into this test's folder."""
    return Program(tmp_path, capfd)
