"""Options of `make_comic`."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path

from vidstyle.comic.layout.paper import LayoutKind
from vidstyle.comic.output.page_file import PageFile, read_page_file
from vidstyle.comic.select.key_frame_options import KeyFrameOptions
from vidstyle.cues.cue_list import CueList
from vidstyle.cues.style_change import StyleChange
from vidstyle.errors import UsageError
from vidstyle.renderer import StyleLike


@dataclass(frozen=True)
class ComicOptions:
    """Options of `make_comic`.

    Attributes:
        key_frames: how the key frames are chosen.
        styles: assigned to the panels in rotation; None: comic, or for a contact sheet none.
        by: where the next of the styles follows; None: with each panel.
        cues: styles over time, for the times of the panels; None: `styles`.
        size: paper size, see `paper`; None: A4, or a page that suits a window for .html.
        dpi: pixels per inch; None: 300 for .pdf, else 150.
        landscape: landscape orientation for a named paper size.
        pages: number of pages; None: depends on the panels.
        seed: random seed for variations of layout and frames; 0 gives the best of both.
        layout: "classic", "dynamic", "manga" (from right to left) or "grid".
        right_to_left: right-to-left reading order.
        bleeding: whether full-width panels extend to the page edge.
        subtitles: a file, "none", or None for the subtitles in the film, if there are any.
        title: title on the first page, if not empty.
        font: a file; None: a hand-lettered font in capitals, or, if that lacks glyphs, Pillow's built-in font
            or an installed one.
        frames: a folder to save the key frames to, with a table of their times.
        save: page file to write as well, which can be edited and used as a source.
        storyboard: make a contact sheet with timecodes instead of a comic.
        rotate: degrees clockwise, a multiple of 90, instead of the rotation in the metadata.
        face_model: face detection model, an OpenCV cascade (.xml) or YuNet (.onnx); None: the networks of
            the package mtcnn.
        overwrite: whether existing files may be overwritten.
        device: device that runs the styles, as for `open_renderer`.
    """

    key_frames: KeyFrameOptions = field(default_factory=KeyFrameOptions)
    styles: tuple[StyleLike, ...] | None = None
    by: StyleChange | None = None
    cues: CueList | None = None
    size: str | None = None
    dpi: float | None = None
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
    rotate: int | None = None
    face_model: Path | None = None
    overwrite: bool = False
    device: str = "auto"


_PAGE_FILE_OPTIONS = {"styles", "cues", "frames", "save", "overwrite", "device"}
"""Options that can be combined with a page file; it contains the values of all others."""


def read_saved(path: Path, options: ComicOptions) -> tuple[PageFile, str, ComicOptions]:
    """Read a page file; return it, its source, and the options with its values."""
    usual = ComicOptions()
    for each in fields(options):
        if each.name not in _PAGE_FILE_OPTIONS and getattr(options, each.name) != getattr(usual, each.name):
            raise UsageError(
                path, f"is a page file that sets the option {each.name}", "change the file instead"
            )
    saved = read_page_file(path)
    styles = options.styles or saved.styles
    options = replace(options, styles=styles, title=saved.title, rotate=saved.rotate)
    return saved, saved.source, options
