"""The GPU gives what the CPU gives: every block at every setting, every style, in both forms of passes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from gpu import SHAPES, Sessions, faults, film_picture, gray_picture
from pictures import step, style
from test_blocks import settings

from vidstyle.block import Asset, Block, SavedRef, Slider
from vidstyle.blocks import all_blocks
from vidstyle.core.picture import Encoding, Picture
from vidstyle.style import Step, Style, load_style, style_names


@pytest.fixture(scope="module")
def sessions() -> Iterator[Sessions]:
    with Sessions() as opened:
        yield opened


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A style's folder with tiles of three sizes, one wider and one higher than the others."""
    folder = tmp_path_factory.mktemp("style")
    (folder / "tiles").mkdir()
    random = np.random.default_rng(1)
    for number, size in enumerate([(5, 31), (40, 7), (12, 12)]):
        tile = random.integers(60 * number, 60 * number + 130, size).astype(np.uint8)
        assert cv2.imwrite(str(folder / "tiles" / f"{number}.png"), tile)
    return folder


def all_settings(block: Block, folder: Path) -> list[dict[str, Any]]:
    """Those of every block test, and each saved picture and what the folder has for a parameter given too."""
    found = settings(block)
    for name, parameter in block.parameters.items():
        if isinstance(parameter.control, SavedRef):
            found += [{name: "soft"}, {name: "flat"}, {**found[-1], name: "soft"}]
        elif isinstance(parameter.control, Asset) and (folder / name).exists():
            found += [{**values, name: name} for values in settings(block)]
    return found


def shapes_for(block: Block, values: dict[str, Any]) -> dict[str, tuple[int, int]]:
    """All sizes; but learned filters, which read much and run often, are tried on small pictures."""
    small = block.kind == "learned" and values
    return {"1x1": (1, 1), "243x181": (181, 243)} if small else SHAPES


def style_of(block: Block, values: dict[str, Any], folder: Path) -> Style:
    """The block upon the source, with a blurred picture and a gray one to be had."""
    saved = (step("gaussian", save="soft"), step("to_gray", source="source", save="flat"))
    return Style("test", base=saved, background=(step(block.name, source="source", **values),), folder=folder)


@pytest.mark.parametrize("block", all_blocks().values(), ids=lambda block: block.name)
def test_every_block_gives_what_it_gives_on_the_cpu(block: Block, sessions: Sessions, folder: Path) -> None:
    makers = [film_picture, gray_picture] if block.on == "channels" else [film_picture]
    found = [
        line
        for values in all_settings(block, folder)
        for chosen in [style_of(block, values, folder)]
        for make in makers
        for size, shape in shapes_for(block, values).items()
        for line in faults(sessions, chosen, make(*shape), f"{block.name} {values}, {make.__name__} {size}")
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
def test_a_code_upon_the_border_of_two_tones_gets_the_same_one(
    name: str, before: tuple[Step, ...], sessions: Sessions
) -> None:
    """All codes of 8 bits, in as many tones as there may be, without a ramp between them."""
    levels = all_blocks()[name].parameters["levels"].control
    assert isinstance(levels, Slider)
    found = []
    for number in range(int(levels.low), int(levels.high) + 1):
        chosen = style(*before, step(name, levels=number, softness=0.0))
        for codes in CODES:
            source = Picture(Encoding(full_range=len(codes) == 256), luma=np.repeat(codes[None], 24, axis=0))
            found += faults(sessions, chosen, source, f"{number} levels, {len(codes)} codes")
    assert not found, "\n".join(found)


@pytest.mark.parametrize("name", style_names())
def test_every_style_gives_what_it_gives_on_the_cpu(name: str, sessions: Sessions) -> None:
    chosen = load_style(name)
    # The plain style hands a gray picture on as it is, which no session is asked for.
    makers = [film_picture] if chosen.is_plain else [film_picture, gray_picture]
    found = [
        line
        for make in makers
        for size, shape in SHAPES.items()
        for line in faults(sessions, chosen, make(*shape), f"{name}, {make.__name__} {size}")
    ]
    assert not found, "\n".join(found)
