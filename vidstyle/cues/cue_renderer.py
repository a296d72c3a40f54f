"""Restyles a film whose style changes over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product

import numpy as np

from vidstyle.backend import Backend, FrameRequest, PendingPicture
from vidstyle.core.picture import Picture
from vidstyle.core.scene_cuts import KnownCuts, SceneCutDetector
from vidstyle.cues.cue_list import ActiveStyle, CueList, Moment
from vidstyle.cues.transitions import mixed_picture
from vidstyle.style import Style
from vidstyle.style.resolve import structure_key

OpenBackend = Callable[[Style, KnownCuts | None], Backend]
"""Opens a renderer for a style and scene cuts."""


@dataclass
class _Slot:
    """A renderer, and what it is used for.

    Attributes:
        cuts: what it takes for scene cuts.
        run: number of the run of cues that it renders, or None.
    """

    backend: Backend
    cuts: KnownCuts
    run: int | None = None


@dataclass(frozen=True)
class TransitionPicture:
    """A picture that is being restyled in two styles; see `PendingPicture`."""

    ending: PendingPicture
    active: PendingPicture
    moment: Moment

    def result(self) -> Picture:
        """Wait for both pictures, and return the mixed one."""
        return mixed_picture(self.ending.result(), self.active.result(), self.moment)


class CueRenderer(Backend):
    """Restyles pictures by a cue list and their times.

    There is one renderer, and a second one if there are transitions. They change their style where a cue
    begins, so compiled programs are kept. The memory of a style ends with its run of cues. All styles restyle
    the first picture of a film, so that compiling and loading delay no later picture.

    Args:
        cues: the cue list.
        open_backend: opens a renderer.
        cuts: scene cuts of the film; None: they are detected.

    Attributes:
        device_kind: see `Backend`.
    """

    def __init__(self, cues: CueList, open_backend: OpenBackend, cuts: KnownCuts | None = None) -> None:
        self._cues, self._open = cues, open_backend
        self._cuts = cuts or SceneCutDetector()
        first = cues.at(0).active.style
        self._slots = [self._new_slot(first)]
        self._shown = self._slots
        self._is_prepared = False
        self.device_kind = self._slots[0].backend.device_kind

    @property
    def frames_in_flight(self) -> int:
        """See `Backend`."""
        return max(slot.backend.frames_in_flight for slot in self._slots)

    def cancel(self) -> None:
        """Give up the pictures in flight; see `Backend.cancel`."""
        for slot in self._slots:
            slot.backend.cancel()

    def memory(self) -> Sequence[np.ndarray]:
        """Return the memory of the styles in the last picture; see `Backend.memory`."""
        return [array for slot in self._shown for array in slot.backend.memory()]

    def close(self) -> None:
        """Close the renderers."""
        for slot in self._slots:
            slot.backend.close()

    def change_style(self, style: Style) -> None:
        """Use one style for the rest of the film."""
        self._cues = CueList.of(style)

    def start_at(self, time: float) -> None:
        """Let the cue list begin at this time of the film, in seconds."""
        self._cues = self._cues.moved(Fraction(time))

    def restyle(self, request: FrameRequest) -> Picture:
        """Restyle a picture; see `Backend.restyle`. Without a time it has the first style."""
        moment, ending, active = self._prepare(request)
        result = active.restyle(request)
        return mixed_picture(ending.restyle(request), result, moment) if ending else result

    def begin(self, request: FrameRequest) -> PendingPicture:
        """Start to restyle a picture."""
        moment, ending, active = self._prepare(request)
        before = ending.begin(request) if ending else None
        result = active.begin(request)
        return TransitionPicture(before, result, moment) if before else result

    def skip(self, request: FrameRequest) -> None:
        """Follow the cues, and what their renderers follow, through a picture that is not restyled."""
        _, ending, active = self._prepare(request)
        for each in (ending, active):
            if each is not None:
                each.skip(request)

    def _prepare(self, request: FrameRequest) -> tuple[Moment, Backend | None, Backend]:
        """Return the styles at a time, and their renderers: of the style that ends, and of the other one."""
        time = request.time
        if time is not None and not self._is_prepared:
            self._prepare_styles(request, time)
        moment = self._cues.at(time or 0)
        wanted = [each for each in (moment.ending, moment.active) if each]
        slots = self._shown = [self._slot(each, wanted, time) for each in wanted]
        if self._cuts.begins_scene(request.picture, time) and time is not None:
            for slot in slots:
                slot.cuts.add(time)
        return moment, slots[0].backend if moment.ending else None, slots[-1].backend

    def _prepare_styles(self, request: FrameRequest, time: float) -> None:
        """Restyle a picture and a similar one in all styles, if there are several."""
        self._is_prepared = True
        styles = unique_styles([self._cues.at(time).active.style, *self._cues.styles])
        if self.device_kind == "gpu" and any(cue.seconds for cue in self._cues.cues):
            self._slots.append(self._new_slot(styles[0]))  # it compiles its own programs
        for slot, style in product(self._slots, styles if len(styles) > 1 else []):
            slot.backend.change_style(style)
            for later in (time, time + 0.01):
                slot.backend.restyle(replace(request, time=later))

    def _slot(self, active: ActiveStyle, wanted: list[ActiveStyle], time: float | None) -> _Slot:
        """Return the renderer of a run, with its style; it may be one whose run is over."""
        slot = next((slot for slot in self._slots if slot.run == active.run), None)
        if slot is None:
            needed = {each.run for each in wanted}
            slot = next((slot for slot in self._slots if slot.run not in needed), None)
            if slot is None:
                slot = self._new_slot(active.style)
                self._slots.append(slot)
            slot.run = active.run
            if time is not None:
                slot.cuts.add(time)
        slot.backend.change_style(active.style)
        return slot

    def _new_slot(self, style: Style) -> _Slot:
        """Open a renderer, which belongs to no run yet."""
        cuts = KnownCuts(())
        return _Slot(self._open(style, cuts), cuts)


def unique_styles(styles: Sequence[Style]) -> list[Style]:
    """Return the first of all styles that differ in numbers and colours only."""
    found: list[tuple[object, Style]] = []
    for style in {id(style): style for style in styles}.values():
        key = structure_key(style)
        if all(key != other for other, _ in found):
            found.append((key, style))
    return [style for _, style in found]
