"""Which streams of a container are decoded, copied, counted as lost, or not read at all."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import av
from av.audio.stream import AudioStream
from av.stream import Discard, Stream
from av.video.stream import VideoStream

from vidstyle.media.read.source import (
    choose_stream,
    is_attached_picture,
    is_chapter_track,
    stream_content,
    video_streams,
)

SINGLE_VIDEO_FORMATS = frozenset({"flv", "live_flv", "mpeg"})
"""Formats with one video stream: FFmpeg creates another if the codec of a packet is damaged or changes."""


@dataclass(frozen=True)
class StreamSelection:
    """The streams of a container by use.

    Attributes:
        video: the video stream that is decoded.
        copied: the streams whose packets are passed through.
        continued: by the index of a stream that starts late, the copied audio stream that it continues.
        lost: video streams that hold damaged parts of the film.
        has_other_videos: whether there is a video stream in addition to `video`.
    """

    video: VideoStream
    copied: list[Stream]
    continued: dict[int, Stream]
    lost: list[VideoStream]
    has_other_videos: bool

    def list_hidden(self, container: av.container.InputContainer) -> list[Stream]:
        """Return the streams that are read, but not delivered under their own index."""
        return [*self.lost, *(container.streams[index] for index in self.continued)]

    def discard_others(self, container: av.container.InputContainer) -> bool:
        """Let the demuxer discard all streams that are not read; return whether there are any."""
        read = [self.video, *self.copied, *self.list_hidden(container)]
        unread = [each for each in container.streams if each not in read]
        for stream in unread:
            stream.discard = Discard.all
        return bool(unread)


def select_streams(
    container: av.container.InputContainer,
    name: str,
    broken: Collection[int],
    successors: dict[int, int],
    is_part: bool,
) -> StreamSelection:
    """Decide on the use of each stream.

    Args:
        broken: indexes of video streams that cannot be decoded.
        successors: by the identifier of an audio stream of a recording, the identifier of the stream that it
            continues.
        is_part: whether the container is a part of a recording, whose other video streams are lost video.

    Raises:
        InputError: there is no video stream, or this build cannot decode it.
    """
    video = choose_stream(container, name, broken)
    others = [each for each in video_streams(container, broken) if each != video]
    copied = _list_copied(container)
    continued = _match_continued(copied, successors)
    single = SINGLE_VIDEO_FORMATS.intersection(container.format.name.split(","))
    return StreamSelection(
        video,
        [each for each in copied if each.index not in continued],
        continued,
        others if is_part or single else [],
        bool(others),
    )


def _list_copied(container: av.container.InputContainer) -> list[Stream]:
    chapters = len(container.chapters())
    return [
        stream
        for stream in container.streams
        if (stream.type != "video" or is_attached_picture(stream)) and not is_chapter_track(stream, chapters)
    ]


def _match_continued(streams: Sequence[Stream], successors: dict[int, int]) -> dict[int, Stream]:
    """Return the audio stream that each later one of a recording continues, by the index of the later one."""
    sounds = [stream for stream in streams if isinstance(stream, AudioStream)]
    earlier = {stream.id: stream for stream in sounds}
    found = {stream.index: earlier.get(successors.get(stream.id, -1)) for stream in sounds}
    # FFmpeg has not probed all streams that start late; their rate is 0.
    return {
        stream.index: first
        for stream in sounds
        if (first := found[stream.index])
        and (not stream.rate or stream_content(first) == stream_content(stream))
    }
