"""A picture that is either whole or work not yet done: at most one filter, then any pixel steps.

Work is done in bands of rows that stay in the cache, on all cores, and each band goes through all
steps before the next one begins.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vidstyle.blade.inference import BankRun
from vidstyle.block import LumaWeights, Measured, PageRegion, SavedRef
from vidstyle.core.bands import in_bands
from vidstyle.core.picture import Picture
from vidstyle.cpu.band import Band, Whole
from vidstyle.style.resolve import ResolvedStep


@dataclass(frozen=True)
class Call:
    """A step that runs on bands, with all that it needs.

    Attributes:
        numbers: what was measured for it.
        pictures: the saved pictures that it asks for, as large as the page.
        page: height and width.
    """

    step: ResolvedStep
    numbers: np.ndarray | None
    pictures: dict[str, Whole]
    page: tuple[int, int]

    @property
    def radius(self) -> int:
        """How many rows around its own it reads."""
        assert self.step.block is not None
        return self.step.block.radius_for(self.step.values)

    def run(self, band: Band, margin: tuple[int, int] = (0, 0)) -> None:
        """Replace the band's values by the block's result; nobody wants that of the margin's rows."""
        block, on = self.step.block, self.step.on
        assert block is not None
        if on == "color" or (on == "channels" and not band.is_gray):
            band.set_color(block.function(band.color(), **self._arguments(band, margin, color=True)))
            return
        if block.kind == "learned":
            band.set_luma(block.function(**self.step.values).run(band.luma(), margin))
        else:
            band.set_luma(block.function(band.luma(), **self._arguments(band, margin, color=False)))
        if block.chroma == "dropped":
            band.take_tint(None)
        for name, whole in self.pictures.items():
            if self._wants(name) == "chroma":
                band.take_tint(whole.tint)

    def _wants(self, name: str) -> str:
        assert self.step.block is not None
        control = self.step.block.parameters[name].control
        assert isinstance(control, SavedRef)
        return control.on

    def _arguments(self, band: Band, margin: tuple[int, int], color: bool) -> dict[str, Any]:
        assert self.step.block is not None
        given: dict[object, Any] = {
            PageRegion: PageRegion(band.top, *self.page, margin),
            LumaWeights: band.encoding.weights,
            Measured: self.numbers,
        }
        arguments = {name: given[kind] for name, kind in self.step.block.injected.items()}
        for name, parameter in self.step.block.parameters.items():
            if isinstance(parameter.control, SavedRef):
                arguments[name] = self._rows(name, band, color)
        return self.step.values | arguments

    def _rows(self, name: str, band: Band, color: bool) -> np.ndarray | None:
        whole = self.pictures.get(name)
        if whole is None or self._wants(name) == "chroma":
            return None
        other = Band(whole, band.top, band.bottom)
        return other.color() if color and self._wants(name) == "same" else other.luma()


@dataclass(frozen=True)
class Work:
    """A whole picture and the calls that are still to be made on it; only the first may be a filter.

    Attributes:
        back: the method by which it goes back to the page's size, if it has another one.
    """

    whole: Whole
    calls: tuple[Call, ...] = ()
    back: str = "bicubic"

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.whole.main.shape

    @property
    def radius(self) -> int:
        """How many rows around its own a band reads."""
        return max((call.radius for call in self.calls), default=0)

    def then(self, call: Call) -> Work:
        """The work with one more call."""
        return replace(self, calls=(*self.calls, call))

    def band(self, top: int, bottom: int) -> Band:
        """These rows with all calls made."""
        radius = self.radius
        band = Band(self.whole, max(top - radius, 0), min(bottom + radius, self.shape[0]))
        for number, call in enumerate(self.calls):
            call.run(band, (top - band.top, band.bottom - bottom))
            if number == 0:
                band.crop(top, bottom)
        return band

    def finished(self, pool: Executor) -> Work:
        """The same with all calls made."""
        return replace(self, whole=self.done(pool), calls=())

    def done(self, pool: Executor) -> Whole:
        """The picture with all calls made, as float32 planes; untouched chroma stays where it is."""
        if not self.calls:
            return self.whole
        canvas = _Canvas(self.shape)
        in_bands(pool, self.shape, self.radius, lambda top, bottom: canvas.put(self.band(top, bottom)))
        return canvas.whole()


class _Canvas:
    """Gathers bands into a whole picture; which planes it needs shows with the first band."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self._shape = shape
        self._planes: dict[str, np.ndarray] = {}
        self._last: Band | None = None

    def put(self, band: Band) -> None:
        if band.is_color:
            self._plane("color", 3)[band.top : band.bottom] = band.color()
        else:
            self._plane("luma")[band.top : band.bottom] = band.luma()
            for name, plane in zip(("blue", "red"), band.own_chroma or (), strict=False):
                self._plane(name)[band.top : band.bottom] = plane
        self._last = band

    def whole(self) -> Whole:
        assert self._last is not None
        encoding, planes = self._last.encoding.as_float(), self._planes
        if "color" in planes:
            return Whole.of(Picture(encoding, color=planes["color"]))
        if "blue" in planes:
            return Whole.of(Picture(encoding, luma=planes["luma"], chroma=(planes["blue"], planes["red"])))
        return Whole(Picture(encoding, luma=planes["luma"]), self._last.tint)

    def _plane(self, name: str, *depth: int) -> np.ndarray:
        plane = self._planes.get(name)
        if plane is None:  # the plane of the thread that loses this race is dropped unused
            plane = self._planes.setdefault(name, np.empty((*self._shape, *depth), np.float32))
        return plane


def run_bank(pool: Executor, run: BankRun, luma: np.ndarray) -> np.ndarray:
    """A bank over a whole plane, H x W float32, on all cores."""
    out = np.empty(luma.shape, np.float32)

    def run_band(top: int, bottom: int) -> None:
        above, below = min(run.radius, top), min(run.radius, len(luma) - bottom)
        band = run.run(luma[top - above : bottom + below], (above, below))
        out[top:bottom] = band[above : above + bottom - top]

    in_bands(pool, luma.shape, run.radius, run_band)
    return out
