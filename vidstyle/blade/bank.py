"""A bank of learned filters, and its file format."""

from __future__ import annotations

import json
import re
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.assets import asset_folder
from vidstyle.blade.bins import FEATURES, Bins, Feature
from vidstyle.blade.symmetry import pair_weights
from vidstyle.core.file_checks import read_regular_file
from vidstyle.media.write.atomic import atomic_file

FORMAT = 1
"""Version of the file format."""
SIZES = range(3, 16, 2)
"""The allowed filter sizes in pixels."""
MAX_BYTES = 64 << 20
"""The largest size of a file that is read, packed and unpacked."""
MAX_ENTRIES = 64
"""The most entries of the archive: a directory of a million takes half a minute."""
MAX_ABOUT = 4 << 20
"""The longest description of a bank, in bytes."""
MAX_FILTERS = 1024
"""The most filters of a part: their numbers are kept in textures of 16 bits."""
MAX_RHO = 8
"""The largest standard deviation of the tensor's window, in pixels: shaders hold 16 of its weights."""
MAX_SLIDERS = 3
"""The most weights that a bank declares as sliders."""
MAX_FEATURES = 2
"""The most further features by which a bank's filters are chosen."""
MAX_WEIGHT = 1024.0
"""The largest weight of a pixel; those of trained banks are below 1."""
ARRAYS = {"format", "filters", "bins", "ranges", "rho", "about"}
CHROMA = "chroma"
"""The array of filters for chroma, which a bank may have."""
SHAPE = ("curvatures", "step")
"""What the description of a bank says of its bins if it is not 1."""
_NPY_HEADER = re.compile(
    rb"\x93NUMPY\x01\x00..\{'descr': '(<[fi][48]|\|u1)', 'fortran_order': (True|False), "
    rb"'shape': \(((?:\d{1,9}, ?)*(?:\d{1,9})?)\), \} *\n",
    re.DOTALL,
)
"""What NumPy writes in front of an array; see `numpy.lib.format`."""
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    OSError,
    UnicodeError,
)
"""What `zipfile` raises for archives that are damaged, or written in unusual ways."""


@dataclass(frozen=True)
class Bank:
    """Learned filters, with the quantization of the features by which they are selected.

    Attributes:
        bins: quantization of the structure tensor's features; there is a filter for each bin.
        rho: standard deviation of the structure tensor's window, in pixels.
        filters: parts x bins x size x size float32. The result is the weighted sum of the parts; a
            block sets the weights.
        chroma: of the same shape, for the two chroma planes; None if they stay as they are.
        about: how it was trained, as plain data: "imitates" (the reference filter), "parts" (names),
            "pictures" (names and checksums), "samples" and "residuals" (in levels of 255) of each filter,
            "sliders" and others.
    """

    bins: Bins
    rho: float
    filters: np.ndarray
    about: dict[str, Any] = field(default_factory=dict)
    chroma: np.ndarray | None = None

    def __post_init__(self) -> None:
        problem = _problem(self)
        if problem:
            raise ValueError(problem)

    @property
    def size(self) -> int:
        """Rows and columns of a filter."""
        return int(self.filters.shape[2])

    @cached_property
    def of_chroma(self) -> Bank:
        """The bank that filters the chroma planes.

        Raises:
            ValueError: it leaves them as they are.
        """
        if self.chroma is None:
            raise ValueError("has no filters for chroma")
        return replace(self, filters=self.chroma, chroma=None)

    @cached_property
    def packed(self) -> tuple[np.ndarray, ...]:
        """The weights of pairs of opposite pixels, a bins x texels x 4 float32 array for each part.

        First those of sums, then, if bins tell curvatures, those of differences; each a multiple of four.
        """
        weights = pair_weights(self.filters, self.bins).astype(np.float32)
        return tuple(weights.reshape(*weights.shape[:2], -1, 4))

    @cached_property
    def packed_in_half(self) -> tuple[np.ndarray, ...]:
        """`packed` as half floats; the error is at most 1/4096 of a weight."""
        return tuple(part.astype(np.float16) for part in self.packed)

    @property
    def sliders(self) -> dict[str, tuple[float, float]]:
        """The names and ranges of the weights of the parts after the first, as the bank declares them."""
        return {name: (low, high) for name, low, high in self.about.get("sliders", [])}

    def weights_at(self, shares: Sequence[float]) -> tuple[float, ...]:
        """The weights of the parts with each slider at this share of its range; 1 for the first part.

        Parts without a slider have no weight.
        """
        ends = zip(shares, self.sliders.values(), strict=False)
        found = [1.0, *(low + share * (high - low) for share, (low, high) in ends)]
        return (*found, *[0.0] * (len(self.filters) - len(found)))

    @property
    def sums(self) -> tuple[float, ...]:
        """For each part, the mean response to a constant 1."""
        return tuple(float(part.sum(axis=(1, 2)).mean()) for part in self.filters)

    def combined(self, weights: tuple[float, ...]) -> np.ndarray:
        """The sum of the parts with these weights: bins x size x size float32.

        Raises:
            ValueError: another number of weights than of parts.
        """
        if len(weights) != len(self.filters):
            raise ValueError(f"has {len(self.filters)} parts, not {len(weights)}")
        return np.tensordot(np.asarray(weights, np.float32), self.filters, 1)


def save_bank(bank: Bank, path: str | Path) -> None:
    """Write a bank atomically. Equal banks give equal bytes.

    Raises:
        OutputError: it cannot be written.
    """
    arrays = {
        "format": np.int32(FORMAT),
        "filters": bank.filters,
        "bins": np.array(bank.bins.counts[:3], np.int32),
        "ranges": np.array([bank.bins.strength_range, bank.bins.coherence_range]),
        "rho": np.float64(bank.rho),
        "about": np.frombuffer(json.dumps(_described(bank), sort_keys=True).encode(), np.uint8),
    }
    if bank.chroma is not None:
        arrays[CHROMA] = bank.chroma
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            # A fixed date: equal banks give equal bytes.
            with archive.open(zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0)), "w") as stream:
                np.lib.format.write_array(stream, np.asarray(array), allow_pickle=False)
    with atomic_file(Path(path), overwrite=True) as write:
        write(content.getvalue())


def _described(bank: Bank) -> dict[str, Any]:
    """What a file tells of a bank beside its arrays."""
    features = [[each.name, each.bins, each.rho, *each.range] for each in bank.bins.features]
    others: dict[str, Any] = {"features": features} if features else {}
    others |= {name: getattr(bank.bins, name) for name in SHAPE if getattr(bank.bins, name) > 1}
    return bank.about | others


def load_bank(path: str | Path) -> Bank:
    """Read a bank and check it.

    Raises:
        ValueError: it is not a valid bank.
        OSError: it cannot be read.
    """
    content = read_regular_file(Path(path), MAX_BYTES)
    try:
        arrays = _arrays_from_npz(content)
    except (ValueError, *_DAMAGED) as error:
        raise ValueError(f"is no bank: {error}") from None
    return _bank_from_arrays(arrays)


def _arrays_from_npz(content: bytes) -> dict[str, np.ndarray]:
    if content.count(b"PK\1\2") > MAX_ENTRIES:
        raise ValueError(f"it holds more than {MAX_ENTRIES} files")
    with zipfile.ZipFile(BytesIO(content)) as archive:
        entries = archive.infolist()
        if sum(entry.file_size for entry in entries) > MAX_BYTES:
            raise ValueError(f"it unpacks to more than {MAX_BYTES >> 20} MiB")
        if any(entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for entry in entries):
            raise ValueError("it is packed in another way than NumPy does")
        if missing := {f"{name}.npy" for name in ARRAYS}.difference(entry.filename for entry in entries):
            raise ValueError(f"{', '.join(sorted(missing))} missing")
        names = ARRAYS.union([CHROMA] if f"{CHROMA}.npy" in archive.namelist() else [])
        return {name: _array_from_npy(archive.read(f"{name}.npy")) for name in names}


def _array_from_npy(content: bytes) -> np.ndarray:
    """The array in a .npy file, read without evaluating its header as Python; ValueError if it is none."""
    header = _NPY_HEADER.match(content)
    if header is None:
        raise ValueError("it holds an array of another kind")
    kind, by_columns, sides = header.groups()
    shape = [int(side) for side in sides.split(b",") if side.strip()]
    numbers = np.frombuffer(content, kind.decode(), offset=header.end())
    return np.array(numbers.reshape(shape, order="F" if by_columns == b"True" else "C"), order="C")


@cache
def shipped_bank(name: str) -> Bank:
    """A bank in filters_bank/, by name."""
    return load_bank(shipped_banks()[name])


@cache
def shipped_parts(name: str, first: int, last: int) -> Bank:
    """The parts first..last - 1 of a bank in filters_bank/: others cost time even with weights of 0."""
    bank = shipped_bank(name)
    return replace(bank, filters=bank.filters[first:last])


def shipped_banks() -> dict[str, Path]:
    """The files in filters_bank/ by name."""
    return {path.stem: path for path in sorted(asset_folder("filters_bank").glob("*.npz"))}


def _bank_from_arrays(arrays: dict[str, np.ndarray]) -> Bank:
    kinds = {"format": ((), "i"), "bins": ((3,), "i"), "ranges": ((2, 2), "f"), "rho": ((), "f")}
    about = arrays["about"]
    if (
        any((arrays[name].shape, arrays[name].dtype.kind) != kind for name, kind in kinds.items())
        or about.dtype != np.uint8
        or about.size > MAX_ABOUT
    ):
        raise ValueError("is no bank: its arrays have wrong types or shapes")
    if arrays["format"] != FORMAT:
        raise ValueError(f"has format {arrays['format']}; this version reads format {FORMAT}")
    try:
        described = json.loads(about.tobytes().decode())
    except (ValueError, RecursionError):
        raise ValueError("is no bank: its description cannot be read") from None
    described = described if isinstance(described, dict) else {}
    of_strength, of_coherence = ((float(low), float(high)) for low, high in arrays["ranges"])
    orientations, strengths, coherences = map(int, arrays["bins"])
    features = _features(described.pop("features", []))
    shape = {name: described.pop(name, 1) for name in SHAPE}
    bins = Bins(orientations, strengths, coherences, of_strength, of_coherence, features=features, **shape)
    return Bank(bins, float(arrays["rho"]), arrays["filters"], described, arrays.get(CHROMA))


def _features(declared: object) -> tuple[Feature, ...]:
    """The further features of the choice, as `save_bank` writes them; ValueError if they are none."""
    if not isinstance(declared, list) or len(declared) > MAX_FEATURES:
        raise ValueError(f"declares features that are no list of at most {MAX_FEATURES}")
    return tuple(map(_feature, declared))


def _feature(declared: object) -> Feature:
    match declared:
        case [str(name), int(bins), int() | float() as rho, int() | float() as low, int() | float() as high]:
            if name in FEATURES and 1 <= bins <= MAX_FILTERS and 0 < rho <= MAX_RHO and low < high:
                return Feature(name, bins, rho, (low, high))
    raise ValueError(
        f"declares a feature that is not [name, bins, rho, low, high] with a name of {', '.join(FEATURES)}"
    )


def _problem(bank: Bank) -> str:
    """What is wrong with a bank, or nothing."""
    bins, filters = bank.bins, bank.filters
    if not isinstance(bins.curvatures, int) or min(bins.counts) < 1 or bins.orientations % 2:
        return f"has bins {' x '.join(map(str, bins.counts))}; orientations are even"
    divided = bins.features or bins.curvatures > 1
    if not isinstance(bins.step, int) or bins.step not in (1, 2) or (bins.step > 1 and divided):
        return f"shares filters among squares of {bins.step} pixels; of 1 or, without features, 2"
    ends = (*bins.strength_range, *bins.coherence_range)
    if not (ends[0] < ends[1] and ends[2] < ends[3] and 0 < bank.rho <= MAX_RHO and bins.is_finite):
        return "has an empty range of bins, or a window of an invalid size"
    if filters.dtype != np.float32 or filters.ndim != 4 or filters.shape[2] != filters.shape[3]:
        return (
            f"has filters of shape {filters.shape} and type {filters.dtype}, not parts x bins x size x size"
        )
    if filters.shape[2] not in SIZES or not 1 <= len(filters) <= 8:
        return f"has {len(filters)} parts of {filters.shape[2]} x {filters.shape[2]} pixels"
    if filters.shape[1] != bins.count or bins.count > MAX_FILTERS:
        return f"has {filters.shape[1]} filters for {bins.count} bins; there are at most {MAX_FILTERS}"
    if not _are_sliders(bank.about.get("sliders", []), len(filters) - 1):
        return "declares sliders that are not [name, low, high] of a part after the first"
    if bank.chroma is not None and (bank.chroma.shape, bank.chroma.dtype) != (filters.shape, filters.dtype):
        return f"has filters for chroma of shape {bank.chroma.shape}, for luma of {filters.shape}"
    planes = filters if bank.chroma is None else np.stack([filters, bank.chroma])
    wrong = planes.size - np.count_nonzero(np.abs(planes) <= MAX_WEIGHT)
    return f"has {wrong} weights that are NaN or beyond {MAX_WEIGHT:g}" if wrong else ""


def _are_sliders(declared: object, most: int) -> bool:
    """Whether sliders are declared as `Bank.sliders` reads them, with weights that a filter may have."""
    return (
        isinstance(declared, list)
        and len(declared) <= min(most, MAX_SLIDERS)
        and all(
            isinstance(each, list)
            and len(each) == 3
            and isinstance(each[0], str)
            and all(type(end) in (int, float) and abs(end) <= MAX_WEIGHT for end in each[1:])
            for each in declared
        )
        and len({each[0] for each in declared}) == len(declared)
    )
