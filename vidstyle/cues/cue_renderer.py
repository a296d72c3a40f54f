"""Restyles a film whose style changes over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.backend import Backend, FrameRequest, PendingPicture
from vidstyle.core.picture import Picture
from vidstyle.core.sampling import small_luma
from vidstyle.core.scene_cuts import KnownCuts, SceneCutDetector
from vidstyle.cues.cue_list import ActiveStyle, CueList, Moment
from vidstyle.cues.transitions import mixed_picture
from vidstyle.style import Style

OpenBackend = Callable[[Style, KnownCuts | None], Backend]
"""Opens a renderer for a style and scene cuts."""


@dataclass
class _Slot:
    """A renderer, and what it is used for.

    Attributes:
        cuts: what it takes for scene cuts.
        run: number of the run of cues that it renders.
    """

    backend: Backend
    cuts: KnownCuts
    run: int


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

    There is one renderer, and a second one from the first transition on. They change their style where a cue
    begins, so compiled programs are kept. The memory of a style ends with its run of cues.

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
        first = cues.at(0).active
        self._slots = [self._new_slot(first)]
        self._shown = self._slots
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
        moment = self._cues.at(time or 0)
        wanted = [each for each in (moment.ending, moment.active) if each]
        slots = self._shown = [self._slot(each, wanted, time) for each in wanted]
        if self._cuts.is_cut(small_luma(request.picture), time) and time is not None:
            for slot in slots:
                slot.cuts.add(time)
        return moment, slots[0].backend if moment.ending else None, slots[-1].backend

    def _slot(self, active: ActiveStyle, wanted: list[ActiveStyle], time: float | None) -> _Slot:
        """Return the renderer of a run, with its style; it may be one whose run is over."""
        slot = next((slot for slot in self._slots if slot.run == active.run), None)
        if slot is None:
            needed = {each.run for each in wanted}
            slot = next((slot for slot in self._slots if slot.run not in needed), None)
            if slot is None:
                slot = self._new_slot(active)
                self._slots.append(slot)
            slot.run = active.run
            if time is not None:
                slot.cuts.add(time)
        slot.backend.change_style(active.style)
        return slot

    def _new_slot(self, active: ActiveStyle) -> _Slot:
        cuts = KnownCuts(())
        return _Slot(self._open(active.style, cuts), cuts, active.run)
