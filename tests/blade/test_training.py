"""Training from the command line, and the learned blocks in styles and films."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from covering import of_the_day
from media import make_clip, photograph
from pictures import codes, run, run_luma, step, style

from tools import fidelity
from vidstyle.blade.bank_file import load_bank, shipped_bank, shipped_banks
from vidstyle.blade.inference import BankRun
from vidstyle.blade.references import detail_base, edge_tangent_flow, flow_dog_parts, tv_flow
from vidstyle.blade.training import psnr
from vidstyle.blocks import all_blocks
from vidstyle.blocks.detail import CONTRAST_LEVELS
from vidstyle.cli import main
from vidstyle.core.picture import Encoding
from vidstyle.pipeline.render import render
from vidstyle.style import load_style

PYTHON = shlex.quote(sys.executable)
BILATERAL = """
import sys, cv2
picture = cv2.imread(sys.argv[1])
cv2.imwrite(sys.argv[2], cv2.bilateralFilter(picture, 9, 30, 3))
"""
"""A user's slow filter, as a program."""

TWO_SLIDERS = """
import cv2, numpy as np

def soft_and_sharp(picture):
    luma = picture.astype(np.float32) / 255
    wide, narrow = (cv2.GaussianBlur(luma, (0, 0), sigma) for sigma in (1.2, 0.6))
    return picture, wide - narrow, luma - narrow
"""
"""A user's filter with two sliders: a picture, and the picture that each slider adds to it."""

SOURCES = {
    "etf": ({"passes": 1}, lambda luma: edge_tangent_flow(luma, 2.0, 2.0)),
    "etf broad": ({"passes": 1, "brush": "broad", "rho": 4}, lambda luma: edge_tangent_flow(luma, 4.0, 4.0)),
    "tvf": ({"passes": 1}, lambda luma: tv_flow(luma, 2.0)),
    "tvf variation": ({"passes": 1, "flow": "variation", "time": 6}, lambda luma: tv_flow(luma, 6.0, 0)),
    "detail": (
        {"delta": -20, "fine": 1, "middle": 0, "coarse": 0},
        lambda luma: detail_base(luma, CONTRAST_LEVELS[0]),
    ),
}
"""Settings of a learned block, and the reference that it approximates with them."""


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("photographs")
    for name in ("astronaut", "chelsea", "coffee", "rocket"):
        cv2.imwrite(str(folder / f"{name}.png"), photograph(name)[::2, ::2, ::-1])
    return folder


def luma_of(name: str) -> np.ndarray:
    return photograph(name)[..., 1].astype(np.float32) / 255


def test_slow_program_becomes_block(
    photographs: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """From a command to a bank, to a style, to a film."""
    program = tmp_path / "bilateral.py"
    program.write_text(BILATERAL)
    bank = tmp_path / "bilateral.npz"
    command = shlex.join([sys.executable, str(program), "{in}", "{out}"])
    options = ["--hold-out", "1", "--bins", "16x3x3"]
    arguments = ["train", str(bank), "--images", str(photographs), "--command", command, *options]
    assert main(arguments) == 0
    said = capfd.readouterr().err
    assert "0.00 dB" not in said and "on 1 held-out pictures" in said and "not local" not in said
    fidelity = load_bank(bank).about["fidelity"]
    assert fidelity["psnr"] > fidelity["untouched psnr"] + 2

    look = tmp_path / "look.toml"
    look.write_text('format = 1\n[[background]]\nblock = "learned"\nbank = "bilateral.npz"\n')
    luma = luma_of("chelsea")[:200, :200]
    with_style = run_luma(load_style(look), luma)
    np.testing.assert_allclose(with_style, BankRun(load_bank(bank)).run(luma), atol=1e-6)
    clip = make_clip(tmp_path / "clip.mp4", frames=5)
    assert render(clip, tmp_path / "out.mp4", str(look)).frames == 5

    assert main(arguments) == 2, "an existing bank is not replaced without -y"
    assert "add -y" in capfd.readouterr().err
    assert main(["train", str(bank), "--show", str(tmp_path / "bank.png")]) == 0
    assert cv2.imread(str(tmp_path / "bank.png")).shape[2] == 3


@pytest.mark.parametrize(
    ("options", "exit_code", "reason"),
    [
        ([], 2, "needs exactly one reference"),
        (["--reference", "etff"], 2, "choose one of edge_tangent_flow"),
        (["--reference", "tv_flow", "--set", "tme=2"], 2, "has no setting 'tme'; its settings are time,"),
        (["--command", "convert x y"], 2, "write {in} and {out}"),
        (["--command", "no-such-program {in} {out}"], 2, "cannot be run"),
        (["--command", f"{PYTHON} -c 'raise SystemExit(3)' {{in}} {{out}}"], 3, "exit code 3"),
        (["--command", f"{PYTHON} -c pass {{in}} {{out}}"], 3, "wrote no picture"),
        (["--reference", "tv_flow", "--depth", "16"], 2, "--depth has no effect without --command"),
        (["--function", "cv2:no_such"], 2, "is not a function"),
        (["--function", "json:loads"], 3, "failed on astronaut.png (TypeError: "),
        (["--pairs", "nowhere"], 3, "nowhere"),
        (["--reference", "tv_flow", "--bins", "15x3x3"], 2, "orientations must be even"),
        (["--reference", "tv_flow", "--size", "8"], 2, "8 is even; use 7 or 9"),
        (["--reference", "tv_flow", "--images", "nowhere"], 3, "nowhere: no such file"),
    ],
)
def test_training_errors_are_one_line_and_leave_no_bank(
    options: list[str],
    exit_code: int,
    reason: str,
    photographs: Path,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    images = [] if "--images" in options else ["--images", str(photographs)]
    assert main(["train", str(tmp_path / "x.npz"), *images, *options]) == exit_code
    said = capfd.readouterr().err
    assert reason in said and said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_nonlocal_filter_is_reported(
    photographs: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arguments = [
        "--images",
        str(photographs),
        "--function",
        "numpy:fliplr",
        "--long-side",
        "96",
        "--size",
        "3",
    ]
    assert main(["train", str(tmp_path / "mirrored.npz"), *arguments]) == 0
    said = capfd.readouterr().err
    assert "explains 0% of the change" in said and "the rest: the filter is not local" in said


def test_python_function_and_pairs_as_reference(
    photographs: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    pairs = tmp_path / "after"
    pairs.mkdir()
    for path in photographs.iterdir():
        cv2.imwrite(str(pairs / path.name), cv2.medianBlur(cv2.imread(str(path)), 3))
    common = ["--images", str(photographs), "--size", "5", "--bins", "16x3x3"]
    assert main(["train", str(tmp_path / "a.npz"), *common, "--pairs", str(pairs)]) == 0
    assert "the cause of the rest is unknown: pairs" in capfd.readouterr().err
    assert main(["train", str(tmp_path / "b.npz"), *common, "--function", "median_filter:of_three"]) == 2
    taught = load_bank(tmp_path / "a.npz").about["fidelity"]
    assert taught["psnr"] > taught["untouched psnr"] + 1


def test_every_shipped_bank_is_valid_and_described() -> None:
    assert {"etf", "tvf", "detail", "flow_dog"} <= set(shipped_banks())
    for name in shipped_banks():
        about = shipped_bank(name).about
        assert about["imitates"] and len(about["pictures"]) >= 30
        parts, bins, *_ = shipped_bank(name).filters.shape
        assert len(about["parts"]) == parts and len(about["samples"]) == bins
        assert np.shape(about["residuals"]) == (parts, bins)
    assert sum(path.stat().st_size for path in shipped_banks().values()) <= 3 << 20


def test_page_of_banks_lists_current_banks_and_settings() -> None:
    page = fidelity.README.read_text()
    for name in shipped_banks():
        assert fidelity.format_bank(name, shipped_bank(name)) in page
    for case in fidelity.cases():
        for output in case.outputs:
            assert f"| `{case.block}` | {case.name}{output and ', '}{output} | " in page


def test_fidelity_is_measured_on_linear_and_clipped_results() -> None:
    luma = luma_of("chelsea")[:64, :96]
    case = fidelity.Case("flow_dog", {"sigma": 1, "p": 0}, lambda z: z, ("linear", "clipped"))
    linear, clipped = fidelity.measure_rows(case, [luma])
    assert "sigma 1, p 0, linear" in linear and "inf dB" in linear and "inf dB" in clipped


def test_fidelity_prints_a_row_of_the_published_table(photographs: Path) -> None:
    options = ["--pictures", "1", "--long-side", "96", "--only", "flow_dog sigma 1, p 20"]
    program = [sys.executable, fidelity.__file__, "--images", str(photographs), *options]
    rows = subprocess.run(program, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [row.split(" | ")[1].rpartition(", ")[2] for row in rows] == ["linear", "clipped", "threshold"]
    gains = [float(row.split(" | ")[6].split()[0]) for row in rows]
    assert min(gains) > 10, "a bank reproduces most of its reference, also after the threshold"


@pytest.mark.parametrize("name", SOURCES)
def test_shipped_bank_is_close_to_reference_on_unseen_picture(name: str) -> None:
    luma = luma_of("astronaut")[::2, ::2]
    values, reference = SOURCES[name]
    target = reference(luma)
    result = all_blocks()[name.split()[0]](**values).whole(luma)
    assert psnr(result, target) > psnr(luma, target) + 5


def test_accurate_flow_and_enhanced_detail_are_as_close_as_clipped_differences_allow() -> None:
    luma = luma_of("astronaut")[::2, ::2]
    enhanced = {"delta": 60, "fine": 1, "middle": 0, "coarse": 0, "accurate": True}
    for block, values, target, gain in (
        ("tvf", {"flow": "variation", "passes": 4, "time": 6, "accurate": True}, tv_flow(luma, 24.0, 0), 14),
        ("detail", enhanced, luma + 3 * (luma - detail_base(luma, CONTRAST_LEVELS[0])), 10),
    ):
        result = all_blocks()[block](**values).whole(luma)
        assert psnr(result, target) > psnr(luma, target) + gain


@pytest.mark.parametrize("sigma", of_the_day([0.5, 0.6, 0.7, 1.0, 1.2, 1.4, 2.0, 5.6], 4))
def test_flow_lines_sharpen_like_reference(sigma: float) -> None:
    luma = luma_of("coffee")[:300, :400]
    result = all_blocks()["flow_dog"](sigma=sigma, p=10).whole(luma)
    smooth, difference = flow_dog_parts(luma, sigma)
    target = smooth + 10 * difference
    assert psnr(result, target) > psnr(luma, target) + 17


def test_each_layer_of_detail_has_a_factor() -> None:
    luma = luma_of("chelsea")[:120, :160]

    def change(**values: float) -> np.ndarray:
        return all_blocks()["detail"](**{"fine": 0, "middle": 0, "coarse": 0} | values).whole(luma) - luma

    layers = [change(delta=10, **{name: 1}) for name in ("fine", "middle", "coarse")]
    assert all(np.abs(layer).max() > 0.003 for layer in layers)
    together = change(delta=10, fine=1, middle=0.5, coarse=0.2)
    np.testing.assert_allclose(together, layers[0] + 0.5 * layers[1] + 0.2 * layers[2], atol=1e-5)
    gone = change(delta=-20, fine=1, middle=1, coarse=1)
    np.testing.assert_allclose(gone, -2 * sum(layers), atol=1e-5)
    np.testing.assert_array_equal(change(delta=-100, fine=1, middle=1, coarse=1), gone)


def test_user_filter_with_two_sliders(
    photographs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """From a function to a bank, to a style whose sliders weight its parts."""
    (tmp_path / "two_sliders.py").write_text(TWO_SLIDERS)
    monkeypatch.syspath_prepend(tmp_path)
    sliders = ["--slider", "soft=0:2", "--slider", "sharp=0:4"]
    common = ["--images", str(photographs), "--function", "two_sliders:soft_and_sharp", "--bins", "8x1x1"]
    for name in ("a.npz", "b.npz"):
        assert main(["train", str(tmp_path / name), *common, *sliders]) == 0
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert main(["train", str(tmp_path / "c.npz"), *common, *sliders[:2]]) == 3
    assert "returned 3 pictures, not one and 1 for sliders" in capfd.readouterr().err
    look = tmp_path / "look.toml"
    look.write_text(
        'format = 1\n[[background]]\nblock = "learned"\nbank = "a.npz"\nfirst = 0.5\nsecond = 0.25\n'
    )
    luma = luma_of("chelsea")[:120, :160]
    wide, narrow = (cv2.GaussianBlur(luma, (0, 0), sigma) for sigma in (1.2, 0.6))
    wanted = luma + (wide - narrow) + (luma - narrow)
    result = run_luma(load_style(look), luma)
    assert psnr(result, wanted) > psnr(luma, wanted) + 10


@pytest.mark.parametrize("name", ["etf", "tvf", "detail"])
def test_learned_blocks_keep_chroma(name: str) -> None:
    source = codes(Encoding(), 40, 60)
    result = run(style(step(name)), source)
    assert result.chroma is source.chroma


def test_detail_at_zero_and_amount_zero_keep_luma() -> None:
    luma = luma_of("chelsea")[:90, :120]
    for look in (step("detail", delta=0), step("tvf", amount=0.0)):
        np.testing.assert_allclose(run_luma(style(look), luma), luma, atol=2e-6)


def test_lines_grow_with_sigma_and_are_dark_on_white() -> None:
    luma = luma_of("astronaut")
    thin, wide = (run_luma(style(step("flow_xdog", sigma=sigma)), luma) for sigma in (1.0, 4.0))
    assert thin.max() == pytest.approx(1, abs=1e-3) and thin.min() < 0.05
    edges = [np.abs(np.diff(lines, axis=1)).mean() for lines in (thin, wide)]
    assert edges[1] < edges[0], "wider lines have fewer edges"


def test_all_learned_blocks_exist() -> None:
    assert {"etf", "tvf", "flow_dog", "flow_xdog", "detail", "learned"} <= set(all_blocks())
