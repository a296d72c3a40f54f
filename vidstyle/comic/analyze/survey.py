"""What key frames are chosen from: a film, or a folder, looked through once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from vidstyle.comic.analyze.features import Candidate


@dataclass(frozen=True)
class Survey:
    """What a look through a film has found.

    Attributes:
        candidates: in the order of time.
        begins: when each scene begins, in seconds.
        seconds: how long the film is, as far as it could be read.
        pictures: whether these are single pictures, each of which somebody has chosen already.
    """

    candidates: list[Candidate]
    begins: list[float]
    seconds: float
    pictures: bool = False


class Film(Protocol):
    """What key frames are chosen from."""

    name: str

    def survey(self) -> Survey:
        """Look through all of it once."""

    def around(self, candidate: Candidate) -> list[Candidate]:
        """The pictures close to a candidate in the same shot, itself among them."""

    def at(self, time: float) -> Candidate:
        """The picture that is shown at a time in seconds."""

    def frames_at(self, times: Iterable[float], keep: bool = False) -> Iterator[np.ndarray]:
        """The pictures shown at these times, whole: H x W x 3 uint8, upright, with square pixels.

        `keep`: each will be asked for again, so that it is held in memory until then if there is room.
        """

    def close(self) -> None:
        """Close the file."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...
