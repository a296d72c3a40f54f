"""Compiled shaders, cached by their text."""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from vidstyle.errors import DeviceError
from vidstyle.gpu.compile.glsl import TRIANGLE_SHADER, Assembly, read_source

if TYPE_CHECKING:
    import moderngl

MAX_UNUSED = 64
"""Maximum number of programs kept for styles that may be used again."""


class Program:
    """A compiled shader and the values of its uniforms."""

    def __init__(self, context: moderngl.Context, assembly: Assembly) -> None:
        self._context = context
        self._values: dict[str, object] = {}
        self._plain_values: dict[str, object] = {}
        self._triangle: Any = None
        self._program: Any
        moderngl: Any = importlib.import_module("moderngl")
        try:
            if assembly.is_compute:
                self._program = context.compute_shader(assembly.text)
            else:
                self._program = context.program(read_source(TRIANGLE_SHADER), assembly.text)
                self._triangle = context.vertex_array(self._program, [])
        except moderngl.Error as error:
            message = assembly.name_places(str(error))
            reason = next((line for line in message.splitlines() if "error" in line.lower()), message)
            raise DeviceError("the GPU", f"rejects a shader: {reason.strip()}", "use --device cpu") from None

    def set(self, name: str, value: Any) -> None:
        """Set a uniform, unless it already has the value or the compiler has removed it."""
        if self._values.get(name) is value:  # most are constants of a plan
            return
        self._values[name], plain = value, _plain(value)
        if self._plain_values.get(name) == plain:
            return
        self._plain_values[name] = plain
        uniform = self._program.get(name, None)
        if uniform is not None:
            length = getattr(uniform, "array_length", 1)
            uniform.value = plain[:length] if isinstance(plain, list) and length < len(plain) else plain

    def run(self, corner: tuple[int, int], size: tuple[int, int], group: tuple[int, int]) -> None:
        """Run over `size` pixels across and down."""
        if self._triangle is None:
            self._program.run(-(-size[0] // group[0]), -(-size[1] // group[1]))
            self._context.memory_barrier()
        else:
            self._context.viewport = (*corner, *size)
            self._triangle.render(self._context.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Release the program."""
        if self._triangle is not None:
            self._triangle.release()
        self._program.release()


class Programs:
    """The programs of a context, cached by their text."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._programs: dict[str, Program] = {}

    def get(self, assembly: Assembly) -> Program:
        """Return the program of a shader; compile it if it is new.

        Raises:
            DeviceError: the driver does not compile it; the message names the file in shaders/ and the line.
        """
        text = assembly.text
        program = self._programs.pop(text) if text in self._programs else Program(self._context, assembly)
        self._programs[text] = program  # at the end, as the most recently used
        return program

    def trim(self, used: Iterable[Assembly]) -> None:
        """Release the least recently used programs, except programs in use and `MAX_UNUSED` others."""
        texts = {assembly.text for assembly in used}
        unused = [text for text in self._programs if text not in texts]
        for text in unused[: max(len(unused) - MAX_UNUSED, 0)]:
            self._programs.pop(text).release()


def _plain(value: Any) -> Any:
    """Convert a value for moderngl, matrices in column order."""
    if isinstance(value, np.ndarray):
        return tuple(float(number) for number in (value.T if value.ndim == 2 else value).ravel())
    return list(value) if isinstance(value, list) else value
