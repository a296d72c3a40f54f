"""Functions for kernels that are written as LLVM instructions, where LLVM finds no vectors itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vidstyle.core.kernels.declare import Compiled


class Intrinsic(ABC):
    """A function that compiled functions may call; it returns nothing.

    Args:
        plain: a compiled function of the same arguments, which does the same without LLVM instructions.
    """

    def __init__(self, plain: Compiled[..., None]) -> None:
        self.plain = plain

    @abstractmethod
    def emit(self, builder: Any, *arguments: Any, **_: Any) -> None:
        """Emit the instructions of one call.

        Args:
            builder: an `llvmlite.ir.IRBuilder`.
            arguments: of the call: values, or the fields of an array, as `data` and `strides`. A subclass
                names them; so they are named for compiled functions.
        """
