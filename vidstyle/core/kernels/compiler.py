"""Compiles kernels to object files. Only this module and `entry_function` use undocumented parts of Numba.

If it fails, as with a changed version of Numba, `plain_numba` replaces it.
"""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from llvmlite import binding
from numba.core import cgutils, config, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Flags, compile_extra
from numba.core.compiler_lock import global_compiler_lock
from numba.core.cpu_options import FastMathOptions
from numba.core.errors import NumbaError
from numba.core.registry import cpu_target
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate
from numba.extending import intrinsic as numba_intrinsic
from numba.extending import typeof_impl
from numba.np.numpy_support import from_dtype

from vidstyle.core.kernels.arguments import is_array_type
from vidstyle.core.kernels.declare import ArgumentType, Compiled, Intrinsic, KernelError
from vidstyle.core.kernels.entry_function import EntryFunction

SCALARS = {int: types.int64, bool: types.boolean, float: types.float64, np.float32: types.float32}
PROCESSOR = binding.get_host_cpu_features()
if PROCESSOR.get("avx512vbmi2"):
    # The first processors with AVX-512 slow down at vectors of 512 bits; LLVM avoids them on later ones too.
    config.CPU_FEATURES = f"{PROCESSOR.flatten()},-prefer-256-bit"
    if binding.llvm_version_info >= (20,):  # older ones complain that they do not know it
        # LLVM would add products of 16 bits by two instructions instead of one: slower if there are many.
        config.CPU_FEATURES += ",+fast-dpwssd"


@global_compiler_lock
def object_code(name: str, compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> bytes:
    """Return an object file with the C function `name`.

    See `EntryFunction` for what it takes and returns.

    Raises:
        KernelError: the function creates an array, or needs another part of Numba's runtime.
    """
    try:
        result = _compile(compiled, tuple(map(_type, kinds)))
    except NumbaError as error:
        raise KernelError(f"{compiled.function.__qualname__} cannot be compiled: {error}") from error
    context = cpu_target.target_context
    library = context.codegen().create_library(name)
    library.add_linking_library(result.library)
    module = library.create_ir_module(name)
    EntryFunction(module, name, result.fndesc, kinds).emit()
    library.add_ir_module(module)
    library.finalize()
    final = library._final_module
    needed = [each.name for each in final.functions if each.is_declaration and _is_run_time(each.name)]
    if needed:
        raise KernelError(f"{compiled.function.__qualname__} needs {', '.join(needed)}, which only Numba has")
    return bytes(context.codegen()._tm.emit_object(final))


def _is_run_time(symbol: str) -> bool:
    return symbol.startswith(("NRT_", "numba_", "Py"))


def emit_object_files_only() -> None:
    """Make no machine code of parts and of wholes that nobody runs in this process: a fifth of the time."""
    JITCodeLibrary._finalize_specific = lambda library: None  # type: ignore[method-assign]


@typeof_impl.register(Compiled)
def _callee(compiled: Compiled, _: object = None) -> types.Function:
    """Return the type of a kernel that another one calls: calling it compiles it."""
    cpu_target.typing_context.refresh()
    return _callee_type(compiled)


@typeof_impl.register(Intrinsic)
def _intrinsic_type(intrinsic: Intrinsic, _: object) -> types.Type:
    declared, context = _declared(intrinsic), cpu_target.typing_context
    context.refresh()  # registers the intrinsic
    return context.resolve_value_type(declared)


@cache
def _declared(intrinsic: Intrinsic) -> Any:
    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        arguments = zip(signature.args, values, strict=True)
        intrinsic.emit(builder, *(_fields(context, builder, *each) for each in arguments))
        return context.get_dummy_value()

    def typed(context: Any, *kinds: types.Type) -> Any:
        return types.void(*kinds), emit

    names = inspect.signature(intrinsic.emit).parameters  # Numba takes the builder's place for its context's
    typed.__signature__ = inspect.Signature(list(names.values()))  # type: ignore[attr-defined]
    return numba_intrinsic(typed)


def _fields(context: Any, builder: Any, kind: types.Type, value: Any) -> Any:
    """Return the fields of an array, or any other value itself."""
    is_array = isinstance(kind, types.Array)
    return cgutils.create_struct_proxy(kind)(context, builder, value) if is_array else value


@cache
def _callee_type(compiled: Compiled) -> types.Function:
    class Callee(AbstractTemplate):
        key = compiled

        def generic(self, arguments: Sequence[types.Type], _: object) -> Any:
            result = _compile(compiled, tuple(arguments))
            return signature(result.signature.return_type, *arguments)

    return types.Function(Callee)


@cache
def _compile(compiled: Compiled, arguments: tuple[types.Type, ...]) -> Any:
    flags: Any = Flags()
    flags.error_model = "numpy"  # Python's division checks for zero each time, which prevents vectorization
    flags.fastmath, flags.noalias = FastMathOptions(compiled.fastmath), compiled.noalias
    flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    typing, target = cpu_target.typing_context, cpu_target.target_context
    typing.refresh()
    target.refresh()
    part = target.codegen().create_library(compiled.function.__qualname__)
    # The whole is optimized with all its parts; each of them before, too, takes a sixth more time.
    part._optimize_final_module = lambda: None
    result = compile_extra(typing, target, compiled.function, arguments, None, flags, {}, part)
    target.insert_user_function(compiled, result.fndesc, [result.library])
    return result


def _type(kind: ArgumentType) -> types.Type:
    if isinstance(kind, Compiled):
        return _callee(kind)
    if not isinstance(kind, tuple):
        return SCALARS[kind]
    if not is_array_type(kind):
        return types.BaseTuple.from_types(tuple(map(_type, kind)))
    dtype, dimensions, is_contiguous = kind
    return types.Array(from_dtype(dtype), dimensions, "C" if is_contiguous else "A")
