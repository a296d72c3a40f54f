"""Facts that hold for the declaration of every block."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import get_args

import pytest
from covering import in_one_test

import vidstyle
from vidstyle.block import Asset, Block, BlockKind, Choice, Color, On, Parameter, SavedRef, Slider, Switch
from vidstyle.blocks import all_blocks

BLOCKS = list(all_blocks().values())
PARAMETERS = [(block, parameter) for block in BLOCKS for parameter in block.parameters.values()]
PAPER = """
    to_gray to_color posterize luma_posterize brightness soft_threshold saturation hue colorize gaussian
    sobel scale pattern halftone equalize minimum_range
""".split()

every_block = in_one_test("block", BLOCKS)
every_parameter = in_one_test("block, parameter", PARAMETERS)


def test_every_file_is_found_as_a_block() -> None:
    folder = Path(__file__).parents[2] / "vidstyle" / "blocks"
    assert set(all_blocks()) == {path.stem for path in folder.glob("*.py")} - {"__init__"}
    assert set(PAPER) <= set(all_blocks())


@every_block
def test_block_file_and_function_share_one_name(block: Block) -> None:
    assert isinstance(block, Block)
    assert block.name == block.function.__name__ == block.function.__module__.rpartition(".")[2]
    assert all_blocks()[block.name] is block


@every_block
def test_block_has_known_kind(block: Block) -> None:
    assert block.kind in get_args(BlockKind)
    assert block.on in get_args(On)
    assert (block.percentiles is not None) == (block.kind == "measured")


@every_block
def test_block_has_one_line_summary(block: Block) -> None:
    assert re.fullmatch(r"[A-Z].{10,100}[.;:].*", block.help), block.help


@every_block
def test_no_parameter_is_named_like_a_key_of_a_step(block: Block) -> None:
    assert {"block", "from", "save", "on", "source"}.isdisjoint(block.parameters)
    assert all(re.fullmatch("[a-z][a-z0-9_]*", name) for name in block.parameters)


@every_block
def test_defaults_complete_themselves(block: Block) -> None:
    complete = block.arguments_for({})
    assert list(complete) == list(block.parameters)
    for name, parameter in block.parameters.items():
        if isinstance(parameter.control, Color):
            assert all(0 <= channel <= 1 for channel in complete[name])


@every_parameter
def test_help_is_short_and_has_no_full_stop(block: Block, parameter: Parameter) -> None:
    help_text = parameter.control.help
    assert 3 <= len(help_text) <= 90
    assert not help_text.endswith(".")
    assert help_text == help_text.strip()
    assert parameter.control.range_text


@every_parameter
def test_the_default_is_allowed_and_has_its_own_type(block: Block, parameter: Parameter) -> None:
    checked = parameter.check(parameter.default)
    assert checked == parameter.default
    assert isinstance(checked, int) or not parameter.is_integer


@every_parameter
def test_values_for_exploring_are_allowed(block: Block, parameter: Parameter) -> None:
    control = parameter.control
    if isinstance(control, Slider):
        assert control.low < control.high
        if control.explore:
            low, high = control.explore
            assert control.low <= low < high <= control.high
    elif isinstance(control, Choice | Switch | Color):
        assert all(parameter.check(value) == value for value in control.explore)


@every_parameter
def test_value_outside_range_is_refused(block: Block, parameter: Parameter) -> None:
    control = parameter.control
    wrong: dict[type, list[object]] = {
        Choice: ["", "none of them", 1, None],
        Switch: [1, 0, "true", None],
        Color: ["reddish", "#12345", "#1234567", 0],
        SavedRef: ["a b", "../x", 3, None],
        Asset: ["/etc/passwd", "../x", 3, None],
    }
    if isinstance(control, Slider):
        wrong[Slider] = [control.low - 1, control.high + 1, float("nan"), float("inf"), "1", None, True]
    for value in wrong[type(control)]:
        with pytest.raises(ValueError, match=re.escape(repr(value)) if isinstance(value, str) else None):
            parameter.check(value)


@every_parameter
def test_the_schema_can_be_written_as_json(block: Block, parameter: Parameter) -> None:
    schema = json.loads(json.dumps(parameter.schema()))
    assert schema["default"] == parameter.default
    assert schema["description"] == parameter.control.help


def test_pages_have_a_function_for_each_kind_of_control() -> None:
    script = (Path(vidstyle.__file__).parent / "export" / "modules" / "controls.js").read_text("utf-8")
    table = re.findall(r"const CONTROLS = \{(.*)\}", script)[0]
    functions = {entry.partition(":")[0].strip() for entry in table.split(",")}
    assert {parameter.describe([])["kind"] for _, parameter in PARAMETERS} == functions
