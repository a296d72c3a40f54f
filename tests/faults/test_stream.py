"""Films with unusual timestamps, sizes or colours: 11 to 23 of "Bad input" in docs/rules.md."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from faults import Program, packets, remux, times, video
from media import frame_from_rgb, make_clip, moving_frames, rgb_from_frame, rms_error


def test_11_times_that_go_back(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=40, options={"bf": "0"})
    swapped = remux(clip, program.folder / "swapped.mkv", stamp={20: 21, 21: 20})
    outcome = program(swapped, "out.mkv")
    found = times(outcome.target)
    assert outcome.exit_code == 0, outcome.said
    assert len(found) == 40 and found == sorted(set(found))


def test_12_gaps_of_two_seconds(program: Program):
    gaps = [Fraction(38, 1000), Fraction(2), Fraction(1, 10)] * 8
    stamps = [sum(gaps[:number], Fraction(0)) for number in range(len(gaps))]
    clip = make_clip(program.folder / "clip.mp4", times=stamps, audio_tracks=1)
    outcome = program(clip)
    assert (outcome.exit_code, outcome.lines) == (0, [])
    assert times(outcome.target) == pytest.approx([float(stamp) for stamp in stamps], abs=0.001)
    assert packets(outcome.target, "audio") == packets(clip, "audio")


def test_13_no_times_and_two_sizes_in_raw_h264(program: Program):
    first = make_clip(program.folder / "one.h264", frames=20, size=(320, 180))
    second = make_clip(program.folder / "two.h264", frames=15, size=(160, 120))
    first.write_bytes(first.read_bytes() + second.read_bytes())
    outcome = program(first)
    assert outcome.exit_code == 0, outcome.said
    assert [(frame.width, frame.height) for frame in video(outcome.target)] == [(320, 180)] * 35
    assert sum("timestamps" in line for line in outcome.lines) == 1
    assert sum("size" in line for line in outcome.lines) == 1


def test_14_nine_sizes_in_one_stream(program: Program):
    path = program.folder / "sizes.webm"
    options = {"deadline": "realtime", "cpu-used": "8", "threads": "1"}
    sizes = [(96 + 32 * number, 200 - 16 * number) for number in range(9)]
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libvpx", rate=25, options=options)
        stream.width, stream.height = sizes[0]
        for number, size in enumerate(sizes):
            encoder = stream.codec_context if number == 0 else av.CodecContext.create("libvpx", "w")
            if number:
                encoder.width, encoder.height, encoder.pix_fmt = *size, "yuv420p"
                encoder.framerate, encoder.time_base = Fraction(25), Fraction(1, 25)
                encoder.options = options
            for index, rgb in enumerate(moving_frames(5, size)):
                frame = frame_from_rgb(rgb)
                frame.pts, frame.time_base = 5 * number + index, Fraction(1, 25)
                for packet in encoder.encode(frame):
                    packet.stream = stream
                    container.mux(packet)
            for packet in encoder.encode(None):
                packet.stream = stream
                container.mux(packet)
    outcome = program(path)
    frames = video(outcome.target)
    assert outcome.exit_code == 0, outcome.said
    assert [(frame.width, frame.height) for frame in frames] == [sizes[0]] * 45
    assert len(outcome.lines) <= 2


@pytest.mark.parametrize("rotation", [90, 180, 270])
def test_15_turned_films_come_out_upright_once(program: Program, rotation):
    clip = make_clip(program.folder / "clip.mp4", frames=3, size=(160, 96), rotation=rotation)
    outcome = program(clip, "out.mp4", "--crf", "5")
    stored, shown = video(clip)[1], video(outcome.target)[1]
    # The matrix turns counterclockwise, as np.rot90 does.
    upright = np.rot90(rgb_from_frame(stored), rotation // 90)
    assert (shown.height, shown.width) == upright.shape[:2] and shown.rotation == 0
    assert rms_error(rgb_from_frame(shown), upright) < 4


def test_16_of_two_video_tracks_the_longer_is_taken_and_named(program: Program):
    short = make_clip(program.folder / "short.mp4", frames=10, size=(64, 64))
    long = make_clip(program.folder / "long.mp4", frames=30, size=(96, 96))
    both = program.folder / "both.mp4"
    with av.open(str(short)) as one, av.open(str(long)) as two, av.open(str(both), "w") as made:
        tracks = [(film, made.add_stream_from_template(film.streams.video[0])) for film in (one, two)]
        for film, stream in tracks:
            for packet in film.demux(video=0):
                if packet.size:
                    packet.stream = stream
                    made.mux(packet)
    outcome = program(both)
    assert outcome.exit_code == 0
    assert len(video(outcome.target)) == 30 and "stream 1, the longest, is used" in outcome.said


def test_17_every_track_of_sound_and_subtitles_is_kept(program: Program):
    clip = make_clip(program.folder / "clip.mkv", frames=60, audio_tracks=2, subtitles=["eng", "deu"])
    outcome = program(clip, "out.mkv")
    assert (outcome.exit_code, outcome.lines) == (0, [])
    for kind in ("audio", "subtitles"):
        for number in range(2):
            assert packets(outcome.target, kind, number) == packets(clip, kind, number)
    with av.open(str(clip)) as given, av.open(str(outcome.target)) as made:
        languages = [[stream.metadata.get("language") for stream in film.streams] for film in (given, made)]
    assert sorted(map(str, languages[0])) == sorted(map(str, languages[1]))


def test_18_broadcast_cut_anywhere_and_starting_at_18_hours(program: Program):
    clip = make_clip(program.folder / "clip.ts", frames=120, audio_tracks=1, options={"bf": "2"})
    late = remux(clip, program.folder / "late.ts", offset=65946)
    content = late.read_bytes()
    middle = len(content) // 188 // 5 * 2 * 188
    head = content[: 188 * 3]  # the tables, which describe the streams
    late.write_bytes(head + content[middle:])
    outcome = program(late)
    assert outcome.exit_code in (0, 4), outcome.said
    found = times(outcome.target)
    assert 0 <= found[0] < 1 and len(found) > 30
    sound = packets(outcome.target, "audio")
    assert len(sound) > 30 and abs(sound[0][0] - found[0]) < 1.5


def test_19_interlaced_films_are_not_combed_in_silence(program: Program):
    options = {"flags": "+ildct+ilme", "x264-params": "tff=1"}
    clip = make_clip(
        program.folder / "clip.mp4", size=(320, 180), frames=10, interlaced=True, options=options
    )
    outcome = program(clip)
    assert outcome.exit_code == 0 and "interlaced" in outcome.said
    assert combing(video(outcome.target)[4]) < 0.5 * combing(video(clip)[4])


def combing(frame: av.VideoFrame) -> float:
    """How much more each row differs from its neighbours than from those two away."""
    luma = rgb_from_frame(frame).mean(axis=2)
    near = np.abs(luma[2:] - luma[1:-1]).mean()
    far = np.abs(luma[2:] - luma[:-2]).mean()
    return float(max(near - far, 0))


def test_20_ten_bits_stay_in_colour(program: Program):
    clip = make_clip(program.folder / "clip.mkv", frames=4, codec="libx265", pix_fmt="yuv420p10le")
    outcome = program(clip, "out.mp4", "--crf", "5")
    assert outcome.exit_code == 0
    pairs = zip(video(clip), video(outcome.target), strict=True)
    assert max(rms_error(rgb_from_frame(one), rgb_from_frame(other)) for one, other in pairs) < 3


def test_20_hdr_is_brought_to_sdr_and_said(program: Program):
    clip = make_clip(
        program.folder / "clip.mp4",
        frames=4,
        codec="libx265",
        pix_fmt="yuv420p10le",
        matrix="bt2020",
        transfer="pq",
    )
    outcome = program(clip)
    frame = video(outcome.target)[2]
    assert outcome.exit_code == 0 and "HDR" in outcome.said
    assert (frame.color_trc, frame.color_primaries, frame.colorspace) == (1, 1, 1)
    scene = list(moving_frames(4, (160, 90)))[2].astype(np.float64)
    shown = rgb_from_frame(frame)
    similar = np.corrcoef(shown.ravel(), scene.ravel())[0, 1]
    assert similar > 0.9 and 0.6 < shown.mean() / scene.mean() < 1.5


@pytest.mark.parametrize("size", [(161, 121), (641, 361), (1, 1), (2, 2), (16, 8192)])
def test_21_odd_sizes(program: Program, size):
    path = program.folder / "clip.mkv"
    make_clip(path, frames=3, size=size, codec="ffv1", pix_fmt="yuv444p")
    outcome = program(path)
    frames = video(outcome.target)
    assert outcome.exit_code == 0, outcome.said
    padded = size[0] + size[0] % 2, size[1] + size[1] % 2
    assert [(frame.width, frame.height) for frame in frames] == [padded] * 3
    if padded != size:
        assert f"{padded[0]}x{padded[1]}" in outcome.said
    for one, other in zip(video(path), frames, strict=True):
        kept = rgb_from_frame(other)[: size[1], : size[0]]
        assert rms_error(cv2.blur(rgb_from_frame(one), (3, 3)), cv2.blur(kept, (3, 3))) < 8


@pytest.mark.parametrize("size", [(3840, 2160), pytest.param((7680, 4320), marks=pytest.mark.thorough)])
def test_22_large_frames(program: Program, size: tuple[int, int]):
    path = program.folder / "large.mkv"
    rgb = cv2.resize(next(moving_frames(1)), size)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=25, width=size[0], height=size[1], pix_fmt="yuvj420p")
        container.mux(stream.encode(av.VideoFrame.from_ndarray(rgb).reformat(format="yuvj420p")))
        container.mux(stream.encode(None))
    style = program.folder / "few.toml"
    style.write_text('format = 1\n[[background]]\nblock = "posterize"\n')
    outcome = program(path, "out.mp4", "--preset", "ultrafast", style=str(style))
    assert outcome.exit_code == 0, outcome.said
    assert [(frame.width, frame.height) for frame in video(outcome.target)] == [size]


@pytest.mark.parametrize("ending", ["webm", "mp4"])
def test_23_alpha_is_kept_or_said_to_be_dropped(program: Program, ending):
    path = program.folder / "clip.webm"
    make_clip(path, frames=3, size=(64, 48), codec="libvpx-vp9", pix_fmt="yuva420p")
    outcome = program(path, f"out.{ending}")
    assert outcome.exit_code == 0, outcome.said
    if ending == "mp4":
        assert "alpha" in outcome.said or "transparen" in outcome.said
    else:
        assert alpha_of(outcome.target) == pytest.approx(alpha_of(path), abs=6)


def alpha_of(path: Path) -> np.ndarray:
    """The alpha plane of the first frame; FFmpeg's own VP9 decoder leaves it out."""
    decoder = av.CodecContext.create("libvpx-vp9", "r")
    with av.open(str(path)) as container:
        for packet in container.demux(video=0):
            for frame in decoder.decode(packet):
                return frame.to_ndarray(format="rgba")[..., 3].astype(float)
    raise AssertionError("no frame")
