"""Which OpenGL renderer this machine has."""

from __future__ import annotations

import importlib
from typing import Any

SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software")
"""Words in the names of renderers that draw on the CPU; those do not count as a GPU (design, section 1)."""
EGL_LIBRARIES = ("libEGL.so.1", "libOpenGL.so.0", "libGL.so.1")
"""Where OpenGL's functions may lie; moderngl by itself looks only for the last, which servers often lack."""


def gl_renderer() -> str:
    """The name and version of the renderer, or why there is none."""
    # Any: moderngl declares its keyword arguments as dictionaries.
    moderngl: Any = importlib.import_module("moderngl")
    reason = "none"
    for library in EGL_LIBRARIES:
        try:
            context = moderngl.create_context(standalone=True, backend="egl", libgl=library)
        except Exception as error:  # moderngl raises plain Exception when it finds no library or device
            reason = f"none ({error})"
            continue
        name, version = context.info["GL_RENDERER"], context.version_code
        context.release()
        return f"{name}, OpenGL {version // 100}.{version // 10 % 10}{_software_note(name)}"
    return reason


def _software_note(name: str) -> str:
    return " (software: not a GPU)" if any(word in name.lower() for word in SOFTWARE) else ""
