"""Uploads: the name of the temporary file."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from media import make_picture

from vidstyle.preview.clip import FilmClip
from vidstyle.preview.uploads import FileUpload


@pytest.mark.parametrize(
    ("encoding", "name", "stored"),
    [
        ("utf-8", "../Fu\u0308r \u30d5 50%.png", "F\u00fcr-\u30d5-50.png"),
        ("ascii", "F\u00fcr.png", "F-r.png"),
        ("ascii", "\u30d5.png", "dropped.png"),
        ("utf-8", 99 * "\u30d5" + ".png", 50 * "\u30d5" + ".png"),
    ],
)
def test_a_file_is_stored_under_the_letters_of_its_name_that_the_file_system_can_store(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, encoding: str, name: str, stored: str
) -> None:
    content = make_picture(tmp_path / "photo.png", size=(50, 40)).read_bytes()
    monkeypatch.setattr(sys, "getfilesystemencoding", lambda: encoding)
    upload = FileUpload(1, name, len(content))
    upload.write(content)
    clip = upload.open()
    assert isinstance(clip, FilmClip)
    assert Path(clip.file()).name == stored
    clip.close()
