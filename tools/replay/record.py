"""Record the processor times of the tasks of a film, in the order in which a frame needs them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from types import BuiltinFunctionType
from typing import Any, Literal
from unittest.mock import patch

import cv2
import numpy as np

from vidstyle.core.kernels import library
from vidstyle.core.kernels.arguments import MIN_UNLOCKED_NUMBERS
from vidstyle.core.kernels.declare import OTHER_TYPES
from vidstyle.core.picture import Picture
from vidstyle.cpu import frame_threads
from vidstyle.cpu.frame_order import FrameOrder
from vidstyle.cpu.remote_style import RemoteStyle
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.cpu.shared_pictures import planes_of
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader
from vidstyle.media.write.film_writer import FilmWriter
from vidstyle.pipeline.stages import Stages
from vidstyle.regions.focus import FocusedPicture
from vidstyle.regions.mask_renderer import MaskRenderer
from vidstyle.stabilize import flow

Event = tuple[str, float | int]
"""("python" or "native", seconds): work with or without the GIL. ("enter" or "leave", number): use of a
state of earlier frames. ("edit" or "style", seconds of copying pictures) and ("moved", 0): begin and end of
work that another process can do."""


@dataclass
class Recording:
    """The tasks of the frames of a film, in seconds of processor time.

    Attributes:
        reading, writing: times of each frame; with one thread, writing includes encoding.
        begun, finished: events of each frame before restyling, and while it is restyled.
        ending: time for the frames that remain in the encoder after the last one is written.
        stages: time of the threads that read, restyle and write; with one thread, they do all tasks.
    """

    reading: list[float] = field(default_factory=list)
    writing: list[float] = field(default_factory=list)
    begun: list[list[Event]] = field(default_factory=list)
    finished: list[list[Event]] = field(default_factory=list)
    ending: list[float] = field(default_factory=list)
    stages: dict[str, float] = field(default_factory=dict)

    def clear(self) -> None:
        """Discard the recorded tasks, for example after a warm-up."""
        for each in vars(self).values():
            each.clear()

    @property
    def seconds(self) -> float:
        """Processor time of all tasks."""
        return sum((*self.reading, *self.writing, *self.ending, self._restyling)) + sum(self.between.values())

    def without(self, part: Literal["lock", "order", "reading", "writing"]) -> Recording:
        """Return a recording without the GIL, the order of frames, or the time of reading or writing."""
        match part:
            case "lock":
                frames = self._changed(lambda kind, value: [("native" if kind == "python" else kind, value)])
                return replace(frames, stages={})
            case "order":
                return self._changed(lambda *event: [] if event[0] in ("enter", "leave") else [event])
            case "reading":
                return replace(self, reading=[0.0] * len(self.reading), stages={**self.stages, "read": 0.0})
        stages = {**self.stages, "write": 0.0}
        return replace(self, writing=[0.0] * len(self.writing), ending=[], stages=stages)

    def _changed(self, change: Callable[[str, float | int], list[Event]]) -> Recording:
        begun, finished = (
            [[new for event in events for new in change(*event)] for events in frames]
            for frames in (self.begun, self.finished)
        )
        return replace(self, begun=begun, finished=finished)

    @property
    def between(self) -> dict[str, float]:
        """Processor time of each stage between its tasks."""
        tasks = {
            "read": sum(self.reading),
            "style": self._restyling,
            "write": sum(self.writing) + sum(self.ending),
        }
        return {name: max(0.0, seconds - tasks[name]) for name, seconds in self.stages.items()}

    @property
    def _restyling(self) -> float:
        events = (each for frame in (*self.begun, *self.finished) for each in frame)
        return sum(time for kind, time in events if kind in TIMED)

    @property
    def python_seconds(self) -> float:
        """Processor time outside kernels, an upper bound of the time with the GIL."""
        events = (each for frame in (*self.begun, *self.finished) for each in frame)
        return sum(seconds for kind, seconds in events if kind == "python")


TIMED = ("python", "native")


class _Marks(threading.local):
    """The events of the current frame of a thread, and the end time of the last one.

    Attributes:
        overhead: time of recording in seconds.
    """

    events: list[Event] | None = None
    last = overhead = 0.0

    def mark(self, kind: str) -> None:
        """Add the time since the last event."""
        if self.events is not None:
            now = time.thread_time()
            self.events.append((kind, now - self.last))
            self.last = time.thread_time()
            self.overhead += self.last - now

    @contextmanager
    def into(self, events: list[Event]) -> Iterator[None]:
        """Add events to this list within the block."""
        self.mark("python")
        before, self.events, self.last = self.events, events, time.thread_time()
        try:
            yield
            self.mark("python")
        finally:
            self.events, self.last = before, time.thread_time()


_marks = _Marks()


@contextmanager
def recording(large_bands: bool = False) -> Iterator[Recording]:
    """Record the tasks of one film, rendered with one thread, within the block.

    Args:
        large_bands: use the bands of more than `MAX_SMALL_BAND_THREADS` threads.
    """
    made, memories = Recording(), dict[int, tuple[int, object]]()
    at, entry = FrameOrder.at, library.entry

    @contextmanager
    def ordered(self: FrameOrder, memory: object) -> Iterator[None]:
        number, _ = memories.setdefault(id(memory), (len(memories), memory))
        _note(("enter", number))
        with at(self, memory):
            yield
        _note(("leave", number))

    def timed_entry(*arguments: Any) -> Callable[..., object]:
        return _native(entry(*arguments), _has_unlocked)

    patches: dict[tuple[Any, str], Any] = {
        (MaskRenderer, "begin"): _begun(MaskRenderer.begin, made),
        (FocusedPicture, "result"): _finished(FocusedPicture.result, made),
        (CpuRenderer, "_finish"): _finished(CpuRenderer._finish, made),
        (CpuRenderer, "_restyle"): _movable(CpuRenderer._restyle, "style"),
        (RemoteStyle, "make"): _movable(RemoteStyle.make, "edit"),
        (FrameOrder, "at"): ordered,
        (Reader, "__iter__"): _timed_frames(Reader.__iter__, made.reading),
        (FilmWriter, "write"): _timed_writes(FilmWriter.write, made.writing),
        (FilmWriter, "finish"): _timed(FilmWriter.finish, made.ending.append),
        **{
            (Stages, f"_{name}"): _timed(getattr(Stages, f"_{name}"), partial(made.stages.__setitem__, name))
            for name in ("read", "style", "write")
        },
        (library, "entry"): timed_entry,
        (np, "partition"): _native(np.partition),
        # A method of OpenCV; the next lines find only functions.
        (flow, "dense_flow"): _native(flow.dense_flow),
        **{
            (cv2, name): _native(each)
            for name, each in vars(cv2).items()
            if isinstance(each, BuiltinFunctionType)
        },
    }
    if large_bands:
        patches[frame_threads, "MAX_SMALL_BAND_THREADS"] = 0
    with ExitStack() as stack:
        for (owner, name), replacement in patches.items():
            stack.enter_context(patch.object(owner, name, replacement))
        yield made


def _note(event: Event) -> None:
    if _marks.events is not None:
        _marks.mark("python")
        _marks.events.append(event)


def _native(
    function: Callable[..., Any], has_unlocked: Callable[..., bool] = lambda *_, **__: True
) -> Callable[..., Any]:
    """Wrap a function so that its time counts as time without the GIL.

    Args:
        has_unlocked: returns whether the call released the GIL, for its result and arguments.
    """

    def call(*arguments: Any, **named: Any) -> Any:
        _marks.mark("python")
        result = function(*arguments, **named)
        if has_unlocked(result, *arguments, **named):
            _marks.mark("native")
        return result

    return call


def _has_unlocked(result: int, arguments: tuple[Any, ...]) -> bool:
    """Return whether a kernel has run and released the GIL; an entry for other types does not run."""
    return result != OTHER_TYPES and _numbers(arguments) > MIN_UNLOCKED_NUMBERS


def _numbers(value: Any) -> int:
    return sum(map(_numbers, value)) if isinstance(value, tuple) else getattr(value, "size", 0)


def _movable(method: Callable[..., Any], kind: str) -> Callable[..., Any]:
    """Mark work that another process can do, with the time of two copies of its input and output planes.

    Args:
        method: takes an object, an argument and a picture; returns a picture, or a picture and other data.
    """

    def call(owner: object, other: Any, picture: Picture, *others: Any) -> Any:
        _note((kind, 0.0))
        place = len(_marks.events or ())
        result = method(owner, other, picture, *others)
        _note(("moved", 0))
        if _marks.events is not None:
            began = time.thread_time()
            made = planes_of(result if isinstance(result, Picture) else result[0])
            taken = planes_of(picture)
            for plane in 2 * (taken + [each for each in made if not any(each is known for known in taken)]):
                plane.copy()
            _marks.last = time.thread_time()
            _marks.events[place - 1] = (kind, _marks.last - began)
            _marks.overhead += _marks.last - began
        return result

    return call


def _begun(method: Callable[..., Any], made: Recording) -> Callable[..., Any]:
    def call(*arguments: Any) -> Any:
        made.begun.append([])
        made.finished.append([])
        with _marks.into(made.begun[-1]):
            return method(*arguments)

    return call


def _finished(method: Callable[..., Any], made: Recording) -> Callable[..., Any]:
    """Record the restyling of a frame and its faces; with one thread it runs in the `begun` part."""

    def call(*arguments: Any) -> Any:
        if not made.begun or _marks.events is not made.begun[-1]:  # a dry run within a frame
            return method(*arguments)
        with _marks.into(made.finished[-1]):
            return method(*arguments)

    return call


def _timed(method: Callable[..., None], note: Callable[[float], None]) -> Callable[..., None]:
    def timed(*arguments: Any) -> None:
        began = time.thread_time() - _marks.overhead
        method(*arguments)
        note(time.thread_time() - _marks.overhead - began)

    return timed


def _timed_frames(iterate: Callable[..., Any], seconds: list[float]) -> Callable[..., Any]:
    def timed(self: Reader) -> Iterator[Any]:
        began = time.thread_time()
        for item in iterate(self):
            if isinstance(item, Frame):
                seconds.append(time.thread_time() - began)
                yield item
                began = time.thread_time()
            else:
                yield item

    return timed


def _timed_writes(write: Callable[..., Any], seconds: list[float]) -> Callable[..., Any]:
    def timed(self: FilmWriter, item: Any) -> None:
        began = time.thread_time()
        write(self, item)
        if isinstance(item, Frame):
            seconds.append(time.thread_time() - began)

    return timed
