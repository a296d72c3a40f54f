"""Every file of examples/, run as a user runs it, and that docs/plug-in.md quotes its own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from media import make_clip, make_picture, photograph, read_all, rms_error

import vidstyle
from vidstyle.media.frame import picture_from_frame

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/plug-in.md").read_text(encoding="utf-8")
EXAMPLES = ROOT / "examples"
TIMES = 0, 33, 50, 150, 233, 250, 300, 420, 433, 500
"""Of frames as a telephone records them, in milliseconds."""
ENVIRONMENT = os.environ | {
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "PYTHONPATH": str(ROOT),
}


def succeed(*command: str | Path, folder: Path, **changes: str) -> None:
    environment = ENVIRONMENT | changes
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("name", ["pyav_loop.py", "camera_loop.py", "pipe.sh"])
def test_the_page_quotes_the_example(name: str) -> None:
    blocks = re.findall(r"```\w+\n(.*?)```", PAGE, re.DOTALL)
    assert (EXAMPLES / name).read_text(encoding="utf-8") in blocks


def test_every_example_is_listed_and_tested() -> None:
    listed = re.findall(r"\]\(([a-z_]+(?:\.[a-z]+)?)\)", (EXAMPLES / "README.md").read_text(encoding="utf-8"))
    tests = Path(__file__).read_text(encoding="utf-8")
    names = {path.name for path in EXAMPLES.iterdir()} - {"README.md", "__pycache__"}
    assert set(listed) == names
    assert all(f'EXAMPLES / "{name}"' in tests for name in names)


def test_a_pyav_loop_keeps_times_and_tags(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "in.mkv", times=[Fraction(each, 1000) for each in TIMES])
    succeed(sys.executable, EXAMPLES / "pyav_loop.py", clip, "out.mkv", folder=tmp_path)
    before, after = read_all(clip), read_all(tmp_path / "out.mkv")
    assert [frame.time for frame in after] == [frame.time for frame in before]
    assert after[0].colorspace == before[0].colorspace
    with vidstyle.Renderer("ink", device="cpu") as renderer:
        expected = [renderer(frame).to_ndarray(format="rgb24") for frame in before]
    for restyled, wanted in zip(after, expected, strict=True):
        # x264 smooths crisp outlines by up to 12.1 at 160 x 90 pixels; another style is 90 away
        assert rms_error(restyled.to_ndarray(format="rgb24"), wanted) < 14


def test_a_camera_loop_has_red_and_blue_where_they_belong(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "in.mp4", frames=8, size=(320, 180))
    succeed(sys.executable, EXAMPLES / "camera_loop.py", clip, "out.mp4", folder=tmp_path)
    before, after = read_all(clip), read_all(tmp_path / "out.mp4")
    with vidstyle.Renderer("cartoon", device="cpu") as renderer:
        expected = [renderer(frame.to_ndarray(format="rgb24"), frame.time) for frame in before]
    for restyled, wanted in zip(after, expected, strict=True):
        # Fine lines do not survive the encoder unharmed, the colours of areas do.
        seen, wanted = (cv2.blur(each, (31, 31)) for each in (restyled.to_ndarray(format="rgb24"), wanted))
        assert rms_error(seen, wanted) < 8 < 16 < rms_error(seen, wanted[..., ::-1])


@pytest.mark.skipif(not shutil.which("ffmpeg"), reason="no ffmpeg program")
def test_a_pipe_between_two_ffmpegs_keeps_sound_and_times(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "in.mp4", frames=12, rate=24, audio_tracks=1)
    succeed("sh", EXAMPLES / "pipe.sh", clip, "out.mp4", folder=tmp_path)
    before, after = read_all(clip), read_all(tmp_path / "out.mp4")
    assert [frame.time for frame in after] == pytest.approx([frame.time for frame in before], abs=1e-3)
    with av.open(str(tmp_path / "out.mp4")) as container:
        assert len(container.streams.audio) == 1
    with vidstyle.Renderer("ink", device="cpu") as renderer:
        expected = [picture_from_frame(renderer(frame)).luma for frame in before]
    for plain, restyled, wanted in zip(before, after, expected, strict=True):
        # x264 smooths crisp ink; the unstyled film is three times as far away
        unstyled = rms_error(picture_from_frame(plain).luma, wanted)
        assert rms_error(picture_from_frame(restyled).luma, wanted) < 0.4 * unstyled


def test_a_film_is_restyled(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "in.mp4", frames=6, size=(160, 90), audio_tracks=1)
    succeed(sys.executable, EXAMPLES / "restyle_film.py", clip, "out.mp4", folder=tmp_path)
    assert len(read_all(tmp_path / "out.mp4")) == 6


def test_a_still_is_restyled(tmp_path: Path) -> None:
    make_picture(tmp_path / "in.png", size=(160, 90))
    succeed(sys.executable, EXAMPLES / "restyle_still.py", "in.png", "out.png", folder=tmp_path)
    before, after = (cv2.imread(str(tmp_path / name)) for name in ("in.png", "out.png"))
    assert before is not None and after is not None
    assert after.shape == before.shape and rms_error(before, after) > 8


def test_a_comic_page_is_made(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "in.mp4", frames=40, size=(160, 90))
    succeed("sh", EXAMPLES / "comic_page.sh", clip, "page.png", folder=tmp_path)
    page = cv2.imread(str(tmp_path / "page.png"))
    assert page is not None and min(page.shape[:2]) > 300 and page.std() > 20


def test_a_bank_is_trained_and_used(tmp_path: Path) -> None:
    (tmp_path / "photographs").mkdir()
    for name in ("chelsea", "coffee"):
        cv2.imwrite(str(tmp_path / f"photographs/{name}.png"), photograph(name)[::4, ::4, ::-1])
    clip = make_clip(tmp_path / "in.mp4", frames=2, size=(160, 90))
    succeed(sys.executable, EXAMPLES / "train_bank.py", "photographs", clip, "out.mp4", folder=tmp_path)
    assert (tmp_path / "smooth.npz").exists() and len(read_all(tmp_path / "out.mp4")) == 2


def test_a_block_is_written(tmp_path: Path) -> None:
    """In a copy of the checkout: its two files are all that is added, and CPU and GPU agree."""
    for folder in ("vidstyle", "shaders", "filters_bank"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    block = EXAMPLES / "write_block"
    shutil.copy(block / "solarize.py", tmp_path / "vidstyle/blocks")
    shutil.copy(block / "solarize.glsl", tmp_path / "shaders/blocks")
    (tmp_path / "sun.toml").write_text('format = 1\n[[background]]\nblock = "solarize"\nthreshold = 100\n')
    make_picture(tmp_path / "in.png", size=(161, 91))
    for device in ("cpu", "gpu"):
        options = ["--style", "sun.toml", "--device", device]
        program = sys.executable, "-m", "vidstyle", "render", "in.png", f"{device}.png", *options
        succeed(*program, folder=tmp_path, PYTHONPATH=str(tmp_path))
    source, cpu, gpu = (
        cv2.imread(str(tmp_path / f"{name}.png")).astype(np.float64) for name in ("in", "cpu", "gpu")
    )
    expected = np.minimum(source, (255 - source) * 100 / 155)
    assert np.abs(cpu - expected).max() <= 1 and np.abs(gpu - cpu).max() <= 1
