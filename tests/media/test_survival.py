"""Nine difficult films restyled with `plain` keep everything that a player shows.

The player is the arithmetic of tests/support/media.py: by the tags, else by the size. Every one of ten other
tools fails at least one of these films.
"""

from __future__ import annotations

import hashlib
import logging
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from media import make_clip, read_all, rgb_from_frame, rms_error

from vidstyle.media.write.writer import WriteOptions
from vidstyle.pipeline.render import render

LARGE, MIDDLE, SMALL = (1280, 720), (640, 360), (320, 180)
HALVED = [Fraction(number, 30) for number in range(12)] + [Fraction(6 + number, 15) for number in range(8)]
"""Presentation times at 30 and then 15 frames a second."""


@dataclass(frozen=True)
class Survivor:
    """A film before and after."""

    source: list[av.VideoFrame]
    result: list[av.VideoFrame]
    source_path: Path
    result_path: Path

    def worst_error(self) -> float:
        """The greatest RMS difference of RGB in 0..255 among the frames, the source turned upright."""
        last = len(self.source) - 1
        return max(self.error(number) for number in {*range(0, last, 4), last})

    def error(self, number: int) -> float:
        """The RMS difference of one frame."""
        before, after = self.source[number], rgb_from_frame(self.result[number])
        upright = np.rot90(rgb_from_frame(before), before.rotation // 90)
        return rms_error(upright, after[: upright.shape[0], : upright.shape[1]])


def survive(folder: Path, ending: str = ".mp4", crf: int | None = None, **clip: object) -> Survivor:
    """Make a film, render it with `plain` and all other defaults, and read both."""
    clip = {"size": LARGE, "frames": 3, "audio_tracks": 1, "photograph_name": "rocket"} | clip
    source = make_clip(folder / f"clip{ending}", **clip)  # type: ignore[arg-type]
    result = folder / f"out{ending}"
    render(source, result, "plain", write=WriteOptions(crf=crf))
    survivor = Survivor(read_all(source), read_all(result), source, result)
    before, after = (
        [float(frame.pts * frame.time_base) for frame in frames]
        for frames in (survivor.source, survivor.result)
    )
    assert after == pytest.approx(before, abs=0.001)
    assert sounds(result) == sounds(source)
    assert all(frame.rotation == 0 for frame in survivor.result)
    return survivor


def sounds(path: Path) -> list[tuple[str, str, str]]:
    """Codec, language and digest of all packets of each sound track."""
    with av.open(str(path)) as container:
        digests = {stream.index: hashlib.sha256() for stream in container.streams.audio}
        for packet in container.demux(*container.streams.audio):
            digests[packet.stream.index].update(bytes(packet))
        return [
            (
                stream.codec_context.name,
                stream.metadata.get("language", "und"),
                digests[stream.index].hexdigest(),
            )
            for stream in container.streams.audio
        ]


def tags(frame: av.VideoFrame) -> tuple[int, int, int, int]:
    """Matrix, primaries, transfer and range."""
    return frame.colorspace, frame.color_primaries, frame.color_trc, frame.color_range


@pytest.mark.parametrize(
    ("clip", "expected"),
    [
        ({}, (1, 1, 1, 1)),
        ({"full_range": True, "size": MIDDLE}, (1, 1, 1, 2)),
        ({"matrix": "bt601"}, (6, 6, 6, 1)),
        ({"times": HALVED, "size": SMALL}, (1, 1, 1, 1)),
        ({"sample_aspect": Fraction(16, 15), "size": (720, 576)}, (1, 1, 1, 1)),
        ({"size": (641, 361), "pix_fmt": "yuv444p"}, (1, 1, 1, 1)),
        ({"rotation": 90, "size": MIDDLE}, (1, 1, 1, 1)),
    ],
    ids=["709", "full range", "HD tagged 601", "30 to 15 fps", "aspect 16:15", "odd 4:4:4", "turned phone"],
)
def test_colours_times_and_sound_survive(tmp_path, clip, expected):
    # So small or cut through so finely, these cost x264 itself 2 at the usual crf.
    fine = "pix_fmt" in clip or clip.get("size") in (MIDDLE, SMALL)
    film = survive(tmp_path, crf=4 if fine else None, **clip)
    assert film.worst_error() < 1.5
    assert tags(film.result[0]) == expected
    shape = film.source[0].height, film.source[0].width
    upright = shape[::-1] if clip.get("rotation") else shape
    assert (film.result[0].height, film.result[0].width) == tuple(side + side % 2 for side in upright)
    with av.open(str(film.result_path)) as container:
        stream = container.streams.video[0]
        assert (stream.sample_aspect_ratio or 1) == clip.get("sample_aspect", 1)
        assert stream.codec_context.name == "h264" and stream.pix_fmt == (
            "yuvj420p" if clip.get("full_range") else "yuv420p"
        )


def test_hdr_becomes_sdr_and_says_so(tmp_path, caplog):
    hdr = {"codec": "libx265", "pix_fmt": "yuv420p10le", "matrix": "bt2020", "transfer": "pq", "size": MIDDLE}
    with caplog.at_level(logging.INFO, "vidstyle"):
        film = survive(tmp_path, **hdr)
    assert any("HDR" in record.message for record in caplog.records)
    assert tags(film.result[0]) == (1, 1, 1, 1)
    # The same scene made in SDR, where white is 203 nits: tones in order, no cast, neither gray nor neon.
    sdr = rgb_from_frame(
        read_all(make_clip(tmp_path / "sdr.mp4", size=MIDDLE, frames=2, photograph_name="rocket"))[0]
    )
    shown = rgb_from_frame(film.result[0])
    tones = [(int(shown[mask].mean()), int(sdr[mask].mean())) for mask in _tone_masks(sdr)]
    assert [tone for tone, _ in tones] == sorted(tone for tone, _ in tones)
    assert all(abs(tone - wanted) < 40 for tone, wanted in tones)
    saturation = [np.ptp(picture, axis=2).mean() for picture in (shown, sdr)]
    assert 0.7 < saturation[0] / saturation[1] < 1.3


def _tone_masks(picture: np.ndarray) -> list[np.ndarray]:
    luma = picture @ [0.2126, 0.7152, 0.0722]
    borders = np.quantile(luma, np.linspace(0, 1, 7))
    return [(luma >= low) & (luma <= high) for low, high in zip(borders, borders[1:], strict=False)]


@pytest.mark.parametrize("ending", [".mkv", ".mp4"])
def test_all_that_a_film_holds_survives(tmp_path, ending):
    held = {"audio_tracks": 2, "subtitles": ("eng",), "chapters": 2, "title": "Nine films"}
    film = survive(tmp_path, ending, crf=4, frames=45, size=SMALL, **held)
    assert film.worst_error() < 1.5
    with av.open(str(film.source_path)) as before, av.open(str(film.result_path)) as after:
        assert after.metadata["title"] == before.metadata["title"] == "Nine films"
        kinds = [[stream.type for stream in container.streams] for container in (before, after)]
        assert sorted(kinds[0]) == sorted(kinds[1]) and kinds[1].count("audio") == 2
        assert [_chapter(chapter) for chapter in after.chapters()] == [_chapter(c) for c in before.chapters()]
        languages = [
            [stream.metadata.get("language") for stream in container.streams.subtitles]
            for container in (before, after)
        ]
        assert languages[0] == languages[1] == ["eng"]
    assert _subtitles(film.result_path) == _subtitles(film.source_path) != []


def _chapter(chapter: dict) -> tuple[float, float, str]:
    base = chapter["time_base"]
    return (
        round(float(chapter["start"] * base), 3),
        round(float(chapter["end"] * base), 3),
        chapter["metadata"]["title"],
    )


def _subtitles(path: Path) -> list[tuple[float, bytes]]:
    with av.open(str(path)) as container:
        packets = [packet for packet in container.demux(*container.streams.subtitles) if packet.size > 2]
        return [(round(float(packet.pts * packet.time_base), 3), bytes(packet)) for packet in packets]
