"""The colours of a picture in plain words."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.explore.colors import oklab
from vidstyle.explore.measure import luma_of_codes, oklab_thumbnail

HUE_WORDS = (
    (15, "pink"),
    (45, "red"),
    (85, "orange"),
    (120, "yellow"),
    (165, "green"),
    (215, "turquoise"),
    (280, "blue"),
    (320, "purple"),
    (360, "pink"),
)
"""Words for hues of Oklab, each up to an angle in degrees."""
MIN_BLACK_AND_WHITE_RATIO = 0.8
"""Share of nearly black and nearly white pixels of a gray picture that is called black and white."""
MAX_BLACK_LEVEL, MIN_WHITE_LEVEL = 0.2, 0.8
MAX_GRAY_CHROMA, MAX_SEPIA_CHROMA, MIN_VIVID_CHROMA = 0.012, 0.05, 0.065
"""Mean chroma of a picture without colours, of orange or yellow called sepia, and of vivid colours."""
MIN_ONE_HUE = 0.9
"""Length of the mean colour vector, relative to the mean chroma, of a picture in one hue."""
MAX_NEUTRAL_CHROMA, MIN_ACCENT_CHROMA = 0.02, 0.06
"""Chroma of pixels without a colour, and of an accent, a colour in a gray picture."""
MIN_NEUTRAL_SHARE, MIN_ACCENT_SHARE = 0.8, 0.008
"""Shares of such pixels in a picture with an accent."""
TONE_SIDE_PX, TONE_COUNT = 64, 16
"""Number of pixels in each direction that are looked at for two tones, and of their groups by lightness."""
MIN_TWO_TONE_SHARES = (0.75, 0.9)
"""Share of the variance of colours that lightness explains in a picture of two tones: with several hues, and
with one. Chosen by eye on 60 looks of 3 photographs, where others had at most 0.68."""
MAX_DARK_LIGHTNESS, MIN_PALE_LIGHTNESS = 0.35, 0.82
MIN_HUE_CHROMA, MIN_HUE_CHANGE_RATIO = 0.03, 0.75
"""Chroma of a mean colour that has a hue, and its change, relative to its chroma, that makes another hue: 45
degrees, or most of the colour."""
MAX_BROWN_LIGHTNESS = 0.45
"""Lightness below which red, orange and yellow are called brown."""


def color_words(picture: np.ndarray) -> str:
    """Return the colours of a picture, such as "dark blue", "cream on green" or "vivid colours"."""
    colors = oklab_thumbnail(picture).reshape(-1, 3)
    chroma = np.hypot(colors[:, 1], colors[:, 2])
    accent = _accent(colors, chroma)
    if accent or chroma.mean() < MAX_GRAY_CHROMA:
        luma = luma_of_codes(picture)
        ends = float(((luma <= MAX_BLACK_LEVEL) | (luma >= MIN_WHITE_LEVEL)).mean())
        gray = "black and white" if ends >= MIN_BLACK_AND_WHITE_RATIO else "gray"
        return f"{gray} with {accent}" if accent else gray
    is_one_hue = _is_one_hue(colors, chroma)
    tones = _two_tones(picture, MIN_TWO_TONE_SHARES[is_one_hue])
    if tones and tones[0].split()[-1] != tones[1].split()[-1]:
        return " on ".join(tones)
    if is_one_hue:
        hue = _hue_word(colors)
        is_sepia = hue in ("orange", "yellow") and chroma.mean() < MAX_SEPIA_CHROMA
        return _shade_word(colors) + ("sepia" if is_sepia else hue)
    vivid = "vivid colours" if chroma.mean() > MIN_VIVID_CHROMA else "muted colours"
    return _shade_word(colors) + vivid


def has_other_colors(picture: np.ndarray, before: np.ndarray) -> bool:
    """Return whether the mean hue of a picture is another one, or only one of the two pictures has a hue."""
    now, then = (oklab_thumbnail(each)[..., 1:].mean((0, 1)) for each in (picture, before))
    strongest = max(float(np.hypot(*now)), float(np.hypot(*then)))
    return strongest > MIN_HUE_CHROMA and float(np.hypot(*(now - then))) > MIN_HUE_CHANGE_RATIO * strongest


def _is_one_hue(colors: np.ndarray, chroma: np.ndarray) -> bool:
    return float(np.hypot(*colors[:, 1:].mean(0))) >= MIN_ONE_HUE * float(chroma.mean())


def _hue_word(colors: np.ndarray) -> str:
    """Return the word for the mean hue of colours in Oklab, N x 3."""
    _, green_red, blue_yellow = colors.mean(0)
    angle = np.degrees(np.arctan2(blue_yellow, green_red)) % 360
    return next(word for end, word in HUE_WORDS if angle <= end)


def _shade_word(colors: np.ndarray) -> str:
    light = float(colors[:, 0].mean())
    return "dark " if light < MAX_DARK_LIGHTNESS else "pale " if light > MIN_PALE_LIGHTNESS else ""


def _accent(colors: np.ndarray, chroma: np.ndarray) -> str:
    """Return the hue, or "colours" if several, of an accent in a gray picture; "" if there is none."""
    strong = chroma > MIN_ACCENT_CHROMA
    if (chroma < MAX_NEUTRAL_CHROMA).mean() < MIN_NEUTRAL_SHARE or strong.mean() < MIN_ACCENT_SHARE:
        return ""
    return _hue_word(colors[strong]) if _is_one_hue(colors[strong], chroma[strong]) else "colours"


def _two_tones(picture: np.ndarray, min_share: float) -> tuple[str, str] | None:
    """Return both colours, the ground last, of a picture whose colours follow its lightness; else None."""
    # Single pixels: means would mix the colours of dots and lines.
    pixels = cv2.resize(picture, (TONE_SIDE_PX, TONE_SIDE_PX), interpolation=cv2.INTER_NEAREST)
    colors = oklab(pixels / 255.0).reshape(-1, 3)
    tones = np.array_split(colors[np.argsort(colors[:, 0], kind="stable")], TONE_COUNT)
    left = sum(float(((tone[:, 1:] - tone[:, 1:].mean(0)) ** 2).sum()) for tone in tones)
    if left > (1 - min_share) * float(((colors[:, 1:] - colors[:, 1:].mean(0)) ** 2).sum()):
        return None
    dark, light = tones[0], tones[-1]
    is_light_ground = np.median(colors[:, 0]) > (dark[:, 0].mean() + light[:, 0].mean()) / 2
    words = _tone_word(dark), _tone_word(light)
    return words if is_light_ground else words[::-1]


def _tone_word(colors: np.ndarray) -> str:
    """Return the word for one tone, such as "black", "cream" or "dark blue"."""
    light, *chroma = colors.mean(0)
    strength = float(np.hypot(*chroma))
    if strength < MAX_NEUTRAL_CHROMA:
        return "black" if light < MAX_DARK_LIGHTNESS else "white" if light > MIN_PALE_LIGHTNESS else "gray"
    hue = _hue_word(colors)
    is_cream = hue in ("orange", "yellow") and strength < MAX_SEPIA_CHROMA and light > MIN_PALE_LIGHTNESS
    is_brown = hue in ("red", "orange", "yellow") and light < MAX_BROWN_LIGHTNESS
    return "cream" if is_cream else "brown" if is_brown else _shade_word(colors) + hue
