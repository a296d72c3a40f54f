"""Banks of learned filters, networks and models of people, with odd numbers and shapes or damaged bytes."""

from __future__ import annotations

import io
import zipfile
from random import Random
from typing import Any

import numpy as np
from face_network import red_people, remembering_people
from onnx_model import convolution, layered, negative

from tools.fuzzing.arrays import array_bytes, make_odd_array
from tools.fuzzing.damage import ODD_FLOATS, ODD_NUMBERS, damage, random_slice
from vidstyle.blade.bank_file import shipped_banks
from vidstyle.regions.chosen_files import people_model

MODEL_SIZES = 0, 1, 31, 32, 144, 256, 4097, 2**31, 2**63
"""Sizes that models declare."""
PORT_NAMES = "r1i", "r1o", "r2i", "state_in", "state_out", "src", "pha", "", "i", "o" * 300, "past", "present"
"""Names of inputs and outputs; some form pairs."""


def bank_case(random: Random) -> tuple[str, bytes]:
    """Return a bank with odd numbers, odd arrays, damaged entries or a damaged archive."""
    with np.load(shipped_banks()["etf"]) as whole:
        entries = dict(whole)
    entries["filters"] *= np.float32(random.choice((1, 1, 10, 1e4, 1e30)))
    fault = random.choice(("weights", "numbers", "numbers", "array", "entry", "archive", "bomb"))
    name = random.choice(list(entries))
    if fault == "weights":
        part = random_slice(random, entries["filters"].size)
        entries["filters"].reshape(-1)[part] = random.choice((0, -1e9, 1e9, 3e38))
    if fault == "numbers":
        entries[name] = _with_odd_numbers(random, entries[name])
    if fault == "array":
        entries[name] = make_odd_array(
            random, tuple(random.choice((0, 1, 3, 24)) for _ in range(random.randint(0, 5)))
        )
    contents = {name: array_bytes(array) for name, array in entries.items()}
    if fault == "entry":
        contents[name] = damage(random, contents[name])
    if fault == "bomb":
        shape = random.choice(
            ("(99999999999,)", "(1,) * 9", "((" * 40, "[" * 3000, "(300000000, 1)", "(-1, 5)")
        )
        header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}}}\n".encode()
        contents[name] = (
            b"\x93NUMPY\1\0"
            + len(header).to_bytes(2, "little")
            + header
            + bytes(random.choice((0, 50 << 20)))
        )
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", random.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as file:
        for name, content in contents.items():
            # A fixed date makes the bytes of a case reproducible.
            file.writestr(zipfile.ZipInfo(f"{name}.npy"), content, file.compression)
    content = archive.getvalue()
    return ".npz", damage(random, content) if fault == "archive" else content


def network_case(random: Random) -> tuple[str, bytes]:
    """Return a network with odd weights, an odd shape or damaged bytes."""
    kind = random.choice(("bytes", "bytes", "bytes", "weights", "shape", "padding"))
    if kind == "bytes":
        return ".onnx", damage(random, random.choice((negative(), layered(4, 2))))
    kernel = np.eye(3, dtype=np.float32).reshape(3, 3, 1, 1)
    sides = (0, 1, 31, 32, 64, 4096, 4097, 2**31, 2**63, 2**64 - 1, "width")
    shape: tuple[int | str, ...] = (1, 3, "height", "width")
    if kind == "weights":
        kernel = _with_odd_numbers(random, kernel)
    if kind == "shape":
        shape = tuple(random.choice((1, 3, *sides)) for _ in range(random.choice((0, 3, 4, 4, 4, 400))))
    padding = random.choice((1, 5, 2**31, 2**63 - 1)) if kind == "padding" else None
    return ".onnx", convolution(kernel, [0.0] * 3, shape, padding)


def people_case(random: Random) -> tuple[str, bytes]:
    """Return a model with or without a state, or the installed model; two thirds have damaged bytes."""
    installed = people_model()
    if installed is not None and random.random() < 0.3:
        return ".people.tflite", damage(random, installed.read_bytes())
    model = red_people() if random.random() < 0.3 else remembering_people(**_odd_state(random))
    return ".people.onnx", damage(random, model) if random.random() < 0.6 else model


def _odd_state(random: Random) -> dict[str, Any]:
    """Return arguments of `remembering_people`, some of them odd."""
    odd: dict[str, Any] = {
        "state": (random.choice(PORT_NAMES), random.choice(PORT_NAMES)),
        "result": random.choice(PORT_NAMES),
        "size": (random.choice(MODEL_SIZES[1:6]), random.choice(MODEL_SIZES[1:6])),
        "state_shape": [random.choice(MODEL_SIZES) for _ in range(random.choice((0, 1, 4, 4, 5)))],
    }
    return {name: value for name, value in odd.items() if random.random() < 0.4}


def _with_odd_numbers(random: Random, array: np.ndarray) -> np.ndarray:
    flat = array.reshape(-1)
    for _ in range(random.choice((1, 5))):
        number = random.choice(ODD_FLOATS if array.dtype.kind == "f" else ODD_NUMBERS)
        with np.errstate(all="ignore"):
            flat[random.randrange(len(flat))] = np.asarray(number).astype(array.dtype)
    return array
