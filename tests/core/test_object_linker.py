"""Machine code of kernels is linked without LLVM, or by LLVM with the same result."""

from __future__ import annotations

import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vidstyle.core.kernels import Compiled, compiled, library, object_files
from vidstyle.core.kernels.declare import types_of
from vidstyle.core.machine.object_linker import RELOCATION, RELOCATIONS_ID, LinkError, _sections, link
from vidstyle.core.machine.processor import LINES, described_processor

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="LLVM links elsewhere"
)

VALUES = np.linspace(-3, 3, 50)
RENDER = """
import sys
import numpy as np
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.style import load_style

with CpuRenderer(load_style("ink")) as renderer:
    renderer.run(Picture.from_array(np.zeros((40, 60, 3), np.uint8)), 0.0)
print([name for name in sys.modules if name.partition(".")[0] in ("llvmlite", "numba")])
"""


@compiled
def set_waves(angles, out):
    """Needs constants, a function of the C library, and copies."""
    out[:] = 0
    for index in range(angles.size):
        out[index] = np.sin(angles[index]) * 0.125 + 3.5


def object_of(kernel: Compiled[Any, Any], *arguments: Any) -> tuple[str, bytes]:
    """Return the name and the object file of a kernel."""
    kernel(*arguments)
    name = library.object_name(kernel, types_of(arguments))
    code = object_files.load(name)
    assert code is not None
    return name, code


@pytest.fixture(scope="module")
def waves() -> tuple[str, bytes]:
    return object_of(set_waves, VALUES, np.empty_like(VALUES))


def test_llvm_is_not_loaded_if_kernels_are_stored() -> None:
    for _ in range(2):  # the first one may compile some
        ran = subprocess.run([sys.executable, "-c", RENDER], capture_output=True, text=True, check=True)
    assert ran.stdout == "[]\n"


def test_both_linkers_give_the_same_results(
    waves: tuple[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert link(*waves) not in (link(*waves), 0)
    own, others = np.empty_like(VALUES), np.empty_like(VALUES)
    set_waves(VALUES, own)
    np.testing.assert_allclose(own, np.sin(VALUES) * 0.125 + 3.5, rtol=1e-15)

    def refuse(*_: object) -> int:
        raise LinkError

    monkeypatch.setattr(library, "link", refuse)
    library.entry(set_waves, types_of((VALUES, others)))((VALUES, others))
    assert np.array_equal(own, others)


def test_what_else_an_object_file_may_have_is_left_to_llvm(waves: tuple[str, bytes]) -> None:
    name, code = waves
    for other in (b"", code[1:], code[:18] + (183).to_bytes(2, "little") + code[20:]):
        with pytest.raises(LinkError, match="another processor"):
            link(name, other)
    [table, *_] = [each for each in _sections(code) if each.type == RELOCATIONS_ID]
    offset, _, symbol, addend = RELOCATION.unpack_from(code, table.offset)
    relative = bytearray(code)
    RELOCATION.pack_into(relative, table.offset, offset, 2, symbol, addend)
    with pytest.raises(LinkError, match="relative"):
        link(name, bytes(relative))
    with pytest.raises(LinkError, match="needs nomset"):
        link(name, code.replace(b"memset", b"nomset"))


def test_the_processor_is_described_by_what_it_can_do(tmp_path: Path) -> None:
    """Code for another one is compiled again; without a full description LLVM is asked."""
    (tmp_path / "proc").mkdir()
    file = tmp_path / "proc/cpuinfo"
    assert described_processor(tmp_path) is None
    lines = [f"{name}\t: {name} of it" for name in LINES]
    file.write_text("\n".join(["processor\t: 0", *lines, "", *lines[::-1]]), encoding="ascii")
    assert described_processor(tmp_path) == tuple(f"{name} of it" for name in LINES)
    file.write_text("\n".join(lines[:-1]), encoding="ascii")
    assert described_processor(tmp_path) is None
