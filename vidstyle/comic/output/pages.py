"""The pages of a comic, drawn one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.comic.analyze.survey import Film
from vidstyle.comic.layout.layout import PageLayout
from vidstyle.comic.layout.storyboard import timecode
from vidstyle.comic.lettering.fonts import Letters
from vidstyle.comic.lettering.letter import LetteredPanel
from vidstyle.comic.moment import Moment
from vidstyle.comic.output.frames import Frames
from vidstyle.comic.output.panel import PanelRenderer
from vidstyle.comic.output.sheet import Label, RenderedPanel, Sheet


@dataclass(frozen=True)
class PagePlan:
    """All that is known of a comic before it is drawn.

    Attributes:
        panels: in the order of reading, page by page.
        labels: of each page.
    """

    moments: Sequence[Moment]
    layout: PageLayout
    panels: Sequence[LetteredPanel]
    labels: Sequence[list[Label]]
    letters: Letters
    dpi: float


def drawn(
    plan: PagePlan,
    film: Film,
    brush: PanelRenderer,
    frames: Frames | None,
    on_panel: Callable[[int, int], None],
) -> Iterator[Sheet]:
    """Every page, drawn when it is asked for; only one is in memory, and one frame.

    Args:
        frames: where to save the frames too.
        on_panel: told before each panel its number, from 0, and how many there are.
    """
    colors = film.frames_at(plan.moments[each.panel.moment].time for each in plan.panels)
    for page, (width, height) in enumerate(plan.layout.sizes):
        sheet = Sheet(width, height, plan.dpi, plan.letters, labels=plan.labels[page])
        for number, each in enumerate(plan.panels):
            if each.panel.page == page:
                on_panel(number, len(plan.panels))
                color, moment = next(colors), plan.moments[each.panel.moment]
                if frames:
                    frames.save(color, moment)
                sheet.panels.append(
                    _shown(each, brush.panel(moment.picture(color), each.crop, each.picture), moment)
                )
        yield sheet


def _shown(lettered: LetteredPanel, color: np.ndarray, moment: Moment) -> RenderedPanel:
    said = [" ".join(bubble.block.lines) for bubble in lettered.bubbles]
    note = ": ".join([timecode(moment.time), *([" / ".join(said)] if said else [])])
    return RenderedPanel(lettered.panel.rectangle, lettered.picture, color, lettered.bubbles, note)
