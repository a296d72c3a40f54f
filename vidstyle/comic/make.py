"""Make a comic of a film: `vidstyle comic` as a function."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.flaws.refused import describe_lack, describe_refused
from vidstyle.comic.analyze.key_frame_source import Film
from vidstyle.comic.comic_options import ComicOptions as ComicOptions
from vidstyle.comic.comic_options import read_saved
from vidstyle.comic.drawn_check import DrawnCheck
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.paper import BORDER_POINTS, paper
from vidstyle.comic.lettering.characters import control_character
from vidstyle.comic.lettering.fonts import Letters, check_pillow
from vidstyle.comic.lettering.omitted import list_omitted
from vidstyle.comic.lettering.subtitle_lines import Line, read_lines_of_file, read_lines_of_film
from vidstyle.comic.output.page_file import PageFile, page_file
from vidstyle.comic.output.panel_renderer import (
    PagePlan,
    PanelRenderer,
    draw_pages,
    oversampling_of,
)
from vidstyle.comic.output.write import Frames, Output
from vidstyle.comic.page_planner import PagePlanner
from vidstyle.comic.panel_styles import PanelStyles
from vidstyle.errors import UsageError, counted, log, printable, text_of_name
from vidstyle.media.options import check_rotation
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.write.atomic import atomic_file
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.regions.faces import FaceFinder
from vidstyle.style import PLAIN, load_style

PAGE_FILE_SUFFIX = ".toml"
"""Suffix of an editable comic."""
_FEW_PANELS = "one panel", "two panels"
"""Numbers of panels that are explained."""
_NO_FACES_NOTICE = "face detection is off: pip install 'vidstyle[comic]', or add --face-model FILE"


@dataclass(frozen=True)
class Comic:
    """The result of `make_comic`.

    Attributes:
        files: the files written.
        key_frames: the key frames shown.
        pages: number of pages.
        damage: the damage found in the film.
        omitted: start times in seconds of the subtitles that no panel shows.
    """

    files: list[Path]
    key_frames: list[KeyFrame]
    pages: int
    damage: DecodeReport
    omitted: tuple[float, ...] = ()


def make_comic(
    source: str | Path,
    target: str | Path,
    options: ComicOptions | None = None,
    on_step: ProgressCallback = ignore_progress,
) -> Comic:
    """Make a comic of a film, of numbered pictures or of a folder of pictures.

    Args:
        source: the film, the numbered pictures, the folder, or a page file.
        target: .png, .jpg or .svg (several pages: name-1.png, or numbered by %02d), .pdf, .cbz, .epub
            or .html.
        options: see `ComicOptions`.
        on_step: called with the name of a step and its progress.

    Raises:
        VidstyleError: of any kind; no unfinished file remains.
    """
    return _Job(str(source), Path(target), options or ComicOptions(), on_step).run()


class _Job:
    """One run of `make_comic`; the constructor checks everything that does not depend on the film."""

    def __init__(self, source: str, target: Path, options: ComicOptions, on_step: ProgressCallback) -> None:
        check_pillow()
        options.key_frames.check()
        check_rotation(options.rotate)
        self._read_saved: PageFile | None = None
        if Path(source).suffix.lower() == PAGE_FILE_SUFFIX:
            self._read_saved, source, options = read_saved(Path(source), options)
        options = replace(options, title=text_of_name(options.title))
        self._source, self._options, self._step = source, options, on_step
        self._output = Output(target, source, options.overwrite)
        size = options.size or ("screen" if self._output.is_strip else "a4")
        border = 0 if options.storyboard else BORDER_POINTS
        dpi = self._output.dpi if options.dpi is None else options.dpi
        self._paper = paper(size, dpi, landscape=options.landscape, border=border)
        self._output.check_pages([(self._paper.width, self._paper.height)])
        default_style = PLAIN if options.storyboard else "comic"
        self._style_names = options.styles or (default_style,)
        styles = [load_style(each) for each in self._style_names]
        self._styles = PanelStyles(styles, options.by, options.cues)
        if options.by is not None and len(styles) == 1:
            raise UsageError("--by", "needs several styles", "give them as in --style ink,noir,poster")
        if options.save:
            self._check_save(options.save)
        if control := control_character(options.title):
            raise UsageError("--title", f"holds the control character {control}", "remove it")
        # An unusable font is an error before the film is analyzed.
        Letters(options.font)
        self._omitted: list[Line] = []
        self._lines: list[Line] | None = None
        if options.subtitles is not None:
            self._lines = [] if options.subtitles == "none" else read_lines_of_file(Path(options.subtitles))

    def run(self) -> Comic:
        """Analyse, select, lay out, letter and draw; or draw a saved comic."""
        faces = FaceFinder(self._options.face_model)
        with open_film(self._source, faces, self._options.rotate) as film:
            if self._read_saved:
                return self._draw(self._read_saved.plan(film), film)
            lines = self._dialogue_lines()
            if lines and not faces.has_model:
                log.info(_NO_FACES_NOTICE)
            trims = self._options.size is None and not self._output.is_printed
            planner = PagePlanner(film, self._options, self._step, self._paper, trims)
            with self._open_check(film, faces) as check:
                plan = planner.plan(lines, check)
            self._omitted = planner.omitted
            self._report_refused(film)
            self._report_few(plan, film)
            self._report_omitted(lines)
            _report_lacking(plan.letters)
            return self._draw(plan, film)

    def _open_check(self, film: Film, faces: FaceFinder) -> AbstractContextManager[DrawnCheck | None]:
        """Return the check of key frames; None for a contact sheet, which shows any frame."""
        options = self._options
        return nullcontext() if options.storyboard else DrawnCheck(film, self._styles, options.device, faces)

    def _report_refused(self, film: Film) -> None:
        """Report the frames that were too bad for a panel."""
        if not self._options.storyboard and (refused := describe_refused(film.survey().candidates)):
            log.info(refused)

    def _report_few(self, plan: PagePlan, film: Film) -> None:
        """Explain why a film gets one or two panels."""
        survey, count = film.survey(), len(plan.key_frames)
        is_free = self._options.key_frames.panels is None and not survey.is_folder
        if is_free and count <= len(_FEW_PANELS):
            reason = describe_lack(survey.candidates, [each.time for each in plan.key_frames])
            text = "%s: the film has %.1f s, and %s; give --panels for more"
            log.info(text, _FEW_PANELS[count - 1], survey.seconds, reason)

    def _report_omitted(self, lines: Sequence[Line]) -> None:
        """Report each subtitle that no panel shows, with its time."""
        if not self._omitted:
            return
        count = sum(len(line.times) for line in self._omitted)
        text, verb = counted(count, "subtitle"), "is" if count == 1 else "are"
        places = ", ".join(list_omitted(self._omitted, lines))
        log.warning("%s %s not shown, at %s; increase --panels to show more of them", text, verb, places)

    def _draw(self, plan: PagePlan, film: Film) -> Comic:
        self._output.check_pages(plan.layout.sizes)
        styles = self._styles.of(_shown(plan))
        key_frames, pages, folder = list(plan.key_frames), len(plan.layout.sizes), self._options.frames
        if save := self._options.save:
            content = self._page_file(plan, save, film.rotate)
            with atomic_file(save, self._source, self._options.overwrite) as write:
                write(content.encode())
        edited = self._page_file(plan, self._output.target, film.rotate) if self._output.is_strip else ""
        oversampling = oversampling_of(plan.layout.sizes) if self._output.is_strip else 1
        with (
            Frames(folder, len(key_frames), self._options.overwrite) if folder else nullcontext() as frames,
            PanelRenderer(styles, plan.dpi, self._options.device, oversampling=oversampling) as renderer,
        ):
            sheets = draw_pages(plan, film, renderer, frames, partial(self._step, "drawing"))
            files = self._output.write(sheets, pages, self._options.title, edited)
        omitted = tuple(time for line in self._omitted for time in line.times)
        return Comic(files, key_frames, pages, film.damage, omitted)

    def _page_file(self, plan: PagePlan, target: Path, rotate: int | None) -> str:
        """Return the comic as a file to edit next to `target`; empty if a style has no name."""
        if not self._has_names:
            return ""
        styles = [str(each) for each in self._style_names]
        if self._options.by is not None:
            styles = [styles[number] for number in self._styles.numbers(_shown(plan))]
        return page_file(plan, self._source, target, self._options.title, styles, rotate)

    @property
    def _has_names(self) -> bool:
        """Whether the styles can be written in a page file."""
        return self._options.cues is None and all(isinstance(each, str) for each in self._style_names)

    def _check_save(self, target: Path) -> None:
        """Raise an error if the page file cannot be written."""
        if target.suffix.lower() != PAGE_FILE_SUFFIX:
            raise UsageError(target, "cannot be a page file", f"end its name in {PAGE_FILE_SUFFIX}")
        if not self._has_names:
            raise UsageError("--save", "needs styles given by name or path")
        for name in (self._source, str(self._options.font or ""), *map(str, self._style_names)):
            if control := control_character(name):
                reason = f"cannot write the name {printable(name)}: it holds {control}"
                raise UsageError("--save", reason, "rename it, or use a UTF-8 locale")
        with atomic_file(target, self._source, self._options.overwrite):
            pass

    def _dialogue_lines(self) -> list[Line]:
        if self._options.storyboard:
            return []
        if self._lines is not None:
            return self._lines
        return read_lines_of_film(self._source) if Path(self._source).is_file() else []


def _report_lacking(letters: Letters) -> None:
    """Report the letters that the font does not have."""
    if letters.lacking:
        lacking = " ".join(letters.lacking)
        log.warning("the font %s has no %s; give another one with --font", letters.family, lacking)


def _shown(plan: PagePlan) -> list[KeyFrame]:
    """Return the key frame of each panel."""
    return [plan.key_frames[panel.key_frame] for panel in plan.layout.panels]
