"""The writer: colours, timestamps, sizes, defaults, and the index in front."""

from __future__ import annotations

import dataclasses
import os
import re
import struct
import sys
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from covering import of_the_day
from media import make_clip, make_picture, read_all, rgb_from_frame, rms_error
from PIL import Image

from vidstyle.core.convert import to_rgb
from vidstyle.errors import UsageError
from vidstyle.media.codecs import choose_pix_fmt, encoder_options, find_encoder
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader
from vidstyle.media.write.containers import CONTAINER_KINDS, RESUMABLE_ENDINGS, find_kind
from vidstyle.media.write.encoder import to_encoder_frame
from vidstyle.media.write.faststart import move_index_first
from vidstyle.media.write.video_plan import plan_video
from vidstyle.media.write.writer import WriteOptions, open_writer
from vidstyle.pipeline.render import render


def copy(source: Path, target: Path, read: ReadOptions | None = None, **options: object) -> Path:
    """Copy a film with reader and writer; the source must have the encoding of the target."""
    with (
        open_reader(source, read) as reader,
        open_writer(target, reader.info, WriteOptions(**options), reader) as writer,  # type: ignore[arg-type]
    ):
        for item in reader:
            writer.write(item)
    return target


def times(path: Path) -> list[Fraction]:
    return [frame.pts * frame.time_base for frame in read_all(path)]


def boxes(path: Path) -> list[bytes]:
    content, start, names = path.read_bytes(), 0, []
    while start < len(content):
        names.append(content[start + 4 : start + 8])
        start += int.from_bytes(content[start : start + 4], "big") or len(content)
    return names


@pytest.mark.parametrize("ending", [".mp4", ".mov", ".mkv"])
def test_a_film_is_h264_that_plays_everywhere(tmp_path, ending):
    clip = make_clip(tmp_path / "clip.mp4")
    target = copy(clip, tmp_path / f"out{ending}")
    with av.open(str(target)) as container:
        context = container.streams.video[0].codec_context
        assert (context.name, context.pix_fmt, context.profile) == ("h264", "yuv420p", "High")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clip.mp4", f"out{ending}"]


@pytest.mark.parametrize(("matrix", "code"), [("bt709", 1), ("bt601", 6), ("bt2020", 9)])
@pytest.mark.parametrize("full_range", [False, True])
def test_colours_and_their_tags_are_the_sources(tmp_path, matrix, code, full_range):
    clip = make_clip(tmp_path / "clip.mp4", matrix=matrix, full_range=full_range, frames=4)
    frames = read_all(copy(clip, tmp_path / "out.mp4", crf=0))
    assert [frames[0].colorspace, frames[0].color_primaries] == [code, code]
    assert frames[0].color_range == (2 if full_range else 1)
    assert rms_error(rgb_from_frame(frames[3]), rgb_from_frame(read_all(clip)[3])) == 0


@pytest.mark.parametrize(("height", "system"), [(288, 5), (576, 5), (480, 6), (570, 6)])
def test_untagged_pal_and_ntsc_have_their_own_tags(tmp_path, height, system):
    clip = make_clip(tmp_path / "clip.mp4", tagged=False, frames=2, size=(720, height))
    frame = read_all(copy(clip, tmp_path / "out.mp4"))[0]
    assert (frame.colorspace, frame.color_primaries, frame.color_trc) == (system, system, 6)


def test_what_was_untagged_is_tagged_as_it_was_understood(tmp_path):
    frame = read_all(copy(make_clip(tmp_path / "clip.mp4", tagged=False), tmp_path / "out.mp4"))[0]
    assert (frame.colorspace, frame.color_primaries, frame.color_trc, frame.color_range) == (6, 6, 6, 1)


@pytest.mark.parametrize("ending", [".mp4", ".mkv"])
@pytest.mark.parametrize(
    "stamps",
    [
        [Fraction(number * 1001, 24000) for number in range(50)],
        [Fraction(number * 2, 25) for number in range(40)],
        [Fraction(3, 1000) + Fraction(number, 30) for number in range(40)],
        [Fraction(3 * number + number // 7 * 29 + number % 3, 90) for number in range(60)],
        [Fraction(2) + Fraction(number * number, 300) for number in range(30)],
    ],
    ids=["24000/1001", "12.5", "from 3 ms", "uneven", "slower and slower from 2 s"],
)
def test_times_are_the_sources(tmp_path, ending, stamps):
    clip = make_clip(tmp_path / f"clip{ending}", times=stamps, audio_tracks=1, size=(64, 48))
    written = times(copy(clip, tmp_path / f"out{ending}"))
    assert written == times(clip)
    assert written == pytest.approx([float(stamp) for stamp in stamps], abs=0.0006)


@pytest.mark.parametrize("rate", [Fraction(30), Fraction(24000, 1001), Fraction(25, 2)])
@pytest.mark.parametrize("frames", of_the_day(range(34, 48), 4))
def test_the_last_frame_is_there_and_lasts_as_long_as_the_others(tmp_path, rate, frames):
    clip = make_clip(tmp_path / "clip.mp4", rate=rate, frames=frames, size=(64, 48))
    target = copy(clip, tmp_path / "out.mp4")
    assert len(read_all(target)) == frames
    with av.open(str(target)) as container:
        stream = container.streams.video[0]
        assert float(stream.duration * stream.time_base) == pytest.approx(float(frames / rate), abs=0.001)
        assert stream.average_rate == rate


def test_the_index_comes_first(tmp_path):
    target = copy(make_clip(tmp_path / "clip.mp4", audio_tracks=2), tmp_path / "out.mp4")
    names = boxes(target)
    assert names.index(b"moov") < names.index(b"mdat") and b"moof" not in names


ROOT = Path(__file__).parents[2]
FILMS = [kind for kind in CONTAINER_KINDS if kind.way == "film"]


@pytest.mark.parametrize("kind", FILMS, ids=lambda kind: kind.endings[0])
def test_no_film_has_its_index_behind_its_pictures(tmp_path, kind):
    target = tmp_path / f"out{kind.endings[0]}"
    render(make_clip(tmp_path / "clip.mp4", frames=3), target, "plain")
    content = target.read_bytes()
    assert content[4:8] != b"ftyp" or content.index(b"moov") < content.index(b"mdat")


def test_each_film_can_be_resumed_or_is_known_not_to_be():
    rules = " ".join((ROOT / "docs" / "rules.md").read_text(encoding="utf-8").split())
    assert f"works for {', '.join(RESUMABLE_ENDINGS)} and numbered pictures" in rules
    not_resumable = "avi mpegts ogv flv asf nut yuv4mpegpipe rawvideo webp apng".split()
    assert [kind.muxer for kind in FILMS if not kind.resumable] == not_resumable


def box(name: bytes, *parts: bytes) -> bytes:
    content = b"".join(parts)
    return struct.pack(">I4s", 8 + len(content), name) + content


@pytest.mark.parametrize(
    ("name", "code", "beyond", "fits"),
    [(b"stco", "I", 0, True), (b"stco", "I", 1, False), (b"co64", "Q", 1, True)],
)
def test_offsets_that_leave_four_gigabytes_are_left_alone(tmp_path, name, code, beyond, fits):
    def film(offset: int) -> bytes:
        table = box(name, struct.pack(f">II{code}", 0, 1, offset))
        index = box(b"moov", box(b"trak", box(b"mdia", box(b"minf", box(b"stbl", table)))))
        return box(b"ftyp", b"isom") + box(b"mdat", b"data") + index

    source, target = tmp_path / "in.mp4", tmp_path / "out.mp4"
    shift = len(film(0)) - len(box(b"ftyp", b"isom") + box(b"mdat", b"data"))
    source.write_bytes(film(2**32 - 1 - shift + beyond))
    assert move_index_first(source, target) is fits
    assert target.exists() is fits
    if fits:
        place = target.read_bytes().index(name) + 12
        assert struct.unpack_from(f">{code}", target.read_bytes(), place) == (2**32 - 1 + beyond,)


def test_a_file_with_its_index_first_is_left_alone(tmp_path):
    target = copy(make_clip(tmp_path / "clip.mp4"), tmp_path / "out.mp4")
    assert move_index_first(target, tmp_path / "again.mp4") is False
    assert not (tmp_path / "again.mp4").exists()


def test_a_broken_index_is_left_alone(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4")
    content = bytearray(clip.read_bytes())
    place = content.index(b"stco") - 4
    content[place : place + 4] = (2**31).to_bytes(4, "big")
    clip.write_bytes(content)
    assert move_index_first(clip, tmp_path / "again.mp4") is False


@pytest.mark.parametrize("size", [(321, 181), (1, 1), (2, 3)])
def test_odd_sizes_are_padded_by_repetition_and_it_is_said(tmp_path, caplog, size):
    make_picture(tmp_path / "one.png", size=size)
    render(tmp_path / "one.png", tmp_path / "out.mp4", "plain")
    frame = read_all(tmp_path / "out.mp4")[0]
    assert (frame.width, frame.height) == tuple(length + length % 2 for length in size)
    assert "padded" in caplog.text and f"{frame.width}x{frame.height}" in caplog.text
    luma = frame.to_ndarray()[: frame.height].astype(int)
    if size[0] % 2:
        assert np.abs(luma[:, -1] - luma[:, -2]).mean() < 4


def test_sample_aspect_stays(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", sample_aspect=Fraction(16, 15))
    with av.open(str(copy(clip, tmp_path / "out.mp4"))) as container:
        assert container.streams.video[0].sample_aspect_ratio == Fraction(16, 15)


def test_a_hardware_encoder_that_is_not_here_is_replaced_and_it_is_said(tmp_path, caplog):
    target = copy(make_clip(tmp_path / "clip.mp4"), tmp_path / "out.mp4", codec="h264_vaapi", preset="p4")
    assert "libx264 is used instead" in caplog.text
    assert len(read_all(target)) == 30


def test_an_unknown_codec_names_those_that_come_near(tmp_path):
    with pytest.raises(UsageError, match="libx264"):
        find_encoder("libx246")


@pytest.mark.parametrize(
    ("encoder", "crf", "preset", "options"),
    [
        ("libx264", None, None, {"crf": "18", "preset": "veryfast"}),
        ("libsvtav1", 30, "6", {"crf": "30", "preset": "6"}),
        ("h264_nvenc", 21, None, {"cq": "21", "preset": "p4", "rc": "vbr"}),
        ("mpeg4", 3, None, {"flags": "+qscale", "global_quality": "354"}),
        ("ffv1", None, None, {}),
    ],
)
def test_quality_and_speed_by_the_encoders_own_names(encoder, crf, preset, options):
    assert encoder_options(encoder, crf, preset) == options


@pytest.mark.parametrize(("preset", "least", "most"), [("veryfast", 10, 10), ("slow", 11, 22)])
def test_a_lookahead_is_that_of_the_preset_or_shortened_to_a_second(tmp_path, preset, least, most):
    clip = make_clip(tmp_path / "clip.mp4", frames=3, rate=25)
    content = copy(clip, tmp_path / "out.mp4", preset=preset).read_bytes()
    (lookahead,) = re.findall(rb"rc_lookahead=(\d+)", content)
    assert least <= int(lookahead) <= most


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_an_encoder_keeps_nothing_else_off_the_processor(tmp_path):
    """As root, SVT-AV1 makes its threads and that which opens it real-time."""

    def policies() -> set[int]:
        return {os.sched_getscheduler(int(thread)) for thread in os.listdir("/proc/self/task")}

    before = policies()
    with open_reader(make_clip(tmp_path / "in.mkv", codec="libsvtav1", frames=3, size=(64, 64))) as reader:
        options = WriteOptions(codec="libsvtav1", preset="12")
        with open_writer(tmp_path / "out.mkv", reader.info, options, reader) as writer:
            assert policies() == before
            for item in reader:
                writer.write(item)
            assert policies() == before


def test_a_setting_that_the_encoder_lacks_is_refused():
    with pytest.raises(UsageError, match="--crf"):
        encoder_options("ffv1", 20, None)


@pytest.mark.parametrize(
    ("encoder", "source", "pix_fmt"),
    [
        ("libx264", (10, (1, 1), False, False), "yuv420p"),
        ("libx265", (10, (2, 2), False, False), "yuv420p10le"),
        ("prores_ks", (8, (2, 2), False, False), "yuv422p10le"),
        ("prores_ks", (8, (1, 1), True, True), "yuva444p10le"),
        ("ffv1", (10, (2, 1), False, False), "yuv422p10le"),
        ("png", (8, (2, 2), False, False), "rgb24"),
        ("png", (16, (1, 1), True, True), "rgba64be"),
    ],
)
def test_the_pixel_format_keeps_what_it_can(encoder, source, pix_fmt):
    assert choose_pix_fmt(encoder, *source) == pix_fmt


@pytest.mark.parametrize("frames", [1, 2, 3])
@pytest.mark.parametrize("ending", [".mp4", ".mkv"])
def test_the_shortest_films_in_hevc_have_their_times(tmp_path, frames, ending):
    clip = make_clip(tmp_path / "clip.mkv", frames=frames, size=(64, 64))
    for attempt in range(4):
        target = copy(clip, tmp_path / f"out{attempt}{ending}", codec="libx265")
        assert [round(float(time), 2) for time in times(target)] == [0, 0.03, 0.07][:frames]


def test_an_unknown_ending_names_those_that_come_near():
    with pytest.raises(UsageError, match=r"did you mean \.mp4"):
        find_kind("out.mp5", None, False)


@pytest.mark.parametrize("ending", [".webm", ".mov", ".mkv", ".webp", ".apng", ".png"])
def test_alpha_stays_where_the_file_can_hold_it(tmp_path, ending):
    make_picture(tmp_path / "one.png", mode="RGBA")
    target = tmp_path / f"out{ending}"
    render(tmp_path / "one.png", target, "plain")
    if ending in (".webp", ".png", ".apng"):
        alpha = np.asarray(Image.open(target).convert("RGBA"))[..., 3]
    else:
        decoder = {"codec": "libvpx-vp9"} if ending == ".webm" else {}
        with av.open(str(target), options=decoder) as container:
            stream = container.streams.video[0]
            context = av.CodecContext.create("libvpx-vp9", "r") if decoder else stream.codec_context
            packets = [packet for packet in container.demux(stream) if packet.size]
            frame = (context.decode(packets[0]) or context.decode(None))[0]
            alpha = frame.reformat(format="rgba").to_ndarray()[..., 3]
    assert alpha[:, 10].mean() > 220 and alpha[:, -10].mean() < 35


def test_lost_alpha_is_said(tmp_path, caplog):
    make_picture(tmp_path / "one.png", mode="RGBA")
    render(tmp_path / "one.png", tmp_path / "out.mp4", "plain")
    assert "transparency is lost" in caplog.text


def test_frames_at_one_time_follow_each_other(tmp_path, caplog):
    clip = make_clip(tmp_path / "clip.mp4", frames=12)
    with open_reader(clip) as reader:
        writer = open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader)
        for item in reader:
            stuck = getattr(item, "pts", 0) in range(5 * 512, 8 * 512) and hasattr(item, "picture")
            writer.write(dataclasses.replace(item, pts=5 * 512) if stuck else item)
        writer.finish()
    written = times(tmp_path / "out.mp4")
    assert len(written) == 12 and written == sorted(set(written))


def test_a_film_ends_with_a_file_or_with_its_partial(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", frames=90, audio_tracks=1)
    with open_reader(clip) as reader:
        writer = open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader)
        for item in reader:
            writer.write(item)
            if writer.frames == 60:
                break
        partial = writer.abandon()
    assert partial == tmp_path / "out.partial.mp4" == writer.abandon()
    assert len(read_all(partial)) == 60 and not (tmp_path / "out.mp4").exists()


def test_nothing_is_left_of_a_film_without_frames(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4")
    with open_reader(clip) as reader:
        assert open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader).abandon() is None
    assert list(tmp_path.iterdir()) == [clip]


def test_pictures_of_a_film_by_number(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", frames=3, size=(64, 48))
    render(clip, tmp_path / "f_%03d.png", "plain")
    assert sorted(path.name for path in tmp_path.glob("*.png")) == ["f_001.png", "f_002.png", "f_003.png"]
    shown = np.asarray(Image.open(tmp_path / "f_002.png")).astype(float)
    assert rms_error(shown, rgb_from_frame(read_all(clip)[1])) < 2


def test_one_picture_holds_one_frame(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", frames=3)
    one = tmp_path / "one.png"
    with pytest.raises(
        UsageError, match=r"can hold only one picture; add --frames 1, or name it one_%05d\.png"
    ):
        render(clip, one, "plain")
    assert list(tmp_path.iterdir()) == [clip]
    render(clip, one, "plain", frames=1)
    assert np.asarray(Image.open(one)).shape[2] == 3


def test_a_folder_takes_a_file_of_the_source_s_name(tmp_path):
    clip, folder = make_clip(tmp_path / "clip.mp4", frames=2, size=(64, 48)), tmp_path / "out"
    folder.mkdir()
    assert render(clip, folder, "plain").target == str(folder / "clip.mp4")
    assert len(read_all(folder / "clip.mp4")) == 2
    with pytest.raises(UsageError, match="input itself"):
        render(clip, tmp_path, "plain")
    with pytest.raises(UsageError, match=r"out is a folder; name a file in it, such as .*out/film\.mp4"):
        render(tmp_path / "%d.png", folder, "plain")


@pytest.mark.parametrize("ending", [".png", ".jpg", ".webp", ".tif", ".bmp"])
def test_a_still_keeps_its_colours(tmp_path, ending):
    source = make_picture(tmp_path / "one.png", size=(161, 121))
    target = tmp_path / f"out{ending}"
    render(source, target, "plain")
    written = np.asarray(Image.open(target).convert("RGB")).astype(float)
    assert rms_error(written, np.asarray(Image.open(source)).astype(float)) < {".webp": 4, ".jpg": 3}.get(
        ending, 1
    )


@pytest.mark.parametrize("ending", [".gif", ".webp", ".apng"])
def test_an_animation_moves_at_the_films_pace(tmp_path, ending):
    clip = make_clip(tmp_path / "clip.mp4", frames=20, rate=10, size=(160, 90))
    target = tmp_path / f"out{ending}"
    render(clip, target, "plain")
    with Image.open(target) as image:
        assert image.n_frames == 20 and image.info.get("loop") == 0
        image.seek(15)
        shown = np.asarray(image.convert("RGB")).astype(float)
        assert image.info["duration"] == pytest.approx(100)
    assert rms_error(shown, rgb_from_frame(read_all(clip)[15])) < 12
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clip.mp4", target.name]


def test_a_native_frame_is_encoded_as_it_is(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", frames=4)
    with open_reader(clip) as reader:
        frames = [item for item in reader if hasattr(item, "picture")]
    assert all(frame.native is not None for frame in frames)
    plan = plan_video("out.mp4", find_kind("out.mp4", None, False), reader.info, WriteOptions())
    assert to_encoder_frame(frames[2], plan) is frames[2].native
    bare = to_encoder_frame(dataclasses.replace(frames[2], native=None), plan)
    assert np.array_equal(bare.to_ndarray(), frames[2].native.to_ndarray())


@pytest.mark.parametrize(
    ("name", "codec", "is_kept"),
    [("a.mp4", None, True), ("a.webm", None, True), ("a.y4m", None, True), ("a.mkv", "ffv1", True),
     ("a.avi", None, False), ("a.ogv", None, False), ("a.wmv", None, False), ("a.nut", None, False),
     ("a.webm", "libvpx", False), ("a.mov", "prores_ks", False)],
)  # fmt: skip
def test_full_range_is_kept_where_a_player_is_told_of_it(tmp_path, caplog, name, codec, is_kept):
    clip = make_clip(tmp_path / "in.mp4", frames=2, size=(64, 48), full_range=True, matrix="bt601")
    render(clip, tmp_path / name, "plain", write=WriteOptions(codec=codec))
    assert ("full range becomes limited" in caplog.text) is not is_kept
    with open_reader(clip) as source, open_reader(tmp_path / name) as result:
        assert source.info.encoding.full_range and result.info.encoding.full_range is is_kept
        first, second = (
            to_rgb(next(item.picture for item in each if isinstance(item, Frame))).astype(int)
            for each in (source, result)
        )
    assert np.abs(first - second).mean() < 4
