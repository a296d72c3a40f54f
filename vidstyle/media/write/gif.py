"""Writes GIF animations: frames are stored losslessly, then mapped to one palette for all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import av
from av.filter import Graph
from av.filter.context import FilterContext

from vidstyle.media.rational import to_fraction
from vidstyle.media.write.atomic import PartialFile
from vidstyle.media.write.film_writer import FilmWriter

TICK = Fraction(1, 100)
"""The unit of time in a GIF, in seconds."""
MIN_TICKS = 2
"""Minimum ticks of a frame; browsers show shorter ones five times as long."""


class GifWriter(FilmWriter):
    """A film that becomes a GIF when it is finished; an abandoned one stays a film."""

    partial_ending = ".mkv"

    def _put_in_place(self, file: PartialFile) -> None:
        file.rewrite(write_gif)
        super()._put_in_place(file)


def write_gif(source: Path, target: Path) -> bool:
    """Write the film at `source` as a GIF with the best palette of 256 colours; returns True.

    Raises:
        OSError: `target` cannot be written.
    """
    colors = _palette(source)
    with av.open(str(target), "w", format="gif") as container:
        stream: av.VideoStream | None = None
        for frame, begin, length in _timed(source):
            if stream is None:
                stream = _add_stream(container, frame)
                mapped = _palette_mapper(frame, colors)
            painted = mapped(frame)
            painted.pts, painted.time_base = begin, TICK
            for packet in stream.encode(painted):
                packet.duration = length
                container.mux(packet)
    return True


def _palette_mapper(like: av.VideoFrame, colors: av.VideoFrame) -> Callable[[av.VideoFrame], av.VideoFrame]:
    """A filter that maps frames to a palette with error diffusion (FFmpeg's paletteuse)."""
    graph = Graph()
    frames, palette = _buffer(graph, like), _buffer(graph, colors)
    use = graph.add("paletteuse", "diff_mode=rectangle")
    frames.link_to(use, 0, 0)
    palette.link_to(use, 0, 1)
    graph.link_nodes(use, graph.add("buffersink")).configure()
    palette.push(colors)
    palette.push(None)

    def mapped(frame: av.VideoFrame) -> av.VideoFrame:
        frames.push(frame)
        return graph.vpull()

    return mapped


def _palette(source: Path) -> av.VideoFrame:
    """The palette for the whole film, as a frame of 16 x 16 pixels."""
    graph: Graph | None = None
    for frame, _, _ in _timed(source):
        if graph is None:
            graph = Graph()
            nodes = _buffer(graph, frame), graph.add("palettegen"), graph.add("buffersink")
            graph.link_nodes(*nodes).configure()
        graph.vpush(frame)
    assert graph is not None
    graph.vpush(None)
    return graph.vpull()


def _buffer(graph: Graph, like: av.VideoFrame) -> FilterContext:
    return graph.add_buffer(
        width=like.width, height=like.height, format=like.format, time_base=like.time_base or TICK
    )


def _add_stream(container: av.container.OutputContainer, like: av.VideoFrame) -> av.VideoStream:
    stream = container.add_stream("gif", rate=25)
    stream.width, stream.height, stream.pix_fmt = like.width, like.height, "pal8"
    stream.codec_context.time_base = stream.time_base = TICK
    return stream


def _timed(source: Path) -> Iterator[tuple[av.VideoFrame, int, int]]:
    """Each frame with its start and duration in ticks; frames that would be too short are dropped."""
    with av.open(str(source), format="matroska") as container:
        waiting: tuple[av.VideoFrame, int] | None = None
        length = MIN_TICKS
        for frame in container.decode(video=0):
            begin = round(Fraction(frame.pts or 0) * to_fraction(frame.time_base or TICK) / TICK)
            if waiting is not None:
                if begin - waiting[1] < MIN_TICKS:
                    continue
                length = begin - waiting[1]
                yield *waiting, length
            waiting = frame, begin
        if waiting is not None:
            yield *waiting, length
