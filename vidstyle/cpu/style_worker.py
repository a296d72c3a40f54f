"""The program of a process that restyles pictures for a renderer in another process.

A request is a packed `StyleJob`, a stored picture, the offset after it, and the `FrameTime`. The answer is
("measured", step, time constant, percentiles) for each measurement, to which the renderer replies with the
smoothed percentiles, and then ("picture", stored picture) or ("error", text).
"""

from __future__ import annotations

import sys
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from vidstyle.core.bands import BandWorkers, CallingThread, keep_freed_memory
from vidstyle.core.kernels.library import use_stored_kernels_only
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.cpu.shared_pictures import SharedPictures
from vidstyle.cpu.style_job import plan
from vidstyle.style.nodes import Node, PercentileRequest

WORKERS = BandWorkers(CallingThread(), 1, seldom_waits=True)


def _answer(connection: Connection, pictures: SharedPictures) -> None:
    job, stored, end, moment = connection.recv()

    def follow(measure: PercentileRequest[Node], measured: np.ndarray) -> Any:
        connection.send(("measured", measure.step, measure.time_constant, measured))
        return connection.recv()

    try:
        lowered, tasks = plan(job)
        executor = FrameExecutor(WORKERS, tasks, pictures.load(stored), follow, moment)
        result, _ = pictures.store(executor.picture(lowered), end)
    except (EOFError, OSError):
        raise
    except Exception as error:  # the renderer restyles the picture itself, and raises its own error
        connection.send(("error", repr(error)))
    else:
        connection.send(("picture", result))


def main() -> None:
    """Answer requests until the other process closes the connection, or ends."""
    import cv2

    connection, pictures = Connection(int(sys.argv[1])), SharedPictures(int(sys.argv[2]))
    keep_freed_memory()
    cv2.setNumThreads(1)
    use_stored_kernels_only()
    with suppress(EOFError, OSError):
        connection.send(("ready",))
        while True:
            _answer(connection, pictures)


if __name__ == "__main__":
    main()
