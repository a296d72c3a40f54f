"""A finished page as shapes and text, before it is rendered to a file."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vidstyle.comic.layout.paper import Rectangle
from vidstyle.comic.lettering.bubble import Bubble
from vidstyle.comic.lettering.fonts import Letters


@dataclass(frozen=True)
class RenderedPanel:
    """A panel: its border fills the rectangle, its picture lies in it, and words over that.

    Attributes:
        color: the picture, uint8, height x width x 3 of `picture`.
        note: what it shows, in words, for those who cannot see it.
    """

    rectangle: Rectangle
    picture: Rectangle
    color: np.ndarray
    bubbles: tuple[Bubble, ...] = ()
    note: str = ""

    @property
    def band(self) -> Rectangle | None:
        """Where words stand above the picture, if they do."""
        boxes = [bubble.box for bubble in self.bubbles if bubble.kind == "band"]
        if not boxes:
            return None
        top, bottom = min(box.top for box in boxes), max(box.bottom for box in boxes)
        return self.picture._replace(top=round(top), bottom=round(bottom))


@dataclass(frozen=True)
class Label:
    """A line of text on the paper: a title, a page's number, a time.

    Attributes:
        middle, foot: where it stands, in pixels.
        size: of its letters.
        is_bold: whether they are thick.
    """

    text: str
    middle: float
    foot: float
    size: int
    is_bold: bool = False

    @property
    def thickness(self) -> int:
        """By so many pixels its letters are thicker on each side."""
        return max(1, self.size // 28) if self.is_bold else 0


@dataclass
class Sheet:
    """A page of so many pixels, `dpi` to the inch."""

    width: int
    height: int
    dpi: float
    letters: Letters
    panels: list[RenderedPanel] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
