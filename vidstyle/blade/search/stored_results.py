"""Results of a reference filter, kept in a folder, so that a slow filter runs once on each picture."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vidstyle.blade.photographs import Photograph
from vidstyle.blade.reference_filter import ReferenceFilter


@contextmanager
def stored_results(reference: ReferenceFilter) -> Iterator[ReferenceFilter]:
    """Give the filter, which then runs once on each photograph, and must get it unchanged."""
    with TemporaryDirectory() as folder:
        yield replace(reference, apply=_StoredResults(reference, Path(folder)))


@dataclass(frozen=True)
class _StoredResults:
    reference: ReferenceFilter
    folder: Path
    counts: dict[Photograph, tuple[int, int]] = field(default_factory=dict)
    """The number of each photograph, and its number of results."""

    def __call__(self, color: np.ndarray, photograph: Photograph) -> list[np.ndarray]:
        """Return the target of each part."""
        if photograph in self.counts:
            number, parts = self.counts[photograph]
            return [np.load(self._path(number, part)) for part in range(parts)]
        targets, number = self.reference.apply(color, photograph), len(self.counts)
        for part, target in enumerate(targets):
            np.save(self._path(number, part), target)
        self.counts[photograph] = number, len(targets)
        return targets

    def _path(self, number: int, part: int) -> Path:
        return self.folder / f"{number}_{part}.npy"
