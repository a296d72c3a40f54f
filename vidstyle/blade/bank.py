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
from vidstyle.blade.bins import FEATURE_RANGES, Bins, Feature
from vidstyle.blade.symmetry import pair_weights
from vidstyle.core.file_checks import read_regular_file
from vidstyle.media.write.atomic import atomic_file

FORMAT_VERSION = 1
"""Version of the file format of banks without constants."""
AFFINE_FORMAT_VERSION = 2
"""Version of the file format of banks with constants, which readers of version 1 would leave out."""
FILTER_SIZES = range(3, 16, 2)
"""The allowed filter sizes in pixels."""
MAX_BYTES = 64 << 20
"""Maximum size of a file, both compressed and decompressed."""
MAX_ENTRIES = 64
"""Maximum number of entries in the archive: a directory of a million entries takes half a minute to read."""
MAX_ABOUT = 4 << 20
"""Maximum length of the description of a bank, in bytes."""
MAX_FILTERS = 1024
"""Maximum number of filters in a part: their numbers are stored in 16-bit textures."""
MAX_RHO = 8
"""Maximum standard deviation of the tensor's window, in pixels: shaders hold 16 of its weights."""
MAX_SLIDERS = 3
"""Maximum number of weights that a bank declares as sliders."""
MAX_FEATURES = 2
"""Maximum number of additional features by which a bank's filters are selected."""
MAX_WEIGHT = 1024.0
"""Maximum weight of a pixel; weights of trained banks are below 1."""
REQUIRED_ARRAYS = {"format", "filters", "bins", "ranges", "rho", "about"}
OPTIONAL_ARRAYS = {"chroma", "constants"}
"""Names of the optional arrays: filters for chroma, and constants."""
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


@dataclass(frozen=True)
class Bank:
    """Learned filters, and the quantization of the features by which they are selected.

    Attributes:
        bins: quantization of the structure tensor's features; each bin has one filter per part.
        rho: standard deviation of the structure tensor's window, in pixels.
        filters: parts x bins x size x size float32. The result is the weighted sum of the parts; a
            block sets the weights.
        chroma: filters of the same shape for the two chroma planes; None if these stay unchanged.
        constants: parts x bins x planes float32, added to the results of the filters of luma, or of luma and
            both chroma planes. None for a bank in which all filters of a part have the same sum, so that flat
            areas stay flat, and filters are symmetric about the middle or bins depend on curvature.
        scale: working size relative to the picture, 0..1.
        about: a record of the training, as plain data: "imitates" (the reference filter), "parts" (names),
            "pictures" (names and checksums), "samples" and "residuals" (in levels of 255) of each filter,
            "sliders" and others.
    """

    bins: Bins
    rho: float
    filters: np.ndarray
    about: dict[str, Any] = field(default_factory=dict)
    chroma: np.ndarray | None = None
    constants: np.ndarray | None = None
    scale: float = 1

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
            ValueError: it has no filters for chroma.
        """
        if self.chroma is None:
            raise ValueError("has no filters for chroma")
        constants = None if self.constants is None else self.constants[..., 1:]
        return replace(self, filters=self.chroma, chroma=None, constants=constants)

    @cached_property
    def packed(self) -> tuple[np.ndarray, ...]:
        """The weights of pairs of opposite pixels, one bins x texels x 4 float32 array per part.

        The weights of sums come first, then the weights of differences if bins depend on curvature or the
        bank has constants. Then a bank with constants has the sum of the filter and its constants for one or
        two planes.
        """
        has_differences = self.bins.curvatures > 1 or self.constants is not None
        weights = pair_weights(self.filters, has_differences)
        if self.constants is not None:
            lines = np.zeros((*weights.shape[:2], 4))
            lines[..., 0] = self.filters.sum(axis=(2, 3), dtype=np.float64)
            planes = min(self.constants.shape[2], 2)
            lines[..., 1 : 1 + planes] = self.constants[..., :planes]
            weights = np.concatenate([weights, lines], axis=2)
        return tuple(weights.astype(np.float32).reshape(*weights.shape[:2], -1, 4))

    @cached_property
    def packed_in_half(self) -> tuple[np.ndarray, ...]:
        """`packed` as half floats; the error is at most 1/4096 of a weight."""
        return tuple(part.astype(np.float16) for part in self.packed)

    @property
    def sliders(self) -> dict[str, tuple[float, float]]:
        """Names and ranges of the weights of the parts after the first, as declared by the bank."""
        return {name: (low, high) for name, low, high in self.about.get("sliders", [])}

    def weights_at(self, shares: Sequence[float]) -> tuple[float, ...]:
        """Return the weights of the parts with each slider at a share of its range; 1 for the first part.

        Parts without a slider have weight 0.
        """
        ends = zip(shares, self.sliders.values(), strict=False)
        found = [1.0, *(low + share * (high - low) for share, (low, high) in ends)]
        return (*found, *[0.0] * (len(self.filters) - len(found)))

    @property
    def sums(self) -> tuple[float, ...]:
        """The response of each part to a constant 1, its mean; 0 if each filter has its own sum."""
        if self.constants is not None:
            return (0.0,) * len(self.filters)
        return tuple(float(part.sum(axis=(1, 2)).mean()) for part in self.filters)

    def combined(self, weights: tuple[float, ...]) -> np.ndarray:
        """Return the weighted sum of the parts: bins x size x size float32.

        Raises:
            ValueError: the numbers of weights and parts differ.
        """
        if len(weights) != len(self.filters):
            raise ValueError(f"has {len(self.filters)} parts, not {len(weights)}")
        return np.tensordot(np.asarray(weights, np.float32), self.filters, 1)

    def combined_constants(self, weights: tuple[float, ...]) -> np.ndarray | None:
        """Return the weighted sum of the parts' constants: bins x planes float32; None without constants."""
        return (
            None if self.constants is None else np.tensordot(np.array(weights, np.float32), self.constants, 1)
        )


def save_bank(bank: Bank, path: str | Path) -> None:
    """Write a bank atomically. Equal banks produce equal bytes.

    Raises:
        OutputError: the file cannot be written.
    """
    arrays = {
        "format": np.int32(FORMAT_VERSION if bank.constants is None else AFFINE_FORMAT_VERSION),
        "filters": bank.filters,
        "bins": np.array(bank.bins.counts[:3], np.int32),
        "ranges": np.array([bank.bins.strength_range, bank.bins.coherence_range]),
        "rho": np.float64(bank.rho),
        "about": np.frombuffer(json.dumps(_described(bank), sort_keys=True).encode(), np.uint8),
    }
    arrays |= {name: array for name in sorted(OPTIONAL_ARRAYS) if (array := getattr(bank, name)) is not None}
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            # A fixed date, so that equal banks produce equal bytes.
            with archive.open(zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0)), "w") as stream:
                np.lib.format.write_array(stream, np.asarray(array), allow_pickle=False)
    with atomic_file(Path(path), overwrite=True) as write:
        write(content.getvalue())


def _described(bank: Bank) -> dict[str, Any]:
    """Return the description of a bank for its file."""
    features = [[each.name, each.bins, each.rho, *each.range] for each in bank.bins.features]
    others: dict[str, Any] = {"features": features} if features else {}
    others |= {
        key: getattr(bank.bins, name) for key, name in BINS_ATTRIBUTES.items() if getattr(bank.bins, name) > 1
    }
    others |= {"scale": bank.scale} if bank.scale != 1 else {}
    return bank.about | others


def load_bank(path: str | Path) -> Bank:
    """Read and check a bank.

    Raises:
        ValueError: the file is not a valid bank.
        OSError: the file cannot be read.
    """
    content = read_regular_file(Path(path), MAX_BYTES)
    try:
        arrays = _arrays_from_npz(content)
    except (ValueError, *_DAMAGE_ERRORS) as error:
        raise ValueError(f"is not a bank: {error}") from None
    return _bank_from_arrays(arrays)


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
        wanted = REQUIRED_ARRAYS.union(name for name in OPTIONAL_ARRAYS if f"{name}.npy" in names)
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
    return replace(bank, filters=bank.filters[first:last])


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
    version = AFFINE_FORMAT_VERSION if "constants" in arrays else FORMAT_VERSION
    if arrays["format"] != version:
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
    scale, optional = described.pop("scale", 1), {name: arrays.get(name) for name in OPTIONAL_ARRAYS}
    return Bank(bins, float(arrays["rho"]), arrays["filters"], described, scale=scale, **optional)


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


def _problem(bank: Bank) -> str:
    """Return the defect of a bank, or an empty text."""
    bins, filters = bank.bins, bank.filters
    if not isinstance(bins.curvatures, int) or min(bins.counts) < 1 or bins.orientations % 2:
        return f"has bins {' x '.join(map(str, bins.counts))}; the number of orientations must be even"
    divided = bins.features or bins.curvatures > 1 or bank.constants is not None
    if not isinstance(bins.pitch, int) or bins.pitch not in (1, 2) or (bins.pitch > 1 and divided):
        allowed = "1 or, without features or constants, 2"
        return f"shares filters in squares of {bins.pitch} pixels; allowed are {allowed}"
    if type(bank.scale) not in (int, float) or not 0 < bank.scale <= 1:
        return f"has a scale of {bank.scale!r}, which is not above 0 and at most 1"
    ends = (*bins.strength_range, *bins.coherence_range)
    if not (ends[0] < ends[1] and ends[2] < ends[3] and 0 < bank.rho <= MAX_RHO and bins.is_finite):
        return "has an empty range of bins, or a window of an invalid size"
    if filters.dtype != np.float32 or filters.ndim != 4 or filters.shape[2] != filters.shape[3]:
        return (
            f"has filters of shape {filters.shape} and type {filters.dtype}, not parts x bins x size x size"
        )
    if filters.shape[2] not in FILTER_SIZES or not 1 <= len(filters) <= 8:
        return f"has {len(filters)} parts of {filters.shape[2]} x {filters.shape[2]} pixels"
    if filters.shape[1] != bins.count or bins.count > MAX_FILTERS:
        return f"has {filters.shape[1]} filters for {bins.count} bins; there are at most {MAX_FILTERS}"
    if not _are_sliders(bank.about.get("sliders", []), len(filters) - 1):
        return "declares sliders that are not [name, low, high] of a part after the first"
    if bank.chroma is not None and (bank.chroma.shape, bank.chroma.dtype) != (filters.shape, filters.dtype):
        return f"has filters for chroma of shape {bank.chroma.shape}, for luma of {filters.shape}"
    constants = bank.constants
    if constants is not None and (
        constants.dtype != np.float32
        or constants.shape[:-1] != filters.shape[:2]
        or constants.shape[-1] not in ((1, 2) if bank.chroma is None else (3,))
    ):
        return f"has constants of shape {constants.shape}, not parts x bins x planes"
    numbers = [each for each in (filters, bank.chroma, constants) if each is not None]
    wrong = sum(each.size - np.count_nonzero(np.abs(each) <= MAX_WEIGHT) for each in numbers)
    return f"has {wrong} weights that are NaN or beyond {MAX_WEIGHT:g}" if wrong else ""


def _are_sliders(declared: object, most: int) -> bool:
    """Whether sliders are declared as `Bank.sliders` expects, with valid weights of a filter."""
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
