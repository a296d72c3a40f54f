"""Copies the other streams of a source: audio, subtitles, attachments, covers, chapters, tags."""

from __future__ import annotations

import io
import logging
from collections.abc import Callable, Iterable
from functools import partial

import av
from av.audio.stream import AudioStream
from av.bitstream import BitStreamFilterContext
from av.stream import AttachmentStream, Disposition, Stream
from av.subtitles.stream import SubtitleStream

from vidstyle.errors import UsageError, log
from vidstyle.media.audio import Loss
from vidstyle.media.write.containers import ContainerKind
from vidstyle.media.write.transcode import TEXT_CODECS, AudioTranscoder, CopiedStream, SubtitleTranscoder

FILE_TAGS = "encoder major_brand minor_version compatible_brands rotate duration vendor_id".split()
"""Tags that are valid only for the file of the source."""
FILE_TAG_STARTS = ("_statistics", "bps", "number_of_", "duration-")
_LANGUAGE_CODES = (
    "deu ger fra fre nld dut zho chi ces cze ell gre fas per ron rum slk slo sqi alb "
    "hye arm mya bur kat geo isl ice mkd mac msa may bod tib"
).split()
BIBLIOGRAPHIC_CODES = dict(zip(_LANGUAGE_CODES[::2], _LANGUAGE_CODES[1::2], strict=True))
"""Bibliographic language codes by terminological ones (ISO 639-2)."""
COVER_CODECS = ("mjpeg", "png", "bmp")
MAX_EARLY_SECONDS = 0.05
"""Time by which sound may be early if it can only start at 0; more is noticeable (ITU-R BT.1359)."""


class PlainCopy(CopiedStream):
    """Stream copy: packets pass unchanged."""

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """Assign the packet to the new stream."""
        if packet.dts is None and self.stream.disposition & Disposition.attached_pic:
            packet.pts = packet.dts = 0
        packet.stream = self.stream
        return [packet]


class FramedCopy(CopiedStream):
    """AAC with ADTS headers, as in MPEG-TS; packets without header cannot be decoded and are dropped."""

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """Return the packet, or none if it has no header."""
        if int.from_bytes(memoryview(packet)[:2]) & 0xFFF0 != 0xFFF0:
            self.loss.add(packet)
            return []
        packet.stream = self.stream
        return [packet]


class AdtsCopy(CopiedStream):
    """AAC with ADTS headers, which are removed as MP4 and Matroska require (aac_adtstoasc)."""

    def __init__(self, stream: Stream, template: Stream) -> None:
        super().__init__(stream)
        self._filter = BitStreamFilterContext("aac_adtstoasc", in_stream=template)

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """Return the packet without its header, or none if it is damaged."""
        time_base = packet.time_base
        try:
            bare = self._filter.filter(packet)
        except av.FFmpegError:
            self.loss.add(packet)
            return []
        for made in bare:
            made.stream, made.time_base = self.stream, time_base
        return bare


StreamMaker = Callable[[av.container.OutputContainer], CopiedStream]
"""Adds a copied or transcoded stream to a container."""


class CopiedStreams:
    """The streams of a source that are copied, or transcoded if the container does not support them.

    Args:
        target: name of the output for messages.
        audio: "copy", "none" or the name of an encoder.

    Attributes:
        awaited: indexes of the streams without a packet so far, for which a muxer may wait.
        needed: indexes of the streams without a packet so far, of which the muxer needs one.

    Raises:
        UsageError: `audio` is not an encoder, or the container does not support its codec.
    """

    def __init__(
        self,
        container: av.container.OutputContainer,
        kind: ContainerKind,
        streams: Iterable[Stream],
        audio: str,
        target: str,
    ) -> None:
        self._container, self._kind, self._audio, self._target = container, kind, audio, target
        _check_encoder(kind, audio)
        self._templates = {stream.index: stream for stream in streams}
        # Read now: the streams of a closed container cannot be queried.
        self._types = {index: stream.type for index, stream in self._templates.items()}
        self._ways = {index: self._find_ways(stream) for index, stream in self._templates.items()}
        self._streams: dict[int, CopiedStream] = {}
        self._early: list[av.Packet] | None = []
        self._first: dict[int, av.Packet] = {}
        kept = {index for index, ways in self._ways.items() if ways}
        self.awaited = {index for index in kept if self._types[index] in ("audio", "data")}
        self.needed = {index for index in self.awaited if not self._works(self._best_way(index), None)}

    def begin(self, over: bool = False) -> list[av.Packet]:
        """Add the streams, before the container's header is written; return the packets so far.

        Args:
            over: whether no more packets follow.
        """
        early, self._early = self._early or [], None
        come = {packet.stream_index for packet in early}
        for index, template in self._templates.items():
            copied = self._add_stream(template, absent=over and index not in come)
            if copied is not None:
                copied.stream.metadata.update(_convert_language(portable_tags(template.metadata), self._kind))
                copied.stream.disposition = template.disposition
                self._streams[index] = copied
        return [made for packet in early for made in self.packets(packet)]

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """Return the packets for the muxer for a packet of the source; none before `begin`."""
        index = packet.stream_index
        if self._early is not None:
            self._early.append(packet)
            if index in self.awaited and self._works(self._best_way(index), packet):
                self.awaited.remove(index)
                self.needed.discard(index)
                self._first[index] = packet
            return []
        copied = self._streams.get(index)
        if copied is None or (packet.size == 0 and packet.dts is None):
            return []
        return copied.packets(packet)

    def flush(self) -> list[av.Packet]:
        """Flush the encoders."""
        return [packet for copied in self._streams.values() for packet in copied.flush()]

    @property
    def loss(self) -> str:
        """Description of the damage, such as "2 packets (0.10 s) of stream 1 (audio) lost"."""
        return ", ".join(
            f"{copied.loss} of stream {index} ({self._types[index]}) lost"
            for index, copied in self._streams.items()
            if copied.loss != Loss()
        )

    def count_refused(self, stream: int, seconds: float) -> None:
        """Count a packet that the muxer refused; `stream`: its index in the new container."""
        for copied in self._streams.values():
            if copied.stream.index == stream:
                copied.loss.packets += 1
                copied.loss.seconds += seconds

    def _add_stream(self, template: Stream, absent: bool) -> CopiedStream | None:
        """Add a stream in the first way that works; log a notice if it is not a copy."""
        first = self._first.get(template.index)
        late = not absent and codec_name(template) in self._kind.untimed and _begins_late(first)
        ways, reason = self._find_ways(template, late), self._reason(template, late)
        for how, way in list(ways.items())[: 1 if absent else None]:
            if self._works(way, first):
                if how:
                    self._log_change(
                        logging.WARNING if template.type == "audio" else logging.INFO, template, how, reason
                    )
                return way(self._container)
        if ways or self._audio != "none" or template.type != "audio":
            reason = "it has no packet before the end" if absent else reason
            self._log_change(logging.WARNING, template, "dropped", reason)
        return None

    def _reason(self, template: Stream, late: bool) -> str:
        """Return the reason why a stream is not copied."""
        files = f"{self._kind.endings[0]} files"
        if late:
            return f"it starts late, which {files} do not support"
        needed = template.index in self.needed
        return f"{files} need a valid early packet of it" if needed else f"{files} do not support it"

    def _best_way(self, index: int) -> StreamMaker:
        return next(iter(self._ways[index].values()))

    def _works(self, way: StreamMaker, packet: av.Packet | None) -> bool:
        """Whether a file with only this stream and this packet can be completed.

        Some muxers fail at the end, and lose everything, if a stream has no packet.
        """
        try:
            options = self._container.container_options
            with av.open(io.BytesIO(), "w", self._kind.muxer, container_options=options) as trial:
                copied = way(trial)
                trial.start_encoding()
                trial.mux(copied.make_sample(packet) if packet is not None else [])
        except (av.FFmpegError, OSError, ValueError) as error:
            log.debug("%s: %s", self._target, error)
            return False
        return True

    def _find_ways(self, template: Stream, late: bool = False) -> dict[str, StreamMaker]:
        """Return the ways to keep a stream, best first, by their descriptions.

        Args:
            late: whether a copy would start too early.
        """
        name, kind = codec_name(template), self._kind
        copy: dict[str, StreamMaker] = {"": partial(_add_copy, template=template, name=name, kind=kind)}
        if isinstance(template, AttachmentStream):
            return {"": partial(_add_attachment, template=template)} if kind.attachments else {}
        if isinstance(template, AudioStream):
            if self._audio == "none":
                return {}
            held = self._audio == "copy" and name in kind.audio and not late
            encoders = dict.fromkeys((self._audio, kind.new_audio)) if template.codec_context else ()
            return (copy if held else {}) | {
                "" if encoder == self._audio else f"re-encoded as {encoder}": partial(
                    AudioTranscoder, template=template, encoder=encoder, untimed=kind.untimed
                )
                for encoder in encoders
                if encoder not in ("", "copy")
            }
        if isinstance(template, SubtitleStream):
            text = next((codec for codec in kind.subtitles if codec in TEXT_CODECS), None)
            if name in kind.subtitles or text is None or name not in TEXT_CODECS:
                return copy if name in kind.subtitles else {}
            return {f"converted to {text}": partial(SubtitleTranscoder, template=template, encoder=text)}
        is_cover = bool(template.disposition & Disposition.attached_pic)
        return copy if (name in COVER_CODECS and kind.covers if is_cover else name in kind.data) else {}

    def _log_change(self, level: int, template: Stream, words: str, reason: str) -> None:
        name = codec_name(template) or getattr(template, "name", "") or "unknown"
        place = f"{self._target}: stream {template.index} ({template.type} {name})"
        log.log(level, "%s is %s, because %s", place, words, reason)


def _begins_late(first: av.Packet | None) -> bool:
    """Whether a stream starts after 0, by its first packet; None: no packet yet."""
    stamp = None if first is None else first.dts if first.pts is None else first.pts
    return first is None or (stamp is not None and float(stamp * first.time_base) > MAX_EARLY_SECONDS)


def _add_attachment(container: av.container.OutputContainer, template: AttachmentStream) -> CopiedStream:
    mimetype = template.mimetype or "application/octet-stream"
    return PlainCopy(container.add_attachment(template.name or "attachment", mimetype, template.data))


def _add_copy(
    container: av.container.OutputContainer, template: Stream, name: str, kind: ContainerKind
) -> CopiedStream:
    stream = container.add_stream_from_template(template, opaque=True)  # type: ignore[type-var]
    context = template.codec_context
    if name != "aac" or context is None or context.extradata is not None:
        return PlainCopy(stream)
    return FramedCopy(stream) if kind.framed_aac else AdtsCopy(stream, template)


def copy_chapters(
    source: av.container.InputContainer, container: av.container.OutputContainer, kind: ContainerKind
) -> None:
    """Copy the chapters; log those with impossible times, or that the container does not support any."""
    found = source.chapters()
    chapters = [each for each in found if 0 <= each["start"] <= each["end"]]
    if len(chapters) < len(found):
        log.warning("%d chapters are dropped, because their times are impossible", len(found) - len(chapters))
    if chapters and kind.chapters:
        container.set_chapters(chapters)
    elif chapters:
        log.warning(
            "%d chapters are dropped, because %s files do not support them", len(chapters), kind.endings[0]
        )


def portable_tags(tags: dict[str, str]) -> dict[str, str]:
    """Return the tags that remain valid in another file.

    >>> portable_tags({"title": "Rain", "ENCODER": "x", "DURATION": "00:00:01", "BPS-eng": "9"})
    {'title': 'Rain'}
    """
    return {
        name: value
        for name, value in tags.items()
        if name.lower() not in FILE_TAGS and not name.lower().startswith(FILE_TAG_STARTS)
    }


def _convert_language(tags: dict[str, str], kind: ContainerKind) -> dict[str, str]:
    """Convert the language tag to the code that the container uses."""
    language = tags.get("language", "")
    known = BIBLIOGRAPHIC_CODES.get(language) if kind.bibliographic else None
    return tags | {"language": known} if known else tags


def codec_name(stream: Stream) -> str:
    """Return FFmpeg's name of the codec of a stream, or "" if it has none."""
    context = stream.codec_context
    return context.codec.canonical_name if context is not None else getattr(stream, "name", None) or ""


def _check_encoder(kind: ContainerKind, audio: str) -> None:
    if audio in ("copy", "none"):
        return
    try:
        codec = av.Codec(audio, "w")
    except av.codec.codec.UnknownCodecError:
        codec = None
    if codec is None or codec.type != "audio":
        raise UsageError("--audio", f"there is no audio encoder {audio!r}", "use copy, none, aac or libopus")
    if codec.canonical_name not in kind.audio:
        remedy = f"use one of {', '.join(kind.audio)}" if kind.audio else "remove the option"
        raise UsageError("--audio", f"{kind.endings[0]} files do not support {audio}", remedy)
