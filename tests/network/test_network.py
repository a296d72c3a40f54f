"""Networks as blocks: layouts, tiles, sizes, and refused files."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import onnx_model as onnx
import pytest
from faults import MEMORY_UNIT_BYTES, measure_peak_memory
from media import photograph
from pictures import noise

from vidstyle.errors import StyleError
from vidstyle.export.export_style import export_style
from vidstyle.network import network_program
from vidstyle.network.network_process import NetworkProcess, StyleNetwork, open_network
from vidstyle.network.network_run import MAX_TILE_PX, RANGES, NetworkRun, enlarge, in_tiles
from vidstyle.network.onnx_file import MAX_FIELDS, MAX_FILE_BYTES, read_layout
from vidstyle.renderer import stylize
from vidstyle.style import Style, load_style

FREE = (1, 3, "height", "width")


def network_style(folder: Path, content: bytes, *lines: str) -> Style:
    """A style with a network of this content."""
    (folder / "model.onnx").write_bytes(content)
    step = '[[background]]\nblock = "network"\nmodel = "model.onnx"\n'
    (folder / "net.toml").write_text("\n".join(["format = 1", step, *lines]), encoding="utf-8")
    return load_style(folder / "net.toml")


@pytest.mark.parametrize("name", RANGES)
@pytest.mark.parametrize("shape", [FREE, (1, 3, 32, 48), ("one", 3, "high", 96)])
def test_a_network_changes_pictures(name: str, shape: Sequence[int | str], tmp_path: Path) -> None:
    """Of free and of fixed size, with any numbers for black and white."""
    content = onnx.convolution(-np.eye(3).reshape(3, 3, 1, 1), [sum(RANGES[name])] * 3, shape)
    picture = (255 * noise(70, 90, 3)).astype(np.uint8)
    result = stylize(picture, network_style(tmp_path, content, f'range = "{name}"'), "cpu")
    assert np.abs(result.astype(int) - (255 - picture.astype(int))).max() <= 1


def multiplying(shape: Sequence[int | str], factors: np.ndarray) -> bytes:
    """A network that multiplies pictures of a shape."""
    nodes, weights = [onnx.node("Mul", ["in", "factors"], "out")], [onnx.tensor("factors", factors)]
    return onnx.model(nodes, weights, [onnx.picture_info("in", shape)], onnx.picture_info("out", shape))


def test_channels_may_be_last(tmp_path: Path) -> None:
    content = multiplying((1, "height", "width", 3), np.array([[[[1, 0, 0]]]]))
    picture = (255 * noise(40, 50, 3)).astype(np.uint8)
    result = stylize(picture, network_style(tmp_path, content), "cpu")
    assert np.array_equal(result[..., 0], picture[..., 0]) and not result[..., 1:].any()


def test_amount_and_an_empty_model(tmp_path: Path) -> None:
    picture = (255 * noise(40, 50, 3)).astype(np.uint8)
    half = stylize(picture, network_style(tmp_path, onnx.negative(), "amount = 0.5"), "cpu")
    assert np.abs(half.astype(int) - 127).max() <= 1
    table = {"format": 1, "background": [{"block": "network"}]}
    assert np.array_equal(stylize(picture, table, "cpu"), picture)


@pytest.mark.parametrize("shape", [(50, 70), (MAX_TILE_PX + 1, 40), (30, 2 * MAX_TILE_PX), (32, 32)])
@pytest.mark.parametrize("fixed", [(0, 0), (64, 96)])
def test_tiles_have_no_seams(shape: tuple[int, int], fixed: tuple[int, int]) -> None:
    """Neither where tiles overlap, nor at the edges of the picture."""
    picture, sizes = noise(*shape, 3), set()

    def blur(tile: np.ndarray) -> np.ndarray:
        sizes.add(tile.shape[:2])
        return cv2.blur(tile, (3, 3), borderType=cv2.BORDER_REFLECT)

    result = in_tiles(picture, blur, fixed)
    expected = cv2.blur(picture, (3, 3), borderType=cv2.BORDER_REFLECT)
    # A tile that ends in the picture repeats its last pixels, where it has next to no weight.
    assert np.abs(result - expected).max() < 0.002
    assert sizes == {fixed} if all(fixed) else max(map(max, sizes)) <= MAX_TILE_PX


def test_a_large_picture_keeps_its_detail() -> None:
    """A network that changes nothing at a third of the size leaves the picture almost unchanged."""
    picture = photograph("astronaut")[:384, :384].astype(np.float32) / 255
    small = cv2.resize(picture, (128, 128), interpolation=cv2.INTER_AREA)
    plain, out = cv2.resize(small, (384, 384), interpolation=cv2.INTER_CUBIC), np.empty_like(picture)
    enlarge(small, small, picture, out)
    assert np.abs(out - picture).mean() < 0.3 * np.abs(plain - picture).mean()
    enlarge(1 - small, small, picture, out)
    assert np.abs(out - (1 - picture)).mean() < 0.3 * np.abs(plain - picture).mean()


def test_a_flat_result_gets_no_detail() -> None:
    picture = noise(90, 90, 3)
    small, out = cv2.resize(picture, (30, 30), interpolation=cv2.INTER_AREA), np.empty_like(picture)
    enlarge(np.full((30, 30, 3), 0.25, np.float32), small, picture, out)
    assert np.abs(out - 0.25).max() < 1e-3


def test_a_photograph_of_12_megapixels_takes_less_than_2_gb(tmp_path: Path) -> None:
    """The program and the process of its network together."""
    network_style(tmp_path, onnx.layered(32, 4))
    program = (
        "import numpy as np, resource, sys, vidstyle\n"
        "picture = np.random.default_rng(1).integers(0, 256, (3000, 4000, 3), np.uint8)\n"
        "result = vidstyle.stylize(picture, sys.argv[1], 'cpu')\n"
        "assert result.std() > 1\n"
        "from vidstyle.network import network_process\n"
        "for each in network_process._kept.values(): each.process.close()\n"
        "who = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN\n"
        "used = sum(resource.getrusage(each).ru_maxrss for each in who)\n"
        f"sys.exit(used * {MEMORY_UNIT_BYTES} >= 2_000_000_000)\n"
    )
    measured = measure_peak_memory([sys.executable, "-c", program, tmp_path / "net.toml"])
    assert measured.exit_code == 0, (measured.errors, measured.peak_bytes)


def shrinking() -> bytes:
    return onnx.convolution(np.ones((3, 3, 3, 3)), [0] * 3, padding=0)


def with_other_file() -> bytes:
    weights = onnx.tensor("kernel", np.eye(3).reshape(3, 3, 1, 1)) + onnx.field(14, 1)
    weights += onnx.field(13, onnx.field(1, "location") + onnx.field(2, "../secret"))
    conv = onnx.node("Conv", ["in", "kernel"], "out", kernel_shape=[1, 1])
    return onnx.model([conv], [weights], [onnx.picture_info("in", FREE)], onnx.picture_info("out", FREE))


def with_constant_in_other_file() -> bytes:
    value = onnx.tensor("kernel", np.eye(3)) + onnx.field(14, 1)
    constant = onnx.field(2, "kernel") + onnx.field(4, "Constant") + onnx.field(5, onnx.field(5, value))
    inner = onnx.field(1, onnx.field(5, onnx.field(6, onnx.field(1, constant))))
    return onnx.field(7, inner + onnx.field(11, b""))


def with_two_inputs() -> bytes:
    inputs = [onnx.picture_info(name, FREE) for name in ("in", "style")]
    return onnx.model([onnx.node("Add", ["in", "style"], "out")], [], inputs, onnx.picture_info("out", FREE))


def of_unknown_operation() -> bytes:
    picture, out = onnx.picture_info("in", FREE), onnx.picture_info("out", FREE)
    return onnx.model([onnx.node("Paint", ["in"], "out")], [], [picture], out)


def without_numbers() -> bytes:
    return multiplying(FREE, np.array([np.inf]))


WRONG = {
    b"": "is not an ONNX file",
    b"no model": "is not an ONNX file",
    onnx.negative()[:-40]: "is not an ONNX file",
    onnx.field(2, b"") * (MAX_FIELDS + 1) + onnx.negative(): "has more than 1,000,000 fields",
    onnx.convolution(
        np.ones((1, 1, 1, 1)), [0], (1, 1, "h", "w")
    ): "takes 1 x 1 x ? x ? instead of a picture",
    onnx.convolution(np.eye(3).reshape(3, 3, 1, 1), [0] * 3, (8, 3, 64, 64)): "takes 8 x 3 x 64 x 64 instead",
    onnx.convolution(np.eye(3).reshape(3, 3, 1, 1), [0] * 3, (1, 3, 9999, 64)): "takes 1 x 3 x 9999 x 64",
    onnx.convolution(np.eye(3).reshape(3, 3, 1, 1), [0] * 3, (1, 3, 8, "width")): "takes 1 x 3 x 8 x ?",
    shrinking(): "returns 1 x 3 x 62 x 62 for a picture of 1 x 3 x 64 x 64",
    with_other_file(): "keeps its weights in another file",
    with_constant_in_other_file(): "keeps its weights in another file",
    with_two_inputs(): "has 2 inputs and 1 outputs",
    of_unknown_operation(): "cannot be run: ",
    without_numbers(): "returns numbers that are not finite",
}


@pytest.mark.parametrize("content", WRONG, ids=WRONG.values())
def test_a_wrong_model_is_refused_in_one_line(content: bytes, tmp_path: Path) -> None:
    style = network_style(tmp_path, content)
    with pytest.raises(StyleError) as raised:
        stylize(np.zeros((8, 8, 3), np.uint8), style, "cpu")
    text = str(raised.value)
    assert text.startswith("net: network: model: 'model.onnx': ") and WRONG[content] in text
    assert "\n" not in text and len(text) < 400


def test_a_huge_model_is_not_read(tmp_path: Path) -> None:
    style = network_style(tmp_path, b"")
    with open(tmp_path / "model.onnx", "wb") as file:
        file.truncate(MAX_FILE_BYTES + 1)
    with pytest.raises(StyleError, match="is larger than 262144 KiB"):
        stylize(np.zeros((8, 8, 3), np.uint8), style, "cpu")


@pytest.mark.parametrize("path", ["../model.onnx", "/model.onnx", "link.onnx", "missing.onnx"])
def test_models_lie_in_the_folder_of_the_style(path: str, tmp_path: Path) -> None:
    folder = tmp_path / "styles"
    folder.mkdir()
    (tmp_path / "model.onnx").write_bytes(onnx.negative())
    (folder / "link.onnx").symlink_to(tmp_path / "model.onnx")
    (folder / "a.toml").write_text(f'format = 1\n[[base]]\nblock = "network"\nmodel = "{path}"\n')
    with pytest.raises(StyleError, match="model: "):
        load_style(folder / "a.toml")


def mutated(content: bytes, random: np.random.Generator) -> bytes:
    """A file with some bits changed, or bytes removed or repeated."""
    changed = bytearray(content)
    for _ in range(random.integers(1, 5)):
        place, length = int(random.integers(len(changed))), int(random.integers(1, 9))
        match random.integers(16):
            case 0:
                del changed[place : place + length]
            case 1:
                changed[place:place] = changed[place : place + length]
            case 2 | 3:
                changed[place] = random.integers(256)
            case _:
                changed[place] ^= 1 << int(random.integers(8))
    return bytes(changed)


def test_mutated_models_do_not_crash_the_program() -> None:
    """500 files: each is refused with a ValueError or runs, even if its process crashes."""
    random, running, outcomes = np.random.default_rng(7), NetworkProcess(), list[str]()
    originals = onnx.negative(), onnx.layered(4, 3)
    for number in range(500):
        content = mutated(originals[number % 2], random)
        if not running.is_running:
            running = NetworkProcess()
        try:
            read_layout(content)
            running.open(content)
            running.run(np.zeros((1, 3, 16, 16), np.float32))
            outcomes.append("runs")
        except ValueError as error:
            assert "\n" not in str(error)
            outcomes.append("refused")
    running.close()
    assert outcomes.count("runs") > 20 and outcomes.count("refused") > 100


def test_a_crash_of_the_process_is_reported(tmp_path: Path) -> None:
    """And the next picture has a new process."""
    (tmp_path / "model.onnx").write_bytes(onnx.negative())
    network = open_network(tmp_path / "model.onnx")
    network.process._process.kill()
    run = NetworkRun(network, (0.0, 1.0), 64, 1.0)
    with pytest.raises(StyleError, match="network: the model crashes the program that runs it"):
        run.run(np.zeros((8, 8, 3), np.float32), np.empty((8, 8, 3), np.float32))
    again = open_network(tmp_path / "model.onnx")
    assert again is not network and again.run(np.zeros((64, 64, 3), np.float32)).max() == 255


def test_a_network_is_opened_once(tmp_path: Path) -> None:
    """A slider resolves the style again and again."""
    (tmp_path / "model.onnx").write_bytes(onnx.negative())
    assert open_network(tmp_path / "model.onnx") is open_network(tmp_path / "model.onnx")


def test_the_process_ends_with_its_network() -> None:
    network = StyleNetwork(onnx.negative())
    child = network.process._process
    del network
    assert child.wait(10) is not None


@pytest.mark.parametrize("ending", ["html", "hook"])
def test_exports_refuse_a_network_in_one_line(ending: str, tmp_path: Path) -> None:
    style = network_style(tmp_path, onnx.negative())
    with pytest.raises(StyleError, match="^(net|out): network: runs on the CPU only; [^\n]*$"):
        export_style(style, tmp_path / f"out.{ending}")
    assert not (tmp_path / f"out.{ending}").exists()


def test_opencv_and_onnxruntime_agree() -> None:
    pytest.importorskip("onnxruntime")
    content, picture = onnx.layered(), noise(1, 3, 64, 64)
    results = [
        open_with(content, "onnx")(picture)
        for open_with in (network_program.open_network, network_program._open_with_opencv)
    ]
    assert np.abs(results[0] - results[1]).max() < 1e-4
