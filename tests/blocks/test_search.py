"""Search: words that people use find the blocks and settings that they mean."""

from __future__ import annotations

import pytest

from vidstyle.block import CATEGORIES
from vidstyle.block.absent_effects import ABSENT_EFFECTS, find_absent_effect
from vidstyle.block.search import find_blocks, find_values, is_named
from vidstyle.blocks import all_blocks
from vidstyle.style import style_names
from vidstyle.style.model import FIELDS

WORDS = """
contrast: equalize minimum_range
more contrast: equalize minimum_range
washed out: saturation minimum_range
b&w: to_gray soft_threshold
smoothing: gaussian tvf kuwahara detail
brushes: strokes etf kuwahara
pen and ink: flow_xdog flow_dog
colored pencil: pattern lic flow_xdog
hand drawn: flow_xdog pattern
skin smoothing: tvf kuwahara
brightness: brightness
lighten: brightness
darken: brightness
exposure: brightness
gamma: brightness equalize
shadows: brightness equalize minimum_range
highlights: brightness equalize minimum_range
levels: equalize
curves: equalize
saturation: saturation
vibrance: saturation
desaturate: saturation to_gray
black and white: to_gray soft_threshold
grayscale: to_gray
greyscale: to_gray
monochrome: to_gray colorize
sepia: colorize
tint: colorize hue
warm: hue colorize
temperature: hue
hue: hue
recolor: hue colorize palette
colour: saturation hue colorize to_color
color: saturation hue colorize to_color
palette: palette
duotone: colorize palette
invert: invert
negative: invert
solarize: invert
threshold: soft_threshold
outline: flow_xdog flow_dog sobel
outlines: flow_xdog flow_dog sobel
edges: sobel flow_dog flow_xdog
edge detection: sobel
contour: flow_xdog flow_dog sobel
pencil: flow_xdog pattern lic
pen: flow_xdog flow_dog pattern
ink: flow_xdog flow_dog
sketch: flow_xdog pattern
drawing: flow_xdog pattern
crayon: lic strokes
charcoal: lic
chalk: lic
hatching: pattern lic
crosshatch: pattern
engraving: line_screen
cartoon: luma_posterize kuwahara flow_xdog
comic: halftone flow_xdog
anime: kuwahara luma_posterize
toon: luma_posterize kuwahara
posterize: posterize luma_posterize
flat: posterize luma_posterize kuwahara tvf
simplify: kuwahara tvf
abstract: kuwahara tvf luma_posterize
paint: strokes kuwahara
brush: strokes kuwahara
brush strokes: strokes
oil: kuwahara
oil painting: kuwahara strokes
watercolor: kuwahara tvf
watercolour: kuwahara tvf
impressionist: strokes
canvas: relief noise
paper: noise paper
texture: noise relief
grain: noise
noise: noise gaussian tvf
film: noise
denoise: tvf gaussian
smooth: gaussian tvf
soften: gaussian tvf
blur: gaussian
sharpen: detail
sharp: detail
unsharp mask: detail
detail: detail
clarity: detail
glow: gaussian blend
bloom: gaussian blend
neon: sobel
vignette:
dark corners:
dots: halftone dither strokes
halftone: halftone
newspaper: halftone
print: halftone overprint
pixelate: pixelate
pixel art: pixelate
mosaic: mosaic
stained glass: mosaic
tiles: mosaic
dither: dither
8-bit: pixelate dither palette
ascii: glyphs
text: glyphs
vhs: shift
old tv: line_screen shift
scanlines: line_screen
glitch: shift
chromatic aberration: shift
wobble: shift
resize: scale
blend: blend
mix: blend strength
mask: only keep blend
face: focus only
background: only keep
depth of field: gaussian
mirror:
motion blur:
flicker: steady
trail:
swirl: etf
emboss: relief
woodcut: line_screen soft_threshold flow_xdog
linocut: line_screen soft_threshold flow_xdog
stippling: dither strokes
points: strokes
"""
"""Words written down before looking at any block, with the blocks and fields that are meant by them. Nothing
is meant by words for effects that no block has."""
MIN_FOUND_SHARE = 0.95
MAX_PLACE = 4
"""Number of results within which the meant one must be."""


def read_words() -> dict[str, set[str]]:
    lines = (line.partition(":") for line in WORDS.strip().splitlines())
    return {word: set(meant.split()) for word, _, meant in lines}


def test_most_words_of_laypeople_find_what_they_mean() -> None:
    words = read_words()
    assert len(words) > 100
    found = {
        word: {*find_blocks(word, all_blocks())[:MAX_PLACE], *find_values(word, FIELDS)} for word in words
    }
    missed = {word: sorted(found[word]) for word, meant in words.items() if not meant & found[word]}
    assert len(missed) <= (1 - MIN_FOUND_SHARE) * len(words), missed


@pytest.mark.parametrize("spelling", ["Halftone dots", "HALFTONE-DOTS", "halftone", "half", "dots halftone"])
def test_spellings_of_a_name_find_the_same_block_first(spelling: str) -> None:
    assert find_blocks(spelling, all_blocks())[0] == "halftone"


def test_names_of_blocks_and_fields_find_them_first() -> None:
    assert {name for name in all_blocks() if find_blocks(name, all_blocks())[0] != name} <= {"hue", "network"}
    assert all(find_blocks(block.label, all_blocks())[0] == name for name, block in all_blocks().items())
    assert all(find_values(field.label, FIELDS)[0] == name for name, field in FIELDS.items())


def test_effects_that_no_block_has_name_what_comes_nearest() -> None:
    effect = find_absent_effect("with a dark vignette frame")
    assert effect is None, "only of nothing else"
    for effect in ABSENT_EFFECTS:
        assert set(effect.nearest) <= all_blocks().keys() and set(effect.values) <= FIELDS.keys()
        assert effect.nearest or effect.values
        assert set(effect.styles) <= set(style_names()) and "Closest" not in effect.advice
        for word in effect.words.split(", "):
            assert find_absent_effect(word.title()) is effect
            named = {
                name for name, block in all_blocks().items() if word in (block.label.lower(), *block.aliases)
            }
            assert not named - {"shift"} - set(effect.nearest), f"{word}: a block claims it"
    toon = find_absent_effect("toon")
    assert toon is not None and toon.advice == "It takes several steps. Styles with it: cartoon, comic."
    assert find_absent_effect("shaky") is not None and "shift" not in find_blocks("shaky", all_blocks())


@pytest.mark.parametrize(
    ("word", "block"),
    [("sharpen", "detail"), ("outline", "flow_xdog"), ("dots", "halftone"), ("skin", "tvf")],
)
def test_the_step_that_a_word_means_comes_first(word: str, block: str) -> None:
    assert find_blocks(word, all_blocks())[0] == block


def test_words_that_name_no_step_are_told_from_those_that_do() -> None:
    assert all(is_named(word, all_blocks(), FIELDS) for word in ("blur", "outlines", "flicker", "dot size"))
    assert not any(is_named(word, all_blocks(), FIELDS) for word in ("shaky picture", "velvet", "furry cat"))


def test_blocks_and_values_of_the_program_have_plain_names() -> None:
    blocks = all_blocks().values()
    labels = [block.label for block in blocks]
    assert len(set(labels)) == len(labels)
    assert {block.category for block in blocks} == set(CATEGORIES)
    assert not [block.name for block in blocks if not block.aliases or block.label == block.name]
    values = [(block.name, value) for block in blocks for value in block.parameters.values()]
    values += [("style", value) for value in FIELDS.values()]
    assert not [(owner, value.name) for owner, value in values if not value.control.label]
    for owner, value in values:
        assert value.label[0].isupper() and not value.label.endswith("."), (owner, value.label)
