"""The other side of a process that restyles pictures; its own program is `style_worker`."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.cpu.execute import FilmState
from vidstyle.cpu.shared_pictures import SharedPictures, planes_of
from vidstyle.picture_edit import Change, Kept
from vidstyle.style.nodes import StepKey

Follow = Callable[[StepKey, float, np.ndarray], np.ndarray]
"""Takes a measured step, its time constant and its percentiles; returns the smoothed ones."""


class WorkerError(Exception):
    """A process could not edit or restyle a picture."""


class StyleProcess:
    """A process that edits or restyles one picture at a time, with one thread.

    It ends when its connection is closed, so also when this process ends.

    Attributes:
        descriptors: of the connection and of the memory, for the process.
        number: its process number, once it is ready.
    """

    def __init__(self) -> None:
        self._pictures = SharedPictures(os.memfd_create("vidstyle"))
        ours, self._theirs = socket.socketpair()
        self._connection = Connection(ours.detach())
        self.descriptors = self._theirs.fileno(), self._pictures.descriptor
        self.number = 0

    def begun(self) -> None:
        """Close what only the process uses now."""
        self._theirs.close()

    @property
    def has_news(self) -> bool:
        """Whether it has sent a message, or has ended."""
        return self._connection.poll()

    def wait_until_ready(self) -> None:
        """Wait for its first message, its number.

        Raises:
            EOFError, OSError: it has ended.
        """
        self.number = int(self._connection.recv())

    def restyle(self, job: bytes, picture: Picture, shown: FilmState, follow: Follow) -> Picture:
        """Restyle a picture.

        Args:
            job: a pickled `StyleJob`.
            shown: what blocks get of the film.

        Raises:
            WorkerError: it cannot restyle the picture.
            EOFError, OSError: it has ended.
        """
        self._connection.send(("style", job, *self._pictures.store(picture), shown))
        while True:
            kind, *content = self._answer()
            if kind == "picture":
                return self._pictures.load(content[0]).map_planes(lambda plane, _: plane.copy())
            self._connection.send(follow(*content))

    def make(self, change: Change[Kept], picture: Picture) -> tuple[Picture, Kept]:
        """Change a picture; for the errors see `restyle`."""
        stored, end = self._pictures.store(picture)
        self._connection.send(("change", change, stored, end))
        _, made, kept = self._answer()
        own = dict(zip(planes_of(stored), planes_of(picture), strict=True))

        def loaded(place: Any, _: str) -> np.ndarray:
            return own[place] if place in own else self._pictures.view(place).copy()

        return made.map_planes(loaded), kept

    def _answer(self) -> tuple[Any, ...]:
        answer: tuple[Any, ...] = self._connection.recv()
        if answer[0] == "error":
            raise WorkerError(answer[1])
        return answer

    def close(self) -> None:
        """Have it end, and release its memory; no thread may wait for it."""
        self._theirs.close()
        self._connection.close()
        os.close(self._pictures.descriptor)
