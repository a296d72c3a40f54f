"""Which pictures steps read and save."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from vidstyle.style.mask_declarations import BACKDROP, REGIONS
from vidstyle.style.model import SOURCE, Step, Style
from vidstyle.style.resolve import structure_key
from vidstyle.style.wiring import START, rename_pictures, wire_layers, wiring_of


def test_a_default_names_a_picture_like_a_value():
    assert wiring_of(Step("to_color")).reads == {"chroma": "chroma"}
    assert wiring_of(Step("to_color", {"chroma": "sky"})).reads == {"chroma": "sky"}
    assert wiring_of(Step("blend")).pictures == {"other": SOURCE}, "an optional picture is not read"


def test_a_step_saves_its_input_and_its_output():
    wiring = wiring_of(Step("to_gray", save="gray"))
    assert (wiring.saved_input, wiring.saved_output) == ("chroma", "gray")
    assert wiring.saves == ("chroma", "gray")
    assert wiring_of(Step("", save="kept")).block is None


def test_each_layer_starts_from_the_end_of_base():
    layers = {
        "base": (Step("to_gray"), Step("hue", save="hued")),
        "background": (Step("posterize"), Step("to_color", source=SOURCE)),
        "lines": (Step("sobel"), Step("blend", {"other": "hued"}, source="missing")),
    }
    wired = list(wire_layers(layers))
    assert [each.start for each in wired] == [None, 0, 1, None, 1, None]
    given = dict.fromkeys([SOURCE, *REGIONS, BACKDROP])
    assert wired[0].savers == given
    assert wired[-1].savers == given | {"chroma": 0, "hued": 1}
    assert wired[-1].wiring.reads == {START: "missing", "other": "hued"}


def test_without_base_layers_start_from_the_source():
    layers = {"base": (), "background": (Step("hue"),), "lines": (Step("sobel"),)}
    assert [each.start for each in wire_layers(layers)] == [None, None]


def test_pictures_are_renamed_wherever_a_step_reads_them():
    step = Step("blend", {"other": "a", "mask": "b"}, source="a", save="a")
    renamed = rename_pictures(step, {"a": "z"})
    assert renamed == Step("blend", {"other": "z", "mask": "b"}, source="z", save="a")
    assert rename_pictures(Step("to_color"), {"chroma": "tint"}).values == {"chroma": "tint"}
    assert rename_pictures(Step("hue", {"degrees": 4.0}), {"a": "z"}) == Step("hue", {"degrees": 4.0})


STEP = Step("halftone", {"cell": 6.0, "inks": "press"}, save="a")


def key_of(*steps: Step) -> object:
    return structure_key(Style("any", background=steps))


def test_only_numbers_leave_the_structure():
    moved = replace(STEP, values={"cell": 9.0, "gain": 0.3, "inks": "press"})
    assert key_of(STEP) == key_of(moved) == key_of(replace(STEP, values={"inks": "press"}))


def test_a_color_leaves_the_structure():
    assert key_of(Step("mosaic", {"gap_color": "#ff0000"})) == key_of(
        Step("mosaic", {"gap_color": "#00ff00"})
    )


def test_each_change_of_wiring_or_of_a_choice_is_another_structure():
    others = [
        (replace(STEP, values={"cell": 6.0, "inks": "pure"}),),
        (replace(STEP, save="b"),),
        (replace(STEP, source=SOURCE),),
        (replace(STEP, on="luma"),),
        (replace(STEP, mute=True),),
        (replace(STEP, block="hue", values={}),),
        (STEP, STEP),
        (),
    ]
    keys = [key_of(STEP), *(key_of(*steps) for steps in others)]
    assert all(one != other for number, one in enumerate(keys) for other in keys[:number])
    assert key_of(Step("blend", {"other": "a"})) != key_of(Step("blend", {"other": "b"}))


def test_steps_with_a_file_of_the_user_are_never_equal():
    own = Step("pattern", {"tiles": "mine"})
    assert key_of(own) != key_of(own)
    assert key_of(Step("pattern")) == key_of(Step("pattern"))


@pytest.mark.parametrize(
    ("change", "is_same"),
    [
        ({"steady": 0.7, "strength": 0.4, "ink": "#102030"}, True),
        ({"steady": 0.0}, False),
        ({"strength": 1.0}, False),
        ({"only": "people"}, False),
        ({"behind": Style("behind", lines=(STEP,))}, False),
    ],
)
def test_fields_of_a_style_leave_its_structure_unless_they_add_work(
    change: dict[str, Any], is_same: bool
) -> None:
    style = Style("any", background=(STEP,), steady=0.5, strength=0.5)
    assert (structure_key(replace(style, **change)) == structure_key(style)) == is_same
