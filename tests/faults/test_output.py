"""Hostile file names, and outputs that cannot be written: 26 to 30 of "Bad input" in docs/rules.md."""

from __future__ import annotations

import hashlib
import os
import re
import resource
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from faults import Program, drop_file_privileges, video
from media import make_clip, make_picture
from waiting import LONG

NAMES = [
    "-x.mp4",
    "a:b.mp4",
    "concat:other.mp4",
    "subfile,,start,0,end,9,,:other.mp4",
    "http:x.mp4",
    "data:x.mp4",
    "pipe:0.mp4",
    "file:x.mp4",
    "new\nline.mp4",
    "\x1b[31mred.mp4",
    "$(touch danger).mp4",
    "a b'c\"d;e|f.mp4",
    "\N{GRINNING FACE}\N{LATIN SMALL LETTER U WITH DIAERESIS}.mp4",
    "n" * 251 + ".mp4",
]


@pytest.mark.parametrize("name", NAMES)
def test_26_a_hostile_name_is_only_a_name(program: Program, name, monkeypatch):
    folder = program.folder / "films"
    folder.mkdir()
    make_clip(folder / "other.mp4", frames=7, size=(64, 64))
    clip = make_clip(program.folder / "clip.mp4", frames=3, size=(96, 64))
    monkeypatch.chdir(folder)
    os.rename(clip, name)
    outcome = program(name, "copy.mp4")
    assert outcome.exit_code == 0, outcome.said
    assert len(video(outcome.target)) == 3
    os.rename(outcome.target, "plain.mp4")
    os.rename(name, "away.mp4")
    outcome = program("away.mp4", Path("films", name))
    assert outcome.exit_code == 0, outcome.said
    assert len(video(folder / name)) == 3
    assert sorted(os.listdir(folder)) == sorted(["other.mp4", "plain.mp4", "away.mp4", name])


@pytest.mark.parametrize("name", ["new\nline.mp4", "\x1b[31mred.mp4"])
def test_26_a_name_plays_no_tricks_in_a_message(program: Program, name):
    (program.folder / name).write_bytes(b"no film")
    outcome = program.refused(3, "not a readable video", program.folder / name)
    assert outcome.said.isprintable()


def test_26_a_percent_sign_in_a_films_name_is_no_pattern(program: Program):
    make_clip(program.folder / "100%d.mp4", frames=3)
    assert program(program.folder / "100%d.mp4").exit_code == 0
    assert len(video(program.folder / "out.mp4")) == 3


def test_27_an_address_is_not_opened_unless_allowed(program: Program):
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setblocking(False)
        program.refused(2, "--allow-url", f"http://127.0.0.1:{server.getsockname()[1]}/x.mp4")
        with pytest.raises(BlockingIOError):
            server.accept()


def test_27_an_allowed_address_that_does_not_answer(program: Program, monkeypatch):
    monkeypatch.setattr("vidstyle.media.read.open.NETWORK_TIMEOUT_SECONDS", 0.3)
    program.refused(3, "127.0.0.1", "http://127.0.0.1:9/x", "out.mp4", "--allow-url")
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"http://127.0.0.1:{server.getsockname()[1]}/x.mp4"
        program.refused(3, "127.0.0.1", address, "out.mp4", "--allow-url")


def test_28_the_input_is_never_the_output(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=3)
    before = hashlib.sha256(clip.read_bytes()).digest()
    (program.folder / "link.mp4").symlink_to(clip)
    os.link(clip, program.folder / "hard.mp4")
    for target in ("clip.mp4", "link.mp4", "hard.mp4", "../" + program.folder.name + "/clip.mp4"):
        program.refused(2, "input", clip, target, "-y")
    assert hashlib.sha256(clip.read_bytes()).digest() == before


def test_28_what_exists_is_kept_unless_told_otherwise(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=3)
    (program.folder / "out.mp4").write_text("mine")
    program.refused(2, "-y", clip)
    assert (program.folder / "out.mp4").read_text() == "mine"
    assert program(clip, "out.mp4", "-y").exit_code == 0
    assert len(video(program.folder / "out.mp4")) == 3


def test_28_links_in_a_circle(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=3)
    (program.folder / "one.mp4").symlink_to("two.mp4")
    (program.folder / "two.mp4").symlink_to("one.mp4")
    program.refused(3, "one.mp4", program.folder / "one.mp4")
    program.refused(2, "one.mp4", clip, "one.mp4")


@pytest.mark.parametrize(
    ("target", "options", "exit_codes"),
    [
        ("missing/out.mp4", [], (5,)),
        ("out.xyz", [], (2,)),
        ("out", [], (2,)),
        ("out.mp4", ["--codec", "nonsense"], (2,)),
        ("out.mp4", ["--codec", "ffv1"], (2,)),
        ("out.webm", ["--codec", "libx264"], (2,)),
        ("out.mp4", ["--pix-fmt", "nonsense"], (2,)),
        ("out.mp4", ["--pix-fmt", "yuva420p"], (2,)),
        ("out.mp4", ["--codec", "mpeg4", "--size", "16384x16"], (2,)),
        ("out.mp4", ["--preset", "nonsense"], (2,)),
        ("out.mp4", ["--crf", "9000"], (2,)),
        ("out.mp4", ["--audio", "nonsense"], (2,)),
    ],
)
def test_29_what_cannot_be_written_is_said_before_the_work(
    program: Program, monkeypatch, target, options, exit_codes
):
    clip = make_clip(program.folder / "clip.mp4", frames=30, audio_tracks=1)
    worked = []
    monkeypatch.setattr("vidstyle.pipeline.stages.Stages.run", lambda *_: worked.append(True))
    outcome = program(clip, target, *options)
    assert outcome.exit_code in exit_codes, outcome.said
    assert len(outcome.lines) == 1 and not worked
    assert sorted(os.listdir(program.folder)) == ["clip.mp4"]


def test_29_a_folder_that_may_not_be_written_to(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=3)
    closed = program.folder / "closed"
    closed.mkdir(mode=0o555)
    picture = make_picture(program.folder / "one.png")
    with drop_file_privileges():
        for source in (clip, picture):
            outcome = program(source, "closed/out" + source.suffix)
            assert outcome.exit_code == 5 and len(outcome.lines) == 1, outcome.said
            assert "no permission" in outcome.said
    assert list(closed.iterdir()) == []


def test_30_a_full_disk_keeps_what_there_is(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=150, size=(320, 180))
    limit = 300_000
    command = [
        sys.executable,
        "-m",
        "vidstyle",
        "render",
        "--style",
        "plain",
        "--progress",
        "none",
        "--crf",
        "5",
    ]
    ended = subprocess.run(
        [*command, str(clip), str(program.folder / "out.mp4")],
        capture_output=True,
        text=True,
        timeout=LONG,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )
    assert ended.returncode == 5 and ended.stderr.count("\n") == 1, ended.stderr
    partial = program.folder / "out.partial.mp4"
    said = re.search(r"the first (\d+) frames", ended.stderr)
    assert str(partial) in ended.stderr and said is not None, ended.stderr
    frames = len(video(partial, cut_off=True))
    assert 5 < int(said[1]) <= frames < 150
    assert not (program.folder / "out.mp4").exists()
