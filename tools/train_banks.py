"""Train the banks in filters_bank/: `python tools/train_banks.py --images DIR`.

The last pictures of the folder, by name, are held out for `fidelity.py`. The same pictures give the same
bytes.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.blade.bank_file import save_bank
from vidstyle.blade.bins import Bins
from vidstyle.blade.photographs import Photograph, photographs_in
from vidstyle.blade.reference_filter import ReferenceFilter, join_references, reference_by_name
from vidstyle.blade.regression import TrainingConfig
from vidstyle.blade.training import train
from vidstyle.blocks.detail import CONTRAST_LEVELS
from vidstyle.blocks.tvf import PASS_TIME, STEPS_PER_PASS

FOLDER = Path(__file__).parent.parent / "filters_bank"
LONG_SIDE_PX = 512
HELD_OUT_COUNT = 10


@dataclass(frozen=True)
class Plan:
    """Training plan of a bank.

    Attributes:
        config: shape of the bank; each teacher sets parts and scale.
        teachers: reference filters of its parts, and the scale of the picture at which each runs.
        about: additional metadata of the bank.
        long_side: longer side of the photographs in pixels, after scaling down.
    """

    name: str
    config: TrainingConfig
    teachers: tuple[tuple[ReferenceFilter, float], ...]
    about: dict[str, Any] = field(default_factory=dict)
    long_side: int = LONG_SIDE_PX


def _teacher(name: str, *settings: dict[str, float], scale: float = 1.0) -> tuple[ReferenceFilter, float]:
    """Return a reference filter with several settings, and the scale at which it runs."""
    return join_references([reference_by_name(name, **each) for each in settings]), scale


def _lines(name: str, config: TrainingConfig, *sigmas: float, long_side: int = LONG_SIDE_PX) -> Plan:
    """Return the plan of a bank for lines of several widths in pixels; widths above 1 use smaller pictures.

    Bins need curvature, as bent lines have different filters; strength and coherence hardly matter.
    """
    whole = [{"sigma": sigma} for sigma in sigmas if sigma <= 1]
    teachers = [_teacher("flow_dog", *whole)] if whole else []
    teachers += [_teacher("flow_dog", {"sigma": sigma}, scale=1 / sigma) for sigma in sigmas if sigma > 1]
    return Plan(name, config, tuple(teachers), {"sigmas": sigmas}, long_side)


LAYER_SETTINGS = [{"contrast": contrast} for contrast in CONTRAST_LEVELS]
FLOW_TIMES_LEVELS_PX = (3.0, 6.0, 12.0)
"""Times of total variation flow, in levels of 255 times pixels; filters are interpolated between them."""
FLOW_SETTINGS = [{"time": time, "gradient_power": 0} for time in FLOW_TIMES_LEVELS_PX]
PLANS = (
    Plan(
        "etf",
        TrainingConfig(Bins(24, 1, 3, pitch=2), 2.0, 5),
        (_teacher("edge_tangent_flow", {"sigma": 2.0, "rho": 2.0}),),
    ),
    Plan(
        "etf_broad",
        TrainingConfig(Bins(24, 1, 3, pitch=2), 4.0, 11),
        (_teacher("edge_tangent_flow", {"sigma": 4.0, "rho": 4.0}),),
    ),
    Plan(
        "tvf",
        TrainingConfig(Bins(16, 3, 4, (0.0, 20.0), (0.0, 1.0)), 0.7, 7),
        (
            _teacher(
                "tv_flow",
                *({"time": time, "gradient_power": 1} for time in (PASS_TIME, PASS_TIME / STEPS_PER_PASS)),
            ),
        ),
    ),
    Plan(
        "tvf_flat",
        TrainingConfig(Bins(8, 20, 4, (0.0, 40.0), (0.1, 0.9)), 1.55, 9, prior_samples=1),
        (_teacher("tv_flow", *FLOW_SETTINGS),),
        {"times": FLOW_TIMES_LEVELS_PX},
        long_side=768,
    ),
    Plan(
        "tvf_flat_clipped",
        TrainingConfig(Bins(4, 12, 2, (0.0, 40.0), (0.1, 0.9)), 1.55, 9, clips=(4.0, 16.0)),
        (_teacher("tv_flow", *FLOW_SETTINGS),),
        {"times": FLOW_TIMES_LEVELS_PX},
    ),
    _lines("flow_dog_fine", TrainingConfig(Bins(24, 1, 1, curvatures=9), 2.0, 9), 0.5, 0.7, 1.0),
    # The reference enlarges the tensor of a reduced picture, which widens its window a little.
    _lines(
        "flow_dog",
        TrainingConfig(Bins(24, 1, 1, curvatures=9), 2.1, 9),
        *(1.0, 1.4, 2.0, 4.0),
        long_side=768,
    ),
    Plan(
        "detail",
        TrainingConfig(Bins(16, 8, 3, (10.0, 58.0)), 1.5, 9),
        (_teacher("detail_base", *LAYER_SETTINGS),),
    ),
    Plan(
        "detail_clipped",
        TrainingConfig(Bins(2, 16, 1, (0.0, 60.0)), 1.5, 9, clips=(16.0, 64.0)),
        (_teacher("detail_base", *LAYER_SETTINGS),),
    ),
)


class KeptPhotograph(Photograph):
    """A photograph that is decoded once for all banks."""

    def color(self) -> np.ndarray:
        return self._color

    @cached_property
    def _color(self) -> np.ndarray:
        return super().color()


def main() -> None:
    """Train the banks and write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", type=Path, required=True)
    parser.add_argument("--only", action="append", choices=[plan.name for plan in PLANS])
    arguments = parser.parse_args()
    FOLDER.mkdir(exist_ok=True)
    pictures: dict[int, list[KeptPhotograph]] = {}
    for plan in PLANS:
        if not arguments.only or plan.name in arguments.only:
            side = plan.long_side
            if side not in pictures:
                found = photographs_in(arguments.images, side)[:-HELD_OUT_COUNT]
                pictures[side] = [KeptPhotograph(each.path, side) for each in found]
            train_plan(plan, pictures[side])


def train_plan(plan: Plan, pictures: Sequence[Photograph]) -> None:
    """Train one bank with the parts of all its teachers, which share the bins."""
    banks = []
    for reference, scale in plan.teachers:
        config = replace(plan.config, sums=reference.sums, scale=scale)
        bank, report = train(config, reference, pictures)
        print(f"{plan.name}: {', '.join(reference.parts)}, scale {scale:g}: {report}", flush=True)
        banks.append(bank)
    joined_lists = {
        name: [each for bank in banks for each in bank.about[name]] for name in ("parts", "residuals")
    }
    about = banks[0].about | joined_lists | plan.about
    filters = np.concatenate([bank.filters for bank in banks])
    save_bank(replace(banks[0], filters=filters, about=about), FOLDER / f"{plan.name}.npz")


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")  # total variation flow of flat areas yields denormal numbers
    main()
