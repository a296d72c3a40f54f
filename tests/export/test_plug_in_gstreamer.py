"""The GStreamer element, run by gst-launch-1.0 and by a program; skipped where GStreamer is not there."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import cv2
import numpy as np
import pytest

import vidstyle
from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.style import override

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/plug-in.md").read_text(encoding="utf-8")
ELEMENT = ROOT / "tools/gstreamer/python/vidstyle_element.py"
SYSTEM_PYTHON = "/usr/bin/python3"
SYSTEM_PATH = "/usr/bin:/bin"
"""The loader takes the first python3 of these folders for its own."""
ENVIRONMENT = os.environ | {
    "PATH": SYSTEM_PATH,
    "PYTHONPATH": os.pathsep.join((str(ROOT), sysconfig.get_path("purelib"))),
    "GST_PLUGIN_PATH": str(ELEMENT.parent.parent),
}


def run(*command: str | Path, folder: Path, **changes: str) -> subprocess.CompletedProcess[str]:
    """Return an environment with a separate index of plug-ins."""
    environment = ENVIRONMENT | {"GST_REGISTRY": str(folder / "registry")} | changes
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )


def missing(folder: Path) -> str:
    """Why GStreamer's element cannot be tried here, or nothing."""
    if not shutil.which("gst-launch-1.0", path=SYSTEM_PATH) or not Path(SYSTEM_PYTHON).exists():
        return "no gst-launch-1.0"
    version = run(SYSTEM_PYTHON, "-c", "import sys, gi; print(sys.version_info[:2])", folder=folder)
    if version.returncode:
        return "the system's Python has no gi"
    if version.stdout.strip() != str(sys.version_info[:2]):
        return f"the system's Python is {version.stdout.strip()}, ours {sys.version_info[:2]}"
    if run("gst-inspect-1.0", "python", folder=folder).returncode:
        return "GStreamer has no loader for Python"
    return ""


@pytest.fixture(scope="module")
def gstreamer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder to run GStreamer in."""
    folder = tmp_path_factory.mktemp("gstreamer")
    if reason := missing(folder):
        pytest.skip(reason)
    return folder


def from_gstreamer(data: bytes, kind: str, size: tuple[int, int], encoding: Encoding) -> list[Picture]:
    """The pictures in GStreamer's own layout: rows, and whole planes, begin at multiples of four bytes."""
    width, height = size
    if kind == "RGB":
        rows = np.frombuffer(data, np.uint8).reshape(-1, height, -(-3 * width // 4) * 4)
        return [Picture(encoding, color=each[:, : 3 * width].reshape(height, width, 3)) for each in rows]
    half_width, half_height = -(-width // 2), -(-height // 2)
    strides = [-(-each // 4) * 4 for each in (width, half_width, half_width)]
    # GStreamer makes room for an even number of rows.
    sizes = [2 * half_height * strides[0], half_height * strides[1], half_height * strides[2]]
    pictures = []
    for frame in np.frombuffer(data, np.uint8).reshape(-1, sum(sizes)):
        parts = np.split(frame, np.cumsum(sizes)[:2])
        luma, blue, red = (part.reshape(-1, stride) for part, stride in zip(parts, strides, strict=True))
        chroma = blue[:, :half_width], red[:, :half_width]
        pictures.append(Picture(encoding, luma=luma[:height, :width], chroma=chroma))
    return pictures


@pytest.mark.parametrize(
    ("rate", "caps", "encoding"),
    [
        (10, "format=RGB", Encoding(full_range=True, subsampling=(1, 1))),
        (10, "format=I420,colorimetry=bt601,chroma-site=jpeg", Encoding("bt601", siting=SITINGS["center"])),
        (1, "format=I420,colorimetry=bt709,chroma-site=mpeg2", Encoding("bt709", siting=SITINGS["left"])),
        (10, "format=I420,colorimetry=(string)1:3:5:1,chroma-site=mpeg2", Encoding(full_range=True)),
    ],
    ids=["RGB", "bt601", "bt709", "full"],
)
def test_the_element_makes_what_the_renderer_makes(
    gstreamer: Path, rate: int, caps: str, encoding: Encoding
) -> None:
    """At one frame a second each stands alone, at ten they are kept steady: it knows their times."""
    size, kind = (161, 91), caps[7:].partition(",")[0]
    video = f"video/x-raw,width={size[0]},height={size[1]},framerate={rate}/1,{caps}"
    source = f"videotestsrc num-buffers=4 pattern=ball ! {video} ! tee name=both ! queue"
    effect = "vidstyle style=comic set=saturation.factor=2;ink=#102080 steady=0.7 device=cpu"
    line = f"{source} ! filesink location=in both. ! queue ! {effect} ! filesink location=out"
    done = run("gst-launch-1.0", *line.split(), folder=gstreamer)
    assert done.returncode == 0, done.stderr
    before, after = (
        from_gstreamer((gstreamer / name).read_bytes(), kind, size, encoding) for name in ("in", "out")
    )
    changes = ["saturation.factor=2", "ink=#102080", "steady=0.7"]
    with CpuRenderer(override(vidstyle.load_style("comic"), changes)) as renderer:
        expected = [
            renderer.run(each, number / rate, encoding, rgb=kind == "RGB")
            for number, each in enumerate(before)
        ]
    assert len(after) == 4
    for restyled, wanted in zip(after, expected, strict=True):
        for one, other in zip(arrays(restyled), arrays(wanted), strict=True):
            np.testing.assert_array_equal(one, other)


def arrays(picture: Picture) -> list[np.ndarray]:
    return [picture.color] if picture.color is not None else [picture.luma, *picture.chroma]


def test_the_page_s_gstreamer_line_makes_pictures(gstreamer: Path) -> None:
    (line,) = re.findall(r"^gst-launch-1\.0 (?:.*\\\n)*.*", PAGE, re.MULTILINE)
    done = run("sh", "-c", line, folder=gstreamer)
    assert done.returncode == 0, done.stderr
    pictures = [cv2.imread(str(path)) for path in sorted(gstreamer.glob("*.png"))]
    assert len(pictures) == 60
    ink = np.array([0x0A, 0x46, 0xC8])
    assert all((np.abs(picture - ink).max(axis=2) < 12).any() for picture in pictures)


def test_a_wrong_style_is_said_before_the_pipeline_plays(gstreamer: Path) -> None:
    done = run("gst-launch-1.0", *"videotestsrc ! vidstyle style=inc ! fakesink".split(), folder=gstreamer)
    assert done.returncode != 0
    assert "vidstyle0: there is no style 'inc'; did you mean 'ink'?" in done.stderr


def test_properties_change_in_mid_film_and_rows_may_lie_apart(gstreamer: Path) -> None:
    """Return the results for the source, plain, ink, ink after a mistake, and green ink."""
    path = os.pathsep.join((ENVIRONMENT["PYTHONPATH"], str(ELEMENT.parent)))
    program = ROOT / "tests/export/gstreamer_pipeline.py"
    done = run(SYSTEM_PYTHON, program, folder=gstreamer, PYTHONPATH=path)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    plain, ink, kept, green = said["equal"]
    assert plain == [True, True, False, False, False]
    assert ink == kept == [False, False, True, True, False]
    assert green == [False, False, False, False, True]
    assert "'nonsense' is not a field of a style" in said["warning"]
