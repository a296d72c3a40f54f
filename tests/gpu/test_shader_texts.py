"""The text of a shader is written once: passes that differ only in numbers share it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest
from covering import DAY, in_one_test, of_the_day
from pictures import VIDEO
from random_styles import Chance

from vidstyle.core.picture import Encoding, PictureLayout
from vidstyle.explore.generate import mutate
from vidstyle.export.adjust import main_controls
from vidstyle.gpu.compile import shader_writer
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.plan import Plan, make_plan, plan_for_rgb
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.preview.plans import PlanSender
from vidstyle.style import Style, load_style, set_values, style_names
from vidstyle.style.resolve import resolve

SHAPE = (90, 160)
FORMS: tuple[Form, ...] = ("compute", "fragment")
OTHERS = (replace(VIDEO, depth=10), replace(VIDEO, subsampling=(1, 1)), replace(VIDEO, full_range=True))
ENCODINGS = [(VIDEO, VIDEO), *((VIDEO, other) for other in OTHERS), *((other, VIDEO) for other in OTHERS)]
"""Of the source and of the target."""


def plans(style: Style) -> Iterator[Plan]:
    """The plans of a style for all forms, and for several sources and targets."""
    for source, target in ENCODINGS:
        yield from (plan_of(style, form, source, target) for form in FORMS)
    yield plan_for_rgb(style, *SHAPE[::-1], 8)


def plan_of(style: Style, form: Form, source: Encoding, target: Encoding) -> Plan:
    layout = PictureLayout(source, SHAPE, "chroma")
    return make_plan(style, resolve(style, *SHAPE), layout, target, False, form)


def texts(plan: Plan) -> list[str]:
    return [write_shader(plan, each).assembly.text for each in plan.passes]


def styles() -> Iterator[Style]:
    """Shipped styles with other values and choices, and styles of any blocks."""
    for name in style_names()[::2]:
        yield mutate(load_style(name), DAY, 1.0)
    for seed in range(DAY, DAY + 20):
        yield Chance(seed, wild=True, learned=True, structure=True).style()


@in_one_test("style", styles())
def test_a_shared_text_equals_a_text_of_its_own(style: Style, monkeypatch: pytest.MonkeyPatch) -> None:
    for plan in plans(style):
        shared = texts(plan)
        with monkeypatch.context() as own:
            own.setattr(shader_writer, "_texts", {})
            is_same = texts(plan) == shared  # apart, as pytest takes minutes to compare long texts
        assert is_same, plan.form


@pytest.mark.parametrize("name", of_the_day(style_names(), 5))
def test_a_slider_of_a_page_writes_no_text(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    style, sender = replace(load_style(name), steady=0.0), PlanSender()
    first = sender.message(style, *SHAPE[::-1])
    monkeypatch.delattr(shader_writer, "_Writer")
    for control in main_controls(style):
        if control["kind"] == "slider" and not control["whole"]:
            near = control["value"] + (control["high"] - control["low"]) * 1e-4
            message = sender.message(
                set_values(style, {control["path"]: min(near, control["high"])}), *SHAPE[::-1]
            )
            assert message["key"] == first["key"] and "plan" not in message, control["path"]


def test_the_texts_of_the_last_plans_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_for_rgb(load_style("comic"), *SHAPE[::-1], 8)
    monkeypatch.setattr(shader_writer, "_texts", {})
    monkeypatch.setattr(shader_writer, "MAX_TEXTS", len(plan.passes))
    texts(plan_for_rgb(load_style("oil"), *SHAPE[::-1], 8))
    expected = texts(plan)
    assert len(shader_writer._texts) <= len(plan.passes)
    monkeypatch.delattr(shader_writer, "_Writer")
    assert texts(plan) == expected
