"""`vidstyle export STYLE OUT.hook`: FFmpeg's libplacebo on software Vulkan agrees with the CPU."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
from block_settings import RICHER_BANKS
from covering import of_the_day
from gpu import ODD, SMALL
from media import photograph

import vidstyle
from vidstyle.cli import main
from vidstyle.core.picture import Picture
from vidstyle.export.frozen import freeze_colors, frozen_percentiles
from vidstyle.export.hook import height_powers, hook_of
from vidstyle.gpu.compile.es import EsPlan
from vidstyle.media.read.reader import open_reader
from vidstyle.style import Step, Style, load_style, style_names

DRIVERS = sorted(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))
MEAN, NEAR = 1.0, 0.998
"""The mean difference in codes that is allowed, and the share of the samples within 8 codes."""
FEW_SAMPLES = 90
"""Of thirty pixels: with half floats, squares of `pixel` may get another of 32 colours of the picture.
In a small picture, where a square is a pixel, this is more than the share above: 27 of 7,575 pixels."""


@cache
def has_libplacebo() -> bool:
    if not DRIVERS or shutil.which("ffmpeg") is None:
        return False
    listed = subprocess.run(["ffmpeg", "-hide_banner", "-filters"], capture_output=True, text=True)
    return " libplacebo " in listed.stdout


needs_ffmpeg = pytest.mark.skipif(
    "not has_libplacebo()", reason="no FFmpeg with libplacebo and software Vulkan here"
)


def picture(height: int, width: int) -> np.ndarray:
    return cv2.resize(photograph("coffee"), (width, height), interpolation=cv2.INTER_AREA)


def text_of(style: Style, width: int, height: int, source: np.ndarray) -> str:
    def plan_of(chosen: Style) -> EsPlan:
        return EsPlan.of(chosen, width, height, depth=0)

    plan = plan_of(style)
    frozen = frozen_percentiles(style, [source]) if plan.data["measures"] else {}
    freeze_colors(plan.data, [source])
    return hook_of(style, plan.data, height_powers(plan, plan_of, style), frozen, "a test")


def run_ffmpeg(hook: Path, source: Path, pixels: str, *target: str) -> None:
    placebo = f"libplacebo=dithering=none:custom_shader_path={hook}"
    filters = f"format=rgba,hwupload,{placebo},hwdownload,format=rgba,format={pixels}"
    run = subprocess.run(
        ["ffmpeg", "-v", "error", "-y", "-init_hw_device", "vulkan=vk", "-filter_hw_device", "vk",
         "-i", str(source), "-vf", filters, *target],
        env=os.environ | {"VK_ICD_FILENAMES": str(DRIVERS[0])}, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr[:2000]


def in_ffmpeg(text: str, source: np.ndarray, folder: Path) -> np.ndarray:
    """A picture, H x W x 3 uint8, as FFmpeg restyles it."""
    assert cv2.imwrite(str(folder / "in.png"), source[..., ::-1])
    (folder / "test.hook").write_text(text)
    run_ffmpeg(folder / "test.hook", folder / "in.png", "rgba", "-frames:v", "1", str(folder / "out.png"))
    made = cv2.imread(str(folder / "out.png"))
    assert made is not None
    return made[..., ::-1]


def check(made: np.ndarray, style: Style, source: np.ndarray) -> None:
    right = vidstyle.stylize(source, replace(style, steady=0.0, keeps_detail=True), "cpu")
    off = np.abs(made.astype(int) - right)
    far = np.count_nonzero(off > 8)
    assert off.mean() <= MEAN and far <= max((1 - NEAR) * off.size, FEW_SAMPLES), f"{off.mean():.3f}, {far}"


@needs_ffmpeg
@pytest.mark.parametrize("name", of_the_day(style_names(), 1))
def test_every_style_gives_in_ffmpeg_what_it_gives_on_the_cpu(name: str, tmp_path: Path) -> None:
    style, source = load_style(name), picture(*ODD)
    check(in_ffmpeg(text_of(style, *ODD[::-1], source), source, tmp_path), style, source)


@needs_ffmpeg
@pytest.mark.parametrize("make_style", RICHER_BANKS)
def test_a_bank_of_another_form_gives_in_ffmpeg_what_it_gives_on_the_cpu(
    make_style: Callable[[Path], Path], tmp_path: Path
) -> None:
    style, source = load_style(make_style(tmp_path)), picture(*SMALL)
    check(in_ffmpeg(text_of(style, *SMALL[::-1], source), source, tmp_path), style, source)


@needs_ffmpeg
def test_noise_is_drawn_anew_from_frame_to_frame(tmp_path: Path) -> None:
    steps = Step("gaussian"), Step("noise", {"amount": 1.0, "rate": 24}), Step("gaussian", {"sigma": 0.5})
    style, source = Style("test", background=steps), picture(90, 160)
    (tmp_path / "test.hook").write_text(text_of(style, 160, 90, source))
    for number in range(4):
        assert cv2.imwrite(str(tmp_path / f"in{number}.png"), source[..., ::-1])
    run_ffmpeg(tmp_path / "test.hook", tmp_path / "in%d.png", "rgba", str(tmp_path / "out%d.png"))
    with vidstyle.Renderer(style, "cpu") as renderer:
        for number in range(4):
            made = cv2.imread(str(tmp_path / f"out{number + 1}.png"))[..., ::-1].astype(int)
            assert np.abs(made - renderer(source, number / 25)).mean() <= MEAN


LENGTHS = {
    "format": 1,
    "height": 720,
    "note": "Tune `gaussian.sigma`.",
    "background": [{"block": "gaussian", "sigma": 9}, {"block": "halftone", "cell": 20}],
}


@needs_ffmpeg
def test_lengths_grow_with_the_picture(tmp_path: Path) -> None:
    style, source = load_style(LENGTHS), picture(181, 243)
    check(in_ffmpeg(text_of(style, 1280, 720, source), source, tmp_path), style, source)


@needs_ffmpeg
@pytest.mark.parametrize("ending", of_the_day(["mp4", "mkv", "avi"], 1))
def test_a_film_keeps_its_frames(ending: str, tmp_path: Path) -> None:
    film, hook = tmp_path / f"in.{ending}", tmp_path / "test.hook"
    make = ["ffmpeg", "-v", "error", "-f", "lavfi", "-i", "testsrc2=size=96x64:rate=25", "-frames:v", "13"]
    subprocess.run([*make, str(film)], check=True)
    vidstyle.save_style(load_style(LENGTHS), tmp_path / "test.toml")
    assert main(["export", str(tmp_path / "test.toml"), str(hook), "--from", str(film)]) == 0
    run_ffmpeg(hook, film, "yuv420p", str(tmp_path / f"out.{ending}"))
    with open_reader(tmp_path / f"out.{ending}") as reader:
        assert sum(1 for _ in reader) == 13


def test_what_is_measured_and_the_size_are_those_of_a_film(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    film = tmp_path / "in.png"
    assert cv2.imwrite(str(film), np.linspace(64, 127, 160 * 90).astype(np.uint8).reshape(90, 160))
    style = {"format": 1, "base": [{"block": "equalize", "low": 0, "high": 100}]}
    vidstyle.save_style(load_style(style), tmp_path / "test.toml")
    arguments = ["export", str(tmp_path / "test.toml")]
    assert main([*arguments, str(tmp_path / "a.hook"), "--from", str(film)]) == 0
    text = (tmp_path / "a.hook").read_text()
    assert "160 x 90" in text and "Frozen: 1 measurement of in.png." in text
    ends = Picture.from_array(np.array([[64, 127]], np.uint8)).luma
    assert ends is not None
    taken = frozen_percentiles(load_style(style), [np.repeat(ends[..., None], 3, axis=2)])["base 0"]
    assert re.search(rf"vec4\({taken[0]!r}, [^,]+, [^,]+, {taken[-1]!r}\)", text)
    assert main([*arguments, str(tmp_path / "b.hook"), "--size", "640x360"]) == 0
    assert "640 x 360" in (tmp_path / "b.hook").read_text()
    assert main([*arguments, str(tmp_path / "a.html"), "--size", "640x360"]) == 2
    assert "--from and --size: apply only to OUT.hook" in capsys.readouterr().err


def test_a_hook_says_what_each_number_is_and_what_is_left_out() -> None:
    style = load_style("blueprint")
    text = text_of(style, 1280, 720, picture(36, 64))
    epsilon = next(step.values["epsilon"] for step in style.base if step.block == "soft_threshold")
    assert re.search(
        rf"const float epsilon_\d+ = {epsilon:.1f}; // soft_threshold.epsilon: the darkest tone that ", text
    )
    assert re.search(r"#define spacing_\d+ max\(36.0 \* vidstyle_growth, 3.0\) // pattern.spacing:", text)
    assert f"a style of vidstyle {vidstyle.__version__}" in text
    assert "Not included: temporal smoothing." in text
