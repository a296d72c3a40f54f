"""Make a comic of a film: `vidstyle comic` as a function."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path

from vidstyle.comic.analyze.faces import FaceFinder
from vidstyle.comic.analyze.film import Film, open_film
from vidstyle.comic.analyze.saliency import attention_map, attention_of_box
from vidstyle.comic.layout.inset import suit_insets
from vidstyle.comic.layout.layout import PageLayout, lay_out, pages_for
from vidstyle.comic.layout.paper import BORDER, DPI, LayoutKind, paper
from vidstyle.comic.layout.storyboard import contact_sheet, time_labels
from vidstyle.comic.lettering.characters import control_character
from vidstyle.comic.lettering.dialogue import match, panels_for
from vidstyle.comic.lettering.fonts import Letters, check_pillow, letter_size, letters_for
from vidstyle.comic.lettering.letter import PanelText, TextStyle, letter
from vidstyle.comic.lettering.subtitle_lines import Line, lines_of_file, lines_of_film
from vidstyle.comic.lettering.title import below_title, lowered, numbers, title_of
from vidstyle.comic.moment import Moment
from vidstyle.comic.output.page_file import PageFile, page_file, read_page_file
from vidstyle.comic.output.panel_renderer import PagePlan, PanelRenderer, drawn
from vidstyle.comic.output.sheet import Label
from vidstyle.comic.output.write import Frames, Output
from vidstyle.comic.select.moments import KeyFrameOptions, find_moments
from vidstyle.errors import UsageError, log, printable, text_of_name
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.write.atomic import atomic_file
from vidstyle.pipeline.progress import OnStep, unwatched
from vidstyle.renderer import StyleLike
from vidstyle.style import PLAIN, load_style

PAGE_FILE = ".toml"
"""Ending of the name of an editable comic."""
_NO_FACES = "faces are not looked for: pip install 'vidstyle[comic]', or add --face-model FILE"


@dataclass(frozen=True)
class Comic:
    """The result of `make_comic`.

    Attributes:
        files: the files written.
        moments: the key frames shown.
        pages: number of pages.
        damage: what was found wrong in the film.
    """

    files: list[Path]
    moments: list[Moment]
    pages: int
    damage: DecodeReport


def make_comic(
    source: str | Path, target: str | Path, options: ComicOptions | None = None, on_step: OnStep = unwatched
) -> Comic:
    """Make a comic of a film, of numbered pictures or of a folder of pictures.

    Args:
        target: .png, .jpg or .svg (several pages: name-1.png, or numbered by %02d), .pdf, .cbz or .html.

    Raises:
        VidstyleError: in any of its kinds; no unfinished file remains.
    """
    return _Job(str(source), Path(target), options or ComicOptions(), on_step).run()


class _Job:
    """One run of `make_comic`; all that does not depend on the film is checked in the constructor."""

    def __init__(self, source: str, target: Path, options: ComicOptions, on_step: OnStep) -> None:
        check_pillow()
        options.key_frames.check()
        self._saved: PageFile | None = None
        if Path(source).suffix.lower() == PAGE_FILE:
            self._saved, source, options = _saved(Path(source), options)
        options = replace(options, title=text_of_name(options.title))
        self._source, self._options, self._step = source, options, on_step
        self._output = Output(target, source, options.overwrite)
        size = options.size or ("strip" if self._output.is_strip else "a4")
        border = 0 if options.storyboard else BORDER
        self._paper = paper(size, options.dpi, landscape=options.landscape, border=border)
        self._output.check_pages([(self._paper.width, self._paper.height)])
        default_style = PLAIN if options.storyboard else "comic"
        self._style_names = options.styles or (default_style,)
        self._styles = [load_style(each) for each in self._style_names]
        if options.save:
            self._check_save(options.save)
        if control := control_character(options.title):
            raise UsageError("--title", f"holds the control character {control}", "remove it")
        self._right_to_left = options.right_to_left or options.layout == "manga"
        self._letters = Letters(options.font)
        self._size = letter_size(self._paper)
        self._title: Label | None = None
        self._title_height = 0
        self._lines: list[Line] | None = None
        if options.subtitles is not None:
            self._lines = [] if options.subtitles == "none" else lines_of_file(Path(options.subtitles))

    def run(self) -> Comic:
        """Analyse, select, lay out, letter and draw; or draw what was saved."""
        faces = FaceFinder(self._options.face_model)
        with open_film(self._source, faces) as film:
            if self._saved:
                return self._draw(self._saved.plan(film), film)
            lines = self._dialogue_lines()
            if lines and not faces.has_model:
                log.info(_NO_FACES)
            self._choose_font(lines)
            spoken = tuple((line.start, line.end) for line in lines if not line.narrated)
            key_frames = replace(self._options.key_frames, min_panels=panels_for(lines), spoken=spoken)
            moments = find_moments(film, key_frames, self._step)
            self._step("laying out", 0, 0)
            return self._draw(self._plan(film, moments, lines), film)

    def _draw(self, plan: PagePlan, film: Film) -> Comic:
        self._output.check_pages(plan.layout.sizes)
        moments, pages, folder = list(plan.moments), len(plan.layout.sizes), self._options.frames
        if save := self._options.save:
            content = self._page_file(plan, save)
            with atomic_file(save, self._source, self._options.overwrite) as write:
                write(content.encode())
        edited = self._page_file(plan, self._output.target) if self._output.is_strip else ""
        with (
            Frames(folder, len(moments), self._options.overwrite) if folder else nullcontext() as frames,
            PanelRenderer(self._styles, plan.dpi, self._options.device) as renderer,
        ):
            sheets = drawn(plan, film, renderer, frames, partial(self._step, "drawing"))
            files = self._output.write(sheets, pages, self._options.title, edited)
        return Comic(files, moments, pages, film.damage)

    def _page_file(self, plan: PagePlan, target: Path) -> str:
        """The comic as a file to edit beside `target`; empty if a style has no name."""
        if not all(isinstance(each, str) for each in self._style_names):
            return ""
        styles = [str(each) for each in self._style_names]
        return page_file(plan, self._source, target, self._options.title, styles)

    def _check_save(self, target: Path) -> None:
        """Raise an error if the page file cannot be written."""
        if target.suffix.lower() != PAGE_FILE:
            raise UsageError(target, "cannot be a page file", f"end its name in {PAGE_FILE}")
        if not all(isinstance(each, str) for each in self._style_names):
            raise UsageError("--save", "needs styles by name or path")
        for name in (self._source, str(self._options.font or ""), *map(str, self._style_names)):
            if control := control_character(name):
                reason = f"cannot write the name {printable(name)}: it holds {control}"
                raise UsageError("--save", reason, "rename it, or use a UTF-8 locale")
        with atomic_file(target, self._source, self._options.overwrite):
            pass

    def _choose_font(self, lines: Sequence[Line]) -> None:
        title = self._options.title
        if not self._options.storyboard:
            self._letters = letters_for([title, *(line.text for line in lines)], self._letters)
        if title:
            self._title, self._title_height = title_of(title, self._paper, self._size, self._letters)

    def _plan(self, film: Film, moments: Sequence[Moment], lines: Sequence[Line]) -> PagePlan:
        if self._options.storyboard:
            layout = contact_sheet(moments, self._paper, self._size, self._title_height)
            labels = time_labels(layout, moments, self._size)
        else:
            layout = self._comic_pages(film, moments, lines)
            labels = numbers(layout, self._paper, self._size)
        if self._title:
            labels[0].append(self._title)
        if self._letters.lacking:
            lacking = " ".join(self._letters.lacking)
            log.warning("the font %s lacks %s; give another with --font", self._letters.family, lacking)
        return PagePlan(moments, layout, labels, self._letters, self._paper.dpi, self._right_to_left)

    def _dialogue_lines(self) -> list[Line]:
        if self._options.storyboard:
            return []
        if self._lines is not None:
            return self._lines
        return lines_of_film(self._source) if Path(self._source).is_file() else []

    def _comic_pages(self, film: Film, moments: Sequence[Moment], lines: Sequence[Line]) -> PageLayout:
        spoken, count = match(lines, moments)
        border, safe = self._paper.border, self._paper.safe
        style = TextStyle(self._letters, self._size, border, self._right_to_left, safe)
        shown = list(zip(moments, spoken, strict=True))
        colors = film.frames_at([moment.time for moment, said in shown if said], keep=True)
        attention = (
            attention_map(moment.picture(next(colors)), moment.faces) if said else attention_of_box(moment)
            for moment, said in shown
        )
        texts = list(map(PanelText, moments, spoken, attention))
        insets = suit_insets(moments, list(map(bool, spoken)))
        layout = letter(partial(self._layout, moments, insets), texts, style)
        if lost := count - sum(len(panel.bubbles) for panel in layout.panels):
            log.info("%d of %d subtitles stand in no panel; more --panels hold more of them", lost, count)
        return layout

    def _layout(
        self, moments: Sequence[Moment], insets: Sequence[int], area_scales: Sequence[float]
    ) -> PageLayout:
        options = self._options
        pages = options.pages or pages_for(len(moments))
        layout = lay_out(
            *(moments, below_title(self._paper, self._title_height, pages)),
            pages=options.pages,
            seed=options.seed,
            right_to_left=self._right_to_left,
            bleeding=options.bleeding or options.layout == "manga",
            kind=options.layout,
            area_scales=area_scales,
            insets=insets,
        )
        return lowered(layout, moments, self._paper, self._title_height) if self._title_height else layout


@dataclass(frozen=True)
class ComicOptions:
    """Options of `make_comic`.

    Attributes:
        key_frames: how the key frames are chosen.
        styles: assigned to the panels in turn; None: comic, or for a contact sheet none.
        size: paper size, see `paper`; None: A4, or a strip for .html.
        dpi: pixels per inch.
        landscape: landscape orientation for a named paper size.
        pages: number of pages; None: depends on the panels.
        seed: varies the layout.
        layout: "classic", "dynamic", "manga" (from right to left) or "grid".
        right_to_left: right-to-left reading order.
        bleeding: whether full-width panels extend to the page edge.
        subtitles: a file, "none", or None for the film's own, if there are any.
        title: title on the first page, if not empty.
        font: a file; None: a hand-lettered font in capitals, else Pillow's built-in one, or an installed one
            if that lacks glyphs.
        frames: a folder to save the key frames to, with a table of their times.
        save: page file to write as well, which can be edited and given as a source.
        storyboard: make a contact sheet with timecodes instead of a comic.
        face_model: face detection model, an OpenCV cascade (.xml) or YuNet (.onnx); None: the networks of
            the package mtcnn.
        overwrite: whether existing files may be overwritten.
        device: device that runs the styles, as for `open_renderer`.
    """

    key_frames: KeyFrameOptions = field(default_factory=KeyFrameOptions)
    styles: tuple[StyleLike, ...] | None = None
    size: str | None = None
    dpi: float = DPI
    landscape: bool = False
    pages: int | None = None
    seed: int = 0
    layout: LayoutKind = "dynamic"
    right_to_left: bool = False
    bleeding: bool = False
    subtitles: str | None = None
    title: str = ""
    font: Path | None = None
    frames: Path | None = None
    save: Path | None = None
    storyboard: bool = False
    face_model: Path | None = None
    overwrite: bool = False
    device: str = "auto"


_WITH_PAGE_FILE = {"styles", "frames", "save", "overwrite", "device"}
"""Options that hold for a page file, in which all others have been decided."""


def _saved(path: Path, options: ComicOptions) -> tuple[PageFile, str, ComicOptions]:
    """A page file, its source, and the options with what it says."""
    usual = ComicOptions()
    for each in fields(options):
        if each.name not in _WITH_PAGE_FILE and getattr(options, each.name) != getattr(usual, each.name):
            raise UsageError(path, f"has decided the option {each.name} already", "change the file instead")
    saved = read_page_file(path)
    styles = options.styles or saved.styles
    return saved, saved.source, replace(options, styles=styles, title=saved.title)
