"""Fixtures for tests of faces and people."""

from __future__ import annotations

from pathlib import Path

import pytest
from face_network import red_people
from pictures import keep_writing

from vidstyle.regions.chosen_files import MODEL_VARIABLE


@pytest.fixture
def faces_alone(monkeypatch: pytest.MonkeyPatch, without_writing: None) -> None:
    """Without writing and finer marks in the whole picture."""
    monkeypatch.setattr("vidstyle.regions.focus.with_detail", lambda style, detail: style)


@pytest.fixture
def without_writing(monkeypatch: pytest.MonkeyPatch) -> None:
    """On the table and the clothes of `picture_with_face` there are thin strokes."""
    monkeypatch.setattr("vidstyle.regions.focus.lift_writing", keep_writing)


@pytest.fixture
def red_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A model for which everything red is people."""
    path = tmp_path / "red.onnx"
    path.write_bytes(red_people())
    monkeypatch.setenv(MODEL_VARIABLE, str(path))
    return path
