"""Partial files: targets that are rejected before one is created, and what remains when writing fails."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from media import make_clip, read_all

from vidstyle.errors import OutputError, UsageError, output_error
from vidstyle.media.read.reader import open_reader
from vidstyle.media.write import atomic as partial
from vidstyle.media.write import file_lock
from vidstyle.media.write.atomic import PartialFile
from vidstyle.media.write.film_writer import frames_in
from vidstyle.media.write.writer import WriteOptions, open_writer


def test_it_gets_its_name_only_when_it_is_whole(tmp_path):
    file = PartialFile(tmp_path / "a.mp4", None, False)
    assert file.path == tmp_path / "a.partial.mp4" and file.path.exists()
    file.path.write_text("film")
    file.finish()
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def test_what_exists_is_replaced_only_when_asked(tmp_path):
    (tmp_path / "a.mp4").write_text("mine")
    with pytest.raises(UsageError, match="-y"):
        PartialFile(tmp_path / "a.mp4", None, False)
    file = PartialFile(tmp_path / "a.mp4", None, True)
    assert (tmp_path / "a.mp4").read_text() == "mine"
    file.finish()
    assert (tmp_path / "a.mp4").read_text() == ""


@pytest.mark.parametrize("link", ["same", "symbolic", "hard", "target", "dotted"])
def test_the_input_is_never_the_output(tmp_path, link):
    source, target = tmp_path / "in.mp4", tmp_path / "out.mp4"
    source.write_text("film")
    if link == "symbolic":
        target.symlink_to(source)
    elif link == "hard":
        os.link(source, target)
    elif link == "target":
        source.rename(target)
        source.symlink_to(target)
    else:
        target = source if link == "same" else tmp_path / "." / "x" / ".." / "in.mp4"
        (tmp_path / "x").mkdir()
    with pytest.raises(UsageError, match="the input itself"):
        PartialFile(target, source, True)
    assert source.read_text() == "film"


def test_a_leftover_that_is_the_input_is_not_replaced(tmp_path):
    leftover = tmp_path / "a.partial.mp4"
    leftover.write_text("film")
    with pytest.raises(UsageError, match="the input itself"):
        PartialFile(tmp_path / "a.mp4", leftover, True)
    assert leftover.read_text() == "film"


def test_a_leftover_is_told_of_and_replaced(tmp_path, caplog):
    (tmp_path / "a.partial.mp4").write_text("old")
    file = PartialFile(tmp_path / "a.mp4", None, False)
    assert "left over from an earlier run" in caplog.text and file.path.read_text() == ""


def test_a_leftover_that_is_a_link_is_not_written_through(tmp_path):
    (tmp_path / "precious").write_text("mine")
    (tmp_path / "a.partial.mp4").symlink_to(tmp_path / "precious")
    PartialFile(tmp_path / "a.mp4", None, False).path.write_text("film")
    assert (tmp_path / "precious").read_text() == "mine"


@pytest.mark.parametrize("length", [251, 240])
def test_the_longest_names_have_room(tmp_path, length):
    target = tmp_path / ("\N{LATIN SMALL LETTER E WITH ACUTE}" * (length // 2) + ".mp4")
    file = PartialFile(target, None, False)
    assert len(os.fsencode(file.path.name)) <= 255 and file.path.name.endswith(".partial.mp4")
    file.rewrite(lambda source, other: other.write_bytes(b"new") == 3)
    assert file.path.read_bytes() == b"new" and len(list(tmp_path.iterdir())) == 1


def test_a_rewrite_that_fails_leaves_the_file_as_it_was(tmp_path):
    file = PartialFile(tmp_path / "a.mp4", None, False)
    file.path.write_text("film")

    def fail(_source: Path, other: Path) -> bool:
        other.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="space"):
        file.rewrite(fail)
    assert file.path.read_text() == "film" and len(list(tmp_path.iterdir())) == 1


def test_a_missing_folder_a_folder_and_a_circle_of_links(tmp_path):
    with pytest.raises(OutputError, match="folder does not exist"):
        PartialFile(tmp_path / "no" / "a.mp4", None, False)
    with pytest.raises(UsageError, match="is a folder"):
        PartialFile(tmp_path, None, True)
    (tmp_path / "b").symlink_to("c")
    (tmp_path / "c").symlink_to("b")
    with pytest.raises(UsageError):
        PartialFile(tmp_path / "b", None, False)


def test_a_nearly_full_disk_stops_the_film_while_it_can_be_closed(tmp_path, monkeypatch):
    clip = make_clip(tmp_path / "clip.mp4", frames=90)
    monkeypatch.setattr(partial, "POLL_SECONDS", 0)
    with open_reader(clip) as reader:
        writer = open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader)
        with pytest.raises(OutputError, match=r"MB are left.*the first \d+ frames are safe in .*out.partial"):
            for item in reader:
                if writer.frames == 60:
                    monkeypatch.setattr(partial, "MIN_FREE", 2**60)
                writer.write(item)
        left = writer.abandon()
    assert left == tmp_path / "out.partial.mp4" and len(read_all(left)) == frames_in(left) > 30


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_run_owns_its_partial_file_until_it_ends(tmp_path, overwrite):
    file = PartialFile(tmp_path / "a.mp4", None, False)
    with pytest.raises(UsageError, match=f"a.mp4: process {os.getpid()} is writing it"):
        PartialFile(tmp_path / "a.mp4", None, overwrite)
    file.rewrite(lambda source, other: other.write_text("film") == 4)
    with pytest.raises(UsageError, match="is writing it"):
        PartialFile(tmp_path / "a.mp4", None, overwrite)
    file.finish()
    assert (tmp_path / "a.mp4").read_text() == "film"
    PartialFile(tmp_path / "a.mp4", None, True).remove()
    assert (tmp_path / "a.mp4").read_text() == "film"


def test_the_lock_of_a_killed_run_is_gone(tmp_path):
    program = (
        "import sys, time; from pathlib import Path; from vidstyle.media.write.atomic import PartialFile\n"
        "file = PartialFile(Path(sys.argv[1]), None, False); print(file.path, flush=True); time.sleep(60)"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "a.mp4")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None and "partial" in other.stdout.readline()
        with pytest.raises(UsageError, match=f"process {other.pid} is writing it"):
            PartialFile(tmp_path / "a.mp4", None, True)
        other.kill()
    PartialFile(tmp_path / "a.mp4", None, False).remove()


def test_a_folder_without_locks_is_written_to_all_the_same(tmp_path, monkeypatch):
    def flock(*_: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr(file_lock.fcntl, "flock", flock)
    first, second = (PartialFile(tmp_path / "a.mp4", None, False) for _ in range(2))
    os.replace(tmp_path / "a.partial.mp4", tmp_path / "away.mp4")
    third = PartialFile(tmp_path / "a.mp4", None, False)
    for other in (first, second):
        with pytest.raises(OutputError, match="removed or replaced"):
            other.finish()
        other.remove()
    third.finish()


@pytest.mark.parametrize("links", [True, False])
def test_what_appears_meanwhile_is_not_overwritten(tmp_path, monkeypatch, links):
    def link(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    if not links:
        monkeypatch.setattr(os, "link", link)
    file = PartialFile(tmp_path / "a.mp4", None, False)
    (tmp_path / "a.mp4").write_text("mine")
    with pytest.raises(OutputError, match="has appeared meanwhile"):
        file.finish()
    assert (tmp_path / "a.mp4").read_text() == "mine" and file.path.exists()
    (tmp_path / "a.mp4").unlink()
    file.finish()
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def test_a_film_whose_target_appears_is_kept_whole(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", frames=10)
    with open_reader(clip) as reader:
        writer = open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader)
        for item in reader:
            writer.write(item)
        (tmp_path / "out.mp4").write_text("mine")
        with pytest.raises(OutputError, match="appeared meanwhile.*the whole film is .*out.partial.mp4"):
            writer.finish()
    assert (tmp_path / "out.mp4").read_text() == "mine"
    assert len(read_all(tmp_path / "out.partial.mp4")) == 10


@pytest.mark.parametrize("replaced", [False, True])
def test_a_partial_file_that_is_taken_away_is_noticed_at_once(tmp_path, monkeypatch, replaced):
    clip = make_clip(tmp_path / "clip.mp4", frames=60)
    monkeypatch.setattr(partial, "POLL_SECONDS", 0)
    with open_reader(clip) as reader:
        writer = open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader)
        for item in reader:
            if writer.frames == 30:
                writer.partial.unlink()
                if replaced:
                    writer.partial.write_text("mine")
                break
            writer.write(item)
        with pytest.raises(OutputError, match="removed or replaced while it was written; nothing is kept"):
            writer.write(item)
        assert writer.abandon() is None
    assert not (tmp_path / "out.mp4").exists()
    assert (tmp_path / "out.partial.mp4").exists() == replaced


def test_a_sequence_is_written_by_one_run_only(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", frames=1)
    with open_reader(clip) as reader:
        for _ in range(2):
            writer = open_writer(tmp_path / "%02d.png", reader.info, WriteOptions(), reader)
            (tmp_path / "01.partial.png").unlink()  # as in the moment between two pictures
            with pytest.raises(UsageError, match=f"process {os.getpid()} is writing it"):
                open_writer(tmp_path / "%02d.png", reader.info, WriteOptions(overwrite=True), reader)
            writer.abandon()
    assert os.listdir(tmp_path) == ["clip.mp4"]


def test_a_system_error_is_said_in_plain_words():
    assert "the disk is full" in str(output_error("a.mp4", OSError(28, "x"), "y"))
    assert output_error("a.mp4", OSError(32, "x")).exit_code == 5
