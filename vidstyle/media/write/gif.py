"""Writes GIF animations: frames are stored without loss, then mapped to one palette."""

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

TICK_SECONDS = Fraction(1, 100)
"""The unit of time in a GIF, in seconds."""
MIN_TICKS = 2
"""Minimum duration of a frame in ticks; browsers show shorter frames five times as long."""


class GifWriter(FilmWriter):
    """Writes a film that is converted to a GIF at the end; an abandoned one stays a film."""

    partial_ending = ".mkv"

    def _put_in_place(self, file: PartialFile) -> None:
        file.rewrite(write_gif)
        super()._put_in_place(file)


def write_gif(source: Path, target: Path) -> bool:
    """Convert the film at `source` to a GIF with the best palette of 256 colours; return True.

    Raises:
        OSError: `target` cannot be written.
    """
    colors = _make_palette(source)
    with av.open(str(target), "w", format="gif") as container:
        stream: av.VideoStream | None = None
        for frame, begin, length in _read_frames(source):
            if stream is None:
                stream = _add_stream(container, frame)
                mapped = _make_palette_mapper(frame, colors)
            painted = mapped(frame)
            painted.pts, painted.time_base = begin, TICK_SECONDS
            for packet in stream.encode(painted):
                packet.duration = length
                container.mux(packet)
    return True


def _make_palette_mapper(
    like: av.VideoFrame, colors: av.VideoFrame
) -> Callable[[av.VideoFrame], av.VideoFrame]:
    """Return a function that maps frames to a palette with error diffusion (FFmpeg's paletteuse)."""
    graph = Graph()
    frames, palette = _add_buffer(graph, like), _add_buffer(graph, colors)
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


def _make_palette(source: Path) -> av.VideoFrame:
    """Compute a palette for the whole film, as a frame of 16 x 16 pixels."""
    graph: Graph | None = None
    for frame, _, _ in _read_frames(source):
        if graph is None:
            graph = Graph()
            nodes = _add_buffer(graph, frame), graph.add("palettegen"), graph.add("buffersink")
            graph.link_nodes(*nodes).configure()
        graph.vpush(frame)
    assert graph is not None
    graph.vpush(None)
    return graph.vpull()


def _add_buffer(graph: Graph, like: av.VideoFrame) -> FilterContext:
    return graph.add_buffer(
        width=like.width, height=like.height, format=like.format, time_base=like.time_base or TICK_SECONDS
    )


def _add_stream(container: av.container.OutputContainer, like: av.VideoFrame) -> av.VideoStream:
    stream = container.add_stream("gif", rate=25)
    stream.width, stream.height, stream.pix_fmt = like.width, like.height, "pal8"
    stream.codec_context.time_base = stream.time_base = TICK_SECONDS
    return stream


def _read_frames(source: Path) -> Iterator[tuple[av.VideoFrame, int, int]]:
    """Yield each frame with its start and duration in ticks; drop frames that are too short."""
    with av.open(str(source), format="matroska") as container:
        waiting: tuple[av.VideoFrame, int] | None = None
        length = MIN_TICKS
        for frame in container.decode(video=0):
            begin = round(
                Fraction(frame.pts or 0) * to_fraction(frame.time_base or TICK_SECONDS) / TICK_SECONDS
            )
            if waiting is not None:
                if begin - waiting[1] < MIN_TICKS:
                    continue
                length = begin - waiting[1]
                yield *waiting, length
            waiting = frame, begin
        if waiting is not None:
            yield *waiting, length
