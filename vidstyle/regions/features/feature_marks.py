"""Layers over a restyled face."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.features.blurring import resized
from vidstyle.regions.rasters import cell_means


class FeatureMarks(NamedTuple):
    """Layers over a part of the page in the order in which they apply, H x W float32; None: not used.

    Attributes:
        clear: coverage by the ground between marks.
        ground: weight of samples in the mean that is this ground; None: all are equal.
        light: factor that lights a dark face.
        factor: of tones, above the darkest colour.
        ink: coverage by the ink of the style.
    """

    clear: np.ndarray
    ground: np.ndarray | None = None
    light: np.ndarray | None = None
    factor: np.ndarray | None = None
    ink: np.ndarray | None = None

    def for_chroma(self, shape: tuple[int, ...]) -> FeatureMarks:
        """Return the layers at the size of a chroma plane, without factors of tones that add colour."""
        capped = self if self.factor is None else self._replace(factor=np.minimum(self.factor, 1))
        planes = {name: plane for name, plane in capped._asdict().items() if plane is not None}
        return capped._replace(**{name: resized(plane, shape) for name, plane in planes.items()})

    def in_cells(self, window: Rectangle, cell: tuple[int, int]) -> FeatureMarks:
        """Return the layers with one value in each square of the page; `window`: their box."""
        planes = {name: plane for name, plane in self._asdict().items() if plane is not None}
        # Outside of the window nothing changes: factors are 1.
        rest = {name: np.float32(name in ("light", "factor")) for name in planes}
        return self._replace(
            **{
                name: rest[name] + cell_means(plane - rest[name], window, cell)
                for name, plane in planes.items()
            }
        )
