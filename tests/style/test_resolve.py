"""Values of steps at the size of a picture."""

from __future__ import annotations

from dataclasses import replace

import pytest

from vidstyle.block import Slider
from vidstyle.blocks import all_blocks
from vidstyle.style import Step, Style, style_from_table
from vidstyle.style.resolve import resolve

HEIGHT = 100
SCALED = [
    pytest.param(block.name, name, id=f"{block.name}-{name}")
    for block in all_blocks().values()
    for name, parameter in block.parameters.items()
    if block.kind != "recipe"
    and isinstance(parameter.control, Slider)
    and parameter.control.power
    and not parameter.control.grows_if
]


def value_at(block: str, name: str, value: float, growth: float) -> float:
    """The value of a parameter in a picture that is larger than the style's height by a factor."""
    style = Style("test", height=HEIGHT, background=(Step(block, {name: value}),))
    size = round(HEIGHT * growth)
    return resolve(style, size, 2 * size)["background"][0].values[name]


@pytest.mark.parametrize(("block", "name"), SCALED)
def test_lengths_exceed_their_slider_in_large_pictures_and_nothing_else_does(block: str, name: str) -> None:
    control = all_blocks()[block].parameters[name].control
    assert isinstance(control, Slider)
    grown = value_at(block, name, control.high, 10.0)
    assert grown == (
        pytest.approx(10 * control.high)
        if control.unit == "px"
        else control.high * 10 ** min(control.power, 0)
    )


@pytest.mark.parametrize(("block", "name"), SCALED)
def test_no_value_falls_below_its_slider_in_small_pictures(block: str, name: str) -> None:
    control = all_blocks()[block].parameters[name].control
    assert isinstance(control, Slider)
    assert value_at(block, name, control.low, 0.25) >= control.low


def test_dots_become_no_finer_in_small_pictures_than_one_sees_unless_they_are_meant_to() -> None:
    assert value_at("halftone", "cell", 8.0, 0.1) == 3
    assert value_at("halftone", "cell", 2.5, 0.1) == 2.5
    assert value_at("halftone", "cell", 2.0, 2.0) == 4


def test_blurs_and_grain_keep_their_size() -> None:
    """While other lengths become finer, each up to its own level of detail."""
    steps = [
        {"block": "gaussian", "sigma": 6}, {"block": "noise", "size": 6}, {"block": "pixelate", "size": 6},
        {"block": "kuwahara", "radius": 6},
    ]  # fmt: skip
    style = style_from_table({"format": 1, "height": 480, "background": steps}, "dots")
    resolved = resolve(replace(style, detail=5.0), 480, 640)["background"]
    names = "sigma", "size", "size", "radius"
    assert [step.values[name] for step, name in zip(resolved, names, strict=True)] == pytest.approx(
        [6, 6, 6 / 4, 6 / 5]
    )


def test_tiles_of_small_pictures_are_finer_only_in_faces() -> None:
    table = {"format": 1, "height": 720, "background": [{"block": "mosaic", "size": 12}]}
    style = style_from_table(table, "tiles")
    steps = [
        resolve(replace(style, detail=detail), lines, lines)["background"][0]
        for lines, detail in ((720, 1.0), (240, 1.0), (240, 2.0))
    ]
    assert [step.values["size"] for step in steps] == [12, 7, 3.5]
