"""OpenGL devices: finding, opening, choosing and closing. Without a graphics card these are Mesa's."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import psutil
import pytest

from vidstyle.errors import DeviceError, UsageError
from vidstyle.gpu.device import devices as devices
from vidstyle.gpu.device.context import close_context, count_devices, open_context
from vidstyle.gpu.device.devices import DeviceChoice, choose, has_gpu_hardware, list_devices

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux has EGL")

NO_VENDOR = {"__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent", "__EGL_VENDOR_LIBRARY_FILENAMES": ""}
REMEDY = "apt-get install libegl1 libgl1 libgl1-mesa-dri"

OPEN = "context = open_context(); print(context.version_code); close_context(context)"
ALL_SOFTWARE = "devices.SOFTWARE_NAMES = ('',)"
"""Every renderer's name contains this text."""
ALL_REAL = "devices.SOFTWARE_NAMES = ()"
A_CARD = "devices.DEVICE_FILES = ('/dev/null',)"
NO_CARD = "devices.DEVICE_FILES = ()"


def answer(*lines: str, **environment: str) -> str:
    """Return the output of a program in a new process without a display."""
    program = f"""
from vidstyle.errors import VidstyleError
from vidstyle.gpu.device import context
from vidstyle.gpu.device import devices as devices
from vidstyle.gpu.device.context import close_context, open_context
from vidstyle.gpu.device.devices import choose, list_devices
try:
    {f"{chr(10)}    ".join(lines)}
except VidstyleError as error:
    print(type(error).__name__, error.exit_code, error)
"""
    inherited = {name: value for name, value in os.environ.items() if "DISPLAY" not in name}
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env=inherited | environment
    )
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout.count("\n") == 1
    return ended.stdout.strip()


def drawn(context: Any) -> bytes:
    """Return the bytes of one pixel that is drawn in the context."""
    framebuffer = context.simple_framebuffer((1, 1), 4)
    framebuffer.clear(1.0, 0.2, 0.4, 1.0)
    return framebuffer.read(components=4)


PAINTED = bytes((255, 51, 102, 255))


def in_a_thread(work: Callable[[], Any]) -> Any:
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(work).result()


def draw_and_close() -> bytes:
    context = open_context()
    try:
        return drawn(context)
    finally:
        close_context(context)


def test_a_context_opens_without_a_display() -> None:
    assert int(answer(OPEN)) >= 330


def test_each_thread_has_separate_context() -> None:
    assert in_a_thread(draw_and_close) == PAINTED
    context = open_context(0)
    try:
        assert in_a_thread(draw_and_close) == PAINTED
        assert drawn(context) == PAINTED
    finally:
        close_context(context)
    assert draw_and_close() == PAINTED


def test_listing_devices_keeps_callers_context() -> None:
    context = open_context()
    try:
        devices._device.cache_clear()
        assert list_devices()
        assert drawn(context) == PAINTED
    finally:
        close_context(context)


@pytest.mark.parametrize("index", [-1, count_devices()])
def test_a_wrong_number_is_a_device_error(index: int) -> None:
    with pytest.raises(DeviceError, match=f"^gpu:{index}: there is no such device") as failure:
        open_context(index)
    assert failure.value.exit_code == 6


def test_without_the_library_the_package_is_named(tmp_path: Path) -> None:
    (tmp_path / "libEGL.so.1").touch()  # the loader finds it first, and rejects it
    broken = answer(OPEN, LD_LIBRARY_PATH=str(tmp_path))
    assert broken.startswith("DeviceError 6 OpenGL: ") and broken.endswith(
        f"libEGL.so.1: file too short; {REMEDY}"
    )
    missing = answer("context.EGL_LIBRARY = 'libnone.so.1'", OPEN)
    assert missing.startswith("DeviceError 6 OpenGL: libnone.so.1: ") and missing.endswith(f"; {REMEDY}")


def test_every_opengl_library_is_tried() -> None:
    assert int(answer("context.GL_LIBRARIES = ('libnone.so.1', 'libEGL.so.1')", OPEN)) >= 330
    nowhere = answer("context.GL_LIBRARIES = ('libnone.so.1', 'libnone.so.2')", OPEN)
    assert nowhere.startswith("DeviceError 6 OpenGL: no OpenGL 3.3 (libnone.so.1 not loaded); ")


@pytest.mark.parametrize("device", ["gpu", "gpu:0"])
def test_without_a_driver_there_is_no_device(device: str) -> None:
    assert answer(OPEN, **NO_VENDOR) == f"DeviceError 6 OpenGL: EGL finds no device; {REMEDY}"
    assert answer("print(list_devices())", **NO_VENDOR) == "[]"
    reason = f"DeviceError 6 --device {device}: EGL finds no device; {REMEDY}"
    assert answer(f"choose('{device}')", **NO_VENDOR) == reason
    notice = "None no GPU: EGL finds no device; using the CPU"
    assert answer(A_CARD, "print(*vars(choose('auto')).values())", **NO_VENDOR) == notice


def test_driver_that_cannot_be_loaded_is_silent() -> None:
    """Mesa would warn on standard error. Newer versions include their drivers, and open."""
    line = answer(OPEN, LIBGL_DRIVERS_PATH="/nonexistent")
    assert line.isdigit() or line.startswith("DeviceError 6 OpenGL: no OpenGL 3.3 (eglInitialize failed")


only_mesa = pytest.mark.skipif(
    not list_devices()[0].software, reason="only Mesa returns another version of OpenGL on request"
)


@only_mesa
def test_old_driver_is_refused() -> None:
    old = answer(OPEN, MESA_GL_VERSION_OVERRIDE="3.0")
    assert old.startswith("DeviceError 6 OpenGL: no OpenGL 3.3 (") and old.endswith("driver")


@only_mesa
def test_form_of_passes_fits_version() -> None:
    form = "device = list_devices()[0]; print(device.version, device.form)"
    assert answer(form, MESA_GL_VERSION_OVERRIDE="3.3") == "330 fragment"
    assert answer(form, MESA_GL_VERSION_OVERRIDE="4.3") == "430 compute"


def test_devices_describe_themselves() -> None:
    context = open_context(0)
    info, version = dict(context.info), context.version_code
    close_context(context)
    device = list_devices()[0]
    assert (device.index, device.name, device.version) == (0, info["GL_RENDERER"], version)
    assert device.texture_size == info["GL_MAX_TEXTURE_SIZE"] >= 1024
    assert device.software == ("llvmpipe" in device.name)


def test_cpu_is_chosen_without_notice() -> None:
    assert choose("cpu") == DeviceChoice(None, "")


@pytest.mark.parametrize("word", ["", "GPU", "cuda", "gpu:", "gpu:-1", "gpu:one", "gpu:0 ", "gpu:²"])
def test_unknown_device_is_usage_error(word: str) -> None:
    with pytest.raises(UsageError, match="is not a device; choose one of auto, cpu, gpu, gpu:N$"):
        choose(word)


@pytest.mark.parametrize(
    ("device", "settings", "chosen", "notice"),
    [
        ("auto", [NO_CARD, ALL_REAL], None, "no GPU: this machine has no graphics card; using the CPU"),
        ("auto", [A_CARD, ALL_REAL], 0, "using gpu:0, {name}"),
        ("auto", [A_CARD, ALL_SOFTWARE], None, "no GPU: {name} is a software renderer; using the CPU"),
        ("gpu", [NO_CARD, ALL_REAL], 0, "using gpu:0, {name}"),
        ("gpu", [A_CARD, ALL_SOFTWARE], 0, "gpu:0, {name}, {software}"),
        ("gpu:0", [NO_CARD, ALL_REAL], 0, "using gpu:0, {name}"),
        ("gpu:0", [A_CARD, ALL_SOFTWARE], 0, "gpu:0, {name}, {software}"),
    ],
)
def test_the_choice_and_its_notice(device: str, settings: list[str], chosen: int | None, notice: str) -> None:
    software = "is a software renderer: --device cpu is faster"
    expected = notice.format(name=list_devices()[0].name, software=software)
    choice = f"choice = choose('{device}'); print(choice.device and choice.device.index, choice.notice)"
    assert answer(*settings, choice) == f"{chosen} {expected}"


def test_unknown_device_number_lists_devices() -> None:
    with pytest.raises(DeviceError) as failure:
        choose("gpu:999")
    there = " or ".join(map(str, list_devices()))
    assert str(failure.value) == f"--device gpu:999: there is no such device; choose {there}"
    assert "gpu:0, " in there


def test_auto_loads_opengl_only_with_graphics_card() -> None:
    loaded = "import sys; choose('auto'); print('moderngl' in sys.modules)"
    assert answer(NO_CARD, loaded) == "False"
    assert answer(A_CARD, loaded) == "True"


def test_cards_are_known_by_their_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    patterns = tuple(f"{tmp_path}{pattern}" for pattern in devices.DEVICE_FILES)
    monkeypatch.setattr(devices, "DEVICE_FILES", patterns)
    (tmp_path / "dev" / "dri").mkdir(parents=True)
    for name in ("card0", "nvidiactl", "dri/card0"):
        (tmp_path / "dev" / name).touch()
        assert not has_gpu_hardware()
    for name in ("nvidia0", "dxg", "dri/renderD128"):
        (tmp_path / "dev" / name).touch()
        assert has_gpu_hardware()
        (tmp_path / "dev" / name).unlink()


def test_auto_reports_why_card_cannot_be_used(tmp_path: Path) -> None:
    card = tmp_path / "renderD128"
    card.symlink_to("nothing")  # not even root can open it
    nvidia = tmp_path / "nvidia0"
    nvidia.touch()
    for file, reason in ((card, f"{card} may not be opened by this"), (nvidia, "NVIDIA's OpenGL is not ins")):
        files = f"devices.DEVICE_FILES = ('{file}',)"
        notice = answer(files, ALL_SOFTWARE, "print(choose('auto').notice)")
        assert notice.startswith(f"no GPU: {reason}") and notice.endswith("; using the CPU")


def test_closed_contexts_leak_nothing() -> None:
    """Neither files nor memory, also not in threads that have ended."""

    def use() -> None:
        context = open_context()
        context.texture((2048, 1024), 4, bytes(1 << 23)).use()
        close_context(context)

    process = psutil.Process()

    def growth(run: Callable[[], Any]) -> int:
        before = process.memory_info().rss
        for _ in range(20):
            run()
        return process.memory_info().rss - before

    for run in (use, lambda: in_a_thread(use)):
        run()
        files = process.num_fds()
        # A large process may allocate more for other reasons once; a leak grows each time.
        assert any(growth(run) < 10 << 23 for _ in range(3)), "half of the leak of twenty contexts"
        assert process.num_fds() <= files  # garbage collection may close files of earlier tests


def test_the_doctor_describes_each_device() -> None:
    lines = (
        "from vidstyle.doctor import diagnose; facts = diagnose(); print(facts['gpu'], facts['device auto'])"
    )
    first = list_devices()[0]
    there = answer(NO_CARD, lines)
    assert f"['{first}" in there and f"textures up to {first.texture_size} x" in there
    assert f"{first.form} passes'" in there and there.endswith("no graphics card; using the CPU")
    assert answer(NO_CARD, lines, **NO_VENDOR).startswith(f"none (EGL finds no device; {REMEDY}) no GPU: ")
