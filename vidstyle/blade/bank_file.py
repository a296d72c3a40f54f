"""The file format of banks: NumPy's .npz archive, read without evaluating its headers."""

from __future__ import annotations

import json
import re
import zipfile
import zlib
from collections.abc import Container
from dataclasses import replace
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.assets import asset_folder
from vidstyle.blade.bank import MAX_FEATURES, MAX_FILTERS, MAX_RHO, Bank
from vidstyle.blade.bins import FEATURE_RANGES, Bins, Feature
from vidstyle.core.file_checks import read_regular_file
from vidstyle.media.write.atomic import atomic_file

FORMAT_VERSION = 1
"""Version of the file format of banks without constants."""
AFFINE_FORMAT_VERSION = 2
"""Version of the file format of banks with constants, which readers of version 1 would leave out."""
CLIPPED_FORMAT_VERSION = 3
"""Version of the file format of banks with clipped differences or two stages, new to earlier readers."""
MATRIX_FORMAT_VERSION = 4
"""Version of the file format of banks with a colour matrix."""
STEP_FORMAT_VERSION = 5
"""Version of the file format of banks with a tone curve through percentiles or a local mode."""
MAX_BYTES = 64 << 20
"""Maximum size of a file, both compressed and decompressed."""
MAX_ENTRIES = 64
"""Maximum number of entries in the archive: a directory of a million entries takes half a minute to read."""
MAX_ABOUT = 4 << 20
"""Maximum length of the description of a bank, in bytes."""
REQUIRED_ARRAYS = {"format", "filters", "bins", "ranges", "rho", "about"}
OPTIONAL_ARRAYS = {"chroma", "constants", "clipped", "matrix", "curve", "mode"}
"""Names of the optional arrays: filters for chroma, constants, weights of clipped differences, and the steps
before the filters."""
SECOND_STAGE = "next"
"""Name of the optional array that holds the file of the bank of the second stage."""
BINS_ATTRIBUTES = {"curvatures": "curvatures", "step": "pitch"}
"""Keys in the description of a bank and the attributes of `Bins` that they hold if these are not 1."""
_NPY_HEADER = re.compile(
    rb"\x93NUMPY\x01\x00..\{'descr': '(<[fi][48]|\|u1)', 'fortran_order': (True|False), "
    rb"'shape': \(((?:\d{1,9}, ?)*(?:\d{1,9})?)\), \} *\n",
    re.DOTALL,
)
"""The header that NumPy writes before an array; see `numpy.lib.format`."""
_DAMAGE_ERRORS = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    OSError,
    UnicodeError,
)
"""Exceptions that `zipfile` raises for damaged or unusual archives."""


def save_bank(bank: Bank, path: str | Path) -> None:
    """Write a bank atomically. Equal banks produce equal bytes.

    Raises:
        OutputError: the file cannot be written.
    """
    with atomic_file(Path(path), overwrite=True) as write:
        write(_as_npz(bank))


def _as_npz(bank: Bank) -> bytes:
    """Return the content of the file of a bank."""
    optional = {name: array for name in sorted(OPTIONAL_ARRAYS) if (array := getattr(bank, name)) is not None}
    if bank.next is not None:
        optional[SECOND_STAGE] = np.frombuffer(_as_npz(bank.next), np.uint8)
    arrays = {
        "format": np.int32(_format_version(optional)),
        "filters": bank.filters,
        "bins": np.array(bank.bins.counts[:3], np.int32),
        "ranges": np.array([bank.bins.strength_range, bank.bins.coherence_range]),
        "rho": np.float64(bank.rho),
        "about": np.frombuffer(json.dumps(_described(bank), sort_keys=True).encode(), np.uint8),
    }
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in (arrays | optional).items():
            # A fixed date, so that equal banks produce equal bytes.
            with archive.open(zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0)), "w") as stream:
                np.lib.format.write_array(stream, np.asarray(array), allow_pickle=False)
    return content.getvalue()


def _format_version(arrays: Container[str]) -> int:
    """Return the lowest version of the file format that can hold a bank with these arrays."""
    if "curve" in arrays or "mode" in arrays:
        return STEP_FORMAT_VERSION
    if "matrix" in arrays:
        return MATRIX_FORMAT_VERSION
    if "clipped" in arrays or SECOND_STAGE in arrays:
        return CLIPPED_FORMAT_VERSION
    return AFFINE_FORMAT_VERSION if "constants" in arrays else FORMAT_VERSION


def _described(bank: Bank) -> dict[str, Any]:
    """Return the description of a bank for its file."""
    features = [[each.name, each.bins, each.rho, *each.range] for each in bank.bins.features]
    others: dict[str, Any] = {"features": features} if features else {}
    others |= {
        key: getattr(bank.bins, name) for key, name in BINS_ATTRIBUTES.items() if getattr(bank.bins, name) > 1
    }
    others |= {"scale": bank.scale} if bank.scale != 1 else {}
    others |= {"clips": list(bank.clips)} if bank.clips else {}
    return bank.about | others


def load_bank(path: str | Path) -> Bank:
    """Read and check a bank.

    Raises:
        ValueError: the file is not a valid bank.
        OSError: the file cannot be read.
    """
    return _bank_from_npz(read_regular_file(Path(path), MAX_BYTES))


def _bank_from_npz(content: bytes, is_second: bool = False) -> Bank:
    try:
        arrays = _arrays_from_npz(content)
    except (ValueError, *_DAMAGE_ERRORS) as error:
        raise ValueError(f"is not a bank: {error}") from None
    second = arrays.get(SECOND_STAGE)
    if second is not None and (is_second or second.dtype != np.uint8 or second.ndim != 1):
        raise ValueError("is not a bank: its second stage is not a bank of one stage")
    bank = _bank_from_arrays(arrays)
    return bank if second is None else replace(bank, next=_bank_from_npz(second.tobytes(), is_second=True))


def _arrays_from_npz(content: bytes) -> dict[str, np.ndarray]:
    if content.count(b"PK\1\2") > MAX_ENTRIES:
        raise ValueError(f"it holds more than {MAX_ENTRIES} files")
    with zipfile.ZipFile(BytesIO(content)) as archive:
        entries = archive.infolist()
        if sum(entry.file_size for entry in entries) > MAX_BYTES:
            raise ValueError(f"it unpacks to more than {MAX_BYTES >> 20} MiB")
        if any(entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for entry in entries):
            raise ValueError("it is not compressed as by NumPy")
        if missing := {f"{name}.npy" for name in REQUIRED_ARRAYS}.difference(
            entry.filename for entry in entries
        ):
            raise ValueError(f"{', '.join(sorted(missing))} missing")
        names = {entry.filename for entry in entries}
        optional = OPTIONAL_ARRAYS | {SECOND_STAGE}
        wanted = REQUIRED_ARRAYS.union(name for name in optional if f"{name}.npy" in names)
        return {name: _array_from_npy(archive.read(f"{name}.npy")) for name in wanted}


def _array_from_npy(content: bytes) -> np.ndarray:
    """Return the array in a .npy file, or raise ValueError; its header is not evaluated as Python."""
    header = _NPY_HEADER.match(content)
    if header is None:
        raise ValueError("it holds an array of another kind")
    kind, by_columns, sides = header.groups()
    shape = [int(side) for side in sides.split(b",") if side.strip()]
    numbers = np.frombuffer(content, kind.decode(), offset=header.end())
    return np.array(numbers.reshape(shape, order="F" if by_columns == b"True" else "C"), order="C")


@cache
def shipped_bank(name: str) -> Bank:
    """Return a bank in filters_bank/ by name."""
    return load_bank(shipped_banks()[name])


@cache
def shipped_parts(name: str, first: int, last: int) -> Bank:
    """Return a shipped bank with only its parts first..last - 1: parts with weight 0 cost time."""
    bank = shipped_bank(name)
    clipped = None if bank.clipped is None else bank.clipped[first:last]
    return replace(bank, filters=bank.filters[first:last], clipped=clipped)


def shipped_banks() -> dict[str, Path]:
    """Return the files in filters_bank/ by name."""
    return {path.stem: path for path in sorted(asset_folder("filters_bank").glob("*.npz"))}


def _bank_from_arrays(arrays: dict[str, np.ndarray]) -> Bank:
    kinds = {"format": ((), "i"), "bins": ((3,), "i"), "ranges": ((2, 2), "f"), "rho": ((), "f")}
    about = arrays["about"]
    if (
        any((arrays[name].shape, arrays[name].dtype.kind) != kind for name, kind in kinds.items())
        or about.dtype != np.uint8
        or about.size > MAX_ABOUT
    ):
        raise ValueError("is not a bank: its arrays have wrong types or shapes")
    if arrays["format"] != (version := _format_version(arrays)):
        raise ValueError(f"has format {arrays['format']}; this version reads format {version}")
    try:
        described = json.loads(about.tobytes().decode())
    except (ValueError, RecursionError):
        raise ValueError("is not a bank: its description cannot be read") from None
    described = described if isinstance(described, dict) else {}
    of_strength, of_coherence = ((float(low), float(high)) for low, high in arrays["ranges"])
    orientations, strengths, coherences = map(int, arrays["bins"])
    features = _features(described.pop("features", []))
    shape = {name: described.pop(key, 1) for key, name in BINS_ATTRIBUTES.items()}
    bins = Bins(orientations, strengths, coherences, of_strength, of_coherence, features=features, **shape)
    clips = described.pop("clips", [])
    if not isinstance(clips, list):
        raise ValueError("declares clips that are not a list")
    return Bank(
        bins,
        float(arrays["rho"]),
        arrays["filters"],
        scale=described.pop("scale", 1),
        about=described,
        clips=tuple(clips),
        **{name: arrays.get(name) for name in OPTIONAL_ARRAYS},  # type: ignore[arg-type]
    )


def _features(declared: object) -> tuple[Feature, ...]:
    """Return the additional features as written by `save_bank`, or raise ValueError."""
    if not isinstance(declared, list) or len(declared) > MAX_FEATURES:
        raise ValueError(f"declares features that are not a list of at most {MAX_FEATURES}")
    return tuple(map(_feature, declared))


def _feature(declared: object) -> Feature:
    match declared:
        case [str(name), int(bins), int() | float() as rho, int() | float() as low, int() | float() as high]:
            if name in FEATURE_RANGES and 1 <= bins <= MAX_FILTERS and 0 < rho <= MAX_RHO and low < high:
                return Feature(name, bins, rho, (low, high))
    names = ", ".join(FEATURE_RANGES)
    raise ValueError(f"declares a feature that is not [name, bins, rho, low, high] with a name of {names}")
