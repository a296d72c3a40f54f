"""Strange pictures, random chains of steps and mutated banks, run as a process because failures may crash it.

python tests/support/bounds_sweep.py chains SEED COUNT
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from pictures import noise, run_color, run_luma, step, style

from vidstyle import stylize
from vidstyle.blade.bank import Bank
from vidstyle.blade.bank_file import load_bank, shipped_banks
from vidstyle.blade.inference import BankRun
from vidstyle.block import Choice, Parameter, SavedRef, Slider, Switch
from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError
from vidstyle.style import Step, Style, load_style, style_names

STRANGE_LEVELS = (np.nan, np.inf, -np.inf, 1e30, -1e30, 1e-40, -1e5, 3.0)
"""Values that are possible only in pictures made without `Picture.from_array`."""


def strange_picture(seed: int, *shape: int) -> np.ndarray:
    """Return noise with strange numbers at single pixels and in a corner."""
    random = np.random.default_rng(seed)
    picture = noise(*shape, seed=seed)
    for number in STRANGE_LEVELS:
        picture[random.random(shape) < random.choice([0.001, 0.02, 0.2])] = number
    picture[: shape[0] // 4, : shape[1] // 4] = random.choice(STRANGE_LEVELS)
    return picture


def pictures(seed: int, count: int) -> None:
    """Run every block and style on strange pictures; the process must survive."""
    chosen = [load_style(name) for name in style_names()]
    chosen += [style(step("to_gray"), step(name, source="source")) for name in all_blocks()]
    for number in range(count):
        for each in chosen:
            run_luma(each, strange_picture(seed + number, 40, 56))
            run_color(each, strange_picture(seed + number, 40, 56, 3))


def random_value(random: np.random.Generator, parameter: Parameter, saved: list[str]) -> Any:
    """Return a value in the range of a parameter, often an end of it."""
    control = parameter.control
    if isinstance(control, Slider):
        ends = (control.low, control.high)
        value = float(random.choice(ends) if random.random() < 0.5 else random.uniform(*ends))
        return round(value) if parameter.is_integer else value
    if isinstance(control, Choice):
        return str(random.choice(control.options))
    if isinstance(control, Switch):
        return bool(random.random() < 0.5)
    if isinstance(control, SavedRef):
        return str(random.choice(saved))
    return parameter.default


def random_style(random: np.random.Generator) -> Style:
    """Return a style of up to 256 steps of a few blocks."""
    blocks = list(all_blocks().values())
    kinds = random.choice(len(blocks), random.integers(1, 6))
    if random.random() < 0.5:  # blocks that may overshoot
        kinds = [number for number, each in enumerate(blocks) if each.kind == "learned" or each.overshoots]
    saved, steps = ["source"], list[Step]()
    for number in range(random.choice([1, 4, 16, 64, 255])):
        block = blocks[random.choice(kinds)]
        values = {name: random_value(random, each, saved) for name, each in block.parameters.items()}
        name = f"picture{number}" if random.random() < 0.2 else ""
        steps.append(step(block.name, name, **values))
        saved += [name] if name else []
    layers = {str(random.choice(["base", "background", "lines"])): tuple(steps)}
    return Style("random", height=int(random.choice([16, 720])), **layers)  # type: ignore[arg-type]


def chains(seed: int, count: int) -> None:
    """Run random valid styles: results are within 0..1, or the style is refused in one line."""
    refused = 0
    for number in range(seed, seed + count):
        random = np.random.default_rng(number)
        picture = noise(*random.integers(1, 49, 2), 3, seed=number)
        try:
            result = stylize(picture, random_style(random), "cpu")
        except StyleError as error:
            assert "\n" not in str(error), number
            refused += 1
            continue
        assert np.isfinite(result).all() and result.min() >= 0 and result.max() <= 1, number
    print(f"{refused} of {count} refused")


def mutate_array(random: np.random.Generator, array: np.ndarray) -> np.ndarray:
    """Return a copy of an array with some changed bytes or strange numbers."""
    if array.dtype.kind == "f" and random.random() < 0.6:
        changed = np.atleast_1d(array.copy())
        changed[random.random(changed.shape) < random.choice([0.001, 0.1, 1])] = random.choice(
            [*STRANGE_LEVELS, 500.0, -900.0, 1e-3, 0.0]
        )
        return changed.reshape(array.shape)
    changed = np.frombuffer(array.tobytes(), np.uint8).copy()
    for place in random.integers(0, changed.size, random.integers(1, 20)):
        changed[place] = random.integers(0, 256)
    return np.frombuffer(changed.tobytes(), array.dtype).reshape(array.shape)


def banks(seed: int, count: int) -> None:
    """Run mutated banks: they are refused with a reason, or their results are within bounds."""
    refused = 0
    with tempfile.TemporaryDirectory() as folder, np.errstate(invalid="ignore", over="ignore"):
        path = Path(folder) / "bank.npz"
        shipped = list(shipped_banks().values())
        for number in range(seed, seed + count):
            random = np.random.default_rng(number)
            with np.load(random.choice(np.array(shipped, object))) as found:
                arrays = {name: found[name] for name in found.files}
            for name in random.choice(["filters", "filters", "bins", "ranges", "rho", "about"], 2):
                arrays[name] = mutate_array(random, arrays[name])
            np.savez(path, **arrays)
            try:
                bank: Bank = load_bank(path)
            except ValueError as error:
                assert "\n" not in str(error), number
                refused += 1
                continue
            weights = (1.0, 60.0, *[1.0] * 8)[: len(bank.filters)]
            for run in (BankRun(bank, weights, passes=8), BankRun(bank, weights, 0.5, is_wide=True)):
                low, high = run.limits
                result = run.run(noise(40, 56, seed=number))
                assert result.min() >= low and result.max() <= high, number
    print(f"{refused} of {count} refused")


if __name__ == "__main__":
    {"pictures": pictures, "chains": chains, "banks": banks}[sys.argv[1]](int(sys.argv[2]), int(sys.argv[3]))
