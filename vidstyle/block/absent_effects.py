"""Effects that no block has, by the words that people use for them, and what comes nearest."""

from __future__ import annotations

from dataclasses import dataclass

from vidstyle.block.search import is_described_by


@dataclass(frozen=True)
class AbsentEffect:
    """An effect that people search in vain.

    Attributes:
        words: what they type, separated by commas.
        note: sentences about what comes nearest.
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
        "Closest: these change the light, inside a mask if you like.",
        ("brightness", "local_exposure"),
        ("only",),
    ),
    AbsentEffect(
        "shaky, shake, shaky camera, wobbly camera, camera shake, stabilize camera, stabilise",
        "Closest: Steadiness calms what flickers; Shift colours has a Wobble. Nothing holds it still.",
        ("shift",),
        ("steady",),
    ),
    AbsentEffect(
        "crop, cut, trim, rotate, mirror, flip, zoom in, straighten, aspect ratio",
        "Steps keep the frame as it is: `vidstyle render` crops time, and has --size and --rotate.",
        ("scale",),
    ),
    AbsentEffect(
        "motion, motion blur, slow motion, slow, fast, time lapse, trails, reverse",
        "Closest: Grain and Shift colours change at their own rate. Nothing changes time or follows motion.",
        ("noise", "shift"),
    ),
    AbsentEffect(
        "sky, sunset, sunrise, golden hour, replace sky, clouds in the sky",
        "Closest: these give a picture other colours. Nothing replaces a sky.",
        ("colorize", "gradient", "hue"),
    ),
    AbsentEffect(
        "rain, snow, sparkle, sparkles, glitter, fire, smoke, lens flare, particles",
        "Closest: Grain adds spots. Nothing adds things that fall or fly.",
        ("noise",),
    ),
    AbsentEffect(
        "text, subtitle, caption, title, speech bubble, logo, watermark, sticker, emoji",
        "Closest: Letters draws the picture in letters; `vidstyle comic` letters balloons.",
        ("glyphs",),
    ),
    AbsentEffect(
        "blur background, blurred background, background blur, bokeh, depth of field, portrait mode",
        "Closest: Blur, with a mask in Keep original inside for what stays sharp.",
        ("gaussian", "kuwahara"),
        ("keep",),
    ),
    AbsentEffect(
        "background, remove background, change background, foreground",
        "Closest: a mask decides where the style applies. One of people is ready.",
        (),
        ("only", "keep"),
    ),
    AbsentEffect(
        "glow, glowing, soft glow, bloom, halo, shine, light leak",
        "Closest: Blur, then Blend pictures in the mode screen. Edge detection makes glowing tubes.",
        ("gaussian", "blend", "sobel"),
    ),
    AbsentEffect(
        "fog, foggy, mist, misty, haze, hazy",
        "Closest: Blur softens and Colour strength pales; Contrast boost takes haze away.",
        ("gaussian", "saturation", "minimum_range"),
    ),
    AbsentEffect(
        "scratches, scratched, scratch, scratched film, hairs, dust and scratches",
        "Closest: Grain adds specks, longer ones with Grain stretch; Shift colours makes rows wobble.",
        ("noise", "shift"),
    ),
    AbsentEffect(
        "cartoon, cartoonish, cartoony, toon, anime",
        "It takes several: open the style Cartoon or Comic, or combine these.",
        ("luma_posterize", "kuwahara", "flow_xdog", "tvf"),
    ),
    AbsentEffect(
        "vintage, old film, old movie, old photo, antique, aged",
        "It takes several, or the style VHS or Noir: these are its parts.",
        ("colorize", "noise", "saturation", "gaussian"),
    ),
    AbsentEffect(
        "smooth skin, beauty, remove wrinkles, wrinkles, make up, makeup, slim, young",
        "Closest: these smooth skin; Detail in faces keeps eyes and mouths.",
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
