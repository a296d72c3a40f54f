"""Functions for kernels that are written as LLVM instructions, where LLVM finds no vectors itself."""

from __future__ import annotations

import importlib
import inspect
from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any


class Intrinsic(ABC):
    """A function that compiled functions may call; it returns nothing."""

    @abstractmethod
    def emit(self, builder: Any, *arguments: Any, **_: Any) -> None:
        """Emit the instructions of one call.

        Args:
            builder: an `llvmlite.ir.IRBuilder`.
            arguments: of the call: values, or the fields of an array, as `data` and `strides`. A subclass
                names them; so they are named for compiled functions.
        """

    @property
    def _numba_type_(self) -> Any:
        """The type of this global for compiled code; read by Numba."""
        registry: Any = importlib.import_module("numba.core.registry")
        intrinsic, context = self._intrinsic, registry.cpu_target.typing_context
        context.refresh()  # registers the intrinsic
        return context.resolve_value_type(intrinsic)

    @cached_property
    def _intrinsic(self) -> Any:
        numba: Any = importlib.import_module("numba.core")
        extending: Any = importlib.import_module("numba.extending")

        def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            self.emit(
                builder,
                *(
                    numba.cgutils.create_struct_proxy(kind)(context, builder, value)
                    if isinstance(kind, numba.types.Array)
                    else value
                    for kind, value in zip(signature.args, values, strict=True)
                ),
            )
            return context.get_dummy_value()

        def typed(context: Any, *kinds: Any) -> Any:
            return numba.types.void(*kinds), emit

        names = inspect.signature(self.emit).parameters  # Numba takes the builder's place for its context's
        typed.__signature__ = inspect.Signature(list(names.values()))  # type: ignore[attr-defined]
        return extending.intrinsic(typed)
