"""Percentiles that one renderer measures and others use for the same picture."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from threading import Condition

import numpy as np


class SharedTones:
    """The percentiles of each measured step of a style, on one picture.

    One renderer measures them; the renderers of parts of the picture wait for them, so that all parts get
    the same tones.
    """

    def __init__(self) -> None:
        self._numbers: dict[Hashable, np.ndarray] = {}
        self._condition = Condition()
        self._is_final = False

    @contextmanager
    def measuring(self) -> Iterator[None]:
        """Measure in this block: after it, nobody waits any longer, even if it fails."""
        try:
            yield
        finally:
            with self._condition:
                self._is_final = True
                self._condition.notify_all()

    def put(self, step: Hashable, numbers: np.ndarray) -> None:
        """Add the percentiles of a step."""
        with self._condition:
            self._numbers[step] = numbers
            self._condition.notify_all()

    def get(self, step: Hashable) -> np.ndarray | None:
        """Wait for the percentiles of a step; None if they were not measured."""
        with self._condition:
            self._condition.wait_for(lambda: self._is_final or step in self._numbers)
            return self._numbers.get(step)
