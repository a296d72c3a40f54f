"""The plan of a comic: key frames, pages and words, before anything is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import chain

from vidstyle.comic.analyze.key_frame_source import Film
from vidstyle.comic.analyze.saliency import attention_map, box_attention
from vidstyle.comic.comic_options import ComicOptions
from vidstyle.comic.drawn_check import DrawnCheck
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.fit import fit_paper, place_panels
from vidstyle.comic.layout.inset import find_insets
from vidstyle.comic.layout.layout import PageLayout, lay_out
from vidstyle.comic.layout.pages import default_pages
from vidstyle.comic.layout.paper import Paper
from vidstyle.comic.layout.storyboard import contact_sheet, time_labels
from vidstyle.comic.lettering.dialogue import assign_lines, count_panels
from vidstyle.comic.lettering.fonts import Letters, choose_letters, letter_size
from vidstyle.comic.lettering.letter import PanelText, TextStyle, letter_panels
from vidstyle.comic.lettering.subtitle_lines import Line
from vidstyle.comic.lettering.title import make_title, move_below_title, page_numbers, shrink_paper
from vidstyle.comic.output.panel_renderer import PagePlan
from vidstyle.comic.output.sheet import Label
from vidstyle.comic.select.key_frames import KeyFrameOptions, find_key_frames
from vidstyle.comic.select.panel_count import MAX_DEFAULT_PANELS
from vidstyle.pipeline.progress import ProgressCallback

_MAX_WORD_ROUNDS = 2
"""Number of times that panels are added for words without room."""


class PagePlanner:
    """Plans a comic.

    Attributes:
        omitted: the subtitles that no panel of the last plan shows.
    """

    def __init__(
        self, film: Film, options: ComicOptions, on_step: ProgressCallback, paper: Paper, trims: bool
    ) -> None:
        """Prepare a plan.

        Args:
            film: the source.
            options: of the comic.
            on_step: called with the name of a step and its progress.
            paper: of the pages.
            trims: whether a page has only the size of its panels.
        """
        self.omitted: list[Line] = []
        self._film, self._options, self._step, self._paper = film, options, on_step, paper
        self._trims, self._size = trims, letter_size(paper)
        self._right_to_left = options.right_to_left or options.layout == "manga"
        self._letters = Letters(options.font)
        self._title: Label | None = None
        self._title_height = 0

    def plan(self, lines: Sequence[Line], check: DrawnCheck | None) -> PagePlan:
        """Return the plan of a comic with these subtitles; `check`: of key frames, as they will be drawn."""
        self._choose_font(lines)
        return self._plan_with_words(lines, check)

    def _choose_font(self, lines: Sequence[Line]) -> None:
        title = self._options.title
        if not self._options.storyboard:
            self._letters = choose_letters([title, *(line.text for line in lines)], self._letters)
        if title:
            self._title, self._title_height = make_title(title, self._paper, self._size, self._letters)

    def _plan_with_words(self, lines: Sequence[Line], check: DrawnCheck | None) -> PagePlan:
        """Plan the comic; words that have no room get more panels, as far as that helps."""
        spoken = tuple((line.start, line.end) for line in lines if not line.narrated)
        options = replace(
            self._options.key_frames,
            min_panels=count_panels(lines),
            spoken=spoken,
            seed=self._options.seed,
        )
        plan = self._plan(self._find_key_frames(options, check), lines)
        best = plan, self.omitted
        for _ in range(_MAX_WORD_ROUNDS if options.panels is None else 0):
            if not self.omitted or len(plan.key_frames) >= MAX_DEFAULT_PANELS:
                break
            options = replace(options, words=(*options.words, *(line.start for line in self.omitted)))
            plan = self._plan(self._find_key_frames(options, check), lines)
            if len(self.omitted) < len(best[1]):
                best = plan, self.omitted
        plan, self.omitted = best
        return plan

    def _find_key_frames(self, options: KeyFrameOptions, check: DrawnCheck | None) -> list[KeyFrame]:
        if check is None:
            return find_key_frames(self._film, options, self._step)
        return check.trim(find_key_frames(self._film, options, self._step, check.readability))

    def _plan(self, key_frames: Sequence[KeyFrame], lines: Sequence[Line]) -> PagePlan:
        self._step("laying out", 0, 0)
        if self._options.storyboard:
            layout = contact_sheet(key_frames, self._paper, self._size, self._title_height)
            labels = time_labels(layout, key_frames, self._size)
        else:
            layout = self._comic_pages(key_frames, lines)
            labels = page_numbers(layout, self._paper, self._size)
        if self._title:
            labels[0].append(self._title)
        return PagePlan(key_frames, layout, labels, self._letters, self._paper.dpi, self._right_to_left)

    def _comic_pages(self, key_frames: Sequence[KeyFrame], lines: Sequence[Line]) -> PageLayout:
        spoken, lost = assign_lines(lines, key_frames)
        border, safe = self._paper.border, self._paper.safe
        style = TextStyle(self._letters, self._size, border, self._right_to_left, safe)
        shown = list(zip(key_frames, spoken, strict=True))
        colors = self._film.frames_at([key_frame.time for key_frame, said in shown if said], keep=True)
        attention = (
            attention_map(key_frame.picture(next(colors)), key_frame.faces)
            if said
            else box_attention(key_frame)
            for key_frame, said in shown
        )
        texts = list(map(PanelText, key_frames, spoken, attention))
        insets = find_insets(key_frames, list(map(bool, spoken)))
        layout = letter_panels(partial(self._layout, key_frames, insets), texts, style)
        unfit = (spoken[each.key_frame][len(each.bubbles) :] for each in layout.panels)
        self.omitted = sorted([*lost, *chain.from_iterable(unfit)], key=lambda line: line.start)
        return layout

    def _layout(
        self, key_frames: Sequence[KeyFrame], insets: Sequence[int], area_scales: Sequence[float]
    ) -> PageLayout:
        options = self._options
        pages = options.pages or default_pages(len(key_frames))
        sheet = shrink_paper(self._paper, self._title_height, pages)
        is_fitted = pages == 1 and options.layout not in ("grid", "manga") and not options.bleeding
        fitted = fit_paper(sheet, key_frames, area_scales) if is_fitted else sheet
        layout = lay_out(
            *(key_frames, fitted),
            pages=options.pages,
            seed=options.seed,
            right_to_left=self._right_to_left,
            bleeding=options.bleeding or options.layout == "manga",
            kind=options.layout,
            area_scales=area_scales,
            insets=insets,
        )
        layout = place_panels(
            *(layout, fitted, sheet),
            trims_width=self._trims and not self._title_height,
            trims_height=self._trims,
        )
        return (
            move_below_title(layout, key_frames, self._paper, self._title_height)
            if self._title_height
            else layout
        )
