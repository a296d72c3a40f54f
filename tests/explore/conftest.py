"""A folder to work in, and a visitor of the explorer's page, which each file of tests makes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from live_page import Visitor, Window

from vidstyle.explore.page.explore_server import ExploreServer


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The working folder, and that of the user's styles."""
    folder = tmp_path_factory.mktemp("explore")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("XDG_CONFIG_HOME", str(folder / "config"))
        yield folder


@pytest.fixture
def visitor(page: ExploreServer) -> Visitor:
    return Visitor(page)  # type: ignore[arg-type]


@pytest.fixture
def window(visitor: Visitor) -> Iterator[Window]:
    with visitor.look() as window:
        yield window
