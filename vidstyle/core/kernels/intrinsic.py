"""Functions for kernels that are written as LLVM instructions, where LLVM finds no vectors itself."""

from __future__ import annotations

import importlib
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import Any


class Intrinsic(ABC):
    """A function that compiled functions may call; it returns nothing."""

    @abstractmethod
    def typed(self, void: Any) -> Callable[..., Any]:
        """The function that Numba calls for its signature and code, see `numba.extending.intrinsic`.

        Args:
            void: Numba's type of nothing: called with the types of the arguments it is the signature.
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
        types: Any = importlib.import_module("numba.core.types")
        extending: Any = importlib.import_module("numba.extending")
        return extending.intrinsic(self.typed(types.void))
