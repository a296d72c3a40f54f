"""Small pictures have all threads in these tests, as large ones have in a film."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def all_threads_for_small_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vidstyle.core.bands.MAX_MEGAPIXEL_THREADS", 1e9)
