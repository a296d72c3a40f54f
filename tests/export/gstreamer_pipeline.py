"""Use the element `vidstyle` from a program, with the Python of GStreamer, and print the results as JSON.

pytest does not run this file; tests/export/test_plug_in_gstreamer.py runs it as a separate program.
"""

from __future__ import annotations

import json
import sys

import gi
import numpy as np

gi.require_version("Gst", "1.0")
gi.require_version("GstVideo", "1.0")
from gi.repository import Gst, GstVideo  # noqa: E402

WIDTH, HEIGHT = 33, 19
STRIDES, OFFSETS = (48, 32, 32), (8, 1000, 1400)
"""Larger strides and offsets than the I420 layout of GStreamer."""
SHAPES = (HEIGHT, WIDTH), (10, 17), (10, 17)
DEFAULT_STRIDES, DEFAULT_OFFSETS = (36, 20, 20), (0, 720, 920)
CAPS = f"video/x-raw,format=I420,width={WIDTH},height={HEIGHT},framerate=25/1"


def main() -> None:
    """Push frames, and change the style between them."""
    Gst.init(None)
    from vidstyle_element import VidstyleElement

    Gst.Element.register(None, "vidstyle", Gst.Rank.NONE, VidstyleElement)
    pipeline = Gst.parse_launch(
        f"appsrc name=source format=time caps={CAPS} ! vidstyle name=effect style=plain device=cpu"
        " ! appsink name=target sync=false"
    )
    pipeline.set_state(Gst.State.PLAYING)
    planes = [np.random.default_rng(7).integers(16, 235, shape, np.uint8) for shape in SHAPES]
    effect = pipeline.get_by_name("effect")
    seen = [_restyled(pipeline, planes, 0)]
    effect.set_property("style", "ink")
    seen.append(_restyled(pipeline, planes, 1))
    effect.set_property("set", "ink=#00ff00; nonsense=1")
    seen.append(_restyled(pipeline, planes, 2))
    message = pipeline.get_bus().timed_pop_filtered(0, Gst.MessageType.WARNING)
    effect.set_property("set", "ink=#00ff00")
    seen.append(_restyled(pipeline, planes, 3))
    pipeline.set_state(Gst.State.NULL)
    equal = [[_are_equal(one, other) for other in (planes, *seen)] for one in seen]
    json.dump({"equal": equal, "warning": message and message.parse_warning()[0].message}, sys.stdout)


def _restyled(pipeline: Gst.Element, planes: list[np.ndarray], number: int) -> list[np.ndarray]:
    data = np.zeros(2000, np.uint8)
    for plane, stride, offset in zip(planes, STRIDES, OFFSETS, strict=True):
        np.ndarray(plane.shape, np.uint8, data.data, offset, (stride, 1))[...] = plane
    buffer = Gst.Buffer.new_wrapped(data.tobytes())
    buffer.pts, buffer.duration = number * Gst.SECOND // 25, Gst.SECOND // 25
    GstVideo.buffer_add_video_meta_full(
        buffer, 0, GstVideo.VideoFormat.I420, WIDTH, HEIGHT, 3, [*OFFSETS, 0], [*STRIDES, 0]
    )
    pipeline.get_by_name("source").emit("push-buffer", buffer)
    made = pipeline.get_by_name("target").emit("pull-sample").get_buffer()
    assert made.pts == buffer.pts
    result = made.extract_dup(0, made.get_size())
    return [
        np.ndarray(shape, np.uint8, result, offset, (stride, 1))
        for shape, stride, offset in zip(SHAPES, DEFAULT_STRIDES, DEFAULT_OFFSETS, strict=True)
    ]


def _are_equal(one: list[np.ndarray], other: list[np.ndarray]) -> bool:
    return all(map(np.array_equal, one, other))


if __name__ == "__main__":
    main()
