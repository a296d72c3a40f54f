"""Programs as reference filters: what they receive, and what is reported about their results."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.blade.bank_file import load_bank
from vidstyle.blade.inference import BankRun
from vidstyle.blade.photographs import Photograph
from vidstyle.blade.program_filter import reference_by_command
from vidstyle.cli import main
from vidstyle.errors import InputError

HEAD = """
import sys, cv2, numpy as np
picture = cv2.imread(sys.argv[1], cv2.IMREAD_UNCHANGED)
"""
PROGRAMS = {
    "depth": "cv2.imwrite(sys.argv[2], np.full_like(picture, 255 if picture.dtype == np.uint8 else 0))",
    "copy": "cv2.imwrite(sys.argv[2], picture)",
    "clip": "cv2.imwrite(sys.argv[2], np.clip(picture.astype(int) * 4, 0, 255).astype(np.uint8))",
    "complain": "print('no such model', file=sys.stderr)",
    "garbage": "open(sys.argv[2], 'w').write('garbage'); print('half a picture', file=sys.stderr)",
    "shrink": "cv2.imwrite(sys.argv[2], picture[::2, ::2])",
}
"""What programs do with a picture."""


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures")
    for name in ("chelsea", "coffee"):
        cv2.imwrite(str(folder / f"{name}.png"), photograph(name)[::4, ::4, ::-1])
    return folder


def command(name: str, folder: Path) -> str:
    program = folder / f"{name}_picture.py"
    program.write_text(HEAD + PROGRAMS[name] + "\n")
    return shlex.join([sys.executable, str(program), "{in}", "{out}"])


@pytest.mark.parametrize(("options", "result"), [([], 1), (["--depth", "8"], 1), (["--depth", "16"], 0)])
def test_program_receives_8_bit_pictures_by_default(
    options: list[str], result: int, pictures: Path, tmp_path: Path
) -> None:
    """The program returns white for 8-bit pictures and black for others, which the bank learns."""
    given = ["--images", str(pictures), "--command", command("depth", tmp_path), *options]
    assert main(["train", str(tmp_path / "a.npz"), *given, "--bins", "4x1x1", "--size", "3"]) == 0
    luma = photograph("coffee")[::4, ::4, 1].astype(np.float32) / 255
    np.testing.assert_allclose(BankRun(load_bank(tmp_path / "a.npz")).run(luma), result, atol=0.01)


@pytest.mark.parametrize("depth", [8, 16])
def test_values_survive_the_way_to_a_program_and_back(depth: int, tmp_path: Path) -> None:
    color = photograph("coffee")[:40, :50].astype(np.float32) / 255
    (made,) = reference_by_command(command("copy", tmp_path), depth).apply(color, Photograph(Path("a.png")))
    np.testing.assert_allclose(made, color, atol=1e-4)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("complain", "wrote no picture for a.png; it printed: no such model"),
        ("garbage", "wrote a file for a.png that cannot be read"),
        ("garbage", "it printed: half a picture"),
        ("shrink", "returned 15x10 for a picture of 30x20"),
    ],
)
def test_program_that_fails_is_named(name: str, reason: str, tmp_path: Path) -> None:
    reference = reference_by_command(command(name, tmp_path))
    with pytest.raises(InputError) as raised:
        reference.apply(np.full((20, 30, 3), 0.5, np.float32), Photograph(Path("a.png")))
    assert reason in str(raised.value) and Path(sys.executable).name in str(raised.value)
    assert "\n" not in str(raised.value) and str(tmp_path) not in str(raised.value)


@pytest.mark.parametrize(("name", "is_reported"), [("clip", True), ("copy", False)])
def test_clipped_values_are_reported(
    name: str, is_reported: bool, pictures: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    options = [
        "--images",
        str(pictures),
        "--command",
        command(name, tmp_path),
        "--bins",
        "4x1x1",
        "--size",
        "3",
    ]
    assert main(["train", str(tmp_path / "a.npz"), *options]) == 0
    assert ("more of the values to black or white" in capfd.readouterr().err) == is_reported
