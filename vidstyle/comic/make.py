"""From a film to a comic: `vidstyle comic` as a function."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from vidstyle.comic.analyze.attention import attention_of_film
from vidstyle.comic.analyze.faces import FaceFinder
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.survey import Film
from vidstyle.comic.layout.layout import PageLayout, lay_out, pages_for
from vidstyle.comic.layout.paper import BORDER, DPI, paper
from vidstyle.comic.layout.storyboard import contact_sheet, time_labels
from vidstyle.comic.lettering.dialogue import match, panels_for
from vidstyle.comic.lettering.fonts import Letters, check_pillow, letter_size, letters_for
from vidstyle.comic.lettering.letter import LetteredPanel, PanelText, TextStyle, letter
from vidstyle.comic.lettering.subtitles import Line, lines_of_file, lines_of_film
from vidstyle.comic.lettering.title import below_title, lowered, numbers, title_of
from vidstyle.comic.moment import Moment
from vidstyle.comic.output.panel import PagePlan, PanelRenderer, drawn
from vidstyle.comic.output.sheet import Label
from vidstyle.comic.output.write import Frames, Output
from vidstyle.comic.select.moments import KeyFrameOptions, find_moments
from vidstyle.renderer import StyleLike
from vidstyle.style import PLAIN, load_style

OnStep = Callable[[str, int, int], None]
"""Told what is being done, how many parts of it are done, and how many there are (0: unknown)."""

_NO_FACES = "no faces are looked for, as OpenCV brings no model here: --face-model FILE gives one"

_log = logging.getLogger("vidstyle")


@dataclass(frozen=True)
class Comic:
    """What was made.

    Attributes:
        files: that were written.
        moments: that are shown.
        pages: how many.
    """

    files: list[Path]
    moments: list[Moment]
    pages: int


def make_comic(
    source: str | Path, target: str | Path, options: ComicOptions | None = None, on_step: OnStep | None = None
) -> Comic:
    """Make a comic of a film, of numbered pictures or of a folder of pictures.

    Args:
        target: .png, .jpg, .svg (several pages: name-1.png, or as %02d says), .pdf, .cbz, .html.

    Raises:
        VidstyleError: of one of its kinds; an unfinished file is not left.
    """
    return _Job(str(source), Path(target), options or ComicOptions(), on_step or (lambda *_: None)).run()


class _Job:
    """All that can be checked before the film is looked at is checked at the start."""

    def __init__(self, source: str, target: Path, options: ComicOptions, on_step: OnStep) -> None:
        check_pillow()
        options.key_frames.check()
        self._source, self._options, self._step = source, options, on_step
        self._output = Output(target, source, options.overwrite)
        size = options.size or ("strip" if self._output.is_strip else "a4")
        border = 0 if options.storyboard else BORDER
        self._paper = paper(size, options.dpi, landscape=options.landscape, border=border)
        self._styles = [load_style(each) for each in options.styles or self._usual_styles]
        self._letters = Letters(options.font)
        self._size = letter_size(self._paper)
        self._title: Label | None = None
        self._head = 0
        self._lines = self._lines_of_file()

    @property
    def _usual_styles(self) -> tuple[str, ...]:
        return (PLAIN,) if self._options.storyboard else ("comic",)

    def _lines_of_file(self) -> list[Line] | None:
        wanted = self._options.subtitles
        if wanted is None:
            return None
        return [] if wanted == "none" else lines_of_file(Path(wanted))

    def run(self) -> Comic:
        """Look, choose, lay out, write in, draw."""
        self._step("looking through the film", 0, 0)
        faces = FaceFinder(self._options.face_model)
        with open_film(self._source, faces) as film:
            lines = self._spoken()
            if lines and not faces.has_model:
                _log.info(_NO_FACES)
            self._take_letters(lines)
            moments = find_moments(film, replace(self._options.key_frames, min_panels=panels_for(lines)))
            self._step("laying out", 0, 0)
            plan = self._plan(film, moments, lines)
            return self._drawn(plan, film)

    def _drawn(self, plan: PagePlan, film: Film) -> Comic:
        moments, pages, folder = list(plan.moments), len(plan.layout.sizes), self._options.frames
        with (
            Frames(folder, len(moments), self._options.overwrite) if folder else nullcontext() as frames,
            PanelRenderer(self._styles, self._paper.dpi, self._options.device) as renderer,
        ):
            sheets = drawn(plan, film, renderer, frames, partial(self._step, "drawing"))
            return Comic(self._output.write(sheets, pages, self._options.title), moments, pages)

    def _take_letters(self, lines: Sequence[Line]) -> None:
        title = self._options.title
        self._letters = letters_for([title, *(line.text for line in lines)], self._letters)
        if title:
            self._title, self._head = title_of(title, self._paper, self._size, self._letters)

    def _plan(self, film: Film, moments: Sequence[Moment], lines: Sequence[Line]) -> PagePlan:
        storyboard = self._options.storyboard
        layout, panels = self._on_sheets(moments) if storyboard else self._on_pages(film, moments, lines)
        if storyboard:
            labels = list(time_labels(layout, moments, self._size))
        else:
            labels = list(numbers(layout, self._paper, self._size))
        if self._title:
            labels[0].append(self._title)
        if self._letters.lacking:
            lacking = " ".join(self._letters.lacking)
            _log.warning("the font %s lacks %s; give another with --font", self._letters.family, lacking)
        return PagePlan(moments, layout, panels, labels, self._letters, self._paper.dpi)

    def _on_sheets(self, moments: Sequence[Moment]) -> tuple[PageLayout, list[LetteredPanel]]:
        layout = contact_sheet(moments, self._paper, self._size, self._head)
        return layout, [LetteredPanel(each, each.rectangle, each.crop) for each in layout.panels]

    def _spoken(self) -> list[Line]:
        if self._options.storyboard:
            return []
        if self._lines is not None:
            return self._lines
        return lines_of_film(self._source) if Path(self._source).is_file() else []

    def _on_pages(
        self, film: Film, moments: Sequence[Moment], lines: Sequence[Line]
    ) -> tuple[PageLayout, list[LetteredPanel]]:
        words = match(lines, moments)
        hand = TextStyle(self._letters, self._size, self._paper.border, self._options.right_to_left)
        attention = attention_of_film(film, moments, list(map(bool, words.panels)))
        speeches = list(map(PanelText, moments, words.panels, attention))
        layout, panels, lost = letter(partial(self._layout, moments), speeches, hand)
        if words.left_out + lost:
            counts = words.left_out + lost, words.lines
            _log.info("%d of %d subtitles stand in no panel; with more --panels more do", *counts)
        return layout, panels

    def _layout(self, moments: Sequence[Moment], growth: Sequence[float]) -> PageLayout:
        options = self._options
        pages = options.pages or pages_for(len(moments))
        layout = lay_out(
            *(moments, below_title(self._paper, self._head, pages)),
            pages=options.pages,
            seed=options.seed,
            right_to_left=options.right_to_left,
            bleeding=options.bleeding,
            growth=growth,
        )
        return lowered(layout, moments, self._paper, self._head) if self._head else layout


@dataclass(frozen=True)
class ComicOptions:
    """What somebody wants of a comic.

    Attributes:
        key_frames: how the key frames are chosen.
        styles: of the panels, in turns; None: comic, or for a contact sheet none.
        size: of the paper, see `paper`; None: A4, and for a web page a strip.
        dpi: pixels per inch.
        landscape: whether a page with a name lies on its side.
        pages: how many; None: as suits the panels.
        seed: another number, another layout.
        right_to_left: whether it is read from the right.
        bleeding: whether panels over the whole width go on to the paper's edges.
        subtitles: a file of them, "none", or None for the film's own, if it has some.
        title: above the first page, if not empty.
        font: a file; None: the one that Pillow brings, or an installed one where that lacks letters.
        frames: a folder for the frames themselves, and a table of their times.
        storyboard: a plain contact sheet with times instead of a comic.
        face_model: a cascade of OpenCV's (.xml) or a YuNet network (.onnx) that finds faces.
        overwrite: whether files may be replaced.
        device: what runs the style, as for `open_renderer`.
    """

    key_frames: KeyFrameOptions = field(default_factory=KeyFrameOptions)
    styles: tuple[StyleLike, ...] | None = None
    size: str | None = None
    dpi: float = DPI
    landscape: bool = False
    pages: int | None = None
    seed: int = 0
    right_to_left: bool = False
    bleeding: bool = False
    subtitles: str | None = None
    title: str = ""
    font: Path | None = None
    frames: Path | None = None
    storyboard: bool = False
    face_model: Path | None = None
    overwrite: bool = False
    device: str = "auto"
