"""OpenGL contexts without a window.

A context is current in the thread that opens it, where it replaces any other; it must be used and closed
there.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import queue
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future
from itertools import product
from typing import Any, ParamSpec, TypeVar

from vidstyle.errors import DeviceError

EGL_LIBRARY = "libEGL.so.1"
"""Opens contexts on Linux without a display. Named, as moderngl finds it only with `ldconfig`."""
GL_LIBRARIES = (EGL_LIBRARY, "libOpenGL.so.0", "libGL.so.1")
"""Libraries with OpenGL's functions; moderngl by default tries only the last, which servers often lack."""
# NVIDIA gives just the version that is asked for, and the Mac's one version whatever is asked for.
VERSIONS = (330,) if sys.platform == "darwin" else (460, 430, 330)
"""The versions of OpenGL to ask for, the best first."""


def open_context(index: int | None = None) -> Any:
    """A moderngl context of at least OpenGL 3.3, current in this thread.

    On Linux it is one of EGL's devices; where EGL has none, and elsewhere, the platform's own, number 0.

    Args:
        index: the number of the device; None: the first that can be opened.

    Raises:
        DeviceError: there is no such device, or it cannot be opened.
    """
    devices, failure = _devices()
    subject = "OpenGL" if index is None else f"gpu:{index}"
    if index is not None and index not in range(len(devices)):
        raise DeviceError(subject, f"there is no such device, the last is gpu:{len(devices) - 1}")
    failures = []
    for settings in devices if index is None else [devices[index]]:
        try:
            return _open(settings)
        except Exception as error:  # moderngl raises plain Exception when it finds no library or device
            failures.append(f"no OpenGL 3.3 ({error})")
    if failure:
        raise DeviceError(subject, failure, "apt-get install libegl1 libgl1 libgl1-mesa-dri")
    raise DeviceError(subject, failures[0], "install or update the graphics driver")


def close_context(context: Any) -> None:
    """Release the context and everything created in it."""
    # Makes no context current, or the one before. A context that is released while current stays alive with
    # its textures until its thread opens another, and for ever if the thread ends first.
    with context:
        pass
    context.release()


def count_devices() -> int:
    """The number of devices; some may fail to open."""
    return len(_devices()[0])


def _devices() -> tuple[list[dict[str, Any]], str]:
    """The arguments of moderngl for each device, and why EGL has none where it should."""
    if not sys.platform.startswith("linux"):
        return [{}], ""
    try:
        count = _count_egl_devices()
    except (OSError, AttributeError) as error:  # no such library, or one without such a function
        return [{}], str(error)
    if not count:
        return [{}], "EGL finds no device"
    return [{"backend": "egl", "libegl": EGL_LIBRARY, "device_index": index} for index in range(count)], ""


def _count_egl_devices() -> int:
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")  # else Mesa writes to standard error
    library = ctypes.CDLL(EGL_LIBRARY)
    library.eglGetProcAddress.restype = ctypes.c_void_p
    address = library.eglGetProcAddress(b"eglQueryDevicesEXT")
    if not address:
        return 0
    query_devices = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(address)
    count = ctypes.c_int(0)
    query_devices(0, None, ctypes.byref(count))
    return count.value


def _open(settings: dict[str, Any]) -> Any:
    """The context of the first library and version that work; else the first failure."""
    # Any: moderngl declares its keyword arguments as dictionaries.
    moderngl: Any = importlib.import_module("moderngl")
    choices = [settings | {"libgl": library} for library in GL_LIBRARIES] if settings else [settings]
    failures: list[Exception] = []
    for choice, version in product(choices, VERSIONS):
        try:
            return moderngl.create_context(version, standalone=True, **choice)
        except Exception as error:  # a plain one, as above
            failures.append(error)
    raise failures[0]


Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class ContextThread:
    """Runs calls in order in one thread, as a context belongs to one thread.

    A daemon thread: a driver that hangs must not keep the program from ending.
    """

    def __init__(self, name: str) -> None:
        self._calls: queue.SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name=name, daemon=True)
        self._thread.start()

    def submit(
        self, function: Callable[Arguments, Result], *values: Arguments.args, **named: Arguments.kwargs
    ) -> Future[Result]:
        """Call the function in the thread, after earlier calls."""
        future: Future[Result] = Future()
        self._calls.put((future, lambda: function(*values, **named)))
        return future

    def end(self, seconds: float) -> None:
        """End the thread after the submitted calls; wait for at most so many seconds."""
        self._calls.put(None)
        self._thread.join(seconds)

    def _work(self) -> None:
        while (item := self._calls.get()) is not None:
            future, call = item
            try:
                future.set_result(call())
            except BaseException as error:  # raised to the caller of result()
                future.set_exception(error)
            # Else the last result, perhaps a picture, would stay alive until the next call.
            del item, future, call
