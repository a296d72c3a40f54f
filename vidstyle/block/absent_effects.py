"""Effects that no block has, by the words that people use for them, and what comes nearest."""

from __future__ import annotations

from dataclasses import dataclass

from vidstyle.block.search import is_described_by


@dataclass(frozen=True)
class AbsentEffect:
    """An effect that people search for and that vidstyle does not have.

    Attributes:
        words: search terms, separated by commas.
        note: an explanation of the alternatives.
        nearest: the closest blocks.
        values: the closest fields of a style.
        styles: the styles that have the effect.
    """

    words: str
    note: str
    nearest: tuple[str, ...] = ()
    values: tuple[str, ...] = ()
    styles: tuple[str, ...] = ()

    @property
    def advice(self) -> str:
        """The note, and the styles that have the effect."""
        return f"{self.note} Styles with it: {', '.join(self.styles)}." if self.styles else self.note


ABSENT_EFFECTS = (
    AbsentEffect(
        "vignette, dark edges, dark corners, round corners, frame, border, photo frame, picture frame",
        "Brightness changes the light, inside a mask if you like.",
        ("brightness", "local_exposure"),
        ("only",),
    ),
    AbsentEffect(
        "shaky, shake, shaky camera, wobbly camera, camera shake, stabilize camera, stabilise",
        "Steadiness reduces flicker; Shift colours has a Wobble. Nothing stabilizes a camera.",
        ("shift",),
        ("steady",),
    ),
    AbsentEffect(
        "crop, cut, trim, rotate, mirror, flip, zoom in, straighten, aspect ratio",
        "No step crops or cuts: `vidstyle render` has --start, --end, --size and --rotate.",
        ("scale",),
    ),
    AbsentEffect(
        "motion, motion blur, slow motion, slow, fast, time lapse, trails, reverse",
        "Grain and Shift colours change at their own rate. Nothing changes time or follows motion.",
        ("noise", "shift"),
    ),
    AbsentEffect(
        "sky, sunset, sunrise, golden hour, replace sky, clouds in the sky",
        "Steps change colours, inside a mask if you like. Nothing replaces a sky.",
        ("colorize", "gradient", "hue"),
    ),
    AbsentEffect(
        "rain, snow, sparkle, sparkles, glitter, fire, smoke, lens flare, particles",
        "Grain adds spots. Nothing adds falling or flying things.",
        ("noise",),
    ),
    AbsentEffect(
        "text, subtitle, caption, title, speech bubble, logo, watermark, sticker, emoji",
        "Letters draws the picture in letters; `vidstyle comic` adds speech balloons.",
        ("glyphs",),
    ),
    AbsentEffect(
        "blur background, blurred background, background blur, bokeh, depth of field, portrait mode",
        "Use Blur, and select in Keep original inside what stays sharp.",
        ("gaussian", "kuwahara"),
        ("keep",),
    ),
    AbsentEffect(
        "background, remove background, change background, foreground",
        "A mask selects where the style applies; a mask of people is built in.",
        (),
        ("only", "keep"),
    ),
    AbsentEffect(
        "glow, glowing, soft glow, bloom, halo, shine, light leak",
        "Use Blur, then Blend pictures in the mode screen. Edge detection makes glowing tubes.",
        ("gaussian", "blend", "sobel"),
    ),
    AbsentEffect(
        "fog, foggy, mist, misty, haze, hazy",
        "Blur softens, Colour strength makes colours pale, and Contrast boost removes haze.",
        ("gaussian", "saturation", "minimum_range"),
    ),
    AbsentEffect(
        "scratches, scratched, scratch, scratched film, hairs, dust and scratches",
        "Grain adds specks, longer ones with Grain stretch; Shift colours makes rows wobble.",
        ("noise", "shift"),
    ),
    AbsentEffect(
        "cartoon, cartoonish, cartoony, toon, anime",
        "It takes several steps.",
        ("luma_posterize", "kuwahara", "flow_xdog", "tvf"),
        styles=("cartoon", "comic"),
    ),
    AbsentEffect(
        "vintage, old film, old movie, old photo, antique, aged",
        "It takes several steps.",
        ("colorize", "noise", "saturation", "gaussian"),
        styles=("vhs", "noir"),
    ),
    AbsentEffect(
        "smooth skin, beauty, remove wrinkles, wrinkles, make up, makeup, slim, young",
        "Flatten texture smooths skin; Detail in faces keeps eyes and mouths.",
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
