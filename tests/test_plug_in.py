"""vidstyle in other people's loops and pipes: the examples of docs/plug-in.md as a user runs them."""

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
import pytest
from media import make_clip, read_all, rms_error

import vidstyle
from vidstyle.media.frame import picture_from_frame

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs/plug-in.md").read_text(encoding="utf-8")
EXAMPLES = sorted((ROOT / "docs/examples").iterdir())
TIMES = 0, 33, 50, 150, 233, 250, 300, 420, 433, 500
"""Of frames as a telephone records them, in milliseconds."""
ENVIRONMENT = os.environ | {
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "PYTHONPATH": str(ROOT),
}


def succeed(*command: str | Path, folder: Path) -> None:
    done = subprocess.run(
        command, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name)
def test_the_page_quotes_the_example(path: Path) -> None:
    blocks = re.findall(r"```\w+\n(.*?)```", PAGE, re.DOTALL)
    assert path.read_text(encoding="utf-8") in blocks


def test_a_pyav_loop_keeps_times_and_tags(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "in.mkv", times=[Fraction(each, 1000) for each in TIMES])
    succeed(sys.executable, ROOT / "docs/examples/pyav_loop.py", clip, "out.mkv", folder=tmp_path)
    before, after = read_all(clip), read_all(tmp_path / "out.mkv")
    assert [frame.time for frame in after] == [frame.time for frame in before]
    assert after[0].colorspace == before[0].colorspace
    with vidstyle.Renderer("ink", device="cpu") as renderer:
        expected = [renderer(frame).to_ndarray(format="rgb24") for frame in before]
    for restyled, wanted in zip(after, expected, strict=True):
        assert rms_error(restyled.to_ndarray(format="rgb24"), wanted) < 12


def test_an_opencv_loop_has_red_and_blue_where_they_belong(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "in.mp4", frames=8, size=(640, 360))
    succeed(sys.executable, ROOT / "docs/examples/opencv_loop.py", clip, "out.mp4", folder=tmp_path)
    before, after = read_all(clip), read_all(tmp_path / "out.mp4")
    with vidstyle.Renderer("comic", device="cpu") as renderer:
        expected = [renderer(frame.to_ndarray(format="rgb24"), frame.time) for frame in before]
    for restyled, wanted in zip(after, expected, strict=True):
        # Dots do not survive the encoder unharmed, what they add up to does.
        seen, wanted = (cv2.blur(each, (31, 31)) for each in (restyled.to_ndarray(format="rgb24"), wanted))
        assert rms_error(seen, wanted) < 8 < 16 < rms_error(seen, wanted[..., ::-1])


@pytest.mark.skipif(not shutil.which("ffmpeg"), reason="no ffmpeg program")
def test_a_pipe_between_two_ffmpegs_keeps_sound_and_times(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "in.mp4", frames=12, rate=24, audio_tracks=1)
    succeed("sh", ROOT / "docs/examples/pipe.sh", clip, "out.mp4", folder=tmp_path)
    before, after = read_all(clip), read_all(tmp_path / "out.mp4")
    assert [frame.time for frame in after] == pytest.approx([frame.time for frame in before], abs=1e-3)
    with av.open(str(tmp_path / "out.mp4")) as container:
        assert len(container.streams.audio) == 1
    with vidstyle.Renderer("ink", device="cpu") as renderer:
        expected = [picture_from_frame(renderer(frame)).luma for frame in before]
    for restyled, wanted in zip(after, expected, strict=True):
        assert rms_error(picture_from_frame(restyled).luma, wanted) < 12
