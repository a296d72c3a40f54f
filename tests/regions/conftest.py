"""A fixture for tests of faces."""

from __future__ import annotations

import pytest


@pytest.fixture
def faces_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without writing: on the table and the clothes of `picture_with_face` there are thin strokes, too."""
    monkeypatch.setattr(
        "vidstyle.regions.writing.lifting.lift_writing", lambda picture, amount: (picture, [])
    )
