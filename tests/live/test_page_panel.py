"""The controls of the page: each value with its path and range, and the command line options for it."""

from __future__ import annotations

import shlex

import pytest
from covering import of_the_day

from vidstyle.blocks import all_blocks
from vidstyle.style import Style, load_style, override, style_names
from vidstyle.style.panel import panel


def read(text: str) -> Style:
    """The style that options of the command line mean."""
    words = shlex.split(text)
    assert words[::2] == ["--style", *["--set"] * (len(words) // 2 - 1)]
    return override(load_style(words[1]), words[3::2])


def values(style: Style) -> dict[str, object]:
    return {entry["path"]: entry["value"] for entry in panel(style, style)["entries"]}


@pytest.mark.parametrize("name", of_the_day(style_names(), 9))
class TestEveryStyle:
    def test_every_value_can_be_set_by_its_path(self, name: str) -> None:
        style = load_style(name)
        entries = panel(style, style)["entries"]
        wanted = sum(len(all_blocks()[step.block].parameters) for step in style.steps if step.block)
        assert len([entry for entry in entries if entry["step"]]) == wanted
        assert len({entry["path"] for entry in entries}) == len(entries)
        same = override(style, [f"{entry['path']}={entry['value']}".lower() for entry in entries])
        assert panel(same, style)["entries"] == entries

    def test_a_value_lies_where_its_control_reaches(self, name: str) -> None:
        style = load_style(name)
        for entry in panel(style, style)["entries"]:
            if entry["kind"] == "slider":
                assert entry["low"] <= entry["value"] <= entry["high"]
            elif entry["kind"] == "choice":
                assert entry["value"] in entry["options"]

    def test_two_to_four_knobs_come_to_the_top(self, name: str) -> None:
        style = load_style(name)
        main = {entry["path"] for entry in panel(style, style)["entries"] if entry["main"]}
        fields = {"ink", "paper", "steady", "strength", "focus"}
        assert fields <= main and len(main) == len(fields.union(style.knobs))
        assert len(style.knobs) in ((0,) if style.is_plain else (2, 3, 4))

    def test_the_options_lead_to_the_style(self, name: str) -> None:
        style = load_style(name)
        assert panel(style, style)["text"] == f"--style {name}"
        ends = [
            f"{entry['path']}={entry['high']}"
            for entry in panel(style, style)["entries"]
            if entry["kind"] == "slider"
        ]
        changed = override(style, [*ends, "paper=#123456"])
        assert values(read(panel(changed, style)["text"])) == values(changed)

    def test_every_variant_is_known_by_its_values(self, name: str) -> None:
        style = load_style(name)
        assert [each["name"] for each in panel(style, style)["variants"]] == list(style.variants)
        for variant in style.variants:
            varied = override(style, [f"{path}={value}" for path, value in style.variants[variant].items()])
            shown = panel(varied, style)
            assert (shown["variant"], shown["text"]) == (variant, f"--style {name}:{variant}")
            further = override(varied, ["steady=0.13"])
            assert panel(further, style)["text"] == f"--style {name}:{variant} --set steady=0.13"


def test_a_step_that_occurs_twice_has_paths_of_its_own() -> None:
    step = {"block": "gaussian", "sigma": 3.0}
    style = load_style({"format": 1, "base": [step], "lines": [step, step, {"block": "sobel"}]})
    paths = [entry["path"] for entry in panel(style, style)["entries"] if entry["step"]]
    assert paths[:3] == ["base.gaussian.sigma", "lines.gaussian#1.sigma", "lines.gaussian#2.sigma"]


def test_what_was_changed_is_told_from_what_it_was() -> None:
    style = load_style("ink")
    entries = {entry["path"]: entry for entry in panel(override(style, ["steady=1"]), style)["entries"]}
    assert (entries["steady"]["value"], entries["steady"]["start"]) == (1, 0.5)
    assert [path for path, entry in entries.items() if entry["value"] != entry["start"]] == ["steady"]
