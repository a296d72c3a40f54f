"""Deinterlacing, one frame per frame, with FFmpeg's bwdif (after BBC R&D's Weston filter)."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction

import av
import av.filter

from vidstyle.errors import log
from vidstyle.media.frame import DecodedFrame


class Deinterlacer:
    """Passes frames through unchanged until the first interlaced one; filters all later ones.

    The filter looks one frame ahead, returns one frame for each, and does not change frames without the flag.
    With `every_frame`, it deinterlaces all frames, for films whose frames lack the flag.
    """

    def __init__(self, time_base: Fraction, every_frame: bool = False) -> None:
        self._time_base, self._every_frame = time_base, every_frame
        self._graph: av.filter.Graph | None = None
        self._kind: tuple[int, int, str] = (0, 0, "")
        self._inside: deque[DecodedFrame] = deque()

    def reset(self) -> None:
        """Clear the state before a seek."""
        self._inside.clear()
        self._kind = (0, 0, "")

    def apply(self, items: Iterable[DecodedFrame | av.Packet]) -> Iterator[DecodedFrame | av.Packet]:
        """Yield the items with progressive frames; packets pass through."""
        for item in items:
            if isinstance(item, DecodedFrame) and (
                self._graph or self._every_frame or item.native.interlaced_frame
            ):
                yield from self._filter(item)
            else:
                yield item
        yield from self.flush()

    def _filter(self, frame: DecodedFrame) -> Iterator[DecodedFrame]:
        native = frame.native
        kind = (native.width, native.height, native.format.name)
        if self._graph is None:
            log.warning("the source is interlaced; it is deinterlaced with bwdif")
        elif self._inside and kind != self._kind:
            yield from self.flush()
        if self._graph is None or kind != self._kind:
            self._graph, self._kind = self._build(native), kind
        native.pts, native.time_base = frame.pts, self._time_base
        self._inside.append(frame)
        self._graph.push(native)
        yield from self._pull()

    def flush(self) -> Iterator[DecodedFrame]:
        """Yield the frame that is still in the filter."""
        if self._graph is not None and self._inside:
            self._graph.push(None)
            yield from self._pull()

    def _build(self, frame: av.VideoFrame) -> av.filter.Graph:
        graph = av.filter.Graph()
        source = graph.add_buffer(
            width=frame.width, height=frame.height, format=frame.format, time_base=self._time_base
        )
        which = "all" if self._every_frame else "interlaced"
        deinterlacer = graph.add("bwdif", mode="send_frame", parity="auto", deint=which)
        graph.link_nodes(source, deinterlacer, graph.add("buffersink")).configure()
        return graph

    def _pull(self) -> Iterator[DecodedFrame]:
        assert self._graph is not None
        while True:
            try:
                native = self._graph.pull()
            except (av.BlockingIOError, av.EOFError):
                return
            assert isinstance(native, av.VideoFrame)
            yield replace(self._inside.popleft(), native=native)
