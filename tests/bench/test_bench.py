"""Benchmarks: everything is measured, and reports follow from the measurements.

Nothing here depends on how fast this machine is.
"""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from covering import of_the_day
from media import make_clip
from pictures import step, style

from vidstyle import cli
from vidstyle.bench import Bench, Timed, _forms
from vidstyle.bench.films import FilmBench
from vidstyle.bench.paper_figures import PAPER_FIGURES, figure_for
from vidstyle.bench.results import as_dict, film_markdown, markdown
from vidstyle.bench.subjects import Subject, film_picture_at, subjects
from vidstyle.blocks import all_blocks
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.errors import DeviceError
from vidstyle.gpu.compile.explain import explain
from vidstyle.gpu.compile.plan import Plan, make_plan, plan_for_video
from vidstyle.gpu.device.context import close_context, open_context
from vidstyle.gpu.device.devices import choose
from vidstyle.gpu.device.gpu_resources import GpuResources
from vidstyle.gpu.timing import GpuTimes, TimedRunner, TimerKind
from vidstyle.style import Style, load_style, style_names
from vidstyle.style.resolve import resolve

SKETCH = Subject("style", "sketch", load_style("sketch"))


def run(capfd: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of `vidstyle bench` with these arguments."""
    exit_code = cli.main(["bench", "--seconds", "0", *map(str, arguments)])
    return exit_code, *capfd.readouterr()


def plan_for(chosen: Style, picture: Picture, form: Any) -> Plan:
    steps = resolve(chosen, *picture.shape)
    return make_plan(chosen, steps, PictureLayout.of(picture), picture.encoding, False, form)


def test_every_block_and_every_style_that_does_something_is_measured() -> None:
    found = subjects()
    assert [each.name for each in found if each.kind == "block"] == list(all_blocks())
    assert [each.name for each in found if each.kind == "style"] == sorted(set(style_names()) - {"plain"})


@pytest.mark.parametrize("subject", of_the_day(subjects(), 20), ids=lambda subject: subject.name)
def test_all_of_them_run_on_both_and_their_last_step_is_the_block(subject: Subject) -> None:
    picture = film_picture_at(64, 36)
    with CpuRenderer(subject.style) as renderer:
        assert renderer.run(picture).shape == (36, 64)
    plan_for_video(subject.style, 64, 36, "compute")
    if subject.kind == "block":
        assert subject.style.background[-1].block == subject.name
        assert not subject.style.background[-1].values, "at its defaults"


def test_the_picture_is_video_of_the_size_that_is_asked_for() -> None:
    picture = film_picture_at(65, 37)
    assert picture.shape == (37, 65)
    assert (picture.encoding, picture.chroma[0].shape) == (Encoding(), (19, 33))
    assert picture.luma.std() > 20, "there is something on it"


@pytest.mark.parametrize("clock", ["timer queries", "wall clock"])
@pytest.mark.parametrize("max_side", [8192, 128])
def test_every_pass_of_every_tile_takes_time(clock: TimerKind, max_side: int) -> None:
    picture = film_picture_at(192, 108)
    plan = plan_for(load_style("riso"), picture, "fragment")
    context = open_context()
    try:
        runner = TimedRunner(GpuResources(context), plan, max_side, clock)
        runner.run(picture, 1)
        times = runner.run(picture, 3)
        assert context.error == "GL_NO_ERROR"
    finally:
        close_context(context)
    assert len(times) == len(plan.passes)
    assert all(0 < seconds < 60 for seconds in times)


def test_the_command_measures_both_forms_of_passes(capfd) -> None:
    exit_code, out, err = run(
        capfd, "--size", "64x36", "--size", "33x17", "--device", "gpu", "--form", "both", "--json",
        "--style", "sketch", "--block", "to_gray",
    )  # fmt: skip
    assert exit_code == 0
    data = json.loads(out)
    results = {(result["name"], *result["size"]): result for result in data["results"]}
    assert list(results) == [(n, *s) for s in ([64, 36], [33, 17]) for n in ("to_gray", "sketch")]
    for name, *size in results:
        assert f"vidstyle: {name}, {size[0]}x{size[1]}: CPU " in err
    for (name, *_), result in results.items():
        assert result["cpu"]["ms"] > 0
        assert [gpu["form"] for gpu in result["gpu"]] == ["compute", "fragment"]
        for gpu in result["gpu"]:
            assert bool(gpu["passes"]) == (name == "sketch"), "an unchanged plane needs no pass"
            assert all(part["ms"] > 0 for part in gpu["passes"])
            parts = [gpu[part]["ms"] for part in ("upload", "download", "whole")]
            assert all(part > 0 for part in parts) or name == "to_gray"
            assert gpu["all_passes"]["ms"] == pytest.approx(sum(part["ms"] for part in gpu["passes"]))
    assert results["sketch", 64, 36]["paper"] == {"style": 3, "desktop": 1469.1, "mobile": 128.4}


def test_the_cpu_alone_needs_no_gpu(capfd, tmp_path: Path) -> None:
    table = tmp_path / "table.md"
    arguments = ("--size", "64x36", "--device", "cpu", "--block", "hue", "-o", table)
    assert run(capfd, *arguments)[:2] == (0, "")
    written = table.read_text()
    assert "## 64x36, CPU" in written and "passes" not in written
    exit_code, _, err = run(capfd, *arguments)
    assert (exit_code, err.count("\n")) == (2, 1) and "already exists" in err and "-y" in err
    assert run(capfd, *arguments, "-y")[0] == 0


@pytest.mark.parametrize(
    ("arguments", "exit_code", "words"),
    [
        (["--block", "posterise"], 2, "posterize"),
        (["--style", "skech"], 3, "sketch"),
        (["--size", "640x-1"], 2, "both sides"),
        (["--device", "gpo"], 2, "gpo"),
        (["--bandwidth", "0"], 2, "--bandwidth"),
    ],
)
def test_what_cannot_be_measured_is_one_line(capfd, arguments, exit_code, words) -> None:
    found, out, err = run(capfd, *arguments)
    assert (found, out, err.count("\n")) == (exit_code, "", 1)
    assert words in err


def test_a_device_without_compute_passes_says_so() -> None:
    device = choose("gpu").device
    assert device is not None
    assert _forms(device, "best") == ["compute"] and _forms(device, "both") == ["compute", "fragment"]
    old = replace(device, version=410)
    assert _forms(old, "best") == ["fragment"]
    for form in ("compute", "both"):
        with pytest.raises(DeviceError, match="--form fragment"):
            _forms(old, form)


def test_speeds_follow_from_times_and_bytes() -> None:
    plan = plan_for_video(SKETCH.style, 1000, 500, "compute")
    passes = tuple(0.001 * number for number in range(1, len(plan.passes) + 1))
    times = GpuTimes(plan, "timer queries", passes, 0.002, 0.004, 0.05)
    bench = Bench([(1000, 500)], [SKETCH], choose("gpu").device, ["compute"], 1)
    data = as_dict(bench, [Timed(SKETCH, (1000, 500), 0.25, (times,))], bandwidth=50)
    (result,) = data["results"]
    (gpu,) = result["gpu"]
    whole = sum(passes)
    assert result["cpu"] == {"ms": 250, "mp_per_s": 2}
    assert gpu["all_passes"] == {"ms": pytest.approx(1e3 * whole), "mp_per_s": pytest.approx(0.5 / whole)}
    assert (gpu["whole"], gpu["upload"]["mp_per_s"]) == ({"ms": 50, "mp_per_s": pytest.approx(10)}, 250)
    rate = explain(plan)["bytes"] * 500_000 / whole / 1e9
    assert gpu["gigabytes_per_s"] == pytest.approx(rate)
    assert gpu["share_of_bandwidth"] == pytest.approx(rate / 50)
    row = rows_after("compute passes, timed by timer queries", markdown(data))["sketch"]
    assert (row["whole, ms"], row["upload, ms"], row["download, ms"]) == ("50", "2", "4")
    assert (row["passes"], row["paper, MP/s"]) == (str(len(passes)), "1469, 128")
    assert row["of bandwidth"] == f"{rate / 50:.0%}"


def rows_after(title: str, text: str) -> dict[str, dict[str, str]]:
    """The rows of the table below this title, by their first cells."""
    table = text.partition(title)[2].strip().partition("\n\n")[0]
    header, _, *rows = ([cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines())
    return {row[0]: dict(zip(header, row, strict=True)) for row in rows}


def test_a_column_without_numbers_is_left_out() -> None:
    times = Timed(Subject("block", "hue", style(step("hue")), "RGB"), (100, 100), 0.001, ())
    text = markdown(as_dict(Bench([(100, 100)], [times.subject], None, (), 1), [times]))
    assert rows_after("CPU", text) == {
        "hue": {"block or style": "hue", "works on": "RGB", "ms": "1", "MP/s": "10"}
    }


def test_learned_filters_stand_beside_those_of_the_paper() -> None:
    etf = Timed(Subject("block", "etf", style(step("etf")), "luma"), (100, 100), 0.001, ())
    hue = Timed(Subject("block", "hue", style(step("hue")), "RGB"), (100, 100), 0.001, ())
    for timed, told in ((etf, True), (hue, False)):
        text = markdown(as_dict(Bench([(100, 100)], [timed.subject], None, (), 1), [timed]))
        assert ("27.1 MP/s on a Xeon" in text) == told


def test_the_figures_of_the_paper_are_those_of_its_table() -> None:
    assert len(PAPER_FIGURES) == 13 and [figure.style for figure in PAPER_FIGURES] == list(range(1, 14))
    assert max(PAPER_FIGURES, key=lambda figure: figure.desktop).style == 11
    assert all(5 < figure.desktop / figure.mobile < 18 for figure in PAPER_FIGURES), "a tenth, its text says"
    assert figure_for("comic") is None


def test_the_styles_made_after_the_paper_stand_beside_its_figures() -> None:
    beside = {name: figure.style for name in style_names() if (figure := figure_for(name))}
    assert beside == {"ink": 1, "crayon": 2, "sketch": 3, "cartoon": 4, "impressionist": 5}
    timed = [
        Timed(Subject("style", name, style()), (100, 100), 0.001, ()) for name in ("cartoon", "comic", "ink")
    ]
    text = markdown(as_dict(Bench([(100, 100)], [each.subject for each in timed], None, (), 1), timed))
    told = "Its style 1 is compared with `ink`, 4 with `cartoon` (`kuwahara` for ETF): similar in look"
    assert told in " ".join(text.split())


def test_a_film_is_measured_part_by_part(tmp_path: Path) -> None:
    film = make_clip(tmp_path / "film.mp4", size=(64, 36), frames=6)
    clock = count()
    (found,) = FilmBench(film, 5, lambda: float(next(clock))).run([SKETCH], "cpu")
    assert (found.decode, found.style, found.steady, found.encode) == (1 / 5, 1, 0, 1 / 5)
    assert found.whole > 0
    table = film_markdown([replace(found, whole=0.5)]).splitlines()
    assert [cell.strip() for cell in table[2].split("|")[1:-1]] == ["sketch", "200", "1000", "0", "200", "2"]


def test_a_film_is_chosen_by_an_option(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    film = make_clip(tmp_path / "film.mp4", size=(64, 36), frames=4)
    exit_code, out, _ = run(capfd, "--film", film, "--style", "sketch", "--device", "cpu", "--json")
    assert exit_code == 0
    assert [each["name"] for each in json.loads(out)] == ["sketch"]
    short = make_clip(tmp_path / "short.mp4", size=(64, 36), frames=2)
    exit_code, _, error = run(capfd, "--film", short)
    assert exit_code == 3
    assert "has 2 frames; give a longer film" in error
