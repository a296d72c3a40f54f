"""Which pictures steps read and save."""

from __future__ import annotations

from vidstyle.style.model import SOURCE, Step
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
    assert wired[0].savers == {SOURCE: None}
    assert wired[-1].savers == {SOURCE: None, "chroma": 0, "hued": 1}
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
