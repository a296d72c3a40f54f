"""Concatenated films in formats that FFmpeg does not continue: losses are reported."""

from __future__ import annotations

from pathlib import Path

import pytest
from media import make_clip

import vidstyle
from vidstyle.media.read.file_structure.headers import FLV_SOUND_ID, FLV_VIDEO_ID, flv_codecs

FRAMES = 60
FLV_HEADER = b"FLV\x01\x05\x00\x00\x00\x09\x00\x00\x00\x00"


def clip(folder: Path, ending: str, codec: str, **options: object) -> Path:
    return make_clip(
        folder / f"{codec}{len(list(folder.iterdir()))}{ending}", frames=FRAMES, codec=codec, **options
    )


def tags(path: Path) -> list[bytes]:
    content, offset, found = path.read_bytes(), len(FLV_HEADER), []
    while offset < len(content):
        size = 11 + int.from_bytes(content[offset + 1 : offset + 4]) + 4
        found.append(content[offset : offset + size])
        offset += size
    return found


def later(tag: bytes, milliseconds: int) -> bytes:
    time = int.from_bytes(tag[7:8] + tag[4:7]) + milliseconds
    return tag[:4] + time.to_bytes(4)[1:] + time.to_bytes(4)[:1] + tag[8:]


def one_stream(folder: Path, *paths: Path) -> Path:
    """A recording of a stream whose sender has begun again."""
    target = folder / "stream.flv"
    content = [later(tag, 2000 * number) for number, path in enumerate(paths) for tag in tags(path)]
    target.write_bytes(FLV_HEADER + b"".join(content))
    return target


def appended(folder: Path, *paths: Path) -> Path:
    target = folder / f"appended{paths[0].suffix}"
    target.write_bytes(b"".join(path.read_bytes() for path in paths))
    return target


@pytest.mark.parametrize("codecs", [("libx264", "flv"), ("flv", "libx264")])
def test_packets_of_a_codec_that_begins_late_in_flv_are_counted(tmp_path, codecs):
    """PyAV passes nothing on of streams that FFmpeg finds after it has opened the file."""
    source = one_stream(tmp_path, *(clip(tmp_path, ".flv", codec, audio_tracks=1) for codec in codecs))
    summary = vidstyle.render(source, tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (4, FRAMES)
    assert summary.damage == f"the input is damaged: {FRAMES} packets without a matching stream"


def test_sound_of_a_codec_that_begins_late_in_flv_is_counted(tmp_path):
    first, second = (clip(tmp_path, ".flv", "libx264", audio_tracks=1) for _ in range(2))
    second.write_bytes(FLV_HEADER + b"".join(as_mp3(tag) for tag in tags(second)))
    summary = vidstyle.render(one_stream(tmp_path, first, second), tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (4, 2 * FRAMES)
    assert "packets without a matching stream" in summary.damage


def as_mp3(tag: bytes) -> bytes:
    return tag[:11] + bytes([0x2F]) + tag[12:] if tag[0] == FLV_SOUND_ID else tag


def test_an_flv_stream_that_begins_again_has_no_damage(tmp_path):
    parts = [clip(tmp_path, ".flv", "libx264", audio_tracks=1) for _ in range(2)]
    source = one_stream(tmp_path, *parts)
    assert [kind for kind, _ in flv_codecs(source)] in (
        [FLV_VIDEO_ID, FLV_SOUND_ID],
        [FLV_SOUND_ID, FLV_VIDEO_ID],
    )
    summary = vidstyle.render(source, tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (0, 2 * FRAMES)


@pytest.mark.parametrize("ending, codecs", [(".flv", ("flv", "flv")), (".wmv", ("wmv2", "msmpeg4"))])
def test_a_film_behind_a_film_is_reported(tmp_path, ending, codecs):
    parts = [clip(tmp_path, ending, codec) for codec in codecs]
    assert vidstyle.render(parts[0], tmp_path / "one.mkv", "plain").exit_code == 0
    summary = vidstyle.render(appended(tmp_path, *parts), tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (4, FRAMES)
    assert "another film follows in the file, which is not read" in summary.damage


def test_video_of_another_codec_in_a_program_stream_is_counted(tmp_path):
    one, two = (clip(tmp_path, ".mpg", codec, audio_tracks=0) for codec in ("mpeg2video", "libx264"))
    assert vidstyle.render(one, tmp_path / "one.mkv", "plain").exit_code == 0
    summary = vidstyle.render(appended(tmp_path, one, two), tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (4, FRAMES)
    assert f"{FRAMES} packets without a matching stream" in summary.damage


@pytest.mark.parametrize(
    "content, codec",
    [
        (b"\x91hvc1\0\0\0", b"\x0c"),  # a key frame of Enhanced RTMP
        (b"\xa3avc1\0", b"\x07"),
        (b"\x90av01\0", None),  # the configuration of a codec
        (b"\x17\0", None),
        (b"\x17\1", b"\x07"),
        (b"\x12\0", b"\x02"),
        (b"\x57\1", None),  # a command
        (b"\x96\0", None),  # several tracks
        (b"", None),
    ],
)
def test_codecs_of_flv_are_told_by_their_tags(tmp_path, content, codec):
    tag = bytes([FLV_VIDEO_ID]) + len(content).to_bytes(3) + bytes(7) + content + bytes(4)
    (path := tmp_path / "a.flv").write_bytes(FLV_HEADER + tag)
    assert list(flv_codecs(path)) == ([] if codec is None else [(FLV_VIDEO_ID, codec)])
