"""Makes a film of pictures and sound that are in memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.media.frame import frame_from_picture

SAMPLES = 1024
"""Samples of sound in one packet of AAC."""


def write_film(
    path: Path, pictures: Iterable[Picture], rate: Fraction, sound: np.ndarray, sample_rate: int
) -> None:
    """Write an MP4 with H.264 and AAC.

    Args:
        path: replaced if it is there.
        pictures: all of one size and in the default encoding: BT.709, 8 bit, 4:2:0.
        rate: frames per second.
        sound: mono samples, float32, -1..1, as long as the pictures.
        sample_rate: samples per second.
    """
    chunks = _sound_frames(sound, sample_rate)
    spoken = 0
    with av.open(str(path.absolute()), "w", format="mp4", options={"movflags": "faststart"}) as container:
        screen = container.add_stream("libx264", rate=rate, options={"crf": "18", "preset": "fast"})
        speaker = container.add_stream("aac", rate=sample_rate, layout="mono")
        for number, picture in enumerate(pictures):
            frame = frame_from_picture(picture)
            frame.pts, frame.time_base = number, 1 / rate
            if number == 0:
                _describe(screen, frame)
            container.mux(screen.encode(frame))
            # Sound goes beside its picture, so that a player need not look for it.
            while spoken * rate < number * sample_rate and (chunk := next(chunks, None)) is not None:
                container.mux(speaker.encode(chunk))
                spoken += SAMPLES
        container.mux(screen.encode(None))
        container.mux(speaker.encode(None))


def _describe(screen: av.VideoStream, frame: av.VideoFrame) -> None:
    context = screen.codec_context
    context.width, context.height, context.pix_fmt = frame.width, frame.height, frame.format.name
    context.color_range, context.colorspace = frame.color_range, frame.colorspace
    context.color_primaries, context.color_trc = frame.color_primaries, frame.color_trc


def _sound_frames(sound: np.ndarray, sample_rate: int) -> Iterator[av.AudioFrame]:
    for start in range(0, len(sound), SAMPLES):
        samples = np.ascontiguousarray(sound[None, start : start + SAMPLES])
        frame = av.AudioFrame.from_ndarray(samples, format="fltp", layout="mono")
        frame.sample_rate, frame.pts, frame.time_base = sample_rate, start, Fraction(1, sample_rate)
        yield frame
