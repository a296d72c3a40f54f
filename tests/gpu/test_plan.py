"""Plans, without OpenGL: passes, their order, and the values stored in textures."""

from __future__ import annotations

import re
from typing import Any

import pytest
from covering import in_one_test
from pictures import RGB8, VIDEO, step, style

import vidstyle
from vidstyle.block import Asset, Block, Choice, Color, Parameter, SavedRef, Slider, Switch
from vidstyle.blocks import all_blocks
from vidstyle.core.picture import Encoding, PictureLayout
from vidstyle.gpu.compile.glsl import Form, functions_of_block
from vidstyle.gpu.compile.passes import MAX_STORED_VALUES
from vidstyle.gpu.compile.plan import Plan, make_plan
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.compile.slots import ending
from vidstyle.gpu.compile.tiles import jobs_of
from vidstyle.style import Style, override, style_names
from vidstyle.style.resolve import resolve

SHAPE = (360, 640)
GIVEN = {"at": "ivec2", "page": "ivec2", "weights": "vec3", "measured": "vec4", "moment": "uint"}
TYPES = {Switch: "bool", Choice: "int", Color: "vec3"}

with_shaders = pytest.mark.parametrize(
    "block",
    [
        block
        for block in all_blocks().values()
        if block.kind not in ("recipe", "resize", "learned", "network") and not block.is_identity
    ],
    ids=lambda block: block.name,
)


def plan_of(look: Style, form: Form = "compute", target: Encoding = VIDEO, **source: Any) -> Plan:
    layout = PictureLayout(**({"encoding": VIDEO, "shape": SHAPE, "planes": "chroma"} | source))
    return make_plan(look, resolve(look, *layout.shape), layout, target, False, form)


def calls(plan: Plan) -> list[list[str]]:
    """The names of the functions that each pass calls."""
    return [[node.function.name for node in each.nodes if node.function] for each in plan.passes]


FIVE = style(
    step("brightness"), step("soft_threshold"), step("posterize"), step("saturation"), step("colorize")
)


def test_five_pixel_blocks_are_one_pass() -> None:
    assert len(plan_of(FIVE).passes) == 1
    fragment = plan_of(FIVE, "fragment")  # chroma is averaged in a separate pass
    assert [each.result.role for each in fragment.passes if each.result] == ["planes", "chroma"]
    assert len(fragment.passes) == 2
    whole = plan_of(FIVE, "fragment", RGB8, encoding=RGB8)
    assert len(whole.passes) == 1


def test_pixel_blocks_are_fused_into_previous_filter() -> None:
    plan = plan_of(style(step("sobel"), step("brightness"), step("gaussian"), step("posterize")))
    assert calls(plan) == [["sobel", "brightness"], ["gaussian_across"], ["gaussian", "posterize"]]
    assert [image.is_plane for image in plan.passes[0].images] == [True], "the luma plane of the decoder"


def test_luma_style_transfers_only_luma() -> None:
    plan = plan_of(style(step("gaussian"), step("brightness")))
    # A picture with chroma is blurred in RGB; a gray one is not.
    assert plan.chroma == "made"
    plan = plan_of(style(step("brightness"), step("to_gray"), step("to_color")))
    assert (plan.luma, plan.chroma) == ("made", "untouched")
    assert [node.kind for node in plan.planes] == ["luma"]


def test_a_style_that_changes_nothing_needs_no_pass() -> None:
    for look in (style(step("to_gray"), step("to_color")), style(step(save="here"))):
        plan = plan_of(look)
        assert (plan.passes, plan.luma, plan.chroma) == ((), "untouched", "untouched")


def test_saved_picture_read_at_same_pixel_needs_no_texture() -> None:
    look = style(
        step("brightness", save="bright"),
        step("posterize", save="flat"),
        step("blend", other="bright", mode="multiply"),
        step("blend", other="flat", mode="screen"),
    )
    plan = plan_of(look)
    assert len(plan.passes) == 1 and plan.passes[0].stored == []


def test_unused_values_are_not_computed() -> None:
    look = style(step("gaussian", save="unused"), step("brightness", source="source"))
    assert calls(plan_of(look)) == [["brightness"]]


def test_filters_around_the_same_picture_share_a_pass() -> None:
    look = style(
        step("to_gray", save="gray"),
        step("gaussian", sigma=4, save="wide"),
        step("gaussian", source="gray", sigma=1),
        step("blend", other="wide", mode="grain_extract"),
    )
    across, *rest = calls(plan_of(look))
    assert (across, rest) == (["gaussian_across"] * 2, [["gaussian"], ["gaussian", "blend"]])


def test_last_pass_combines_layers_and_writes_planes() -> None:
    look = style(step("gaussian"), lines=(step("sobel", invert=True), step("soft_threshold")), ink="#402010")
    plan = plan_of(look)
    assert [name for name in calls(plan)[-1] if name.startswith("inked")] == ["inked_color"]
    assert "gaussian" in calls(plan)[-1], "the wider picture is not stored, the lines are"


@in_one_test("form", ["compute", "fragment"])
@in_one_test("name", style_names())
def test_passes_run_after_inputs_and_reuse_only_free_textures(name: str, form: Form) -> None:
    plan = plan_of(vidstyle.load_style(name), form)
    made: set[object] = set()
    for number, each in enumerate(plan.passes):
        assert all(image.is_plane or image in made for image in each.images)
        measured = [node.measure for node in each.nodes if node.measure]
        assert all(measure in made for measure in measured)
        made |= {*each.stored, each.sampled}
        later = {image for other in plan.passes[number + 1 :] for image in other.images}
        assert later.isdisjoint(ending(plan, number))
        assert (
            sum(node.is_heavy for node in each.nodes) <= 1
            or len({n.around for n in each.nodes if n.is_heavy}) == 1
        )


def test_no_pass_exceeds_guaranteed_render_targets() -> None:
    saves = [step("brightness", f"s{number}", "source", factor=0.5 + number / 10) for number in range(14)]
    blurs = [
        part
        for number in range(14)
        for part in (step("gaussian", f"b{number}", f"s{number}"), step("blend", other="b0"))
    ]
    plan = plan_of(style(*saves, *blurs))
    assert max(len(each.stored) for each in plan.passes) <= MAX_STORED_VALUES


@pytest.mark.parametrize("form", ["compute", "fragment"])
def test_a_slider_changes_no_shader(form: Form) -> None:
    look = vidstyle.load_style("comic")
    changes = ["halftone.cell=9", "lines.soft_threshold.epsilon=90", "posterize.levels=3"]
    other = override(look, changes)
    texts = [
        [write_shader(plan, each).assembly.text for each in plan.passes]
        for plan in (plan_of(look, form), plan_of(other, form))
    ]
    assert texts[0] == texts[1]


@with_shaders
def test_shader_parameters_match_block_parameters(block: Block) -> None:
    for signature in functions_of_block(block.name):
        for parameter in signature.parameters:
            name = parameter.name.rstrip("_")
            if name in GIVEN:
                assert parameter.type == GIVEN[name]
            elif name in block.parameters:
                assert parameter.type == glsl_type(block.parameters[name], block)
            else:
                asset = re.fullmatch(r"(\w+)_(count|sizes?)", name)
                is_picture = parameter is signature.parameters[0] and block.kind != "filter"
                assert is_picture or (asset and isinstance(block.parameters[asset[1]].control, Asset)), name


def glsl_type(parameter: Parameter, block: Block) -> str:
    control = parameter.control
    if isinstance(control, Slider):
        return "int" if parameter.is_integer else "float"
    if isinstance(control, Asset):
        return "sampler2DArray"
    if isinstance(control, SavedRef):
        same = {"luma": "float", "color": "vec3", "channels": "channels"}[block.on]
        return same if control.on == "same" else "float"
    return TYPES[type(control)]


def test_long_page_is_processed_in_tiles() -> None:
    plan = plan_of(vidstyle.load_style("oil"), shape=(700, 1300))
    jobs = jobs_of(plan, 512)
    assert len(jobs) > 6 and all(max(w.shape) <= 512 for job in jobs for w in job.windows.values())
    covered = [job.result_window("luma") for job in jobs if any(each.result for each in job.passes)]
    assert sum(w.shape[0] * w.shape[1] for w in covered) == 700 * 1300
    assert len(jobs_of(plan, 2048)) == 1
