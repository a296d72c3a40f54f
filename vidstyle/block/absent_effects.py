"""Effects that no block has, by the words that people use for them, and what comes nearest."""

from __future__ import annotations

from dataclasses import dataclass

from vidstyle.block.search import is_described_by


@dataclass(frozen=True)
class AbsentEffect:
    """An effect that people search in vain.

    Attributes:
        words: what they type, separated by commas.
        note: a sentence about it.
        nearest: the blocks that come nearest.
        values: the fields of a style that come nearest.
    """

    words: str
    note: str
    nearest: tuple[str, ...] = ()
    values: tuple[str, ...] = ()


ABSENT_EFFECTS = (
    AbsentEffect(
        "vignette, dark edges, dark corners, round corners, frame, border, photo frame, picture frame",
        "No block darkens corners or draws a frame. These change the light, inside a mask if you like.",
        ("brightness", "local_exposure"),
        ("only",),
    ),
    AbsentEffect(
        "shaky, shake, shaky camera, wobbly camera, camera shake, stabilize camera, stabilise",
        "No block holds a shaky camera still. Steadiness calms what flickers in a style.",
        (),
        ("steady",),
    ),
    AbsentEffect(
        "crop, cut, trim, rotate, mirror, flip, zoom in, straighten, aspect ratio",
        "Blocks keep the frame as it is: `vidstyle render` crops time, and has --size and --rotate.",
        ("scale",),
    ),
    AbsentEffect(
        "motion, motion blur, slow motion, slow, fast, time lapse, trails, reverse",
        "No block changes time or follows motion. Grain and shifted colours change at their own rate.",
        ("noise", "shift"),
    ),
    AbsentEffect(
        "sky, sunset, sunrise, golden hour, replace sky, clouds in the sky",
        "No block replaces a sky. These give a picture other colours.",
        ("colorize", "gradient", "hue"),
    ),
    AbsentEffect(
        "rain, snow, sparkle, sparkles, glitter, fire, smoke, lens flare, particles",
        "No block adds things to a picture. Grain adds spots.",
        ("noise",),
    ),
    AbsentEffect(
        "text, subtitle, caption, title, speech bubble, logo, watermark, sticker, emoji",
        "No block writes on a picture; `vidstyle comic` letters balloons. Letters draws in letters.",
        ("glyphs",),
    ),
    AbsentEffect(
        "blur background, blurred background, background blur, bokeh, depth of field, portrait mode",
        "No block knows what is near. Blur inside a mask leaves the rest sharp.",
        ("gaussian", "kuwahara"),
    ),
    AbsentEffect(
        "cartoon, cartoonish, cartoony, toon, anime",
        "Such a look takes several steps: open the style Cartoon or Comic, or combine these.",
        ("luma_posterize", "kuwahara", "flow_xdog", "tvf"),
    ),
    AbsentEffect(
        "vintage, old film, old movie, old photo, antique, aged",
        "Such a look takes several steps, or the style VHS or Noir. These are its parts.",
        ("colorize", "noise", "saturation", "gaussian"),
    ),
    AbsentEffect(
        "beauty, remove wrinkles, wrinkles, make up, makeup, slim, age, young",
        "No block knows faces. These smooth skin; Detail in faces keeps features.",
        ("tvf", "detail"),
        ("focus",),
    ),
)


def find_absent_effect(text: str) -> AbsentEffect | None:
    """Return the absent effect that a text names, if any.

    >>> find_absent_effect("Vignette") is ABSENT_EFFECTS[0], find_absent_effect("blur")
    (True, None)
    """
    for effect in ABSENT_EFFECTS:
        if is_described_by(text, effect.words.split(", ")):
            return effect
    return None
