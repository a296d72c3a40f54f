"""What key frames are chosen from: the interface of a film or a folder, and the result of analysing it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from vidstyle.comic.analyze.features import Candidate


@dataclass(frozen=True)
class Survey:
    """The result of analysing a film.

    Attributes:
        candidates: in the order of time.
        scene_starts: when each scene begins, in seconds.
        seconds: the duration, as far as the film could be read.
        is_folder: whether these are single pictures that somebody has chosen already.
    """

    candidates: list[Candidate]
    scene_starts: list[float]
    seconds: float
    is_folder: bool = False


class Film(Protocol):
    """A source of key frames."""

    name: str

    def survey(self) -> Survey:
        """Analyse all of it once."""

    def around(self, candidate: Candidate) -> list[Candidate]:
        """The frames near a candidate in the same shot, itself included."""

    def at(self, time: float) -> Candidate:
        """The frame shown at a time in seconds."""

    def frames_at(self, times: Iterable[float], keep: bool = False) -> Iterator[np.ndarray]:
        """The frames shown at these times in full size: H x W x 3 uint8, upright, with square pixels.

        `keep`: hold each in memory, if there is room, until it is requested again.
        """

    def close(self) -> None:
        """Close the file."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...
