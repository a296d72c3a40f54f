"""The style of everything except people, from a short text."""

from __future__ import annotations

from dataclasses import replace

from vidstyle.block import Color
from vidstyle.errors import StyleError, UsageError
from vidstyle.style import load_style, style_names
from vidstyle.style.mask_declarations import BACKDROP, BACKGROUND
from vidstyle.style.model import SOURCE, Step, Style

BLUR = "blur"
BLUR_SIGMA_PX, BLUR_HEIGHT_PX = 12.0, 720.0
"""Standard deviation of the blur, in a picture of this height."""
_BLUR_FACTOR = 0.25
_BLUR_GAUSSIAN = {"sigma": BLUR_SIGMA_PX * _BLUR_FACTOR}
_BLUR_STEPS = (
    Step("scale", {"factor": _BLUR_FACTOR}, source=BACKGROUND),
    Step("gaussian", _BLUR_GAUSSIAN, save="seen"),
    Step("scale", {"factor": _BLUR_FACTOR, "back": "bilinear"}, source=SOURCE),
    Step("blend", {"other": BACKGROUND, "mode": "multiply", "opacity": 1.0}),
    Step("gaussian", _BLUR_GAUSSIAN),
    Step("blend", {"other": "seen", "mode": "divide", "opacity": 1.0}),
)
"""In a smaller picture, which is several times as fast and looks the same. People are left out of the blur:
else they would glow around their outline (normalized convolution, Knutsson and Westin 1993)."""


def style_behind(text: str) -> Style:
    """Return the style that a text names: "blur", "backdrop", a colour, or a style as for `load_style`.

    Raises:
        UsageError: the style declares masks.
        StyleError: there is no such style, or it has mistakes.
    """
    if text == BACKDROP:
        return Style(BACKDROP, background=(Step("", source=BACKDROP),))
    if text == BLUR:
        return Style(BLUR, height=BLUR_HEIGHT_PX, background=_BLUR_STEPS)
    color = _color(text) if text not in style_names() else None
    if color is not None:
        # Lines without ink show the paper.
        return Style(text, paper=color, lines=(Step("soft_threshold", {"epsilon": 0.0}),))
    try:
        style = load_style(text)
    except StyleError as error:
        hint = f"a background is {BLUR}, a colour such as #00b140, a picture, a film or a style"
        raise StyleError(error.subject, [*error.mistakes, hint]) from None
    if style.masks:
        raise UsageError(text, "declares masks", "use it as --style, and the other style as --background")
    return replace(
        style,
        steady=0.0,
        focus=Style.focus,
        kinds=(),
        aliases="",
        knobs=(),
        labels={},
        variants={},
        masks={},
        behind=None,
        note="",
    )


def _color(text: str) -> str | None:
    try:
        return Color("").check(text, False)
    except ValueError:
        return None
