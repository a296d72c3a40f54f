"""Links object files into this process, with LLVM."""

from __future__ import annotations

import llvmlite.binding as llvm


def processor() -> tuple[object, ...]:
    """Return what machine code is made for, and by which LLVM."""
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), llvm.llvm_version_info


class Engine:
    """Machine code that was linked into this process."""

    def __init__(self) -> None:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        self._machine = llvm.Target.from_default_triple().create_target_machine(jit=True)
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), self._machine)
        self._added: set[str] = set()

    def add(self, name: str, code: bytes) -> int:
        """Link an object file, once, and return the address of the function of that name."""
        if name not in self._added:
            self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
            self._engine.finalize_object()
            self._added.add(name)
        return int(self._engine.get_function_address(name))
