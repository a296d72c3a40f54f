"""Sources of key frames: what films and folders of pictures have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from vidstyle.comic.analyze.faces.face_search import add_faces
from vidstyle.comic.analyze.features import (
    Candidate,
    Survey,
    add_saliency,
)
from vidstyle.core.bands import keep_freed_memory
from vidstyle.core.closing import Closing
from vidstyle.core.machine.cores import available_cores, single_threaded_opencv
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.regions.faces import FaceFinder

MAX_KEPT_BYTES = 2**28
"""Full-size frames that are needed twice are kept in memory up to this size."""
STEP_NAME = "analyzing the film"
"""The name of the step in progress reports."""


class Film(Closing):
    """A source of key frames; a context manager.

    Attributes:
        name: of the source.
        damage: the damage that `survey` found in the frames that it decoded.
        rotate: degrees clockwise instead of the rotation in the metadata; None: that rotation.
    """

    name: str

    def __init__(self, faces: FaceFinder, rotate: int | None = None) -> None:
        keep_freed_memory()
        self.rotate = rotate
        self.damage = DecodeReport()
        self._kept: dict[float, np.ndarray] = {}
        self._found: Survey | None = None
        self._faces = faces
        self._pool = ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-comic")

    def survey(self, on_step: ProgressCallback = ignore_progress) -> Survey:
        """Analyse the whole film, once, and report progress in seconds.

        Raises:
            InputError: it cannot be read, or no frame of it can be decoded.
        """
        if self._found is None:
            with single_threaded_opencv():  # frames are measured side by side
                self._found = self._survey(on_step)
        return self._found

    @abstractmethod
    def _survey(self, on_step: ProgressCallback) -> Survey:
        """Analyse the whole film."""

    @abstractmethod
    def around(self, candidate: Candidate) -> list[Candidate]:
        """Return the frames near a candidate in the same shot, the candidate included, without subjects."""

    def with_large_faces(self, candidates: Iterable[Candidate]) -> list[Candidate]:
        """Return the frames with their large faces."""
        return list(self._pool.map(lambda each: add_faces(each, self._faces, only_large=True), candidates))

    def with_subjects(
        self, candidates: Sequence[Candidate], neighbours: Sequence[Sequence[Candidate]]
    ) -> list[Candidate]:
        """Return the frames with all their faces, salient boxes and blobs.

        Args:
            candidates: the frames.
            neighbours: for each, frames of the same shot with large faces, which confirm its large faces.
        """

        def look(each: Candidate, others: Sequence[Candidate]) -> Candidate:
            return add_saliency(add_faces(each, self._faces, others=others))

        return list(self._pool.map(look, candidates, neighbours))

    @abstractmethod
    def at(self, time: float) -> Candidate:
        """Return the frame shown at a time in seconds."""

    @abstractmethod
    def _decode_image(self, time: float) -> np.ndarray:
        """Decode the frame shown at a time in full size."""

    def frames_at(self, times: Iterable[float], keep: bool = False) -> Iterator[np.ndarray]:
        """Yield the frames shown at these times in full size: H x W x 3 uint8, upright, with square pixels.

        `keep`: keep each frame in memory, up to `MAX_KEPT_BYTES`, until it is requested again.
        """
        for time in times:
            frame = self._kept.pop(time, None)
            if frame is None:
                frame = self._decode_image(time)
            if keep and sum(each.nbytes for each in self._kept.values()) + frame.nbytes <= MAX_KEPT_BYTES:
                self._kept[time] = frame
            yield frame

    def close(self) -> None:
        """Close the file."""
        self._kept.clear()
        self._pool.shutdown(cancel_futures=True)
