"""GPU results agree with CPU results: every block at every setting, every style, in both forms of passes.

Settings are combined in pairs at one size, a third of them each day; `-m thorough` tests each at all sizes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from block_settings import block_style, ends_of, settings
from block_settings import folder as folder
from covering import covering_rows, drawn, of_the_day
from gpu import FORMS, ODD, SHAPES, SMALL, Sessions, faults, film_picture, gray_picture
from pictures import FLOAT, noise, run_luma, step, style

from vidstyle.block import Asset, Block, SavedRef, Slider
from vidstyle.blocks import all_blocks
from vidstyle.core.picture import Encoding, Picture
from vidstyle.gpu.compile.glsl import Form
from vidstyle.style import Step, load_style, style_names

MakePicture = Callable[[int, int], Picture]


sessions = Sessions.fixture()


def all_settings(block: Block, folder: Path) -> list[dict[str, Any]]:
    """Settings as in the tests of every block, plus all saved pictures and files of the folder."""
    found = settings(block)
    for name, parameter in block.parameters.items():
        if isinstance(parameter.control, SavedRef):
            found += [{name: "soft"}, {name: "flat"}, {**found[-1], name: "soft"}]
        elif isinstance(parameter.control, Asset) and (folder / name).exists():
            found += [{**values, name: name} for values in settings(block)]
    return found


def paired_settings(block: Block, folder: Path) -> list[tuple[dict[str, Any], MakePicture]]:
    """Values and pictures that combine defaults, ends, options, saved pictures and assets in pairs."""
    factors = {name: [None, *values] for name, values in ends_of(block).items()}
    for name, parameter in block.parameters.items():
        if isinstance(parameter.control, SavedRef):
            factors[name] = [None, "soft", "flat"]
        elif isinstance(parameter.control, Asset) and (folder / name).exists():
            factors[name] = [None, name]
    rows = covering_rows(factors | {"picture": makers_for(block)})
    return [
        ({name: value for name, value in row.items() if value is not None and name != "picture"}, make)
        for row in rows
        for make in [row["picture"]]
    ]


def shapes_for(block: Block, values: dict[str, Any]) -> dict[str, tuple[int, int]]:
    """All sizes, but small pictures for learned filters, which read many pixels, and for `lic`.

    The longest lines of `lic` take 44 steps, each of which reads the pixel at its position: at the border of
    two pixels rounding decides, and the rest of the line differs.
    """
    small = values and (block.kind == "learned" or block.name == "lic")
    return {"1x1": (1, 1), "243x181": (181, 243)} if small else SHAPES


def makers_for(block: Block) -> list[MakePicture]:
    """A picture of a film, and a gray one for blocks that work on any channels."""
    return [film_picture, gray_picture] if block.on == "channels" else [film_picture]


BLOCKS = all_blocks().values()
KINDS = {block.kind: block for block in BLOCKS}
"""One block of each kind."""

every_block = pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.name)


def block_faults(
    sessions: Sessions,
    block: Block,
    values: dict[str, Any],
    folder: Path,
    *shapes: tuple[int, int],
    makers: Sequence[MakePicture] = (film_picture,),
    forms: Sequence[Form] = FORMS,
) -> list[str]:
    chosen = block_style(block, values, folder)
    return [
        line
        for make in makers
        for shape in shapes
        for label in [f"{block.name} {values}, {make.__name__} {shape}"]
        for line in faults(sessions, chosen, make(*shape), label, forms)
    ]


@every_block
@pytest.mark.parametrize("third", of_the_day(range(3), 1))
def test_every_block_agrees_with_cpu(block: Block, third: int, sessions: Sessions, folder: Path) -> None:
    defaults, *others = paired_settings(block, folder)
    found = block_faults(sessions, block, {}, folder, (1, 1), (1, 50), (50, 1))
    for values, make in (defaults, *others[third::3]):
        shape = SMALL if block.kind == "learned" and values else ODD
        forms = [drawn(FORMS, f"{block.name} {values}")] if values else FORMS
        found += block_faults(sessions, block, values, folder, shape, makers=[make], forms=forms)
    assert not found, "\n".join(found)


def test_large_ellipses_agree(sessions: Sessions, folder: Path) -> None:
    """On a page large enough that squares of pixels share a weight."""
    chosen = replace(block_style(all_blocks()["kuwahara"], {"radius": 7}, folder), height=32)
    for side in (60, 96):
        assert faults(sessions, chosen, film_picture(side, side + 3), f"kuwahara, side {side}", FORMS) == []


@pytest.mark.parametrize(
    ("chosen", "luma", "keeps_highlights"),
    [
        (step("minimum_range", dynamic_range=100), noise(*SMALL), True),
        (step("minimum_range", dynamic_range=100, lift=1.0), noise(*SMALL) ** 4, True),
        (step("equalize", low=25, high=75), np.rint(noise(*SMALL)), False),
    ],
    ids=["enough contrast", "dim", "only black and white"],
)
def test_highlights_above_white_agree(
    chosen: Step, luma: np.ndarray, keeps_highlights: bool, sessions: Sessions
) -> None:
    """A picture with enough contrast keeps them; a stretch clips them, even if it changes no other tone."""
    lit = luma.copy()
    lit[::7, ::5] = 1.4
    assert faults(sessions, style(chosen), Picture(FLOAT, luma=lit), chosen.block) == []
    assert (run_luma(style(chosen), lit).max() > 1.3) == keeps_highlights


@pytest.mark.parametrize("kind", KINDS)
def test_the_longest_pages_agree(kind: str, sessions: Sessions, folder: Path) -> None:
    long, high = SHAPES["8192x16"], SHAPES["16x8192"]
    block = KINDS[kind]
    for shape, forms in ((long, FORMS), (high, [drawn(FORMS, kind)])):
        assert block_faults(sessions, block, {}, folder, shape, makers=makers_for(block), forms=forms) == []


@pytest.mark.thorough
@every_block
def test_every_block_at_every_setting_and_size(block: Block, sessions: Sessions, folder: Path) -> None:
    found = [
        line
        for values in all_settings(block, folder)
        for shapes in [shapes_for(block, values).values()]
        for line in block_faults(sessions, block, values, folder, *shapes, makers=makers_for(block))
    ]
    assert not found, "\n".join(found)


BEFORE = {
    "the codes themselves": (),
    "by way of a texture": (step("gaussian", sigma=0),),
    "by way of RGB": (step("saturation", factor=1.0), step("gaussian", sigma=0)),
    "the middle gray of no difference": (
        step("gaussian", sigma=0, save="same"),
        step("blend", source="source", other="same", mode="grain_extract", opacity=1.0),
    ),
}
CODES = [np.arange(16, 236, dtype=np.uint8), np.arange(256, dtype=np.uint8)]


@pytest.mark.parametrize("before", BEFORE.values(), ids=BEFORE)
@pytest.mark.parametrize("name", ["posterize", "pattern"])
@pytest.mark.parametrize("turn", of_the_day(range(2), 1))
def test_codes_on_border_of_tones_get_same_tone(
    turn: int, name: str, before: tuple[Step, ...], sessions: Sessions
) -> None:
    """All 8-bit codes, in all numbers of tones, without a ramp between tones.

    The two ranges of codes alternate.
    """
    levels = all_blocks()[name].parameters["levels"].control
    assert isinstance(levels, Slider)
    found = []
    for number in range(int(levels.low), int(levels.high) + 1):
        chosen = style(*before, step(name, levels=number, softness=0.0))
        for codes in CODES[(turn + number) % 2 :: 2]:
            source = Picture(Encoding(full_range=len(codes) == 256), luma=np.repeat(codes[None], 24, axis=0))
            found += faults(sessions, chosen, source, f"{number} levels, {len(codes)} codes")
    assert not found, "\n".join(found)


def style_faults(
    name: str, sessions: Sessions, gray_forms: Sequence[Form] = FORMS, **shapes: Sequence[tuple[int, int]]
) -> list[str]:
    """Disagreements of a style on a picture of a film and on a gray one, at these sizes."""
    chosen = load_style(name)
    # The plain style passes a gray picture through without a session.
    makers = {"film": film_picture} if chosen.is_plain else {"film": film_picture, "gray": gray_picture}
    return [
        line
        for kind, make in makers.items()
        for shape in shapes[kind]
        for forms in [gray_forms if kind == "gray" else FORMS]
        for line in faults(sessions, chosen, make(*shape), f"{name}, {kind} {shape}", forms)
    ]


@pytest.mark.parametrize("name", of_the_day(style_names(), 5))
def test_every_style_agrees_with_cpu(name: str, sessions: Sessions) -> None:
    assert style_faults(name, sessions, [drawn(FORMS, name)], film=[ODD], gray=[SMALL]) == []


@pytest.mark.thorough
@pytest.mark.parametrize("name", style_names())
def test_every_style_at_every_size(name: str, sessions: Sessions) -> None:
    every = list(SHAPES.values())
    assert style_faults(name, sessions, film=every, gray=every) == []
