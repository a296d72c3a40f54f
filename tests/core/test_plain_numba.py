"""Kernels where Numba's inside is not the one that they are compiled with: slower, and almost the same."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from covering import of_the_day

from vidstyle.blade.clipped_simd import add_clipped_block, pack_clipped
from vidstyle.blade.simd import filter_pixel_block, pack_filters
from vidstyle.core.kernels import Compiled, compiled
from vidstyle.core.kernels.declare import Intrinsic
from vidstyle.core.kernels.neighbors import add_neighbors
from vidstyle.core.kernels.sector_means import SECTOR_LANES, mean_of_sectors, sector_sums
from vidstyle.core.kernels.vectors import VECTOR_LANES
from vidstyle.stabilize.segment import GROUP_ROWS, SEGMENT_SIZE, take_segment, take_segments
from vidstyle.style import style_names

ROOT = Path(__file__).parents[2]
DOORS = "compiler", "entry_function", "engine"
"""The modules that use what Numba and llvmlite may change."""
OWN = "self", "compiled", "np", "inspect"
"""What else they use attributes of."""


def names_asked_for() -> Iterator[tuple[str, str]]:
    """Imports and attributes of Numba and llvmlite, as patterns, by module."""
    for door in DOORS:
        tree = ast.parse((ROOT / "vidstyle" / "core" / "kernels" / f"{door}.py").read_text(encoding="utf-8"))
        found = dict.fromkeys(
            rf"\b{each.name}\b"
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(("numba", "llvmlite"))
            for each in node.names
        )
        attributes = (node for node in ast.walk(tree) if isinstance(node, ast.Attribute))
        of_others = (
            node for node in attributes if root_of(node) not in ("self", "compiled", "np", "inspect")
        )
        found |= dict.fromkeys(rf"\.{node.attr}\b" for node in of_others)
        yield from ((door, pattern) for pattern in found)


def root_of(node: ast.expr) -> str:
    while isinstance(node, ast.Attribute):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


RENAMED = r"""
import os, re, sys
from importlib.machinery import PathFinder, SourceFileLoader

class Loader(SourceFileLoader):
    def get_code(self, name):
        source = self.get_data(self.path).decode()
        pattern = os.environ["GONE"]
        assert re.search(pattern, source)
        return self.source_to_code(re.sub(pattern, r"\g<0>_that_is_gone", source), self.path)

class Finder:
    @staticmethod
    def find_spec(name, path, target=None):
        if name == "vidstyle.core.kernels." + os.environ["DOOR"]:
            spec = PathFinder.find_spec(name, path)
            spec.loader = Loader(name, spec.origin)
            return spec

sys.meta_path.insert(0, Finder)
"""

KERNELS = """
from vidstyle.core.kernels import compiled
from vidstyle.stabilize.segment import take_segment

@compiled
def halve(value):
    return value / 2

@compiled
def use(formula, parts, samples, weights, lines):
    take_segment(samples, 0, 1, weights, lines, 0, 0)
    for x in range(lines.shape[1]):
        lines[0, x] = formula(halve(lines[0, x])) + parts[0][0, x]
"""

USE = """
import logging, sys
import numpy as np
from kernels_of_the_test import halve, use

logging.basicConfig(format="notice: %(message)s", stream=sys.stdout)
samples, weights = np.arange(18, dtype=np.float32), (np.float32(0.25),) * 4
lines = np.zeros((1, 16), np.float32)
use(halve, (lines + 1, 2), samples, weights, lines)
print(lines[0].tolist() == (np.arange(16) / 4 + 1.25).tolist())
"""


def run_without(door: str, pattern: str, script: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a script where a module asks Numba for names that it does not have."""
    (folder / "sitecustomize.py").write_text(RENAMED)
    path = os.pathsep.join([str(folder), str(ROOT), str(ROOT / "tests" / "support")])
    environment = {"DOOR": door, "GONE": pattern, "XDG_CACHE_HOME": str(folder), "PYTHONPATH": path}
    return subprocess.run(
        [sys.executable, "-c", script], env=os.environ | environment, capture_output=True, text=True
    )


@pytest.mark.parametrize("name", of_the_day(list(names_asked_for()), 3), ids=" ".join)
def test_each_name_may_vanish(name, tmp_path):
    """Numba has another name for something that it does not document: the same result, and one notice."""
    (tmp_path / "kernels_of_the_test.py").write_text(KERNELS)
    ran = run_without(*name, USE, tmp_path)
    *notices, result = ran.stdout.splitlines() or [""]
    assert result == "True", ran.stdout + ran.stderr
    is_imported = name[1].startswith(r"\b")  # what an attribute does may not be needed here
    assert len(notices) == 1 if is_imported else len(notices) <= 1, notices
    assert all(each.startswith("notice: kernels are slower, and compiled in each run") for each in notices)


RENDER = """
import numpy as np
from pictures import VIDEO, codes

from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.style import load_style

def planes(name):
    picture = codes(VIDEO, 72, 128)
    with CpuRenderer(load_style(name)) as renderer:
        for time, each in ((0.0, picture), (0.04, picture.map_planes(lambda plane, _: plane & 0xFE))):
            result = renderer.run(each, time)
            yield from (result.luma, *result.chroma)
"""


@pytest.mark.thorough
@pytest.mark.parametrize("name", style_names())
def test_every_style_is_nearly_the_same(name, tmp_path):
    render = {}
    exec(RENDER, render)
    save = f"{RENDER}\nnp.savez('{tmp_path}/planes.npz', *planes({name!r}))"
    ran = run_without("compiler", r"\bFlags\b", save, tmp_path)
    assert ran.returncode == 0, ran.stderr
    with np.load(tmp_path / "planes.npz") as saved:
        for plane, wanted in zip(saved.values(), render["planes"](name), strict=True):
            difference = np.abs(plane.astype(int) - wanted)
            assert np.mean(difference > 1) < 0.001


@compiled
def call_add_neighbors(line, start, step, offsets, weights, tap, windows, taps, out, place):
    add_neighbors(line, start, step, offsets, weights, tap, windows, taps, out, place)


@compiled
def call_sector_sums(pixels, at, offsets, weights, first, last, out, place):
    sector_sums(pixels, at, offsets, weights, first, last, out, place)


@compiled
def call_mean_of_sectors(sums, first, squarings, out, place):
    mean_of_sectors(sums, first, squarings, out, place)


@compiled
def call_take_segment(samples, first, stride, weights, lines, place, pitch):
    four = weights[0], weights[1], weights[2], weights[3]
    take_segment(samples, first, stride, four, lines, place, pitch)


@compiled
def call_take_segments(samples, first, stride, weights, lines, place, pitch):
    four = weights[0], weights[1], weights[2], weights[3]
    take_segments(samples, first, stride, four, lines, place, pitch)


@compiled
def call_plain_segment(take, samples, first, stride, weights, lines, place, pitch):
    take(samples, first, stride, (weights[0], weights[1], weights[2], weights[3]), lines, place, pitch)


CALLS = {
    "take_segment": (call_take_segment, take_segment.plain),
    "take_segments": (call_take_segments, take_segments.plain),
}


@compiled
def call_filter_pixel_block(bank, bins, luma, row, column, sides, low, high, out):
    filter_pixel_block(bank, bins, luma, row, column, sides, low, high, out)


@compiled
def call_add_clipped_block(bank, selected, lines, column, sides, clips, out):
    add_clipped_block(bank, selected, lines, column, sides, clips, out)


def agree(
    call: Compiled, intrinsic: Intrinsic, *arguments: object, out: np.ndarray, rest: tuple = ()
) -> None:
    """Equal for whole numbers, and up to the order of sums for others."""
    plain = out.copy()
    call(*arguments, out, *rest)
    intrinsic.plain(*arguments, plain, *rest)
    assert out.any()
    np.testing.assert_allclose(out, plain, rtol=1e-5, atol=1e-6 if out.dtype == np.float32 else 0)


@pytest.mark.parametrize(("windows", "tap"), [((0,), 0), ((0, 0), 0), ((0, 0), 2)])
def test_add_neighbors_is_equal(windows, tap):
    draw = np.random.default_rng(1)
    line, weights, out = (
        draw.random(shape, np.float32) for shape in (64, (4, VECTOR_LANES), 2 * VECTOR_LANES)
    )
    offsets = np.sort(draw.integers(0, len(windows) * VECTOR_LANES, VECTOR_LANES)).astype(np.int32)
    plain, arguments = out.copy(), (line, 3, 2, offsets, weights, tap, windows, (0, 0))
    call_add_neighbors(*arguments, out, 5)
    add_neighbors.plain(*arguments, plain, 5)
    assert out.tolist() == plain.tolist()


def test_sector_sums_are_equal():
    draw = np.random.default_rng(1)
    pixels = draw.integers(-(1 << 31), 1 << 31, 400).astype(np.int32)
    offsets = 4 * draw.integers(-40, 40, (9, 4))
    weights = draw.integers(-(1 << 31), 1 << 31, (9, 4, 4)).astype(np.int32)
    out = np.zeros(2 * SECTOR_LANES + 3, np.int32)
    agree(call_sector_sums, sector_sums, pixels, 200, offsets, weights, 2, 8, out=out, rest=(3,))


@pytest.mark.parametrize("squarings", [(0,), (0, 0, 0)])
def test_mean_of_sectors_is_nearly_equal(squarings):
    sums = np.random.default_rng(1).integers(-(1 << 28), 1 << 28, 2 * SECTOR_LANES + 2).astype(np.int32)
    out = np.zeros(5, np.float32)
    agree(call_mean_of_sectors, mean_of_sectors, sums, 2, squarings, out=out, rest=(1,))


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
@pytest.mark.parametrize("name", ["take_segment", "take_segments"])
def test_segments_are_nearly_equal(name, dtype):
    call, plain = CALLS[name]
    samples = (np.random.default_rng(1).random(200) * 65535).astype(dtype)
    weights = np.array([20000, 10000, 5000, 30535], dtype)
    lines, wanted = np.zeros((2, 2 * GROUP_ROWS, 2 * SEGMENT_SIZE), dtype)
    call(samples, 3, 30, weights, lines, 7, 2 * SEGMENT_SIZE)
    call_plain_segment(plain, samples, 3, 30, weights, wanted, 7, 2 * SEGMENT_SIZE)
    assert lines.any()
    np.testing.assert_allclose(lines, wanted, rtol=1e-6 if dtype == np.float32 else 0)


@pytest.mark.parametrize(("size", "shared"), [(7, 1), (9, 1), (9, 2), (11, 2)])
def test_filtered_blocks_are_nearly_equal(size, shared):
    draw, together = np.random.default_rng(1), 2
    bank = pack_filters(draw.random((5, size, size), np.float32) - np.float32(0.4))
    bins = draw.integers(0, 5, (together, 32)).astype(np.int32)
    luma = draw.random((size + together * shared - 1, 64), np.float32)
    out = np.zeros((together * shared, 24), np.float32)
    sides = (0,) * size, (0,) * shared, (0,) * together
    ends = np.float32(-0.5), np.float32(1.5)
    agree(call_filter_pixel_block, filter_pixel_block, bank, bins, luma, 2, 8, sides, *ends, out=out)


@pytest.mark.parametrize(
    ("size", "clips"), [(3, (8.0,)), (7, (1.0, 4.0, 16.0)), (9, (8.0, 32.0)), (15, (8.0,))]
)
def test_clipped_blocks_are_nearly_equal(size, clips):
    draw = np.random.default_rng(1)
    bank = pack_clipped(draw.random((5, len(clips), size, size), np.float32) - np.float32(0.4))
    selected = draw.integers(0, 5, 32).astype(np.int32)
    lines, out = draw.random((size, 64), np.float32), draw.random(24, np.float32)
    sides, limits = ((0,) * size, (0,) * len(clips)), np.array(clips, np.float32) / 255
    agree(call_add_clipped_block, add_clipped_block, bank, selected, lines, 8, sides, limits, out=out)
