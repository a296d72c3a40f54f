"""Lowering of styles: which planes are converted, resampled, passed through or dropped."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from covering import in_one_test
from pictures import FLOAT, RGB8, VIDEO, step, style

from vidstyle.core.picture import Encoding, PictureLayout
from vidstyle.cpu.scheduling.schedule import MAX_FUSED_RADIUS, schedule
from vidstyle.cpu.scheduling.sweeps import READS_PLANES, Sweep
from vidstyle.gpu.compile.shader_graph import OPERATION_FILES
from vidstyle.style import Style, load_style, style_names
from vidstyle.style.lower import lower
from vidstyle.style.nodes import LoweredStyle, Node, Op, nodes_in_order
from vidstyle.style.resolve import resolve

SHAPE = (48, 64)
FILM, GRAY, RGB = (
    PictureLayout(VIDEO, SHAPE, "chroma"),
    PictureLayout(RGB8, SHAPE, "gray"),
    PictureLayout(RGB8, SHAPE, "color"),
)


def lowered(
    chosen: Style, source: PictureLayout = FILM, target: Encoding | None = None, rgb: bool = False
) -> LoweredStyle:
    return lower(chosen, resolve(chosen, *source.shape), source, target or source.encoding, rgb)


def ops(node: Node | None) -> list[str]:
    """The operations that a node needs, in order; blocks by their names."""
    assert node is not None
    return [each.block.name if each.block else each.op for each in nodes_in_order([node])]


def test_a_style_without_effect_hands_the_planes_on() -> None:
    for chosen in (style(step(save="here")), style(step("to_gray"), step("to_color"))):
        result = lowered(chosen)
        assert (result.luma_untouched, result.chroma_untouched) == (True, True)
        assert [each.op for each in result.outputs] == ["plane", "plane"]


@pytest.mark.parametrize(
    ("source", "luma", "chroma"),
    [
        (FILM, ["plane", "brightness"], ["plane"]),
        (GRAY, ["plane", "brightness"], None),
        (RGB, ["plane", "luma_from_rgb", "brightness"], ["plane", "chroma_from_rgb"]),
    ],
    ids=["film", "gray", "RGB"],
)
def test_a_luma_block_leaves_chroma_where_it_is(source: Any, luma: list[str], chroma: list[str]) -> None:
    result = lowered(style(step("brightness")), source)
    assert ops(result.luma) == luma
    assert result.chroma is None if chroma is None else ops(result.chroma) == chroma
    assert result.chroma_untouched == (source is FILM)


@pytest.mark.parametrize(
    ("source", "through_rgb"),
    [
        (FILM, ["plane", "plane", "upsample", "rgb_from_yuv"]),
        (GRAY, ["plane", "rgb_from_gray"]),
        (RGB, ["plane"]),
    ],
    ids=["film", "gray", "RGB"],
)
def test_a_color_block_takes_rgb(source: Any, through_rgb: list[str]) -> None:
    result = lowered(style(step("saturation")), source)
    assert ops(result.luma) == [*through_rgb, "saturation", "luma_from_rgb"]
    assert ops(result.chroma) == [*through_rgb, "saturation", "chroma_from_rgb"]


def test_a_block_on_channels_takes_luma_of_a_gray_picture_and_rgb_of_any_other() -> None:
    kinds = [
        next(node.kind for node in nodes_in_order(lowered(chosen, source).outputs) if node.block)
        for chosen, source in [
            (style(step("gaussian")), GRAY),
            (style(step("gaussian")), FILM),
            (style(step("to_gray"), step("gaussian")), FILM),
        ]
    ]
    assert kinds == ["luma", "color", "luma"]


def test_chroma_is_dropped_and_taken_up_again() -> None:
    assert lowered(style(step("to_gray"))).chroma is None
    again = lowered(style(step("saturation"), step("to_gray"), step("sobel"), step("to_color")))
    assert ops(again.chroma)[-2:] == ["saturation", "chroma_from_rgb"]
    source = lowered(style(step("saturation"), step("sobel"), step("to_color", chroma="source")))
    assert source.chroma_untouched and ops(source.luma)[-3:] == ["saturation", "luma_from_rgb", "sobel"]


def test_from_starts_at_a_saved_picture_and_equal_nodes_are_one() -> None:
    chosen = style(
        step("brightness", save="bright"),
        step("saturation"),
        step("brightness", source="source"),
        step("blend", other="bright"),
    )
    nodes = nodes_in_order(lowered(chosen, GRAY).outputs)
    (blend,) = [node for node in nodes if node.block and node.block.name == "blend"]
    assert blend.inputs["image"] is blend.inputs["other"]
    assert "saturation" not in [node.block.name for node in nodes if node.block], "nobody reads it"


def test_another_size_keeps_chroma_on_its_grid_and_the_page_gets_its_own_back() -> None:
    result = lowered(style(step("scale", factor=0.5, method="area", back="lanczos"), step("brightness")))
    assert ops(result.luma) == ["plane", "resample", "brightness", "resample"]
    assert ops(result.chroma) == ["plane", "resample", "resample"]
    assert result.luma is not None and result.chroma is not None
    small = result.chroma.inputs["image"]
    assert (small.shape, small.page, small.values) == ((12, 16), (24, 32), {"method": "area"})
    assert (result.luma.shape, result.luma.values) == (SHAPE, {"method": "lanczos"})


def test_a_saved_picture_is_resampled_to_the_working_size() -> None:
    chosen = style(step("to_gray"), step("scale", factor=0.5), step("blend", other="source"))
    (blend,) = [node for node in nodes_in_order(lowered(chosen).outputs) if node.op == "block"]
    assert [(each.op, each.shape) for each in blend.inputs.values()] == [("resample", (24, 32))] * 2
    assert blend.inputs["other"].values == {"method": "bilinear"}


def test_a_scale_that_undoes_another_returns_to_its_very_size() -> None:
    """Not to one of a pixel more, which would be resampled once more for the page: to 47 x 855 here."""
    steps = step("to_gray"), step("scale", factor=0.75), step("scale", factor=1.3333)
    result = lowered(style(*steps), replace(FILM, shape=(46, 854)))
    assert ops(result.luma) == ["plane", "resample", "resample"]


def test_a_small_saved_picture_is_converted_before_it_grows() -> None:
    """Luma and chroma are less to resample than RGB."""
    small = step("saturation", factor=2.0, save="small")
    chosen = style(
        step("scale", factor=0.5),
        small,
        step(source="source"),
        step("to_gray"),
        step("to_color", chroma="small"),
    )
    result = lowered(chosen)
    assert result.chroma is not None
    assert ops(result.chroma)[-3:] == ["saturation", "chroma_from_rgb", "resample"]


def test_a_bank_runs_on_luma_at_its_own_scale() -> None:
    result = lowered(style(step("etf", passes=2)))
    assert result.luma is not None and result.chroma_untouched
    assert (ops(result.luma), result.luma.radius) == (
        ["plane", "filter_bank"],
        result.luma.values["run"].radius,
    )
    reduced = lowered(style(step("flow_dog", sigma=4.0)))
    assert ops(reduced.luma) == ["plane", "resample", "filter_bank", "resample"]
    assert reduced.luma is not None and reduced.luma.shape == SHAPE


def test_a_measured_block_measures_the_luma_that_it_works_on() -> None:
    result = lowered(style(step("saturation"), step("equalize", settle=2.0)))
    assert result.luma is not None and result.luma.measure is not None
    measure = result.luma.measure
    assert (measure.of, measure.time_constant) == (result.luma.inputs["image"], 2.0)
    assert (measure.percentages, measure.step) == ((5, 35, 65, 95), ("background", 1))


def test_another_matrix_goes_through_rgb_but_gray_does_not() -> None:
    target = Encoding("bt601")
    film = lowered(style(step("brightness")), target=target)
    assert ops(film.luma)[-2:] == ["rgb_from_yuv", "luma_from_rgb"]
    assert film.luma is not None and film.luma.matrix == "bt601"
    assert film.luma.inputs["color"].matrix == "bt709"
    assert ops(lowered(style(step("brightness")), GRAY, target).luma) == ["plane", "brightness"]


@pytest.mark.parametrize(
    ("target", "on_grid"),
    [
        (replace(VIDEO, depth=10), True),
        (replace(VIDEO, full_range=True), True),
        (Encoding(subsampling=(1, 1)), False),
        (Encoding(siting=(0.0, 0.0)), False),
    ],
    ids=["depth", "range", "grid", "siting"],
)
def test_chroma_on_the_targets_grid_is_not_resampled(target: Encoding, on_grid: bool) -> None:
    result = lowered(style(step("brightness")), target=target)
    assert result.chroma is not None and not result.chroma_untouched
    assert (result.chroma.op, result.chroma.grid is not None) == (
        ("plane", True) if on_grid else ("upsample", False)
    )


def test_packed_rgb_is_one_node() -> None:
    result = lowered(style(step("brightness")), target=FLOAT, rgb=True)
    assert result.outputs == (result.color,)
    assert ops(result.color) == ["plane", "brightness", "plane", "upsample", "rgb_from_yuv"]


LINES = (step("to_gray"), step("sobel", invert=True))


@pytest.mark.parametrize(
    ("chosen", "luma", "chroma"),
    [
        (style(lines=LINES), ["constant_luma", "plane", "sobel", "inked_luma"], None),
        (
            style(lines=LINES, ink="#ff0000"),
            ["constant_luma", "plane", "sobel", "inked_luma"],
            ["constant_chroma", "plane", "sobel", "inked_chroma"],
        ),
        (
            style(step("brightness"), lines=LINES),
            ["plane", "brightness", "plane", "sobel", "inked_luma"],
            ["plane", "upsample", "plane", "sobel", "inked_chroma"],
        ),
        (
            style(step("to_gray"), lines=LINES, paper="#ffe0c0"),
            None,
            ["constant_chroma", "plane", "sobel", "inked_chroma"],
        ),
        (
            style(step("brightness"), lines=LINES, paper="#ffe0c0"),
            None,
            ["plane", "brightness", "upsample", "rgb_from_yuv", "on_paper", "sobel", "inked_color"]
            + ["chroma_from_rgb"],
        ),
    ],
    ids=["lines alone", "coloured ink", "over the background", "gray on paper", "on paper"],
)
def test_lines_are_inked_over_the_background(chosen: Style, luma: Any, chroma: Any) -> None:
    result = lowered(chosen)

    def once(names: list[str]) -> list[str]:
        return sorted(set(names))

    assert luma is None or once(ops(result.luma)) == once(luma)
    assert result.chroma is None if chroma is None else once(ops(result.chroma)) == once(chroma)


@in_one_test("name", style_names())
def test_each_node_of_a_shipped_style_has_an_operation_that_the_gpu_knows(name: str) -> None:
    known = {"plane", "mask", "upsample", "resample", "filter_bank", "block", *OPERATION_FILES} - {
        "same_chroma"
    }
    assert known | {"network"} == set(Op.__args__)  # type: ignore[attr-defined]
    for node in nodes_in_order(lowered(load_style(name)).outputs):
        assert node.op in known and (node.op == "block") == (node.block is not None)
        assert node.radius == 0 or node.reads_neighbors


@in_one_test("name", style_names())
def test_the_cpu_stores_what_filters_read_before_they_run(name: str) -> None:
    """And computes nothing but conversions twice."""
    plan = schedule(lowered(load_style(name)))
    at_hand: set[object] = set()
    computed: list[Node] = []
    for task in [*(task for task, _ in plan.tasks), plan.output]:
        if isinstance(task, Sweep):
            for each in task.steps:
                for read in plan.recomputed[each.node].steps if each.node in plan.recomputed else [each]:
                    assert not read.is_loaded or read.node.is_given or read.node in at_hand
                if not each.is_loaded and (each.node.block or each.node.op == "resample"):
                    computed.append(each.node)
                if not each.is_loaded and each.node.op in READS_PLANES:
                    images = each.node.inputs.values()
                    known = at_hand | plan.recomputed.keys()
                    assert all(image.is_given or image in known for image in images)
                assert each.node.measure is None or each.is_loaded or each.node.measure in at_hand
                if each.node.reads_neighbors and not each.is_loaded:
                    most = MAX_FUSED_RADIUS if plan.recomputed else 0
                    assert each.margin <= most, "a sweep has one large neighborhood operation in a row"
            at_hand |= set(task.stores)
        else:
            at_hand.add(task)
    assert len(computed) == len(set(computed))


def test_pixel_blocks_after_a_filter_need_one_sweep() -> None:
    plan = schedule(lowered(style(step("to_gray"), step("gaussian"), step("posterize"), step("brightness"))))
    assert plan.tasks == () and plan.output.stores == ()
    assert plan.output.radius == 6


def test_what_two_sweeps_need_is_stored_by_the_first() -> None:
    chosen = style(
        step("brightness", save="bright"),
        step("posterize"),
        step("sobel"),
        step("blend", other="bright"),
    )
    plan = schedule(lowered(chosen, GRAY))
    ((sweep, _),) = plan.tasks
    assert isinstance(sweep, Sweep)
    assert [node.block.name for node in sweep.stores if node.block] == ["brightness", "posterize"]


def test_a_picture_is_resampled_in_the_sweep_that_reads_it_and_stored_for_two() -> None:
    small, blurred = step("scale", factor=0.5, save="small"), step("gaussian")
    (once,) = schedule(lowered(style(small, blurred), GRAY)).tasks
    assert [node.block.name for node in once[0].stores if node.block] == ["gaussian"]
    twice = style(small, step("sobel"), blurred, step("blend", other="small"))
    stored, *_ = (task for task, _ in schedule(lowered(twice, GRAY)).tasks)
    assert isinstance(stored, Sweep) and [node.op for node in stored.stores] == ["resample"]


def test_two_filters_of_a_sweep_share_the_rows_that_they_read() -> None:
    small, edges = step("scale", factor=0.5, save="small"), step("sobel", save="edges")
    again = step("gaussian", source="small"), step("blend", other="edges")
    (sweep, _), *_ = schedule(lowered(style(small, edges, *again), GRAY)).tasks
    assert isinstance(sweep, Sweep)
    (read,) = [each for each in sweep.steps if each.node.op == "resample"]
    assert read.margin == 6 and read.narrower == ((read.node, 1),) and not read.stores


def test_a_long_style_needs_no_recursion() -> None:
    chosen = style(*[step("brightness", factor=1 + number / 9000) for number in range(2000)])
    assert len(schedule(lowered(chosen, GRAY)).output.steps) == 2001


def test_the_choice_of_recomputed_nodes_visits_each_node_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain of steps that read their input twice has 2 ** 12 ways through it."""
    monkeypatch.setattr("vidstyle.cpu.scheduling.schedule.MAX_STORED_BYTES_PER_PIXEL", 0)
    monkeypatch.setattr("vidstyle.cpu.scheduling.schedule.MAX_COMPACT_RATIO", math.inf)
    monkeypatch.setattr("vidstyle.cpu.scheduling.stored_nodes.MAX_RECOMPUTED_STEPS", 20)
    visits: list[Node] = []
    monkeypatch.setattr(Node, "reads_neighbors", property(_counted(Node.reads_neighbors.fget, visits)))  # type: ignore[attr-defined]
    chain = [step("blend", other=f"s{number}", save=f"s{number + 1}") for number in range(12)]
    plan = schedule(lowered(style(step("brightness", save="s0"), *chain, step("kuwahara")), RGB))
    assert [node.block.name for node in plan.recomputed if node.block] == ["blend"]
    assert len(visits) < 200


def _counted(function: Callable[[Node], bool], calls: list[Node]) -> Callable[[Node], bool]:
    def called(node: Node) -> bool:
        calls.append(node)
        return function(node)

    return called


def test_values_that_resampling_puts_out_of_range_are_clipped_when_resampled_again() -> None:
    """Once is possible without clipping: a chain of it would leave every bound."""
    twice = step("scale", factor=0.5, method="lanczos"), step("scale", factor=0.5, method="lanczos")
    luma = lowered(style(*twice, step("posterize"))).luma
    assert luma is not None
    found = [each for each in nodes_in_order([luma]) if each.op == "resample"]
    assert [each.limits is not None for each in found][:2] == [False, True]
    assert [each.may_overshoot for each in found][:2] == [True, False]
