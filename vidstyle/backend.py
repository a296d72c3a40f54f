"""What restyles pictures, on any device."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any, Protocol

import numpy as np

from vidstyle.core.closing import Closing
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.shared_tones import SharedTones
from vidstyle.picture_edit import MakeChange, PictureEdit, make_here
from vidstyle.style import Style


@dataclass(frozen=True)
class FrameRequest:
    """A picture to restyle.

    Attributes:
        picture: any picture; its planes are only read.
        time: presentation time in seconds, or None for a picture that stands alone.
        target: encoding of the result's planes; None: as the picture's own.
        rgb: packed RGB of the target's depth is wanted instead of luma and chroma.
        measured: gets the percentiles that are measured on this picture.
        tones: percentiles of a larger picture, which this one is a part of; None: this picture is measured.
        seen_side: the shorter side, in pixels, of the picture that the user sees, if this one is a reduced
            copy or a part of it; infinity where no picture is small. None: this one is seen.
        is_clean: whether noise of a picture that stands alone has been removed.
        edit: makes the picture to restyle in place of `picture`, in the same layout; cuts and motion still
            come from `picture`. None: no change.
    """

    picture: Picture
    time: float | None = None
    target: Encoding | None = None
    rgb: bool = False
    measured: SharedTones | None = None
    tones: SharedTones | None = None
    seen_side: float | None = None
    is_clean: bool = False
    edit: PictureEdit[Any] | None = None

    def edited(self, make: MakeChange = make_here) -> FrameRequest:
        """Return the request for the edited picture; `make` calls what changes it."""
        return self if self.edit is None else replace(self, picture=self.edit.picture(make), edit=None)

    def tones_of(self, step: Hashable, measure: Callable[[], np.ndarray]) -> np.ndarray:
        """Return the percentiles of a step, those that `measure` returns or those to use instead."""
        given = self.tones.get(step) if self.tones is not None else None
        numbers = measure() if given is None else given
        if self.measured is not None:
            self.measured.put(step, numbers)
        return numbers

    def measuring(self) -> AbstractContextManager[None]:
        """Restyle the picture in this block, in which its percentiles are measured."""
        return nullcontext() if self.measured is None else self.measured.measuring()

    @property
    def encoding(self) -> Encoding:
        """The encoding of the result."""
        return self.target or self.picture.encoding

    def is_passthrough(self, style: Style) -> bool:
        """Whether the result is the picture itself."""
        has_kind = self.rgb == (self.picture.color is not None)
        return style.is_plain and has_kind and self.encoding == self.picture.encoding


class PendingPicture(Protocol):
    """A picture that is being restyled."""

    def result(self) -> Picture:
        """The restyled picture; waits for it."""


class Backend(Closing, ABC):
    """Restyles one picture after another, on the CPU (`CpuRenderer`) or a GPU (`GpuRenderer`).

    It remembers earlier pictures where a style follows a film over time; a scene cut, a jump in time and
    another size reset that.

    Attributes:
        frames_in_flight: how many pictures may be started before the result of the first is asked for.
        device_kind: "cpu" or "gpu".
    """

    device_kind: str

    @property
    @abstractmethod
    def frames_in_flight(self) -> int: ...

    def start(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> PendingPicture:
        """Start to restyle a picture; see `FrameRequest` for the arguments."""
        return self.begin(FrameRequest(picture, time, target, rgb))

    def run(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Picture:
        """Restyle a picture at once; see `FrameRequest` for the arguments, and `restyle` for the errors."""
        return self.restyle(FrameRequest(picture, time, target, rgb))

    @abstractmethod
    def begin(self, request: FrameRequest) -> PendingPicture:
        """Start to restyle a picture."""

    def skip(self, request: FrameRequest) -> None:  # noqa: B027
        """Take note of a picture that comes before those to restyle, where later ones depend on it."""

    def restyle(self, request: FrameRequest) -> Picture:
        """Return the restyled picture, at its own size; wait for it.

        Raises:
            DeviceError: both the GPU and the CPU have failed.
            StyleError: the style cannot be used.
        """
        return self.begin(request).result()

    def memory(self) -> Sequence[np.ndarray]:
        """Return the state that the next picture of a scene depends on, while no picture is in flight.

        A renderer that has restyled the same last picture, and whose arrays are overwritten with these,
        continues in the same way. Missing are masks, faces in focus, film colours, and the state of a GPU.
        """
        return []

    @abstractmethod
    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on; pictures in flight keep theirs.

        Device, threads and compiled programs are kept. Where only numbers and colours differ, memory of
        earlier pictures is kept too. A style that cannot be used raises with the next result.
        """

    @abstractmethod
    def cancel(self) -> None:
        """Give up the pictures in flight, whose results may raise CancelledError; only `close` may follow."""


def completed_future(picture: Picture) -> Future[Picture]:
    """Return a completed future with this result."""
    future: Future[Picture] = Future()
    future.set_result(picture)
    return future


def joined_future(parts: Sequence[Future[Picture]], join: Callable[[], Picture]) -> Future[Picture]:
    """Return the result of `join`, which the thread calls that completes the last of the pictures."""
    assert parts, "nothing would complete the result"
    joined: Future[Picture] = Future()
    # A future keeps its callbacks: with `join`, which may refer to it, pictures would stay in memory.
    lock, waiting, pending = Lock(), list(parts), [join]

    def complete(part: Future[Picture]) -> None:
        with lock:
            waiting.remove(part)
            if waiting:
                return
        try:
            joined.set_result(pending.pop()())
        except BaseException as error:  # raised again by `result`
            joined.set_exception(error)

    for part in parts:
        part.add_done_callback(complete)
    return joined
