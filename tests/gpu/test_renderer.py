"""The GPU as a `Backend`: one frame in flight, order, completeness, and loss of the GPU."""

from __future__ import annotations

import ctypes
import gc
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from faults import Program, times
from media import make_clip, rgb_from_frame
from pictures import VIDEO, codes, step, style

import vidstyle
from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.errors import DeviceError, StyleError
from vidstyle.gpu import renderer as gpu_renderer
from vidstyle.gpu import session
from vidstyle.gpu.compile import glsl as includes
from vidstyle.gpu.compile import shader_writer
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.device import devices as devices
from vidstyle.gpu.renderer import GpuRenderer
from vidstyle.gpu.session import GpuSession
from vidstyle.pipeline.render import render
from vidstyle.renderer import open_renderer
from vidstyle.style import Style

LOOK = style(step("gaussian", sigma=1.5), step("brightness", factor=1.2), step("saturation", factor=1.5))


@pytest.fixture(scope="module")
def device() -> devices.Device:
    chosen = devices.choose("gpu").device
    assert chosen is not None
    return chosen


@pytest.fixture
def renderer(device: devices.Device) -> Iterator[GpuRenderer]:
    made = GpuRenderer(LOOK, device, CpuRenderer)
    yield made
    made.close()


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_clip(tmp_path_factory.mktemp("clip") / "clip.mp4", size=(96, 54), frames=45, audio_tracks=1)


def by_cpu(picture: Picture, look: Style = LOOK) -> Picture:
    with CpuRenderer(look) as cpu:
        return cpu.run(picture)


def differ(one: Picture, two: Picture) -> int:
    """Return the largest difference between the planes of two pictures, in codes."""
    assert one.luma is not None and two.luma is not None and one.chroma and two.chroma
    pairs = zip((one.luma, *one.chroma), (two.luma, *two.chroma), strict=True)
    return max(int(np.abs(a.astype(int) - b.astype(int)).max()) for a, b in pairs)


def fail_once(renderer: GpuRenderer) -> None:
    """Make the driver report an error by an invalid request."""
    assert renderer._session is not None
    enable = ctypes.CDLL("libGL.so.1").glEnable
    renderer._session._thread.submit(enable, 0xFFFF).result()


def test_results_are_in_order_and_agree_with_cpu(renderer: GpuRenderer) -> None:
    sources = [codes(VIDEO, 37, 53, seed) for seed in range(9)]
    pending = [renderer.begin(FrameRequest(sources[0], 0.0))]
    for number, source in enumerate(sources[1:], 1):
        pending.append(renderer.begin(FrameRequest(source, number / 25)))
        assert differ(pending[number - 1].result(), by_cpu(sources[number - 1])) <= 1
    assert differ(pending[-1].result(), by_cpu(sources[-1])) <= 1


def test_any_number_of_pictures_can_be_in_flight(renderer: GpuRenderer) -> None:
    sources = [codes(VIDEO, 20 + seed, 30, seed) for seed in range(6)]
    pending = [renderer.begin(FrameRequest(source, number / 25)) for number, source in enumerate(sources)]
    for source, each in zip(sources, pending, strict=True):
        assert differ(each.result(), by_cpu(source)) <= 1


def test_readback_lags_one_frame(clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Frame n + 1 is uploaded before the program waits for frame n; the last frames are complete."""
    order: list[tuple[str, float]] = []
    start, fetch = GpuSession._start, GpuSession._fetch
    monkeypatch.setattr(
        GpuSession,
        "_start",
        lambda self, look, request: (order.append(("start", request.time)), start(self, look, request))[1],
    )
    monkeypatch.setattr(
        GpuSession,
        "_fetch",
        lambda self, drawn: (order.append(("fetch", drawn.request.time)), fetch(self, drawn))[1],
    )
    summary = render(clip, tmp_path / "gpu.mp4", LOOK, device="gpu")
    assert summary.frames == 45 and times(tmp_path / "gpu.mp4") == pytest.approx(times(clip), abs=0.001)
    starts = [at for what, at in order if what == "start"]
    expected = [("start", starts[0])]
    for before, after in zip(starts, starts[1:], strict=False):
        expected += [("start", after), ("fetch", before)]
    assert order == [*expected, ("fetch", starts[-1])]


@pytest.mark.parametrize("start", [None, 1.0], ids=["whole", "from the middle"])
def test_film_agrees_with_cpu(clip: Path, tmp_path: Path, start: float | None) -> None:
    from fractions import Fraction

    read = vidstyle.ReadOptions(start=None if start is None else Fraction(start))
    for device in ("cpu", "gpu"):
        render(
            clip,
            tmp_path / f"{device}.mkv",
            LOOK,
            device=device,
            read=read,
            write=vidstyle.WriteOptions(crf=0),
        )
    frames = {device: shown(tmp_path / f"{device}.mkv") for device in ("cpu", "gpu")}
    assert len(frames["gpu"]) == len(frames["cpu"]) == (45 if start is None else 15)
    for one, two in zip(frames["gpu"], frames["cpu"], strict=True):
        assert (np.abs(one - two) > 3).mean() < 0.002


def shown(path: Path) -> list[np.ndarray]:
    import av

    with av.open(str(path)) as container:
        return [rgb_from_frame(frame).astype(int) for frame in container.decode(video=0)]


def test_size_changes_and_returns(renderer: GpuRenderer) -> None:
    for number, shape in enumerate([(31, 47), (31, 47), (90, 20), (1, 1), (31, 47)]):
        source = codes(VIDEO, *shape, seed=number)
        assert differ(renderer.run(source, number / 25), by_cpu(source)) <= 1


def test_lost_gpu_is_reopened_once_before_cpu_takes_over(
    renderer: GpuRenderer, caplog: pytest.LogCaptureFixture
) -> None:
    """Pictures in flight are not lost."""
    caplog.set_level("INFO", "vidstyle")
    sources = [codes(VIDEO, 24, 36, seed) for seed in range(6)]
    pending = [renderer.begin(FrameRequest(source, number / 25)) for number, source in enumerate(sources[:2])]
    fail_once(renderer)
    for source, each in zip(sources, pending, strict=False):
        assert differ(each.result(), by_cpu(source)) <= 1
    assert [record.message for record in caplog.records] == [
        "the GPU is lost (the GPU reports GL_INVALID_ENUM; use --device cpu): reopened"
    ]
    assert differ(renderer.run(sources[2], 0.2), by_cpu(sources[2])) <= 1
    fail_once(renderer)
    for number, source in enumerate(sources[3:]):
        assert differ(renderer.run(source, 0.3 + number / 25), by_cpu(source)) == 0 or number == 0
    assert "continuing on the CPU" in caplog.records[-1].message and len(caplog.records) == 2


def test_cpu_takes_over_if_gpu_cannot_be_reopened(
    renderer: GpuRenderer, caplog: pytest.LogCaptureFixture
) -> None:
    renderer._device = replace(renderer._device, index=99)
    source = codes(VIDEO, 24, 36)
    fail_once(renderer)
    assert differ(renderer.run(source), by_cpu(source)) <= 1
    assert len(caplog.records) == 1 and "continuing on the CPU" in caplog.records[0].message


def test_cpu_takes_over_if_gpu_hangs(
    renderer: GpuRenderer, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gpu_renderer, "HANG_SECONDS", 0.2)
    monkeypatch.setattr(session, "END_SECONDS", 0.1)
    renderer._device = replace(renderer._device, software=False)
    assert renderer._session is not None
    awake = threading.Event()
    hanging = renderer._session._thread.submit(awake.wait, 60)
    source = codes(VIDEO, 24, 36)
    assert differ(renderer.run(source), by_cpu(source)) == 0
    assert not hanging.done()
    assert "no picture for 0.2 s" in caplog.records[0].message
    awake.set()


def test_lost_gpu_without_memory_for_cpu_exits_with_6(
    device: devices.Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_memory(style: Style) -> Any:
        raise MemoryError

    renderer = GpuRenderer(LOOK, device, no_memory)
    renderer._device = replace(device, index=99)
    fail_once(renderer)
    with pytest.raises(DeviceError, match="not enough memory") as raised:
        renderer.run(codes(VIDEO, 8, 8))
    assert raised.value.exit_code == 6
    renderer.close()


def test_a_shader_that_does_not_compile_is_named_by_file_and_line(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    read = includes.read_source
    broken = "// Line 1.\nfloat brightness(float luma, float factor) {\n    return luma * factors;\n}\n"
    monkeypatch.setattr(
        includes, "read_source", lambda file: broken if file == "blocks/brightness.glsl" else read(file)
    )
    monkeypatch.setattr(shader_writer, "_texts", {})
    made = open_renderer(style(step("brightness")), "gpu")
    source = codes(VIDEO, 6, 8)
    assert differ(made.run(source), by_cpu(source, style(step("brightness")))) == 0
    made.close()
    assert "shaders/blocks/brightness.glsl:3" in caplog.records[-1].message


def test_style_error_does_not_count_as_lost_gpu(device: devices.Device, tmp_path: Path) -> None:
    hatched = style(step("pattern", tiles="none"), folder=tmp_path)
    made = GpuRenderer(hatched, device, CpuRenderer)
    with pytest.raises(StyleError, match="is not in the style"):
        made.run(codes(VIDEO, 6, 8))
    made.close()


@pytest.mark.parametrize(("word", "exit_code"), [("gpu:99", 6), ("tpu", 2)])
def test_missing_device_is_one_line_error(program: Program, clip: Path, word: str, exit_code: int) -> None:
    outcome = program(clip, "out.mp4", "--device", word, style="sketch")
    assert (outcome.exit_code, len(outcome.lines), outcome.left) == (exit_code, 1, [])
    assert word in outcome.said


def test_device_is_reported_in_one_line(device: devices.Device, program: Program, clip: Path) -> None:
    outcome = program(clip, "a.mp4", "--frames", "2", "--device", "gpu", style="sketch")
    said = "--device cpu is faster" if device.software else f"using {device}"
    assert outcome.exit_code == 0 and said in outcome.said
    outcome = program(clip, "b.mp4", "--frames", "2", style="sketch")
    said = "no GPU" if device.software else f"using {device}"
    assert outcome.exit_code == 0 and outcome.said.startswith(f"vidstyle: {said}")
    assert len(outcome.lines) == 1


@pytest.mark.parametrize("form", ["compute", "fragment"])
def test_changing_styles_and_sizes_leaks_nothing(device: devices.Device, form: Form) -> None:
    looks = [vidstyle.load_style("sketch"), LOOK, style(step("equalize"), step("sobel"))]
    made = GpuSession(device, form)
    counts = []
    for number in range(18):
        shape = (30, 40) if number % 2 else (36, 28)
        for _ in range(3):
            made.fetch(made.start(looks[number % 3], FrameRequest(codes(VIDEO, *shape))).result()).result()
        counts.append(made._thread.submit(living, made._context).result())
    made.close()
    assert counts[6:12] == counts[12:18]


def living(context: Any) -> int:
    """Return the number of objects of a context that have not been released."""
    import moderngl

    kinds = (moderngl.Texture, moderngl.TextureArray, moderngl.Buffer, moderngl.Framebuffer, moderngl.Program)
    kinds += (moderngl.VertexArray,)
    held = [
        thing
        for thing in gc.get_objects()
        if type(thing) in kinds and getattr(thing, "ctx", context) is context
    ]
    return sum(not isinstance(thing.mglo, moderngl.InvalidObject) for thing in held)
