"""Where the user's own files are."""

from __future__ import annotations

from pathlib import Path

import pytest

from vidstyle.assets import configuration_folder


@pytest.mark.parametrize(
    ("platform", "folder"), [("darwin", "Library/Application Support"), ("linux", ".config")]
)
def test_configuration_lies_where_each_system_keeps_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, platform: str, folder: str
) -> None:
    for name in ("XDG_CONFIG_HOME", "APPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    monkeypatch.setattr("sys.platform", platform)
    assert configuration_folder() == tmp_path / folder / "vidstyle"
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "own"))
    assert configuration_folder() == tmp_path / "own" / "vidstyle"
