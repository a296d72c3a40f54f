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
"""Library for contexts on Linux without a display. Named explicitly, as moderngl only finds it with
`ldconfig`."""
GL_LIBRARIES = (EGL_LIBRARY, "libOpenGL.so.0", "libGL.so.1")
"""Libraries with OpenGL's functions; by default moderngl only tries the last, which servers often lack."""
# NVIDIA returns exactly the requested version; macOS has only one version.
GL_VERSIONS = (330,) if sys.platform == "darwin" else (460, 430, 330)
"""Versions of OpenGL to request, the best first."""


def open_context(index: int | None = None) -> Any:
    """Open a moderngl context of at least OpenGL 3.3 and make it current in this thread.

    On Linux it uses one of EGL's devices. If EGL has none, and on other systems, it uses the platform's
    device, number 0.

    Args:
        index: the number of the device; None for the first that can be opened.

    Raises:
        DeviceError: the device does not exist or cannot be opened.
    """
    devices, failure = _devices()
    subject = "OpenGL" if index is None else f"gpu:{index}"
    if index is not None and index not in range(len(devices)):
        raise DeviceError(subject, f"there is no such device, the last is gpu:{len(devices) - 1}")
    failures = []
    for settings in devices if index is None else [devices[index]]:
        try:
            return _open(settings)
        except Exception as error:  # moderngl raises Exception if it finds no library or device
            failures.append(f"no OpenGL 3.3 ({error})")
    if failure:
        raise DeviceError(subject, failure, "apt-get install libegl1 libgl1 libgl1-mesa-dri")
    raise DeviceError(subject, failures[0], "install or update the graphics driver")


def close_context(context: Any) -> None:
    """Release the context and all its objects."""
    # Makes no context or the previous one current. A context released while current stays alive with its
    # textures until its thread opens another context, or forever if the thread ends first.
    with context:
        pass
    context.release()


def count_devices() -> int:
    """Return the number of devices; some may fail to open."""
    return len(_devices()[0])


def _devices() -> tuple[list[dict[str, Any]], str]:
    """Return the arguments of moderngl for each device, and the reason if EGL has none on Linux."""
    if not sys.platform.startswith("linux"):
        return [{}], ""
    try:
        count = _count_egl_devices()
    except (OSError, AttributeError) as error:  # the library or its function is missing
        return [{}], str(error)
    if not count:
        return [{}], "EGL finds no device"
    return [{"backend": "egl", "libegl": EGL_LIBRARY, "device_index": index} for index in range(count)], ""


def _count_egl_devices() -> int:
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")  # otherwise Mesa writes to standard error
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
    """Open a context with the first library and version that work, or raise the first failure."""
    # Any, as moderngl annotates its keyword arguments as dictionaries.
    moderngl: Any = importlib.import_module("moderngl")
    choices = [settings | {"libgl": library} for library in GL_LIBRARIES] if settings else [settings]
    failures: list[Exception] = []
    for choice, version in product(choices, GL_VERSIONS):
        try:
            return moderngl.create_context(version, standalone=True, **choice)
        except Exception as error:  # moderngl raises Exception, see above
            failures.append(error)
    raise failures[0]


Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class ContextThread:
    """Runs calls in order in one thread, as a context belongs to one thread.

    It is a daemon thread, so that a hanging driver does not keep the program from exiting.
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
        """End the thread after the submitted calls; wait for at most `seconds`."""
        self._calls.put(None)
        self._thread.join(seconds)

    def _work(self) -> None:
        while (item := self._calls.get()) is not None:
            future, call = item
            try:
                future.set_result(call())
            except BaseException as error:  # raised to the caller of result()
                future.set_exception(error)
            # Otherwise the last result, which may be a picture, would stay alive until the next call.
            del item, future, call
