"""Inference of a bank on the CPU: select and apply one filter at each pixel.

Paper, section 5.1, equation 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.before.luma_steps import LumaStep, luma_steps
from vidstyle.blade.choice import choice_radius, choose_filters
from vidstyle.blade.clipped_simd import pack_clipped
from vidstyle.blade.filtering import apply_filters
from vidstyle.blade.simd import pack_filters
from vidstyle.core.color.deferred_color import Mixed
from vidstyle.core.picture import RANGES, WIDE_RANGE
from vidstyle.core.resample import resample, scaled_shape

RESAMPLING_METHOD = "smooth"
"""Method for reducing a picture for a bank and enlarging its result; banks are trained with it."""
REDUCED_BORDER_PX = 3
"""Pixels on every side of a reduced picture that lie beyond the picture. The reduction reads two pixels of
its result on each side: the outermost of these shows only the picture's border, as all beyond it would."""


@dataclass(frozen=True)
class BankPass:
    """One pass of one stage of a bank.

    Attributes:
        run: the stage as a run with a single pass.
        stage: the number of the stage.
        selects: whether filters are selected; otherwise the last selection of the stage is used.
        after: number of pixels on each side that later passes depend on.
        is_read: whether filters of a later pass are selected from its luma.
    """

    run: BankRun
    stage: int
    selects: bool
    after: int
    is_read: bool

    @property
    def radius(self) -> int:
        """Number of pixels on each side that the pass depends on."""
        bank = self.run.bank
        of_selection = choice_radius(bank.bins, self.run.window) if self.selects else 0
        return max(bank.size // 2, of_selection)

    @property
    def work(self) -> int:
        """Approximate number of multiplications per pixel."""
        bank = self.run.bank
        selection = (12 * choice_radius(bank.bins, self.run.window) + 50) * (1 + len(bank.bins.features))
        planes = (1 if bank.chroma is None else 3) + 2 * len(bank.clips)
        return planes * bank.size**2 + (selection if self.selects else 0)


@dataclass(frozen=True)
class BankRun:
    """One use of a bank: identity * luma + the weighted sum of the bank's parts.

    Attributes:
        weights: one per part.
        identity: weight of the picture itself.
        rho: standard deviation of the structure tensor's window in pixels; None for the bank's.
        passes: number of passes, each of all stages of the bank, on the result of the previous one.
        reselect: whether filters are selected in each pass; otherwise the first selection is used in all
            passes.
        scale: working size relative to the picture, 0..1; the result is enlarged again.
        is_wide: whether the result may far exceed black and white.
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
    def limits(self) -> tuple[float, float]:
        """The range that the result of each pass is clipped to."""
        return WIDE_RANGE if self.is_wide else RANGES["luma"]

    @property
    def window(self) -> float:
        """Standard deviation of the structure tensor's window, in pixels."""
        return self.bank.rho if self.rho is None else self.rho

    @cached_property
    def matrix(self) -> np.ndarray | None:
        """The colour matrix before the filters, 3 x 4, weighted like the bank; None if it has none."""
        if self.bank.matrix is None:
            return None
        share = np.float32(1 - self.identity)
        return share * self.bank.matrix + (1 - share) * np.eye(3, 4, dtype=np.float32)

    @cached_property
    def luma_steps(self) -> tuple[LumaStep, ...]:
        """Blocks that change luma before the filters, and their values, weighted like the bank."""
        return luma_steps(self.bank.curve, self.bank.mode, 1 - self.identity)

    @cached_property
    def sequence(self) -> tuple[BankPass, ...]:
        """All passes of all stages of the bank, in order."""
        stages = [replace(self, bank=each, passes=1) for each in self.bank.stages]
        passes: list[BankPass] = []
        for number in reversed(range(self.passes * len(stages))):
            selects = self.reselect or number < len(stages)
            next_one = passes[0] if passes else None
            after = next_one.after + next_one.radius if next_one else 0
            is_read = bool(next_one and (next_one.selects or next_one.is_read))
            stage = number % len(stages)
            passes.insert(0, BankPass(stages[stage], stage, selects, after, is_read))
        return tuple(passes)

    @property
    def radius(self) -> int:
        """Number of pixels on each side that a pixel of the result depends on, at the working size."""
        return self.sequence[0].after + self.sequence[0].radius

    @property
    def work(self) -> int:
        """Approximate number of multiplications per pixel at the working size."""
        return sum(each.work for each in self.sequence)

    @property
    def border(self) -> int:
        """Pixels on every side of the working picture that lie beyond the picture."""
        return 0 if self.scale == 1 else REDUCED_BORDER_PX

    def shape_at_scale(self, shape: tuple[int, int]) -> tuple[int, int]:
        """Return the working height and width for a picture of this size, with the border."""
        height, width = scaled_shape(shape, self.scale)
        return height + 2 * self.border, width + 2 * self.border

    @cached_property
    def filters(self) -> np.ndarray:
        """The filters of a pass: bins x size x size float32."""
        return self._filters_of(self.bank)

    def _filters_of(self, bank: Bank) -> np.ndarray:
        filters = bank.combined(self.weights)
        middle = bank.size // 2
        filters[:, middle, middle] += np.float32(self.identity)
        return filters

    @cached_property
    def _packed(self) -> np.ndarray:
        return pack_filters(self.filters)

    @cached_property
    def _packed_for_chroma(self) -> np.ndarray:
        return pack_filters(self._filters_of(self.bank.of_chroma))

    @cached_property
    def _packed_clipped(self) -> np.ndarray | None:
        weights = self.bank.combined_clipped(self.weights)
        return None if weights is None else pack_clipped(weights)

    @cached_property
    def _constants(self) -> list[np.ndarray | None]:
        """The constants of each bin for luma and both chroma planes; None if the bank has none."""
        constants = self.bank.combined_constants(self.weights)
        return [None] * 3 if constants is None else list(np.ascontiguousarray(constants.T))

    def run(
        self,
        luma: np.ndarray,
        margin: tuple[int, int] = (0, 0),
        top: int = 0,
        out: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return the result at the size of the picture, undefined in the margin; or `out`.

        Args:
            luma: H x W float32; beyond its border the border is repeated.
            margin: numbers of first and last rows that are only read.
            top: the number of luma's first row in the whole picture.
            out: rows without the margin, for the result; used if they fill whole cache lines.
        """
        return self._passes(luma, (), margin, top, out)[0]

    def run_chroma(
        self,
        luma: np.ndarray,
        chroma: tuple[np.ndarray, ...],
        margin: tuple[int, int] = (0, 0),
        top: int = 0,
    ) -> tuple[np.ndarray, ...]:
        """Return the chroma planes, with filters selected by luma; arguments as in `run`."""
        return tuple(self._passes(luma, chroma, margin, top)[1:])

    def _passes(
        self,
        luma: np.ndarray,
        chroma: tuple[np.ndarray, ...],
        margin: tuple[int, int],
        top: int,
        out: np.ndarray | None = None,
    ) -> list[np.ndarray]:
        """Return luma and the chroma planes; luma is undefined if chroma is requested."""
        chosen: dict[int, np.ndarray] = {}
        for each in self.sequence:
            # Later passes read rows around the needed ones.
            rows = max(0, margin[0] - each.after), max(0, margin[1] - each.after)
            run = each.run
            if each.selects:
                chosen[each.stage] = choose_filters(luma, run.bank.bins, run.window, rows, top)
            place = rows, run.bank.bins.pitch, top
            filtered = run._chroma_pass(chroma, chosen[each.stage], place)
            if not chroma or each.is_read:
                luma = run._luma_pass(luma, chosen[each.stage], place, None if each.after else out)
            chroma = filtered
        return [luma, *chroma]

    def _chroma_pass(
        self, chroma: tuple[np.ndarray, ...], selected: np.ndarray, place: tuple[tuple[int, int], int, int]
    ) -> tuple[np.ndarray, ...]:
        """Return the chroma planes after one pass; unchanged if the bank has no filters for chroma."""
        if self.bank.chroma is None:
            return chroma
        return tuple(
            apply_filters(
                each,
                selected,
                self._packed_for_chroma,
                self.bank.size,
                RANGES["chroma"],
                *place,
                constants=constants,
            )
            for each, constants in zip(chroma, self._constants[1:], strict=False)
        )

    def _luma_pass(
        self,
        luma: np.ndarray,
        selected: np.ndarray,
        place: tuple[tuple[int, int], int, int],
        out: np.ndarray | None,
    ) -> np.ndarray:
        """Return luma after one pass."""
        clipped = self._packed_clipped
        return apply_filters(
            luma,
            selected,
            self._packed,
            self.bank.size,
            self.limits,
            *place,
            out,
            self._constants[0],
            None if clipped is None else (clipped, self.bank.clips),
        )

    def mixed(self, color: np.ndarray) -> np.ndarray:
        """Return RGB, H x W x 3 float32, after the colour matrix, if the bank has one."""
        return color if self.matrix is None else Mixed(color, self.matrix).whole()

    def whole(self, luma: np.ndarray) -> np.ndarray:
        """Return the result for a picture, including the reduction and enlargement, as in a style."""
        return self._enlarged(self.run(self._reduced(luma)), (luma.shape[0], luma.shape[1]))

    def whole_chroma(self, luma: np.ndarray, chroma: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return the chroma planes of the size of luma, including the reduction and enlargement."""
        shape = luma.shape[0], luma.shape[1]
        filtered = self.run_chroma(self._reduced(luma), tuple(map(self._reduced, chroma)))
        return [self._enlarged(each, shape) for each in filtered]

    def _reduced(self, plane: np.ndarray) -> np.ndarray:
        shape = self.shape_at_scale((plane.shape[0], plane.shape[1]))
        return resample(plane, shape, RESAMPLING_METHOD, self.border)

    def _enlarged(self, plane: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
        return resample(plane, shape, RESAMPLING_METHOD, -self.border)
