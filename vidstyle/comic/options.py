"""What somebody may want of a comic."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from vidstyle.comic.layout.paper import DPI
from vidstyle.comic.select.moments import KeyFrameOptions
from vidstyle.renderer import StyleLike


@dataclass(frozen=True)
class ComicOptions:
    """What somebody wants of a comic.

    Attributes:
        wishes: which moments.
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

    wishes: KeyFrameOptions = field(default_factory=KeyFrameOptions)
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
