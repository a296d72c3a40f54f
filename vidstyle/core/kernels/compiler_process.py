"""Compiles kernels in this process; or as a program that reads requests and writes answers."""

from __future__ import annotations

import gc
import importlib
import pickle
import sys
from contextlib import suppress
from typing import Any

from vidstyle.core.kernels.declare import ArgumentType, Compiled, CompilerError, KernelError


def compile_here(
    name: str, compiled: Compiled, kinds: tuple[ArgumentType, ...], runs_nothing: bool = False
) -> bytes:
    """Return the object file of a kernel.

    Args:
        runs_nothing: whether this process calls no function that Numba compiles.

    Raises:
        KernelError: the kernel cannot be compiled.
        CompilerError: no kernel can be compiled with this Numba.
    """
    try:
        compiler: Any = importlib.import_module("vidstyle.core.kernels.compiler")
        if runs_nothing:
            compiler.emit_object_files_only()
        code: bytes = compiler.object_code(name, compiled, kinds)
    except (KernelError, MemoryError):
        raise
    except Exception as error:
        raise CompilerError(f"{type(error).__name__}: {error}") from error
    return code


def main() -> None:
    """Answer the requests, until there are no more."""
    gc.disable()  # what Numba makes lives as long as the process
    with suppress(EOFError, KeyboardInterrupt):
        while True:
            name, module, function, kinds = pickle.load(sys.stdin.buffer)
            kernel = getattr(importlib.import_module(module), function)
            pickle.dump(_answer(name, kernel, kinds), sys.stdout.buffer)
            sys.stdout.flush()


def _answer(name: str, kernel: Compiled, kinds: tuple[ArgumentType, ...]) -> bytes | Exception:
    try:
        return compile_here(name, kernel, kinds, runs_nothing=True)
    except (KernelError, CompilerError) as error:
        return error


if __name__ == "__main__":
    main()
