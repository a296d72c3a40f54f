"""Memory traffic of plans, and its description. Nothing here needs OpenGL."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest
from covering import in_one_test
from pictures import RGB8, VIDEO, step, style

from vidstyle.bench.subjects import subjects
from vidstyle.block import Slider
from vidstyle.blocks import all_blocks
from vidstyle.cli.styles import FORMS, OPENGL_FORMS
from vidstyle.core.picture import Encoding, PictureLayout
from vidstyle.gpu.compile.explain import (
    HeldTexture,
    Traffic,
    calls_of,
    download_bytes,
    explain,
    held_textures,
    lines_of,
    pass_traffic,
    plan_traffic,
    upload_bytes,
)
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.plan import Plan, make_plan, plan_for_video
from vidstyle.gpu.compile.shader_nodes import WORKING_FORMATS, plane_format
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.style import Style, expand, load_style, style_names
from vidstyle.style.resolve import resolve

SUBJECTS = subjects()
BLOCKS = [subject for subject in SUBJECTS if subject.kind == "block"]
every_form = pytest.mark.parametrize("form", FORMS)

STRUCTURE = {"passes", "sigma", "p"}
"""Sliders of learned blocks that decide the number of passes, the bank, and the format of its result."""

FIVE = style(
    step("brightness", factor=1.1), step("saturation"), step("hue"), step("posterize"), step("soft_threshold")
)
"""Five pixel blocks: luma, then RGB."""
LUMA = style(step("brightness"), step("luma_posterize"), step("minimum_range"))


def plan_of(chosen: Style, layout: PictureLayout, target: Encoding | None = None, rgb: bool = False) -> Plan:
    steps = resolve(chosen, *layout.shape)
    return make_plan(chosen, steps, layout, target or layout.encoding, rgb, "compute")


def test_the_forms_are_those_of_plans() -> None:
    assert get_args(Form) == FORMS


def test_five_pixel_blocks_are_one_compute_pass() -> None:
    plan = plan_for_video(FIVE, 1920, 1080, "compute")
    assert [pass_traffic(plan, each) for each in plan.passes] == [Traffic(1.5, 1.5)]
    assert [room.format.components for room in held_textures(plan, 8192)] == [1, 1, 1], "the result's planes"
    assert (upload_bytes(plan), download_bytes(plan)) == (1.5, 1.5)
    assert calls_of(plan, plan.passes[0])[-1] == "shrunk_chroma"


def test_as_fragments_a_second_small_pass_averages_chroma() -> None:
    """A fragment cannot read values of its neighbours, so their chroma is stored in a texture."""
    plan = plan_for_video(FIVE, 1920, 1080, "fragment")
    assert [each.shape for each in plan.passes] == [(1080, 1920), (540, 960)]
    assert [pass_traffic(plan, each) for each in plan.passes] == [Traffic(1.5, 5), Traffic(4, 0.5)]
    assert sum(room.bytes for room in held_textures(plan, 8192)) == (4 + 1.5) * 1920 * 1080


@pytest.mark.parametrize("form", OPENGL_FORMS)
def test_luma_style_transfers_one_byte_each_way(form: Form) -> None:
    plan = plan_for_video(LUMA, 1920, 1080, form)
    assert (upload_bytes(plan), download_bytes(plan)) == (1, 1)


def test_a_filter_keeps_its_first_half_in_a_texture_of_two_bytes() -> None:
    plan = plan_of(style(step("gaussian")), PictureLayout(VIDEO, (90, 160), "gray"))
    assert [pass_traffic(plan, each) for each in plan.passes] == [Traffic(1, 2), Traffic(2, 1)]
    assert plan_traffic(plan) == Traffic(3, 3)
    assert held_textures(plan, 8192) == [
        HeldTexture(90, 160, WORKING_FORMATS["luma"]),
        HeldTexture(90, 160, plane_format(8)),
    ]


def test_long_pages_need_only_the_textures_of_a_tile() -> None:
    plan = plan_of(style(step("gaussian", sigma=1)), PictureLayout(VIDEO, (90, 1600), "gray"))
    assert all(room.width <= 256 for room in held_textures(plan, 256))
    assert any(room.width == 1600 for room in held_textures(plan, 8192))


def test_a_sampling_pass_reads_only_its_grid() -> None:
    plan = plan_for_video(style(step("minimum_range")), 1920, 1080, "compute")
    samples = 320 * 180 / (1920 * 1080)
    assert pass_traffic(plan, plan.passes[0]) == Traffic(pytest.approx(samples), pytest.approx(2 * samples))


def test_traffic_of_deep_odd_and_packed_pictures() -> None:
    hue = style(step("hue"))
    deep = plan_of(hue, PictureLayout(replace(VIDEO, depth=10), (4, 6), "chroma"))
    assert (upload_bytes(deep), download_bytes(deep), plan_traffic(deep)) == (3, 3, Traffic(3, 3))
    odd = plan_of(hue, PictureLayout(VIDEO, (3, 5), "chroma"))
    assert upload_bytes(odd) == download_bytes(odd) == 1 + 2 * (2 * 3) / (3 * 5)
    packed = plan_of(hue, PictureLayout(RGB8, (4, 6), "color"), rgb=True)
    assert (upload_bytes(packed), download_bytes(packed)) == (3, 3)
    assert plan_traffic(packed) == Traffic(3, 4), "a texture of RGB has a fourth component"


@every_form
@in_one_test("subject", BLOCKS)
def test_no_slider_changes_the_text_of_a_shader(subject, form: Form) -> None:
    """Except the size of shared memory for the pixels that a filter reads, in few steps."""
    *before, last = subject.style.background

    def texts(**values: float) -> dict[tuple[str, ...], list[str]]:
        changed = replace(subject.style, background=(*before, replace(last, values=values)))
        plan = plan_for_video(changed, 64, 48, form)
        shaders = [write_shader(plan, each) for each in plan.passes]
        rooms = (re.findall(r"#define (\w+_ROOM \d+)", shader.assembly.text) for shader in shaders)
        return {tuple(map(str, rooms)): [shader.assembly.text for shader in shaders]}

    usual = texts()

    learned = any(all_blocks()[each.block].kind == "learned" for each in expand(subject.style).steps)
    for name, parameter in all_blocks()[subject.name].parameters.items():
        if isinstance(parameter.control, Slider) and not (learned and name in STRUCTURE):
            for value in (parameter.control.low, parameter.control.high):
                changed = texts(**{name: parameter.check(value)})
                assert (usual | changed) == (changed | usual)
                assert form == "compute" or changed == usual


def test_choice_may_change_shader_text() -> None:
    """Otherwise the test above could not fail."""
    plans = [plan_for_video(style(step(name)), 64, 48, "compute") for name in ("hue", "saturation")]
    assert len({write_shader(plan, plan.passes[0]).assembly.text for plan in plans}) == 2


@every_form
@in_one_test("name", style_names())
def test_every_pass_of_every_style_is_explained(name: str, form: Form) -> None:
    plan = plan_for_video(load_style(name), 1280, 720, form)
    explained = explain(plan)
    text = "\n".join(lines_of(explained))
    for each, described in zip(plan.passes, explained["passes"], strict=True):
        for node in each.nodes:
            assert node.function is not None
            words = re.findall(r"\w+", " ".join(described["calls"]))
            assert {node.function.name, Path(node.function.file).stem} & set(words)
        for phrase in (*described["calls"], *described["reads"], *described["writes"]):
            assert phrase in text
    parts = sum(each["bytes_read"] + each["bytes_written"] for each in explained["passes"])
    assert explained["bytes"] == pytest.approx(parts, abs=0.05)
    assert f"form: {len(plan.passes)} pass" in text


def test_explanation_names_stored_values() -> None:
    lined = style(step("gaussian"), lines=(step("to_gray"), step("sobel", invert=True)))
    lines = list(lines_of(explain(plan_for_video(lined, 640, 360, "fragment"))))
    text = "\n".join(lines)
    assert lines[0] == "640x360, fragment form: 5 passes"
    assert "gaussian (across)\n" in text and "writes color 1 (RGBA16)\n" in text
    assert "reads luma 3 (R16), color 2 (RGBA16)\n" in text
    assert "at 320x180: shrunk_chroma" in text
    assert "up: 1.50, down: 1.50" in lines[-1]
