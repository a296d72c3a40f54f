"""Lettering: text is placed in panels, and panels change if it does not fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.comic.analyze.saliency import crop_attention, mean_under
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.crop import crop, map_point_to_page, map_to_page, shift_window
from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.layout.slant import upright_area
from vidstyle.comic.lettering.balloons import FreeSpace, Wording, place_bubbles
from vidstyle.comic.lettering.bubble import Bubble, BubbleKind, TextBlock, break_text, bubble_size
from vidstyle.comic.lettering.dialogue import ANSWERING_VOICE, find_voices
from vidstyle.comic.lettering.fonts import Letters
from vidstyle.comic.lettering.subtitle_lines import Line, Manner
from vidstyle.regions.boxes import Box, Point, Rectangle

# Panels whose text does not fit.
TEXT_AREA_FACTOR = 1.6
"""Factor on the wanted area of such a panel."""
MAX_LAYOUT_ROUNDS = 3
"""Maximum number of layouts tried."""
_SMALL_FONT_RATIO = 0.85
"""Factor on the font size if there is little room."""
_CALM_ATTENTION_LEVEL, _MAX_ATTENTION_LEVEL = 1.0, 1.5
"""Attention under a bubble: up to the first no other window is tried, above the second the panel grows."""
_MAX_BAND_SHARE, _MAX_LAST_BAND_SHARE = 0.3, 0.55
"""Maximum share of a panel for bands above its picture, and in the last round."""

# The speaker, and what text must not cover.
_MIN_SPEAKER_AREA_RATIO = 1.3
"""Area of a single speaker's face relative to the next one: faces of one size may both be speaking."""
_MIN_SPEAKER_HEIGHT_RATIO = 1 / 3
"""Minimum height of a speaker's face relative to the largest one: others are far away, or no faces."""
_MAX_KEPT_SUBJECT_SHARE = 0.35
"""Share of a panel up to which its moving subject stays clear of text."""

# The look of text, in font sizes.
_WHISPER_FONT_RATIO = 0.85
"""Font size of whispers."""
_BORDER_DISTANCE_RATIO = 0.35
"""Distance between bubbles and the border."""
_BAND_OVERLAP_RATIO = 0.3
"""Overlap of neighbouring bands."""
_BUBBLE_KINDS: dict[Manner, BubbleKind] = {
    "said": "balloon",
    "shouted": "burst",
    "whispered": "whisper",
    "thought": "cloud",
    "sound": "caption",
}


@dataclass(frozen=True)
class TextStyle:
    """Text settings.

    Attributes:
        letters: the font.
        size: font size in pixels.
        border: width of panel borders in pixels.
        right_to_left: reading order.
        safe: the part of a page that may contain text.
    """

    letters: Letters
    size: int
    border: int
    right_to_left: bool = False
    safe: Box = Box(-math.inf, -math.inf, math.inf, math.inf)

    def break_line(self, line: Line, widest: float) -> list[TextBlock]:
        """Return the line breaks that the text of a line can take, none wider than `widest` pixels."""
        text = self.letters.make_writable(line.text.upper() if line.manner == "sound" else line.text)
        return break_text(self.letters, text, self.size, widest) if widest > 0 else []


@dataclass(frozen=True)
class PanelText:
    """The text of a panel.

    Attributes:
        attention: see `attention_map`.
    """

    key_frame: KeyFrame
    lines: Sequence[Line]
    attention: np.ndarray


def letter_panels(
    lay_out: Callable[[Sequence[float]], PageLayout], texts: Sequence[PanelText], style: TextStyle
) -> PageLayout:
    """Lay out panels and place their text.

    If text does not fit, other windows of the picture and a smaller font are tried, then bands above the
    picture. If these take too much of it, the panel's wanted area grows and the layout is repeated. Lines
    that do not fit in the last layout are omitted, the last one first.

    Args:
        lay_out: makes a layout, given the factor on the area of each panel.
        texts: the text of each key frame.
        style: of the text.

    Returns:
        The layout with a bubble for each line in its panel.
    """
    area_scales = [1.0] * len(texts)
    for _ in range(MAX_LAYOUT_ROUNDS - 1):
        layout = lay_out(area_scales)
        written = [_add_text(panel, texts[panel.key_frame], style) for panel in layout.panels]
        if None not in written:
            return replace(layout, panels=tuple(filter(None, written)))
        area_scales = [
            scale * (1.0 if found else TEXT_AREA_FACTOR)
            for scale, found in zip(area_scales, written, strict=True)
        ]
    layout = lay_out(area_scales)
    ends = (_add_fitting_text(panel, texts[panel.key_frame], style) for panel in layout.panels)
    return replace(layout, panels=tuple(ends))


def _add_text(
    panel: Panel,
    text: PanelText,
    style: TextStyle,
    band: float = _MAX_BAND_SHARE,
    busiest: float = _MAX_ATTENTION_LEVEL,
) -> Panel | None:
    """Add its text to a panel; None if it does not fit, or only over busy parts of the picture."""
    inwards = -style.border
    # The border changes the aspect a little.
    panel = _set_picture(panel, panel.rectangle.padded(inwards, inwards, inwards), text.key_frame)
    if not text.lines:
        return panel
    found = _find_calmest(panel, text, style)
    if found is None:
        return _add_bands(panel, text, style, band)
    return found[1] if found[0] <= busiest else None


def _set_picture(panel: Panel, picture: Rectangle, key_frame: KeyFrame) -> Panel:
    return replace(panel, picture=picture, crop=crop(key_frame, picture.aspect))


def _find_calmest(panel: Panel, text: PanelText, style: TextStyle) -> tuple[float, Panel] | None:
    """Return the first window whose bubbles cover only calm parts, or else the calmest window.

    A window in which fewer balloons lack a tail comes first, as readers cannot tell who speaks.

    Returns:
        The highest attention under a bubble, and the panel; None if the text does not fit.
    """
    least: tuple[tuple[int, float], Panel] | None = None
    answers = find_voices(text.lines).count(ANSWERING_VOICE)
    windows = panel.crop, *shift_window(panel.crop, text.key_frame)
    for size in (style.size, round(style.size * _SMALL_FONT_RATIO)):
        for window in windows:
            bubbles = _place_balloons(panel, window, text, replace(style, size=size))
            if bubbles is None:
                continue
            seen = crop_attention(text.attention, text.key_frame, window)
            boxes = np.array([bubble.box for bubble in bubbles])
            covered = float(mean_under(seen, panel.picture, boxes).max())
            lacking = sum(each.kind == "balloon" and each.tip is None for each in bubbles)
            cost = max(0, lacking - answers), covered
            if least is None or cost < least[0]:
                least = cost, replace(panel, crop=window, bubbles=tuple(bubbles))
            if cost <= (0, _CALM_ATTENTION_LEVEL):
                return covered, least[1]
    return (least[0][1], least[1]) if least else None


def _add_fitting_text(panel: Panel, text: PanelText, style: TextStyle) -> Panel:
    """Add the first lines that fit to a panel."""
    parts = (replace(text, lines=text.lines[:count]) for count in range(len(text.lines), -1, -1))
    tried = (_add_text(panel, part, style, _MAX_LAST_BAND_SHARE, np.inf) for part in parts)
    return next(filter(None, tried))


def _place_balloons(panel: Panel, window: Box, text: PanelText, style: TextStyle) -> list[Bubble] | None:
    picture = panel.picture
    key_frame = text.key_frame
    mouths = {map_to_page(face, window, picture): key_frame.mouth(face) for face in key_frame.faces}
    mouths = {
        face: map_point_to_page(mouth, window, picture) for face, mouth in mouths.items() if face.area > 0
    }
    air = round(_BORDER_DISTANCE_RATIO * style.size)
    area = upright_area(picture, panel.leans).padded(-air, -air, -air).intersection(style.safe)
    kept = (*mouths, *panel.insets, *_clear_subject(key_frame, window, picture))
    room = FreeSpace(area, picture, kept, crop_attention(text.attention, key_frame, window))
    wordings = list(_wordings(text.lines, mouths, area, style))
    return (
        None
        if any(not each.blocks for each in wordings)
        else place_bubbles(wordings, room, style.right_to_left)
    )


def _clear_subject(key_frame: KeyFrame, window: Box, picture: Rectangle) -> Iterator[Box]:
    """Yield the visible part of the moving subject, if it leaves room for text."""
    if key_frame.subject is not None and not key_frame.faces:
        shown = map_to_page(key_frame.subject, window, picture)
        if 0 < shown.area <= _MAX_KEPT_SUBJECT_SHARE * picture.area:
            yield shown


def _wordings(
    lines: Sequence[Line], mouths: Mapping[Box, Point], area: Box, style: TextStyle
) -> Iterator[Wording]:
    """Yield each line with its speaker's face; a line without one is a caption, unless it is loud or thought.

    Several speakers are assumed to stand from left to right, if there are as many people. An answer by
    someone who is not shown is a balloon without a tail.

    Args:
        lines: of a panel.
        mouths: of each visible face.
        area: where text may be placed.
        style: of the text.
    """
    voices = find_voices(lines)
    speakers = list(
        dict.fromkeys(voice for line, voice in zip(lines, voices, strict=True) if not line.narrated)
    )
    least = _MIN_SPEAKER_HEIGHT_RATIO * max((face.height for face in mouths), default=0.0)
    near = [face for face in mouths if face.height >= least]
    across = sorted(near, key=lambda face: face.left, reverse=style.right_to_left)
    is_known = 1 < len(speakers) <= len(across) and ANSWERING_VOICE not in speakers
    of = dict(zip(speakers, across if is_known else _only_speaker(mouths), strict=False))
    for line, voice in zip(lines, voices, strict=True):
        size = round(style.size * _WHISPER_FONT_RATIO) if line.manner == "whispered" else style.size
        blocks = replace(style, size=size).break_line(line, area.width - 2 * style.size)
        face = None if line.narrated else of.get(voice)
        if face is None and of and voice == ANSWERING_VOICE and line.manner == "said":
            yield Wording("balloon", blocks)
        elif face is None and (line.manner == "said" or line.narrated and line.manner != "sound"):
            yield Wording("caption", blocks)
        else:
            yield Wording(_BUBBLE_KINDS[line.manner], blocks, face, mouths[face] if face else None)


def _only_speaker(mouths: Mapping[Box, Point]) -> list[Box]:
    """Return the face of a single speaker, if there is no other of about its size, who may be speaking."""
    faces = sorted(mouths, key=lambda face: -face.area)
    if len(faces) > 1 and faces[0].area < _MIN_SPEAKER_AREA_RATIO * faces[1].area:
        return []
    return faces[:1]


def _add_bands(panel: Panel, text: PanelText, style: TextStyle, most: float) -> Panel | None:
    """Place the lines in bands above the picture, which gets lower; None if they take too much of it."""
    inside = panel.picture
    written = upright_area(inside, panel.leans)
    found, top = list[Bubble](), inside.top
    for line in text.lines:
        blocks = style.break_line(line, written.width - round(1.2 * style.size))
        if not blocks:
            return None
        block = min(blocks, key=lambda block: len(block.lines))
        _, height = bubble_size("band", block)
        found.append(Bubble("band", Box(written.left, top, written.right, top + height), block))
        top += round(height - _BAND_OVERLAP_RATIO * style.size)
    picture = inside._replace(top=round(found[-1].box.bottom) + style.border)
    if picture.top - inside.top > most * inside.height:
        return None
    return replace(_set_picture(panel, picture, text.key_frame), bubbles=tuple(found))
