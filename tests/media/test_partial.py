"""Partial files: targets that are rejected before one is created, and what remains when writing fails."""

from __future__ import annotations

import os
import secrets
import subprocess
import sys
from pathlib import Path

import pytest
from media import make_clip, read_all

from vidstyle.errors import OutputError, UsageError, output_error
from vidstyle.media.read.reader import open_reader
from vidstyle.media.write import atomic, temporary_files
from vidstyle.media.write.atomic import PartialFile
from vidstyle.media.write.resume_source import count_frames
from vidstyle.media.write.run_record import RunRecord
from vidstyle.media.write.writer import WriteOptions, open_writer
from vidstyle.pipeline.render import render


def snapshot(folder: Path) -> dict[str, bytes]:
    """The content of every file in a folder; the targets of its links."""
    return {
        path.name: os.fsencode(os.readlink(path)) if path.is_symlink() else path.read_bytes()
        for path in folder.iterdir()
        if not path.is_dir()
    }


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


@pytest.mark.parametrize("overwrite", [False, True])
@pytest.mark.parametrize("kind", ["film", "empty", "link", "folder", "film of an unfinished run"])
def test_a_file_of_the_partial_files_name_is_never_touched(tmp_path, kind, overwrite):
    (tmp_path / "precious").write_text("mine")
    path = tmp_path / "a.partial.mp4"
    if kind == "link":
        path.symlink_to(tmp_path / "precious")
    elif kind == "folder":
        path.mkdir()
    else:
        path.write_text("" if kind == "empty" else "mine")
    clip = make_clip(tmp_path / "clip.mp4", frames=3)
    if kind == "film of an unfinished run":
        RunRecord(tmp_path / "a.mp4").release()
    before = snapshot(tmp_path)
    with open_reader(clip) as reader, pytest.raises(UsageError, match=r"a.partial.mp4.*rename or remove it"):
        open_writer(tmp_path / "a.mp4", reader.info, WriteOptions(overwrite=overwrite), reader)
    assert snapshot(tmp_path) == before


@pytest.mark.parametrize("ending", [".mp4", ".mkv", ".avi", ".gif", ".png"])
def test_neighbours_with_every_name_that_the_program_uses_stay(tmp_path, monkeypatch, ending):
    clip = make_clip(tmp_path / "clip.mp4", frames=20)
    tokens = [f"{number:016x}" for number in range(4)]
    drawn = iter([*tokens, *"free"])
    monkeypatch.setattr(secrets, "token_hex", lambda _: next(drawn))
    random = [f"a.vidstyle-{token}{ending}" for token in tokens]
    random += [f"a{ending}.partial.vidstyle-{token}.jsonl" for token in tokens]
    for name in [*random, f"a.partial.2{ending}", f"a{ending}.partial", f"a{ending}.partial.json", "a.lock"]:
        (tmp_path / name).write_text(name)
    before = snapshot(tmp_path)
    render(clip, tmp_path / f"a{ending}", "plain", frames=1 if ending == ".png" else 20)
    after = snapshot(tmp_path)
    assert after.pop(f"a{ending}") and after == before


@pytest.mark.parametrize("ending", [".mp4", ".mov"])
def test_an_input_whose_name_was_that_of_a_temporary_file_stays(tmp_path, ending):
    source = make_clip(tmp_path / f"a.partial.2{ending}", frames=3)
    content = source.read_bytes()
    render(source, tmp_path / f"a{ending}", "plain")
    assert source.read_bytes() == content and sorted(os.listdir(tmp_path)) == [f"a{ending}", source.name]


@pytest.mark.parametrize("content", ["", "{}", '{"unfinished output of vidstyle": "b.mp4"}', "[[[" * 100000])
def test_a_file_that_is_no_record_of_this_output_is_never_touched(tmp_path, content):
    path = tmp_path / "a.mp4.partial.jsonl"
    path.write_text(content)
    with pytest.raises(UsageError, match="a.mp4.partial.jsonl exists and is not.*rename or remove it"):
        PartialFile(tmp_path / "a.mp4", None, True)
    assert snapshot(tmp_path) == {path.name: content.encode()}


def test_the_next_run_removes_the_temporary_files_of_a_killed_one_and_no_other(tmp_path):
    record = RunRecord(tmp_path / "a.mp4")
    temporary, _ = record.create_temporary(tmp_path / "a.mp4")
    (tmp_path / "folder").mkdir()
    mine = [tmp_path / name for name in ("b.mp4", "folder/a.vidstyle-0123456789abcdef.mp4")]
    for path in mine:
        path.write_text("mine")
        record.append(temporary=str(path.relative_to(tmp_path)))
    record.release()
    assert temporary.exists()
    RunRecord(tmp_path / "a.mp4").remove()
    assert sorted(os.listdir(tmp_path)) == ["b.mp4", "folder"] and all(path.exists() for path in mine)


def test_a_record_is_not_removed_twice(tmp_path):
    """Its number may be that of another run's record by then."""
    first = RunRecord(tmp_path / "a.mp4")
    first.remove()
    second = RunRecord(tmp_path / "a.mp4")
    first._lock.identity = second._lock.identity
    first.remove()
    assert second.path.exists()


@pytest.mark.parametrize("length", [251, 240])
def test_the_longest_names_have_room(tmp_path, length):
    target = tmp_path / ("\N{LATIN SMALL LETTER E WITH ACUTE}" * (length // 2) + ".mp4")
    file = PartialFile(target, None, False)
    assert len(os.fsencode(file.path.name)) <= 255 and file.path.name.endswith(".partial.mp4")
    file.rewrite(lambda source, other: other.write_bytes(b"new") == 3)
    assert file.path.read_bytes() == b"new"
    assert sorted(tmp_path.iterdir()) == sorted([file.path, file.record.path])


def test_a_rewrite_that_fails_leaves_the_file_as_it_was(tmp_path):
    file = PartialFile(tmp_path / "a.mp4", None, False)
    file.path.write_text("film")

    def fail(_source: Path, other: Path) -> bool:
        other.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="space"):
        file.rewrite(fail)
    assert file.path.read_text() == "film"
    assert sorted(tmp_path.iterdir()) == sorted([file.path, file.record.path])


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
    monkeypatch.setattr(atomic, "POLL_SECONDS", 0)
    with open_reader(clip) as reader:
        writer = open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader)
        with pytest.raises(OutputError, match=r"MB are left.*the first \d+ frames are kept in .*out.partial"):
            for item in reader:
                if writer.frames == 60:
                    monkeypatch.setattr(atomic, "MIN_FREE_BYTES", 2**60)
                writer.write(item)
        left = writer.abandon()
    assert left == tmp_path / "out.partial.mp4" and len(read_all(left)) == count_frames(left) > 30


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_run_owns_its_partial_file_until_it_ends(tmp_path, overwrite):
    file = PartialFile(tmp_path / "a.mp4", None, False)
    with pytest.raises(UsageError, match=f"a.mp4 is being written by process {os.getpid()}"):
        PartialFile(tmp_path / "a.mp4", None, overwrite)
    file.rewrite(lambda source, other: other.write_text("film") == 4)
    with pytest.raises(UsageError, match="is being written"):
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
        with pytest.raises(UsageError, match=f"is being written by process {other.pid}"):
            PartialFile(tmp_path / "a.mp4", None, True)
        other.kill()
    PartialFile(tmp_path / "a.mp4", None, False).remove()


@pytest.mark.parametrize("ending", [".mp4", ".mkv", ".webm", ".nut"])
def test_a_run_killed_before_its_first_frame_does_not_block_the_next(tmp_path, ending):
    """Kernels may be compiled for a minute before the first frame, when only a header is written."""
    target = tmp_path / f"a{ending}"
    with open_reader(make_clip(tmp_path / "in.mp4", frames=2)) as reader:
        killed = open_writer(target, reader.info, WriteOptions())
        killed._file.record.release()  # as the system does
        left = snapshot(tmp_path)
    assert left.keys() > {f"a.partial{ending}"}
    render(tmp_path / "in.mp4", target, "plain")
    assert len(read_all(target)) == 2
    killed.abandon()


def test_a_folder_without_locks_is_written_to_all_the_same(tmp_path, monkeypatch):
    def flock(*_: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr(temporary_files.fcntl, "flock", flock)
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
    with pytest.raises(OutputError, match="appeared during the run"):
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
        with pytest.raises(OutputError, match="appeared during the run.*complete film is .*out.partial.mp4"):
            writer.finish()
    assert (tmp_path / "out.mp4").read_text() == "mine"
    assert len(read_all(tmp_path / "out.partial.mp4")) == 10


@pytest.mark.parametrize("replaced", [False, True])
def test_a_partial_file_that_is_taken_away_is_noticed_at_once(tmp_path, monkeypatch, replaced):
    clip = make_clip(tmp_path / "clip.mp4", frames=60)
    monkeypatch.setattr(atomic, "POLL_SECONDS", 0)
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
            with pytest.raises(UsageError, match=f"is being written by process {os.getpid()}"):
                open_writer(tmp_path / "%02d.png", reader.info, WriteOptions(overwrite=True), reader)
            writer.abandon()
    assert os.listdir(tmp_path) == ["clip.mp4"]


def test_a_system_error_is_said_in_plain_words():
    assert "the disk is full" in str(output_error("a.mp4", OSError(28, "x"), "y"))
    assert output_error("a.mp4", OSError(32, "x")).exit_code == 5
