"""Plans for WebGL 2, run by the runner in a browser, agree with the CPU."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from block_settings import RICHER_BANKS, block_style, ends_of
from block_settings import folder as folder
from browser import StyleBrowser
from covering import of_the_day
from gpu import ODD, SMALL, scene

import vidstyle
from vidstyle.block import Block
from vidstyle.blocks import all_blocks
from vidstyle.cli.styles import OPENGL_FORMS
from vidstyle.core.resample import scaled_shape
from vidstyle.core.sampling import ExponentialSmoother, Sampling
from vidstyle.gpu.compile.es import es_plan, vertex_shader
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.plan import plan_for_video
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.style import Step, Style, load_style, override, style_names

SHARES = {False: 0.001, True: 0.002}
"""The share of samples that may be off by more than one code, in float32 and in half floats."""
FILM_PALETTE = Step("palette", {"colors": "film-8"})
SAMPLES_AROUND_A_CHOICE = 27
"""Samples of 3 x 3 pixels: where one pixel takes another filter of a bank, a second bank spreads that. In
small pictures these are more than the share above."""


@cache
def picture(height: int, width: int) -> np.ndarray:
    return (scene(height, width) * 255 + 0.5).astype(np.uint8)


def fault(browser: StyleBrowser, chosen: Style, shape: tuple[int, int], half: bool) -> str:
    """Return the disagreements of a style in the browser with the CPU, or ""."""
    source = picture(*shape)
    right = vidstyle.stylize(source, replace(chosen, steady=0.0, keeps_detail=True), "cpu").astype(int)
    (made,) = browser.restyled(es_plan(chosen, *shape[::-1]), [source], half)
    off = np.abs(made - right) > 1
    allowed = max(SHARES[half] * off.size, SAMPLES_AROUND_A_CHOICE)
    return "" if off.sum() <= allowed else f"{off.mean():.3%} of the samples are off"


STYLES = [f"{name} in {precision}" for name in style_names() for precision in ("float", "half")]


@pytest.mark.parametrize("case", of_the_day(STYLES, 1))
def test_every_style_gives_in_a_browser_what_it_gives_on_the_cpu(
    case: str, style_browser: StyleBrowser
) -> None:
    name, _, precision = case.split()
    assert not fault(style_browser, load_style(name), ODD, precision == "half")


def settings(block: Block) -> list[dict[str, Any]]:
    """The defaults, all values at their low ends, and all at their high ends."""
    ends = ends_of(block)
    return [{}, *({name: values[end] for name, values in ends.items()} for end in (0, -1) if ends)]


@pytest.mark.parametrize("block", of_the_day(list(all_blocks().values()), 1), ids=lambda block: block.name)
def test_every_block_gives_in_a_browser_what_it_gives_on_the_cpu(
    block: Block, style_browser: StyleBrowser, folder: Path
) -> None:
    for values in settings(block):
        assert not fault(style_browser, block_style(block, values, folder), SMALL, False), values


@pytest.mark.parametrize("make_style", RICHER_BANKS)
def test_a_bank_of_another_form_gives_in_a_browser_what_it_gives_on_the_cpu(
    make_style: Callable[[Path], Path], style_browser: StyleBrowser, tmp_path: Path
) -> None:
    look = load_style(make_style(tmp_path))
    assert not fault(style_browser, look, SMALL, False)


@pytest.mark.parametrize("shape", [(1, 3), (2, 5), (20, 40)], ids=str)
def test_a_bank_works_on_a_single_pixel(shape: tuple[int, int], style_browser: StyleBrowser) -> None:
    look = Style("test", background=(Step("scale", {"factor": 0.05}), Step("etf"), Step("detail")))
    right = vidstyle.stylize(picture(*shape), look, "cpu").astype(int)
    (made,) = style_browser.restyled(es_plan(look, *shape[::-1]), [picture(*shape)], False)
    assert np.abs(made - right).max() <= 1


def test_a_bank_at_reduced_size_runs_on_pictures_of_another_width(style_browser: StyleBrowser) -> None:
    """The page computes the size of the reduced picture and its border itself."""
    look, wide = Style("test", background=(Step("flow_dog", {"sigma": 3.0, "p": 1.0}),)), picture(61, 140)
    right = vidstyle.stylize(wide, look, "cpu").astype(int)
    (made,) = style_browser.restyled(es_plan(look, 97, 61), [wide], False)
    assert (np.abs(made - right) <= 1).mean() > 0.999


def test_percentiles_and_smoothing_are_those_of_python(style_browser: StyleBrowser) -> None:
    random = np.random.default_rng(3)
    pictures = [random.normal(0.5, 0.3, count).astype(np.float32) for count in (1, 2, 7, 4000)]
    percentages, times = [0.0, 5.0, 33.3, 50.0, 98.7, 100.0], [0.0, 0.04, 0.5, 0.2, 0.3]
    found = style_browser.run(
        """return pictures.map((numbers) => {
          const smoother = new vidstyle.Smoother();
          const measured = vidstyle.percentiles(Float32Array.from(numbers), percentages);
          const next = (each) => measured.map((one) => one * (each + 1));
          return times.map((time, each) => smoother.follow(next(each), time, 0.4));
        })""",
        pictures=[each.tolist() for each in pictures], percentages=percentages, times=times,
    )  # fmt: skip
    for numbers, smoothed in zip(pictures, found, strict=True):
        smoother, measured = ExponentialSmoother(), np.percentile(numbers, percentages)
        right = [smoother.follow(measured * (each + 1), time, 0.4) for each, time in enumerate(times)]
        assert np.allclose(smoothed, right, atol=1e-6)


def test_sizes_and_samples_are_those_of_python(style_browser: StyleBrowser) -> None:
    sizes = [(1, 1), (97, 61), (1920, 1080), (321, 17), (4000, 3), (640, 641)]
    factors = [0.05, 0.125, 0.3333333, 0.5, 0.75, 1.0, 2.5]
    found = style_browser.run(
        """return sizes.map((size) => [
          factors.map((factor) => vidstyle.scaledSize(size, factor, 0)), vidstyle.sampling(size, 320)]);""",
        sizes=sizes, factors=factors,
    )  # fmt: skip
    for (width, height), (scaled, sampled) in zip(sizes, found, strict=True):
        assert [size[::-1] for size in scaled] == [
            list(scaled_shape((height, width), each)) for each in factors
        ]
        right = Sampling.of(height, width)
        assert (sampled["stride"], sampled["first"][::-1], sampled["size"][::-1]) == (
            right.stride, list(right.first), list(right.shape),
        )  # fmt: skip


@pytest.mark.parametrize("shape", [(181, 243), (240, 320), (100, 601), (2, 300)])
def test_colors_of_a_larger_picture_are_taken_as_on_the_cpu(
    shape: tuple[int, int], style_browser: StyleBrowser
) -> None:
    assert fault(style_browser, Style("test", background=(FILM_PALETTE,)), shape, False) == ""


def test_noise_is_drawn_anew_as_on_the_cpu(style_browser: StyleBrowser) -> None:
    chosen = Style("test", background=(Step("noise", {"amount": 1.0, "rate": 12}),))
    times = [0.0, 0.04, 0.16, 7200.04]
    with vidstyle.Renderer(chosen, "cpu") as renderer:
        right = [renderer(picture(*SMALL), time).astype(int) for time in times]
    made = style_browser.restyled(es_plan(chosen, *SMALL[::-1]), [picture(*SMALL)] * 4, times=times)
    assert (right[0] == right[1]).all() and (right[1] != right[2]).any()
    assert all((np.abs(one - other) <= 1).mean() > 0.999 for one, other in zip(made, right, strict=True))


@pytest.mark.parametrize(
    "taken",
    [Step("equalize", {"settle": 0.3}), FILM_PALETTE],
    ids=lambda step: step.block,
)
def test_what_is_taken_of_a_film_follows_it_as_on_the_cpu(taken: Step, style_browser: StyleBrowser) -> None:
    chosen = Style("test", background=(taken,))
    films = [picture(*SMALL), (picture(*SMALL) * 0.8 + 20).astype(np.uint8), picture(*SMALL)]
    times = [0.0, 0.1, 0.3]
    with vidstyle.Renderer(chosen, "cpu") as renderer:
        right = [renderer(each, time) for each, time in zip(films, times, strict=True)]
    made = style_browser.restyled(es_plan(chosen, *SMALL[::-1]), films, times=times)
    assert (right[0] != right[2]).any()
    for one, other in zip(right, made, strict=True):
        assert (np.abs(one.astype(int) - other) > 1).mean() <= SHARES[False]


def test_a_slider_changes_numbers_alone_and_another_size_needs_no_other_plan(
    style_browser: StyleBrowser,
) -> None:
    """For pictures whose shorter side is as long: on it depend all lengths."""
    before = es_plan(load_style("cartoon"), 97, 61)
    chosen = override(load_style("cartoon"), ["posterize#1.levels=7", "saturation.factor=0.5"])
    after = es_plan(chosen, 143, 61)
    values = after.pop("values")
    assert after | {"size": [97, 61], "values": before["values"]} == before
    source = picture(61, 143)
    (made,) = style_browser.restyled(before | {"values": values}, [source])
    right = vidstyle.stylize(source, replace(chosen, steady=0.0, keeps_detail=True), "cpu").astype(int)
    assert (np.abs(made - right) > 1).mean() <= SHARES[False]


def test_a_lost_context_comes_back(style_browser: StyleBrowser) -> None:
    lost, back = style_browser.run(
        """let restored;
        const returned = new Promise((done) => { restored = done; });
        const runner = new vidstyle.Runner({ onrestored: restored });
        const style = await runner.load(plan);
        const source = new ImageData(new Uint8ClampedArray(4 * 12).fill(90), 4, 3);
        const canvas = Object.assign(document.createElement("canvas"), { width: 4, height: 3 });
        const pixel = () => [...canvas.getContext("2d").getImageData(1, 1, 1, 1).data];
        const switches = runner.context.gl.getExtension("WEBGL_lose_context");
        runner.draw(style, source, canvas);
        const before = pixel();
        switches.loseContext();
        const lost = runner.draw(style, source, canvas);
        await new Promise((done) => setTimeout(done, 50));
        switches.restoreContext();
        await returned;
        canvas.getContext("2d").clearRect(0, 0, 4, 3);
        runner.draw(style, source, canvas);
        runner.release();
        return [lost, String(before) === String(pixel()) && before[3] === 255];""",
        plan=es_plan(load_style({"format": 1, "background": [{"block": "gaussian"}]}), 4, 3),
    )
    assert lost is None and back


@pytest.mark.skipif(shutil.which("glslangValidator") is None, reason="no glslangValidator here")
@pytest.mark.parametrize(
    "form", ["es", *(pytest.param(form, marks=pytest.mark.thorough) for form in OPENGL_FORMS)]
)
def test_every_shader_is_valid_glsl(form: Form, tmp_path: Path) -> None:
    """By the reference compiler, without an error or a warning: a check for drivers that are not here."""
    ending = "comp" if form == "compute" else "frag"
    texts = {
        write_shader(plan, each).assembly.text
        for name in style_names()
        for plan in [plan_for_video(load_style(name), 640, 360, form)]
        for each in plan.passes
    }
    files = [tmp_path / f"{number}.{ending}" for number in range(len(texts))]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    if form == "es":
        files.append(tmp_path / "triangle.vert")
        files[-1].write_text(vertex_shader("es"))
    checked = subprocess.run(["glslangValidator", *files], capture_output=True, text=True)
    said = [line for line in checked.stdout.splitlines() if line and line not in map(str, files)]
    assert (checked.returncode, said) == (0, [])


def test_what_this_form_leaves_out_is_named() -> None:
    assert es_plan(load_style("sketch"), 64, 36)["server"] == ["steady"]
    assert es_plan(override(load_style("sketch"), ["steady=0"]), 64, 36)["server"] == []
