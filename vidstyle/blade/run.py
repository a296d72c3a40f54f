"""What a learned block asks for: a bank, how its parts are weighted, and how often it runs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vidstyle.blade.apply import apply_filters, padded_filters
from vidstyle.blade.bank import Bank
from vidstyle.blade.features import choose_filters, window_radius


@dataclass(frozen=True)
class BankRun:
    """One use of a bank: identity * luma + the parts of the bank, each with its weight.

    Attributes:
        weights: one for each part.
        identity: weight of the picture itself.
        rho: standard deviation of the window for structure in pixels; None: as the bank was learned.
        passes: how often it runs, each time over the result of the time before.
        reselect: whether filters are chosen anew in each pass; else the first choice holds for all.
        scale: runs at this part of the size, 0..1, and the result is enlarged again.
        is_wide: whether the result may go far beyond black and white.
    """

    bank: Bank
    weights: tuple[float, ...] = (1.0,)
    identity: float = 0.0
    rho: float | None = None
    passes: int = 1
    reselect: bool = True
    scale: float = 1.0
    is_wide: bool = False

    @property
    def window(self) -> float:
        """Standard deviation of the window for structure, in pixels."""
        return self.bank.rho if self.rho is None else self.rho

    @property
    def radius(self) -> int:
        """How many pixels around its own the result depends on, at the size at which it runs."""
        of_pass, of_choice = self.bank.size // 2, window_radius(self.window)
        if self.reselect:
            return self.passes * max(of_pass, of_choice)
        return (self.passes - 1) * of_pass + max(of_pass, of_choice)

    def shape_at_scale(self, shape: tuple[int, int]) -> tuple[int, int]:
        """The height and width at which it runs on a picture of this size."""
        height, width = (max(1, int(side * self.scale + 0.5)) for side in shape)
        return height, width

    @cached_property
    def filters(self) -> np.ndarray:
        """The filters of a pass: bins x size x size float32."""
        filters = self.bank.combined(self.weights)
        middle = self.bank.size // 2
        filters[:, middle, middle] += np.float32(self.identity)
        return filters

    @cached_property
    def _padded(self) -> np.ndarray:
        return padded_filters(self.filters)

    def run(self, luma: np.ndarray, margin: tuple[int, int] = (0, 0)) -> np.ndarray:
        """The result on the CPU, at the size that the picture has.

        Args:
            luma: H x W float32; beyond its border the border is repeated.
            margin: how many of the first and last rows are only there to be read.
        """
        step = self.radius // self.passes if self.reselect else self.bank.size // 2
        chosen: np.ndarray | None = None
        for left in range(self.passes - 1, -1, -1):
            # Rows that the passes still to come read around those that are wanted.
            above, below = (max(0, rows - left * step) for rows in margin)
            if chosen is None or self.reselect:
                chosen = choose_filters(luma, self.bank.bins, self.window, (above, below))
            luma = apply_filters(luma, chosen, self._padded, (above, below))
        return luma
