"""The CPU renderer: bands, sizes, lengths, and arrays of any memory layout."""

from __future__ import annotations

import platform
import subprocess
import sys
import threading
from itertools import product
from typing import Any

import cv2
import numpy as np
import pytest
from pictures import (
    FLOAT,
    SOURCES,
    VIDEO,
    codes,
    noise,
    run,
    run_color,
    run_luma,
    same_bits,
    step,
    style,
)

from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.core.planes import chroma_rows
from vidstyle.core.resample import scaled_shape
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.cpu.renderer import CpuRenderer

LONG = style(
    step("gaussian", sigma=1.0, save="soft"),
    step("saturation"),
    step("posterize", levels=6),
    step("halftone", cell=4.0),
    step("blend", other="soft", mode="multiply", mask="soft"),
    lines=(step("to_gray"), step("gaussian", sigma=0.7), step("sobel", invert=True), step("soft_threshold")),
    ink="#302010",
)


@pytest.mark.parametrize(
    "target", [VIDEO, Encoding(siting=SITINGS["bottom"]), Encoding(subsampling=(4, 4)), FLOAT], ids=str
)
@pytest.mark.parametrize("name", ["video", "rgb", "gray"])
def test_bands_keep_every_bit_of_long_style(
    monkeypatch: pytest.MonkeyPatch, target: Encoding, name: str
) -> None:
    results = []
    for size, threads in ((1 << 30, 1), (1, 1), (1, 4), (9000, 3)):
        monkeypatch.setenv("VIDSTYLE_THREADS", str(threads))
        monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", size)
        results.append(run(LONG, SOURCES[name], threads=threads, target=target))
    assert all(same_bits(results[0], result) for result in results[1:])


def test_lengths_grow_with_the_shorter_side() -> None:
    """Lengths are relative to `height`; a rotated picture gets the same lengths."""
    luma = noise(40, 90)
    twice = run_luma(style(step("gaussian", sigma=2.0), height=20.0), luma)
    np.testing.assert_array_equal(twice, run_luma(style(step("gaussian", sigma=4.0)), luma))
    turned = run_luma(style(step("gaussian", sigma=2.0), height=20.0), luma.T)
    np.testing.assert_allclose(turned, twice.T, atol=1e-6)
    threshold = run_luma(style(step("soft_threshold"), height=20.0), luma)
    np.testing.assert_array_equal(threshold, run_luma(style(step("soft_threshold")), luma))


def test_no_length_falls_below_minimum() -> None:
    color = noise(30, 40, 3)
    tiny = run_color(style(step("halftone", cell=6.0), height=3000.0), color)
    np.testing.assert_array_equal(tiny, run_color(style(step("halftone", cell=3.0)), color))


def test_one_renderer_accepts_any_size_and_kind() -> None:
    with CpuRenderer(LONG) as renderer:
        for shape, encoding in product([(20, 30), (8, 9), (20, 30)], [VIDEO, Encoding(depth=10)]):
            picture = codes(encoding, *shape)
            assert same_bits(renderer.run(picture, 0.0), run(LONG, picture))


def test_alpha_and_color_in_one_array() -> None:
    """RGBA floats: the colour is a view with gaps."""
    rgba = noise(20, 30, 4)
    expected = run_color(LONG, np.ascontiguousarray(rgba[..., :3]))
    out = run(LONG, Picture.from_array(rgba), rgb=True)
    np.testing.assert_array_equal(out.color, expected)
    np.testing.assert_array_equal(out.alpha, rgba[..., 3])


def test_padded_and_reversed_planes_are_read_correctly() -> None:
    """Rows with padding, as from decoders, and flipped views."""
    source = codes(VIDEO, 18, 20)
    assert source.luma is not None and source.chroma is not None
    wide = [np.pad(plane, ((0, 0), (0, 7))) for plane in (source.luma, *source.chroma)]
    views = [plane[:, :-7] for plane in wide]
    padded = Picture(VIDEO, luma=views[0], chroma=(views[1], views[2]))
    assert same_bits(run(LONG, padded), run(LONG, source))
    flipped = Picture(VIDEO, luma=views[0][::-1], chroma=(views[1][::-1], views[2][::-1]))
    copied = Picture(VIDEO, luma=views[0][::-1].copy(), chroma=(views[1][::-1].copy(), views[2][::-1].copy()))
    assert same_bits(run(LONG, flipped), run(LONG, copied))


@pytest.mark.parametrize("factor", [0.5, 0.7, 1.3])
@pytest.mark.parametrize(
    ("method", "opencv"),
    [("bilinear", cv2.INTER_LINEAR), ("bicubic", cv2.INTER_CUBIC), ("lanczos", cv2.INTER_LANCZOS4)],
)
def test_working_size_resamples_as_opencv_does(method: str, opencv: int, factor: float) -> None:
    luma = noise(41, 60)
    out = run_luma(style(step("scale", factor=factor, method=method, back=method)), luma)
    other = cv2.resize(luma, scaled_shape(luma.shape, factor)[::-1], interpolation=opencv)
    np.testing.assert_allclose(out, cv2.resize(other, (60, 41), interpolation=opencv), atol=2e-5)


def test_chroma_rows_of_result_follow_siting() -> None:
    """A colour edge written to 4:2:0 with each siting is read back at the same position."""
    x = np.linspace(-0.2, 0.2, 40, dtype=np.float32)[None].repeat(24, axis=0)
    source = Picture(FLOAT, luma=np.full_like(x, 0.5), chroma=(x, -x))
    for siting in SITINGS.values():
        target = Encoding(depth=0, full_range=True, siting=siting)
        back = chroma_rows(run(style(step("saturation", factor=1.0)), source, target=target), 0, 24)
        np.testing.assert_allclose(back[0][2:-2, 2:-2], x[2:-2, 2:-2], atol=1e-5)


@pytest.mark.skipif("glibc" not in platform.libc_ver(), reason="only glibc has the setting")
def test_freed_memory_is_kept_for_all_threads() -> None:
    """A second frame needs no new memory pages of the system, on the same thread or another."""
    code = """if True:
    import resource, threading
    import numpy as np
    from vidstyle.core.bands import keep_freed_memory

    def note_new_pages():
        before = resource.getrusage(resource.RUSAGE_THREAD).ru_minflt
        np.ones(4 << 20, np.float32)
        print(resource.getrusage(resource.RUSAGE_THREAD).ru_minflt - before)

    keep_freed_memory()
    note_new_pages()
    note_new_pages()
    thread = threading.Thread(target=note_new_pages)
    thread.start()
    thread.join()
    """
    made = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    first, second, other = map(int, made.split())
    assert first > 256
    assert max(second, other) < 64


def test_few_threads_share_a_small_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """More of them would only wait for each other."""
    monkeypatch.setattr("vidstyle.core.bands.MAX_MEGAPIXEL_THREADS", 3)
    given, finish = [], CpuRenderer._finish

    def noted(self: CpuRenderer, frame: Any, workers: Any) -> Picture:
        given.append(workers.count)
        return finish(self, frame, workers)

    monkeypatch.setattr(CpuRenderer, "_finish", noted)
    for threads in (2, 16):
        with CpuRenderer(style(step("posterize")), threads) as renderer:
            for shape in ((1, 1), (360, 640), (720, 1280)):
                renderer.run(Picture.from_array(np.zeros((*shape, 3), np.uint8)))
    assert given == [1, 2, 2, 1, 2, 3]


@pytest.mark.parametrize("threads", (1, 2))
def test_calling_thread_takes_part_in_restyling(threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    used: set[threading.Thread] = set()
    run_band = FrameExecutor._run_band

    def noted(*arguments: Any) -> Any:
        used.add(threading.current_thread())
        return run_band(*arguments)

    monkeypatch.setattr(FrameExecutor, "_run_band", noted)
    with CpuRenderer(LONG, threads) as renderer:
        renderer.run(Picture.from_array(np.zeros((256, 64, 3), np.uint8)))
    assert threading.current_thread() in used
    assert threads > 1 or len(used) == 1
