"""Remakes the banks in filters_bank/ and its README: `python tools/train_banks.py --images DIR`.

The last pictures of the folder, by name, are only measured with. The same pictures give the same bytes.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vidstyle.blade.bank import Bank, load_bank, save_bank
from vidstyle.blade.inference import BankRun
from vidstyle.blade.photographs import Photograph, photographs_in
from vidstyle.blade.reference_filter import ReferenceFilter, reference_by_name
from vidstyle.blade.regression import TrainingConfig
from vidstyle.blade.structure_tensor import Bins
from vidstyle.blade.training import measure, train

FOLDER = Path(__file__).parent.parent / "filters_bank"
LONG_SIDE = 1000
HELD_OUT = 10


@dataclass(frozen=True)
class Plan:
    """How a bank is made and measured.

    Attributes:
        uses: weights of the parts and of the picture itself with which fidelity is measured, by a name.
    """

    name: str
    reference: ReferenceFilter
    config: TrainingConfig
    uses: dict[str, tuple[tuple[float, ...], float]]


ALONE = {"alone": ((1.0,), 0.0)}
PLANS = (
    Plan(
        "etf",
        reference_by_name("edge_tangent_flow", sigma=2.0, rho=2.0),
        TrainingConfig(Bins(24, 1, 3), 2.0, 5),
        ALONE,
    ),
    Plan(
        "tvf",
        reference_by_name("tv_flow", time=2.0, gradient_power=1),
        TrainingConfig(Bins(16, 4, 4), 1.0, 7),
        ALONE,
    ),
    Plan(
        "flow_dog",
        reference_by_name("flow_dog", sigma=1.0),
        TrainingConfig(Bins(16, 5, 3), 1.5, 7, (1, 0)),
        {"p 10": ((1.0, 10.0), 0.0), "p 20": ((1.0, 20.0), 0.0)},
    ),
    Plan(
        "flow_dog_fine",
        reference_by_name("flow_dog", sigma=0.5),
        TrainingConfig(Bins(16, 5, 3), 1.5, 7, (1, 0)),
        {"p 10": ((1.0, 10.0), 0.0)},
    ),
    Plan(
        "detail",
        reference_by_name("detail_base"),
        TrainingConfig(Bins(16, 5, 3), 1.5, 9),
        {
            "delta -100": ((1.0,), 0.0),
            "delta -20": ((0.2,), 0.8),
            "delta +20": ((-0.2,), 1.2),
            "delta +60": ((-0.6,), 1.6),
        },
    ),
)


def main() -> None:
    """Train, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", type=Path, required=True)
    parser.add_argument("--only", action="append", choices=[plan.name for plan in PLANS])
    arguments = parser.parse_args()
    pictures = photographs_in(arguments.images, LONG_SIDE)
    FOLDER.mkdir(exist_ok=True)
    for plan in PLANS:
        if not arguments.only or plan.name in arguments.only:
            make(plan, pictures[:-HELD_OUT], pictures[-HELD_OUT:])
    write_readme({path.stem: load_bank(path) for path in sorted(FOLDER.glob("*.npz"))})


def make(plan: Plan, pictures: list[Photograph], held_out: list[Photograph]) -> None:
    """One bank."""
    bank, report = train(plan.config, plan.reference, pictures)
    print(f"{plan.name}: {report}", flush=True)
    bank.about["fidelity"] = {
        use: measured(bank, plan.reference, weights, identity, held_out)
        for use, (weights, identity) in plan.uses.items()
    }
    save_bank(bank, FOLDER / f"{plan.name}.npz")
    for use, fidelity in bank.about["fidelity"].items():
        print(f"  {use}: {fidelity}", flush=True)


def measured(
    bank: Bank,
    reference: ReferenceFilter,
    weights: tuple[float, ...],
    identity: float,
    pictures: list[Photograph],
) -> dict[str, float]:
    """How close one use of a bank comes to the same use of its reference."""
    run = BankRun(bank, weights, identity)
    return measure(run, reference, pictures, weights, identity)


def write_readme(banks: dict[str, Bank]) -> None:
    """What the banks are, read from themselves."""
    lines = [HEAD, *(row(name, bank) for name, bank in banks.items()), FIDELITY]
    for name, bank in banks.items():
        for use, fidelity in bank.about["fidelity"].items():
            numbers = " | ".join(
                f"{fidelity[f'{which}psnr']:.2f} dB | {fidelity[f'{which}mssim']:.4f}"
                for which in ("", "untouched ")
            )
            lines.append(f"| `{name}` | {use} | {numbers} |")
    one = next(iter(banks.values()))
    lines.append(PICTURES.format(count=len(one.about["pictures"]), long_side=one.about["long_side"]))
    lines += [f"| {name} | `{checksum}` |" for name, checksum in one.about["pictures"]]
    (FOLDER / "README.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def row(name: str, bank: Bank) -> str:
    """What a bank is."""
    settings = ", ".join(f"{key} {value:g}" for key, value in bank.about["settings"].items())
    bins = f"{bank.bins.orientations} x {bank.bins.strengths} x {bank.bins.coherences}"
    parts = ", ".join(bank.about["parts"])
    what = f"{bank.about['imitates']}{f' ({settings})' if settings else ''}"
    return f"| `{name}` | {what} | {parts} | {bins} | {bank.size} x {bank.size} | {bank.rho:g} |"


HEAD = """\
# Banks of learned filters

Each file holds a small linear filter for each bin of local structure (orientation x strength x coherence),
trained on photographs by `python tools/train_banks.py --images DIR`, which also writes this page; the same
photographs give the same bytes. `vidstyle train etf --show etf.png` draws a bank. The files are NumPy
archives, read without pickle and checked.

| bank | reference | parts | bins | filters | rho |
|---|---|---|---|---|---|"""
FIDELITY = """
## Fidelity

Luma of held-out photographs, against the reference filter with the same settings; *untouched* compares the
photographs themselves with the same reference.

| bank | used | PSNR | MSSIM | untouched PSNR | untouched MSSIM |
|---|---|---|---|---|---|"""
PICTURES = """
## Training pictures

{count} photographs, their longer side reduced to {long_side} pixels; the next ten by name were
held out. The photographs are not part of this repository.

| file | SHA-256 begins with |
|---|---|"""


if __name__ == "__main__":
    np.seterr(all="raise")
    main()
