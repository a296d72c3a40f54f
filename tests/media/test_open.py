"""Opening of media: exactly the named file, and errors with a reason."""

from __future__ import annotations

import random
import struct
import zlib
from pathlib import Path

import av
import media
import psutil
import pytest
from covering import DAY

from vidstyle.errors import InputError, UsageError
from vidstyle.media.frame import Frame
from vidstyle.media.read.open import FILE_FORMATS
from vidstyle.media.read.reader import ReadOptions, open_reader


def reason_of(path: object, options: ReadOptions | None = None) -> str:
    with pytest.raises(InputError) as caught:
        open_reader(path, options)
    assert "\n" not in str(caught.value)
    return caught.value.reason


def test_a_missing_file(tmp_path):
    assert reason_of(tmp_path / "nope.mp4") == "no such file"


def test_a_folder(tmp_path):
    assert reason_of(tmp_path) == "is a folder"


@pytest.mark.parametrize(
    "content",
    [b"", bytes(4096), random.Random(DAY).randbytes(50_000), b"no film at all\n" * 50],
    ids=["empty", "zeros", "noise", "text"],
)
def test_rubbish_named_as_a_film(tmp_path, content):
    path = tmp_path / "film.mp4"
    path.write_bytes(content)
    assert reason_of(path).startswith("not a readable video")


def test_sound_alone(tmp_path):
    path = tmp_path / "sound.m4a"
    with av.open(str(path), "w", format="mp4") as container:
        stream = container.add_stream("aac", rate=48000)
        stream.layout = "stereo"
        media.write_sound(container, stream, 300, 1)
    assert reason_of(path) == "no video stream"


def test_subtitles_alone(tmp_path):
    path = tmp_path / "lines.srt"
    path.write_text("1\n00:00:01,000 --> 00:00:02,000\nHello\n")
    assert reason_of(path) == "no video stream"


def test_a_recording_without_its_index(tmp_path):
    path = media.make_clip(tmp_path / "clip.mp4")
    content = path.read_bytes()
    path.write_bytes(content[: content.rindex(b"moov") - 4])
    assert reason_of(path) == "the recording was not finished (no index)"


def test_a_small_file_with_a_huge_picture(tmp_path):
    """8200 x 8200 black pixels in a quarter of a megabyte: refused before it is decoded."""
    side = 8_200
    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    packed = zlib.compressobj(1)
    rows = b"".join([packed.compress(bytes(side * 3 + 1)) for _ in range(side)]) + packed.flush()
    path = tmp_path / "bomb.png"
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", rows) + _chunk(b"IEND", b"")
    )
    before = psutil.Process().memory_info().rss
    assert reason_of(path) == "8200x8200 is larger than the limit of 64 MP"
    assert psutil.Process().memory_info().rss - before < 100e6


def test_the_limit_is_an_option(tmp_path):
    path = media.make_clip(tmp_path / "clip.mp4", frames=2)
    assert "larger than the limit" in reason_of(path, ReadOptions(max_pixels=160 * 89))


def test_a_bomb_that_hides_its_size_until_it_is_decoded(tmp_path):
    """A GIF whose first screen is larger than any picture may be."""
    path = tmp_path / "bomb.gif"
    path.write_bytes(
        b"GIF89a" + struct.pack("<HHBBB", 65535, 65535, 0x80, 0, 0) + bytes(6) + b"," + bytes(9) + b"\x02"
    )
    with pytest.raises(InputError):
        open_reader(path)


@pytest.mark.parametrize(
    "text",
    [
        "ffconcat version 1.0\nfile '{}'\n",
        "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n{}\n#EXT-X-ENDLIST\n",
        '<?xml version="1.0"?>\n<MPD xmlns="urn:mpeg:dash:schema:mpd:2011"><BaseURL>{}</BaseURL></MPD>\n',
    ],
)
def test_playlists_in_disguise(tmp_path, text):
    secret = media.make_clip(tmp_path / "secret.mp4", frames=2)
    path = tmp_path / "film.mp4"
    path.write_text(text.format(secret))
    assert reason_of(path) == "playlist formats are not accepted"


def test_formats_that_open_other_files_are_not_on_the_list():
    allowed = set(FILE_FORMATS.split(","))
    assert not allowed & {
        "concat",
        "hls",
        "dash",
        "image2",
        "imf",
        "tedcaptions",
        "lavfi",
        "webm_dash_manifest",
    }
    assert allowed <= {name for entry in av.formats_available for name in entry.split(",")}


@pytest.mark.parametrize(
    "name",
    ["-x.mp4", "a:b.mp4", "data:x.mp4", "concat:a.mp4|b.mp4", "subfile,,start,0,end,9,,:a.mp4", "%03d.mp4",
     "two\nlines.mp4", "smile \N{GRINNING FACE}.mp4", "$(id).mp4", "pipe:0.mp4", "x" * 251 + ".mp4"],
)  # fmt: skip
def test_hostile_names_are_names(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    media.make_clip(tmp_path / "plain.mp4", frames=3).rename(name)
    with open_reader(name) as reader:
        assert sum(isinstance(item, Frame) for item in reader) == 3


def test_urls_must_be_allowed():
    with pytest.raises(UsageError, match="--allow-url"):
        open_reader("http://127.0.0.1:9/x.mp4")
    assert reason_of("http://127.0.0.1:9/x.mp4", ReadOptions(allow_url=True)).startswith("cannot be opened")


def test_hardware_that_is_not_there_is_said(tmp_path, caplog):
    path = media.make_clip(tmp_path / "clip.mp4", frames=3)
    with open_reader(path, ReadOptions(hwaccel="qsv")) as reader:
        assert sum(isinstance(item, Frame) for item in reader) == 3
    assert "the CPU decodes" in caplog.text


def test_files_are_closed(tmp_path):
    path = media.make_clip(tmp_path / "clip.mp4", frames=3)
    process = psutil.Process()
    before = process.num_fds()
    for _ in range(5):
        with open_reader(path) as reader:
            next(iter(reader))
        with pytest.raises(InputError):
            open_reader(Path(__file__))
    assert process.num_fds() <= before


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
