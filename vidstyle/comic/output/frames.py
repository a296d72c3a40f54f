"""The frames of a comic as files of their own, with a table of their times."""

from __future__ import annotations

import csv
from contextlib import ExitStack
from io import StringIO
from pathlib import Path

import cv2
import numpy as np

from vidstyle.comic.layout.storyboard import timecode
from vidstyle.comic.moment import Moment
from vidstyle.errors import OutputError
from vidstyle.media.write.atomic import whole_file

TABLE = "frames.csv"


class Frames:
    """A folder that frames are saved in, as they come; a context manager.

    Raises:
        UsageError: a file exists and may not be replaced.
        OutputError: the folder cannot be made or written to.
    """

    def __init__(self, folder: Path, count: int, overwrite: bool) -> None:
        """`count`: how many frames there will be."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(
                folder, f"cannot be made ({error.strerror})", "choose another folder"
            ) from error
        digits = max(2, len(str(count)))
        self._names = [f"frame-{number:0{digits}}.png" for number in range(1, count + 1)]
        self._rows = [("panel", "file", "seconds", "time", "scene", "importance")]
        with ExitStack() as files:
            self._writers = [
                files.enter_context(whole_file(folder / name, overwrite=overwrite))
                for name in [*self._names, TABLE]
            ]
            self._files = files.pop_all()

    def __enter__(self) -> Frames:
        return self

    def __exit__(self, *_: object) -> None:
        self._files.close()

    def save(self, color: np.ndarray, moment: Moment) -> None:
        """Save the next frame, H x W x 3 uint8; after the last one, the table."""
        number = len(self._rows)
        done, content = cv2.imencode(".png", color[..., ::-1])
        assert done
        self._writers[number - 1](content.tobytes())
        time = f"{moment.time:.3f}", timecode(moment.time)
        weight = f"{moment.importance:.3f}"
        self._rows.append((str(number), self._names[number - 1], *time, str(moment.scene + 1), weight))
        if number == len(self._names):
            table = StringIO()
            csv.writer(table, lineterminator="\n").writerows(self._rows)
            self._writers[-1](table.getvalue().encode())
