"""Lettering: text is placed in panels, and panels change where it does not fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.comic.analyze.saliency import crop_attention, mean_under
from vidstyle.comic.key_frame import Box, KeyFrame, Point, Rectangle
from vidstyle.comic.layout.crop import crop, map_point_to_page, map_to_page, shift_window
from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.layout.slant import upright_area
from vidstyle.comic.lettering.balloons import FreeSpace, Wording, place
from vidstyle.comic.lettering.bubble import Bubble, BubbleKind, TextBlock, shapes, size_of
from vidstyle.comic.lettering.fonts import Letters
from vidstyle.comic.lettering.subtitle_lines import Line, Manner

GROWTH = 1.6
"""Factor on the wanted area of a panel whose text does not fit."""
ROUNDS = 3
"""Maximum number of layouts tried."""

_SMALLER = 0.85
"""Factor on the font size where there is little room."""
_QUIET = 0.85
"""Factor on the font size of what is whispered."""
_KINDS: dict[Manner, BubbleKind] = {
    "said": "balloon",
    "shouted": "burst",
    "whispered": "whisper",
    "thought": "cloud",
    "sound": "burst",
}
_AIR = 0.35
"""Distance between bubbles and the border, in font sizes."""
_BAND, _WIDEST_BAND = 0.3, 0.55
"""Maximum share of a panel that bands above its picture take, and in the last round."""
_BANDS_OVERLAP = 0.3
"""Overlap of neighbouring bands, in font sizes."""
_CALM, _BUSY = 1.0, 1.5
"""Attention under a bubble: up to the first no other window is tried, above the second the panel grows."""


@dataclass(frozen=True)
class TextStyle:
    """Text settings.

    Attributes:
        size: font size in pixels.
        border: width of panel borders in pixels.
        safe: the part of a page in which words are.
    """

    letters: Letters
    size: int
    border: int
    right_to_left: bool = False
    safe: Box = Box(-math.inf, -math.inf, math.inf, math.inf)

    def shapes(self, line: Line, widest: float) -> list[TextBlock]:
        """The shapes that the text of a line can take, none wider than `widest` pixels."""
        text = self.letters.writable(line.text.upper() if line.manner == "sound" else line.text)
        return shapes(self.letters, text, self.size, widest) if widest > 0 else []


@dataclass(frozen=True)
class PanelText:
    """The text of a panel.

    Attributes:
        attention: see `attention_map`.
    """

    key_frame: KeyFrame
    lines: Sequence[Line]
    attention: np.ndarray


def letter(
    lay_out: Callable[[Sequence[float]], PageLayout], texts: Sequence[PanelText], style: TextStyle
) -> PageLayout:
    """Lay out panels and place their text.

    Where text does not fit, other windows of the picture and a smaller font are tried, then bands above the
    picture. If these take too much of it, the panel's wanted area grows and all is laid out again. Lines that
    do not fit in the last layout are left out, the last one first.

    Args:
        lay_out: makes a layout, given the factor on the area of each panel.
        texts: the text of each key frame.

    Returns:
        The layout with a bubble for each line in its panel.
    """
    area_scales = [1.0] * len(texts)
    for _ in range(ROUNDS - 1):
        layout = lay_out(area_scales)
        written = [_written(panel, texts[panel.key_frame], style) for panel in layout.panels]
        if None not in written:
            return replace(layout, panels=tuple(filter(None, written)))
        area_scales = [
            scale * (1.0 if found else GROWTH) for scale, found in zip(area_scales, written, strict=True)
        ]
    layout = lay_out(area_scales)
    ends = (_written_at_last(panel, texts[panel.key_frame], style) for panel in layout.panels)
    return replace(layout, panels=tuple(ends))


def _written(
    panel: Panel, text: PanelText, style: TextStyle, band: float = _BAND, busiest: float = _BUSY
) -> Panel | None:
    """The panel with its text; None if it does not fit, or only over busy parts of the picture."""
    inwards = -style.border
    # The border changes the aspect a little.
    panel = _with_picture(panel, panel.rectangle.padded(inwards, inwards, inwards), text.key_frame)
    if not text.lines:
        return panel
    found = _calmest(panel, text, style)
    if found is None:
        return _with_band(panel, text, style, band)
    return found[1] if found[0] <= busiest else None


def _with_picture(panel: Panel, picture: Rectangle, key_frame: KeyFrame) -> Panel:
    return replace(panel, picture=picture, crop=crop(key_frame, picture.aspect))


def _calmest(panel: Panel, text: PanelText, style: TextStyle) -> tuple[float, Panel] | None:
    """The first window whose bubbles cover calm parts only, or the one where they are calmest.

    Returns:
        The highest attention under a bubble, and the panel; None if the text does not fit.
    """
    least: tuple[float, Panel] | None = None
    windows = panel.crop, *shift_window(panel.crop, text.key_frame)
    for size in (style.size, round(style.size * _SMALLER)):
        for window in windows:
            bubbles = _balloons(panel, window, text, replace(style, size=size))
            if bubbles is None:
                continue
            seen = crop_attention(text.attention, text.key_frame, window)
            boxes = np.array([bubble.box for bubble in bubbles])
            covered = float(mean_under(seen, panel.picture, boxes).max())
            if least is None or covered < least[0]:
                least = covered, replace(panel, crop=window, bubbles=tuple(bubbles))
            if covered <= _CALM:
                return least
    return least


def _written_at_last(panel: Panel, text: PanelText, style: TextStyle) -> Panel:
    """The panel with as many of its first lines as fit."""
    parts = (replace(text, lines=text.lines[:count]) for count in range(len(text.lines), -1, -1))
    tried = (_written(panel, part, style, _WIDEST_BAND, np.inf) for part in parts)
    return next(filter(None, tried))


def _balloons(panel: Panel, window: Box, text: PanelText, style: TextStyle) -> list[Bubble] | None:
    picture = panel.picture
    key_frame = text.key_frame
    mouths = {map_to_page(face, window, picture): key_frame.mouth(face) for face in key_frame.faces}
    mouths = {
        face: map_point_to_page(mouth, window, picture) for face, mouth in mouths.items() if face.area > 0
    }
    air = round(_AIR * style.size)
    area = upright_area(picture, panel.leans).padded(-air, -air, -air).intersection(style.safe)
    room = FreeSpace(
        area, picture, (*mouths, *panel.insets), crop_attention(text.attention, key_frame, window)
    )
    wordings = list(_wordings(text.lines, mouths, area, style))
    return None if any(not each.blocks for each in wordings) else place(wordings, room, style.right_to_left)


def _wordings(
    lines: Sequence[Line], mouths: Mapping[Box, Point], area: Box, style: TextStyle
) -> Iterator[Wording]:
    """Each line with its speaker's face: several speakers are assumed to stand from left to right.

    Args:
        lines: of a panel.
        mouths: of each face that is seen.
        area: where words may be.
        style: of the text.
    """
    speakers = list(dict.fromkeys(line.speaker for line in lines if not line.narrated))
    across = sorted(mouths, key=lambda face: face.left, reverse=style.right_to_left)
    if len(speakers) < 2 and mouths:
        across = [max(mouths, key=lambda face: face.area)]
    of = dict(zip(speakers, across, strict=False))
    for line in lines:
        size = round(style.size * _QUIET) if line.manner == "whispered" else style.size
        blocks = replace(style, size=size).shapes(line, area.width - 2 * style.size)
        if line.narrated and line.manner != "sound":
            yield Wording("caption", blocks)
        else:
            face = None if line.narrated else of.get(line.speaker)
            yield Wording(_KINDS[line.manner], blocks, face, mouths[face] if face else None)


def _with_band(panel: Panel, text: PanelText, style: TextStyle, most: float) -> Panel | None:
    """The lines in bands above the picture, which is lower by them; None if they take too much of it."""
    inside = panel.picture
    written = upright_area(inside, panel.leans)
    found, top = list[Bubble](), inside.top
    for line in text.lines:
        blocks = style.shapes(line, written.width - round(1.2 * style.size))
        if not blocks:
            return None
        block = min(blocks, key=lambda block: len(block.lines))
        _, height = size_of("band", block)
        found.append(Bubble("band", Box(written.left, top, written.right, top + height), block))
        top += round(height - _BANDS_OVERLAP * style.size)
    picture = inside._replace(top=round(found[-1].box.bottom) + style.border)
    if picture.top - inside.top > most * inside.height:
        return None
    return replace(_with_picture(panel, picture, text.key_frame), bubbles=tuple(found))
