"""The part of a film's restyling that other processes do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.cpu.execute import FilmState
from vidstyle.cpu.frame_memory import processes_in_memory
from vidstyle.cpu.style_process import Follow
from vidstyle.cpu.style_processes import (
    MIN_PROCESS_THREADS,
    PROCESS_BYTES,
    StyleProcesses,
    borrow_processes,
    can_share_pictures,
    return_processes,
    useful_processes,
)
from vidstyle.picture_edit import Change, Kept, PictureEdit, make_here
from vidstyle.style.nodes import StepKey


class RemoteStyle:
    """Edits and restyles pictures of a film in processes, after `start_once`, if one is free."""

    def __init__(self) -> None:
        self._processes: StyleProcesses | None = None
        self._may_start, self._restyles = can_share_pictures(), False

    def start_once(
        self, job: bytes | None, threads: int, frame_bytes: Callable[[], int], edit: PictureEdit[Any] | None
    ) -> None:
        """Start the processes, unless they already run: the useful number, or fewer if memory is short.

        Args:
            frame_bytes: returns the memory that a picture takes.
            edit: of the present picture; later ones are similar.
        """
        self._restyles = job is not None and threads >= MIN_PROCESS_THREADS
        if not self._may_start or not (self._restyles or edit) or not useful_processes(threads):
            return
        self._may_start = False
        each = PROCESS_BYTES + frame_bytes()
        if count := processes_in_memory(each, useful_processes(threads)):
            prepared = (job or b"") if self._restyles else b""
            self._processes = borrow_processes(count, each, prepared, None if edit is None else edit.change)

    def restyle(
        self, job: bytes | None, picture: Picture, shown: FilmState, follow: Follow
    ) -> tuple[Picture | None, Follow]:
        """Restyle a picture; see `StyleProcesses.restyle`.

        Returns:
            The picture, or None and a function in place of `follow` for restyling it here: it continues with
            the percentiles that were already followed.
        """
        if self._processes is None or job is None or not self._restyles:
            return None, follow
        known: list[np.ndarray] = []
        result = self._processes.restyle(job, picture, shown, _noted(follow, known))
        return result, _continued(follow, known)

    def make(self, change: Change[Kept], picture: Picture) -> tuple[Picture, Kept]:
        """Call a change of a picture in a free process, else here."""
        result = self._processes.make(change, picture) if self._processes is not None else None
        return make_here(change, picture) if result is None else result

    def kill(self) -> None:
        """End the processes at once; pictures in progress become None."""
        if self._processes is not None:
            self._processes.kill()

    def close(self) -> None:
        """End the processes if no other renderer uses them; no thread may use them any more."""
        if self._processes is not None:
            self._processes = None
            return_processes()


def _noted(follow: Follow, known: list[np.ndarray]) -> Follow:
    def noted(step: StepKey, time_constant: float, measured: np.ndarray) -> np.ndarray:
        known.append(follow(step, time_constant, measured))
        return known[-1]

    return noted


def _continued(follow: Follow, known: list[np.ndarray]) -> Follow:
    earlier = iter(known)

    def continued(step: StepKey, time_constant: float, measured: np.ndarray) -> np.ndarray:
        found = next(earlier, None)
        return follow(step, time_constant, measured) if found is None else found

    return continued
