"""What a live source is to those who take from it."""

from __future__ import annotations

import threading
from typing import Protocol, TypeVar

OWN_CLOCK_SECONDS = 2.0
"""A driver's stamp so little before now is of a clock that we know, and says when something was taken."""


class OpenedSource(Protocol):
    """What a source opens: pictures or sound."""

    def close(self) -> None:
        """Let go of it; from the thread that takes from it."""


T = TypeVar("T", bound=OpenedSource)
T_co = TypeVar("T_co", bound=OpenedSource, covariant=True)


class CaptureSource(Protocol[T_co]):
    """Something that can be opened, and opened again after it was lost."""

    @property
    def name(self) -> str:
        """What it is, for people."""

    @property
    def reconnects(self) -> bool:
        """Whether it may come back after its end."""

    def open(self, stopping: threading.Event) -> T_co:
        """Begin to take.

        Args:
            stopping: once it is set, the wait for a beginning is over, and so is what was opened.

        Raises:
            DeviceError: a device that is missing or busy.
            InputError: anything else that cannot be read.
        """
