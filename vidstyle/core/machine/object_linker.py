"""Links object files into this process without LLVM, which takes 45 MB and 0.05 s to load.

Numba's code holds whole addresses, as for any distance between functions and data; only these are filled in.
LLVM links all other object files: with other relocations, and for other processors and systems.
"""

from __future__ import annotations

import ctypes
import mmap
import struct
import sys
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

HEADER, X86_64 = b"\x7fELF\x02\x01\x01", (62).to_bytes(2, "little")
"""How files for 64 bits, the lowest byte first, begin, and their number of the processor, at byte 18."""
TABLE = struct.Struct("<40xQ10x3H")
"""The place of the section headers, then the size and number of them, and the number of their names."""
SECTION, SYMBOL, RELOCATION = struct.Struct("<2I4Q2I2Q"), struct.Struct("<IBBH2Q"), struct.Struct("<Q2Iq")
SYMBOLS_ID, RELOCATIONS_ID, ZEROS_ID, UNWINDING_ID = 2, 4, 8, 0x70000001
"""Types of sections; the last one is for exceptions, which kernels do not raise."""
WRITABLE_BIT, LOADED_BIT = 1, 2
"""Flags of sections."""
WHOLE_ADDRESS_ID = 1
"""The kind of relocation that is an address of 64 bits."""


class LinkError(Exception):
    """An object file has what only LLVM can link."""


class _Section(NamedTuple):
    name: int
    type: int
    flags: int
    address: int
    offset: int
    size: int
    link: int
    info: int
    alignment: int
    entry_size: int

    def content(self, code: bytes) -> bytes:
        return bytes(self.size) if self.type == ZEROS_ID else code[self.offset : self.offset + self.size]


_linked: list[Any] = []
"""The memory of all machine code, in use until the program ends."""


def link(name: str, code: bytes) -> int:
    """Link an object file, and return the address of its function of this name.

    Raises:
        LinkError: LLVM must do it.
    """
    sections = _sections(code)
    places, size = _places(sections)
    memory = mmap.mmap(-1, max(size, 1))
    base = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    for number, place in places.items():
        memory[place : place + sections[number].size] = sections[number].content(code)
    symbols = [*_symbols(code, sections, {number: base + place for number, place in places.items()})]
    for place, symbol, addend in _relocations(code, sections, places):
        struct.pack_into("<Q", memory, place, _found(symbols[symbol]) + addend)
    _make_executable(base, len(memory))
    _linked.append(memory)
    return _found((name, dict(symbols)[name]))


def _sections(code: bytes) -> list[_Section]:
    if not code.startswith(HEADER) or code[18:20] != X86_64 or sys.platform != "linux":
        raise LinkError("it is for another processor or system")
    start, size, count, _ = TABLE.unpack_from(code)
    return [_Section(*SECTION.unpack_from(code, start + size * number)) for number in range(count)]


def _places(sections: list[_Section]) -> tuple[dict[int, int], int]:
    """Return where each section that is loaded begins in memory, by its number, and the size of all."""
    places, end = dict[int, int](), 0
    for number, each in enumerate(sections):
        if not each.flags & LOADED_BIT or each.type == UNWINDING_ID:
            continue
        if each.flags & WRITABLE_BIT:
            raise LinkError("it has variables")
        places[number] = -(-end // max(each.alignment, 1)) * max(each.alignment, 1)
        end = places[number] + each.size
    return places, end


def _symbols(
    code: bytes, sections: list[_Section], addresses: dict[int, int]
) -> Iterator[tuple[str, int | None]]:
    """Yield names and addresses; the address of a symbol defined elsewhere is None."""
    [table] = [each for each in sections if each.type == SYMBOLS_ID]
    names = sections[table.link].content(code)
    for name, _, _, section, value, _ in SYMBOL.iter_unpack(table.content(code)):
        text = names[name : names.index(b"\0", name)].decode()
        yield text, None if section not in addresses else addresses[section] + value


def _relocations(
    code: bytes, sections: list[_Section], places: dict[int, int]
) -> Iterator[tuple[int, int, int]]:
    """Yield the place in memory, the number of the symbol, and the addend of its address."""
    for each in sections:
        if each.type != RELOCATIONS_ID or each.info not in places:
            continue
        for offset, kind, symbol, addend in RELOCATION.iter_unpack(each.content(code)):
            if kind != WHOLE_ADDRESS_ID:
                raise LinkError("it has relative addresses")
            yield places[each.info] + offset, symbol, addend


def _found(symbol: tuple[str, int | None]) -> int:
    """Return the address of a symbol, in this process if no section has it."""
    name, address = symbol
    return _own_address(name) if address is None else address


@cache
def _own_address(name: str) -> int:
    """Return the address of a function of the C library."""
    try:
        return ctypes.cast(getattr(ctypes.CDLL(None), name), ctypes.c_void_p).value or 0
    except AttributeError as error:
        raise LinkError(f"it needs {name}") from error


def _make_executable(address: int, size: int) -> None:
    mprotect = ctypes.CDLL(None, use_errno=True).mprotect
    mprotect.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
    if mprotect(address, size, mmap.PROT_READ | mmap.PROT_EXEC):
        raise LinkError("the system forbids it")
