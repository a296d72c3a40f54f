"""A finished page as shapes and text, before it is rendered to a file."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vidstyle.comic.layout.slant import Leans
from vidstyle.comic.lettering.bubble import Bubble
from vidstyle.comic.lettering.fonts import Letters, thickness
from vidstyle.regions.boxes import Rectangle


@dataclass(frozen=True)
class RenderedPanel:
    """A panel: a border that fills its rectangle, a picture inside it, and text above the picture.

    Attributes:
        rectangle: on the page.
        picture: rectangle of the picture.
        color: the picture, H x W x 3 uint8, of the size of `picture`, or larger for web pages.
        bubbles: its text.
        note: description of the picture for screen readers.
        leans: see `slant`.
    """

    rectangle: Rectangle
    picture: Rectangle
    color: np.ndarray
    bubbles: tuple[Bubble, ...] = ()
    note: str = ""
    leans: Leans = (0, 0)

    @property
    def border(self) -> int:
        """Width of the border in pixels."""
        return self.picture.left - self.rectangle.left

    @property
    def inside(self) -> Rectangle:
        """The rectangle without its border."""
        return self.rectangle.padded(-self.border, -self.border, -self.border)

    @property
    def band(self) -> Rectangle | None:
        """The band for text above the picture, or None."""
        boxes = [bubble.box for bubble in self.bubbles if bubble.kind == "band"]
        if not boxes:
            return None
        top, bottom = min(box.top for box in boxes), max(box.bottom for box in boxes)
        return self.picture._replace(top=round(top), bottom=round(bottom))


@dataclass(frozen=True)
class Label:
    """A line of text outside panels: a title, a page number or a timecode.

    Attributes:
        text: one line.
        middle, foot: horizontal centre and baseline in pixels.
        size: font size in pixels.
        is_bold: whether it is bold.
    """

    text: str
    middle: float
    foot: float
    size: int
    is_bold: bool = False

    @property
    def thickness(self) -> int:
        """Width of the outline that makes the letters bold, in pixels on each side."""
        return thickness(self.size) if self.is_bold else 0


@dataclass
class Sheet:
    """A page of `width` x `height` pixels at `dpi` pixels per inch."""

    width: int
    height: int
    dpi: float
    letters: Letters
    panels: list[RenderedPanel] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    right_to_left: bool = False
