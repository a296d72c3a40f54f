"""The program of the processes that edit and restyle pictures for a renderer in another process.

It prepares a first job, and forks a process for each pair of descriptors but the last, which it serves
itself: they begin at once and share the memory of loaded modules and kernels. No thread may run before that.

A request is "style", a packed `StyleJob`, a stored picture, the offset after it, and the `FilmState`. The
answer is ("measured", step, time constant, percentiles) for each measurement, to which the renderer replies
with the smoothed percentiles, and then ("picture", stored picture). Or a request is "change", a `Change`, a
stored picture and the offset after it, with the answer ("changed", stored picture, what the change keeps):
unchanged planes keep their places from the request. An error is answered by ("error", text).
"""

from __future__ import annotations

import gc
import os
import pickle
import sys
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from vidstyle.core.bands import BandWorkers, CallingThread, keep_freed_memory
from vidstyle.core.kernels.library import use_stored_kernels_only
from vidstyle.core.picture import Picture
from vidstyle.cpu.execute import FilmState, FrameExecutor
from vidstyle.cpu.shared_pictures import SharedPictures, planes_of
from vidstyle.cpu.style_job import blank_picture, plan
from vidstyle.picture_edit import Change
from vidstyle.style.nodes import Node, PercentileRequest

WORKERS = BandWorkers(CallingThread(), 1, seldom_waits=True)


def _prepare(job: bytes) -> None:
    """Load what a job needs, by restyling a blank picture."""
    with suppress(Exception), np.errstate(all="ignore"):  # the first picture raises it again
        lowered, tasks = plan(job)
        executor = FrameExecutor(WORKERS, tasks, blank_picture(job), lambda _, measured: measured)
        executor.picture(lowered)


def _answer(connection: Connection, pictures: SharedPictures) -> None:
    kind, *request = connection.recv()
    try:
        answer = (
            _restyled(connection, pictures, *request) if kind == "style" else _changed(pictures, *request)
        )
    except (EOFError, OSError):
        raise
    except Exception as error:  # the renderer does it itself, and raises its own error
        connection.send(("error", str(error) or repr(error)))
    else:
        connection.send(answer)


def _restyled(
    connection: Connection, pictures: SharedPictures, job: bytes, stored: Picture, end: int, shown: FilmState
) -> tuple[Any, ...]:
    def follow(measure: PercentileRequest[Node], measured: np.ndarray) -> Any:
        connection.send(("measured", measure.step, measure.time_constant, measured))
        return connection.recv()

    lowered, tasks = plan(job)
    executor = FrameExecutor(WORKERS, tasks, pictures.load(stored), follow, shown)
    result, _ = pictures.store(executor.picture(lowered), end)
    return "picture", result


def _changed(pictures: SharedPictures, change: Change[Any], stored: Picture, end: int) -> tuple[Any, ...]:
    source = pictures.load(stored)
    result, kept = change(source)
    places = dict(zip(map(id, planes_of(source)), planes_of(stored), strict=True))
    return "changed", pictures.store(result, end, places)[0], kept


def _serve(connection: Connection, pictures: SharedPictures) -> None:
    """Answer requests until the other process closes the connection, or ends."""
    with suppress(EOFError, OSError):
        connection.send(os.getpid())
        while True:
            _answer(connection, pictures)


def main(job: int, descriptors: Sequence[int]) -> None:
    """Serve each connection with its memory in a process, the last one in this, until all are closed."""
    import cv2

    keep_freed_memory()
    cv2.setNumThreads(1)
    use_stored_kernels_only()
    with open(job, "rb") as file:
        file.seek(0)
        _prepare(pickle.load(file)[0])  # loads the change of pictures, too
    gc.freeze()  # collections in a process would copy the memory that they share
    *others, last = zip(descriptors[::2], descriptors[1::2], strict=True)
    for own in others:
        if os.fork() == 0:
            _serve_only(own, descriptors)
            os._exit(0)
    _serve_only(last, descriptors)
    with suppress(ChildProcessError):
        while True:
            os.wait()


def _serve_only(own: Sequence[int], descriptors: Sequence[int]) -> None:
    """Serve one connection, and close the connections of the other processes."""
    _close(each for each in descriptors if each not in own)
    _serve(Connection(own[0]), SharedPictures(own[1]))


def _close(descriptors: Any) -> None:
    for each in descriptors:
        os.close(each)


if __name__ == "__main__":
    main(int(sys.argv[1]), [*map(int, sys.argv[2:])])
