"""Inputs that cannot be used, or only in part: 1 to 9, 24, 25 and 39 of "Bad input" in docs/rules.md."""

from __future__ import annotations

import re
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from covering import of_the_day
from faults import (
    Measured,
    Program,
    assert_not_opened,
    cut,
    damage_packets,
    drop_file_privileges,
    measure_peak_memory,
    packets,
    remux,
    times,
    video,
)
from media import make_clip, make_picture
from waiting import LONG

from vidstyle import cli

NOISE = np.random.default_rng(3).bytes(50_000)


def test_1_a_missing_input(program: Program):
    program.refused(3, "nope.mp4: no such file", program.folder / "nope.mp4")
    assert list(program.folder.iterdir()) == []


def test_2_a_folder_as_input(program: Program):
    folder = program.folder / "folder.mp4"
    folder.mkdir()
    program.refused(3, "is a folder", folder)


def test_2_an_input_that_may_not_be_read(program: Program):
    secret = make_clip(program.folder / "secret.mp4", frames=2)
    secret.chmod(0)
    with drop_file_privileges():
        outcome = program(secret, "other.mp4")
    assert (outcome.exit_code, len(outcome.lines)) == (3, 1) and "permission denied" in outcome.said


@pytest.mark.parametrize(
    "words",
    ["render {} out.mp4 -s plain", "render -i {} -o out.mp4 -s plain", "comic {} page.png",
     "comic film.mp4 page.png --subtitles {}", "comic film.mp4 page.png --font {}",
     "comic film.mp4 page.png --face-model {}", "live {} -s plain --to null", "design {} --no-open",
     "explore {} -o found", "styles --preview {} -o sheet.png", "styles --like {}",
     "bench --film {} -s plain", "export ink ink.hook --from {}",
     "train bank.npz --images {} --reference tv_flow", "train {} --show bank.png",
     "render film.mp4 out.mp4 -s {}"],
)  # fmt: skip
def test_2_an_input_of_any_command_that_may_not_be_read(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: str
):
    monkeypatch.chdir(tmp_path)
    make_clip(tmp_path / "film.mp4", frames=2)
    secret = tmp_path / "secret.mp4"
    secret.mkdir() if "--images" in words else secret.touch()
    cli.main(words.format("missing.mp4").split())  # imports what the files' rights would hide
    capfd.readouterr()
    secret.chmod(0)
    with drop_file_privileges():
        exit_code = cli.main(words.format(secret).split())
    said = capfd.readouterr().err
    assert (exit_code, said.count("\n")) == (3, 1) and "secret.mp4" in said, said
    assert re.search("permission denied", said, re.IGNORECASE), said
    assert not list(tmp_path.glob("*.partial.*"))


@pytest.mark.parametrize(
    "content",
    [b"", bytes(100_000), NOISE, b"This is a letter.\n" * 1000],
    ids=["empty", "zeros", "noise", "text"],
)
def test_3_no_film_at_all(program: Program, content):
    path = program.folder / "film.mp4"
    path.write_bytes(content)
    program.refused(3, "not a readable video", path)


def test_4_sound_alone(program: Program):
    clip = make_clip(program.folder / "clip.mkv", frames=10, audio_tracks=1)
    sound = remux(clip, program.folder / "sound.m4a", kinds=("audio",))
    program.refused(3, "no video stream", sound)


def test_4_subtitles_alone(program: Program):
    path = program.folder / "lines.srt"
    path.write_text("1\n00:00:01,000 --> 00:00:02,000\nHello\n\n" * 3)
    program.refused(3, "no video stream", path)


def test_5_an_mp4_cut_short(program: Program):
    options = {"g": "10"}
    clip = make_clip(program.folder / "clip.mp4", frames=150, audio_tracks=1, options=options)
    front = program.folder / "front.mp4"
    remux(clip, front, movflags="faststart")
    outcome = program(cut(front, 0.5))
    frames = len(video(outcome.target))
    assert outcome.exit_code == 4 and 40 < frames < 110
    assert f"{150 - frames} frames missing of 150" in outcome.said
    last_sound = packets(outcome.target, "audio")[-1][0]
    assert last_sound <= frames / 30 + 0.05


def test_6_an_mp4_without_its_index(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=60)
    program.refused(3, "the recording was not finished (no index)", cut(clip, 0.9))


@pytest.mark.parametrize("kind", ["mkv", "webm"])
def test_7_a_matroska_cut_short(program: Program, kind):
    codec = "libx264" if kind == "mkv" else "libvpx-vp9"
    clip = make_clip(program.folder / f"clip.{kind}", frames=150, codec=codec, size=(160, 90))
    outcome = program(cut(clip, 0.5))
    assert outcome.exit_code == 4 and "5.0" in outcome.said
    assert 30 < len(video(outcome.target)) < 140


def test_8_one_picture_spoilt(program: Program):
    options = {"bf": "0", "g": "300"}
    clip = make_clip(program.folder / "clip.mp4", frames=60, options=options)
    outcome = program(damage_packets(clip, slice(20, 21)))
    assert outcome.exit_code == 4 and "1 frame damaged" in outcome.said
    assert times(outcome.target) == pytest.approx([number / 30 for number in range(60)], abs=0.001)


def test_9_no_picture_decodes(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=30)
    program.refused(3, "no frame could be decoded", damage_packets(clip, slice(None)))
    assert not (program.folder / "out.mp4").exists()


def huge_png(path: Path, side: int) -> Path:
    """A black picture of one bit for each pixel: a few kilobytes."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return (
            struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        )

    rows = zlib.compress(bytes(side * (1 + -(-side // 8))), 9)
    header = struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
    )
    return path


def render_plain(*arguments: str | Path) -> Measured:
    return measure_peak_memory([sys.executable, "-m", "vidstyle", "render", "--style", "plain", *arguments])


def test_24_a_picture_that_would_fill_memory(program: Program):
    usual = render_plain(make_picture(program.folder / "small.png"), program.folder / "small.mp4")
    assert usual.exit_code == 0
    huge = render_plain(huge_png(program.folder / "huge.png", 14000), program.folder / "out.png")
    assert huge.exit_code == 3 and "larger than the limit of 64 MP" in huge.errors
    assert huge.errors.count("\n") == 1
    assert huge.peak_bytes - usual.peak_bytes < 100 * 2**20
    assert not (program.folder / "out.png").exists()


def test_24_a_gif_that_says_it_is_huge(program: Program):
    path = program.folder / "huge.gif"
    path.write_bytes(b"GIF89a" + struct.pack("<HHBBB", 65535, 65535, 0, 0, 0) + b"\x2c" + bytes(100))
    outcome = program(path)
    assert outcome.exit_code == 3 and len(outcome.lines) == 1 and not outcome.target.exists()


PLAYLISTS = {
    "concat": "ffconcat version 1.0\nfile other.mp4\n",
    "concat after a comment": "# a list\nffconcat version 1.0\nfile other.mp4\n",
    "hls": "#EXTM3U\n#EXT-X-TARGETDURATION:5\n#EXTINF:5,\nother.mp4\n#EXT-X-ENDLIST\n",
    "dash": '<?xml version="1.0"?><MPD xmlns="urn:mpeg:dash:schema:mpd:2011" type="static"><Period>'
    '<AdaptationSet mimeType="video/mp4"><Representation id="1" bandwidth="1"><BaseURL>other.mp4</BaseURL>'
    "</Representation></AdaptationSet></Period></MPD>",
}


@pytest.mark.parametrize("ending", ["mp4", "m3u8", "ffconcat", "mpd", "txt"])
@pytest.mark.parametrize("kind", PLAYLISTS)
def test_25_a_playlist_in_disguise_opens_nothing_else(program: Program, kind, ending):
    other = make_clip(program.folder / "other.mp4", frames=2, size=(32, 32))
    path = program.folder / f"film.{ending}"
    path.write_text(PLAYLISTS[kind])
    with assert_not_opened(other):
        program.refused(3, "playlist" if "after" not in kind else "not a readable video", path)


@pytest.mark.parametrize("kind", of_the_day(list(PLAYLISTS), 1))
def test_25_a_playlist_on_standard_input_opens_nothing_else(program: Program, kind):
    other = make_clip(program.folder / "other.mp4", frames=2, size=(32, 32))
    command = [sys.executable, "-m", "vidstyle", "render", "--style", "plain", "-", "out.mp4"]
    content = PLAYLISTS[kind].encode()
    with assert_not_opened(other):
        ended = subprocess.run(command, input=content, capture_output=True, cwd=program.folder, timeout=LONG)
    assert ended.returncode == 3 and ended.stderr.count(b"\n") == 1


HOSTILE_STYLES = {
    "unknown format": "format = 99\n",
    "infinite": 'format = 1\n[[background]]\nblock = "brightness"\nfactor = inf\n',
    "too large": 'format = 1\n[[background]]\nblock = "brightness"\nfactor = 1e308\n',
    "way out": 'format = 1\n[[background]]\nblock = "pattern"\ntiles = "../../etc/passwd"\n',
    "no toml": "{",
    "many steps": "format = 1\n" + '[[background]]\nblock = "hue"\n' * 20_000,
}


@pytest.mark.parametrize("kind", HOSTILE_STYLES)
def test_39_a_hostile_style(program: Program, kind):
    clip = make_clip(program.folder / "clip.mp4", frames=2, size=(32, 32))
    path = program.folder / "style.toml"
    path.write_text(HOSTILE_STYLES[kind])
    program.refused(3, str(path), clip, style=str(path))
