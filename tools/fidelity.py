"""Measure every learned block over its range, and write filters_bank/README.md.

`nice python tools/fidelity.py --images DIR` uses the last pictures of the folder, by name, which are held out
of the training.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.bank_file import shipped_bank, shipped_banks
from vidstyle.blade.inference import BankRun
from vidstyle.blade.photographs import luma_of, photographs_in
from vidstyle.blade.references import (
    detail_base,
    edge_tangent_flow,
    flow_dog_parts,
    second_order_tv_flow,
    tv_flow,
)
from vidstyle.blade.training import mssim, psnr
from vidstyle.blocks import all_blocks
from vidstyle.blocks.detail import CONTRAST_LEVELS, FULL_DELTA

README = Path(__file__).parent.parent / "filters_bank" / "README.md"
HELD_OUT_COUNT = 10
"""Number of held-out pictures, the last of the folder."""
SHARPENING_FACTOR = 20.0
"""Value of the parameter `p` with which lines are measured."""
PAPER_SCORES = {
    "etf": (34.85, 0.9619),
    "tvf": (35.86, 0.9683),
    "detail -20": (38.38, 0.9845),
    "detail +20": (41.36, 0.9895),
}
"""PSNR and MSSIM in the paper's figures 8 and 11, which gives neither settings nor the source pictures."""

Picture = np.ndarray


@dataclass(frozen=True)
class Case:
    """One setting of a block, and its reference.

    Attributes:
        values: the parameters of the block.
        target: the reference filter for luma.
        outputs: forms of the output to compare, see `convert_output`.
        paper: key in `PAPER_SCORES`, or "".
    """

    block: str
    values: Mapping[str, object]
    target: Callable[[Picture], Picture]
    outputs: tuple[str, ...] = ("",)
    paper: str = ""

    @property
    def run(self) -> BankRun:
        """The bank with these parameters."""
        block = all_blocks()[self.block]
        made: BankRun = block.function(**block.arguments_for(dict(self.values)))
        return made

    @property
    def name(self) -> str:
        """The parameters as text, as in a style file."""
        return ", ".join(f"{key} {format_toml(value)}" for key, value in self.values.items())


def cases() -> Iterator[Case]:
    """Yield all measured settings."""
    for passes in (1, 3, 6, 12):
        for reselect in (True, False):
            yield stroke_case(passes, 2, 2, reselect=reselect, paper="etf" if reselect else "")
    for brush in ("broad",):
        for passes, rho in ((1, 4), (3, 4), (6, 4), (6, 8)):
            yield stroke_case(passes, rho, 4, brush=brush, reselect=True, paper="etf")
    for passes in (1, 2, 6, 12):
        yield Case("tvf", {"passes": passes}, partial(tv_flow, time=2.0 * passes), paper="tvf")
    yield Case("tvf", {"passes": 2}, partial(second_order_tv_flow, time=4.0), ("paper's scheme",), "tvf")
    for passes, time in ((1, 3), (2, 6), (4, 6), (4, 12), (8, 12)):
        settings: dict[str, object] = {"flow": "variation", "passes": passes, "time": time}
        for accurate in ({}, {"accurate": True}) if passes > 1 else ({},):
            yield Case(
                "tvf",
                settings | accurate,
                partial(tv_flow, time=passes * time, gradient_power=0),
                paper="tvf",
            )
    for delta in (-100, -60, -20, 20, 60, 100):
        paper = f"detail {delta:+d}" if abs(delta) == 20 else ""
        for accurate in ({}, {"accurate": True}) if delta > FULL_DELTA else ({},):
            values = {"delta": delta} | accurate
            yield Case("detail", values, partial(apply_detail, delta=delta), paper=paper)
    for sigma in (0.5, 0.7, 1, 1.4, 2, 2.8, 4, 5.6, 8):
        outputs = ("linear", "clipped", "threshold")
        yield Case(
            "flow_dog",
            {"sigma": sigma, "p": SHARPENING_FACTOR},
            partial(apply_flow_dog, sigma=sigma),
            outputs,
        )


def stroke_case(passes: int, rho: float, sigma: float, paper: str, **values: object) -> Case:
    """Return a case of edge tangent flow; the reference computes the tensor in each pass, as in the paper."""

    def target(luma: Picture) -> Picture:
        return cached_edge_tangent_flow(luma, sigma, rho, passes)

    return Case("etf", {"passes": passes, "rho": rho, **values}, target, paper=paper)


def cached(reference: Callable[..., Picture]) -> Callable[..., Picture]:
    """Decorate a reference filter so that it caches the result for each picture and settings."""
    results: dict[tuple[object, ...], Picture] = {}

    def compute(luma: Picture, *settings: float) -> Picture:
        key = hash(luma.tobytes()), *settings
        if key not in results:
            results[key] = reference(luma, *settings)
        return results[key]

    return compute


@cached
def cached_edge_tangent_flow(luma: Picture, sigma: float, rho: float, passes: int) -> Picture:
    """Return edge tangent flow; each pass starts from the cached result of the previous one."""
    before = cached_edge_tangent_flow(luma, sigma, rho, passes - 1) if passes > 1 else luma
    return edge_tangent_flow(before, sigma, rho)


cached_detail_base = cached(detail_base)


def apply_detail(luma: Picture, delta: float) -> Picture:
    """Return the reference of `detail`: each detail layer is multiplied by its factor."""
    block = all_blocks()["detail"]
    run: BankRun = block.function(**block.arguments_for({"delta": delta}))
    bases = (cached_detail_base(luma, contrast) for contrast in CONTRAST_LEVELS)
    return sum(
        (weight * base for weight, base in zip(run.weights, bases, strict=True)),
        run.identity * luma,
    )


def apply_flow_dog(luma: Picture, sigma: float) -> Picture:
    """Return the reference of `flow_dog`."""
    smooth, difference = flow_dog_parts(luma, sigma)
    return smooth + np.float32(SHARPENING_FACTOR) * difference


def format_toml(value: object) -> str:
    """Return a value as text: 2, 0.5, true, broad."""
    return str(value).lower() if isinstance(value, bool | str) else f"{value:g}"


def convert_output(picture: Picture, outputs: str) -> Picture:
    """Return the picture unchanged, clipped to 0..1, or after the soft threshold."""
    if outputs == "threshold":
        return all_blocks()["soft_threshold"](picture, np.empty_like(picture), phi=0.02, epsilon=130)
    return np.clip(picture, 0, 1) if outputs == "clipped" else picture


def measure_rows(case: Case, pictures: Sequence[Picture]) -> list[str]:
    """Return rows of the table: mean PSNR and MSSIM of the block and of the untouched pictures."""
    measured = []
    for luma in pictures:
        target, result = case.target(luma), case.run.whole(luma)
        for outputs in case.outputs:
            wanted = convert_output(target, outputs)
            pairs = ((each, wanted) for each in (convert_output(result, outputs), luma))
            measured.append([measure(*pair) for pair in pairs for measure in (psnr, mssim)])
    means = np.reshape(measured, (len(pictures), len(case.outputs), 4)).mean(axis=0)
    return [
        f"| `{case.block}` | {case.name}{outputs and ', '}{outputs} | {found:.2f} dB | {similar:.4f} | "
        f"{untouched:.2f} dB | {untouched_mssim:.4f} | {found - untouched:.2f} dB | "
        f"{format_paper_scores(case, untouched)} |"
        for outputs, (found, similar, untouched, untouched_mssim) in zip(case.outputs, means, strict=True)
    ]


def format_paper_scores(case: Case, untouched: float) -> str:
    """Return the scores of the paper, and the gain that they mean at the strength of our reference."""
    if not case.paper:
        return ""
    found, similar = PAPER_SCORES[case.paper]
    return f"{found:.2f} dB, {similar:.4f}; {found - untouched:+.2f} dB"


def format_bank(name: str, bank: Bank) -> str:
    """Return a row of the table of banks."""
    bins, samples = bank.bins, np.array(bank.about["samples"])
    residuals = np.sqrt((np.square(bank.about["residuals"]) * samples).sum(axis=1) / max(samples.sum(), 1))
    return (
        f"| `{name}` | {bank.about['imitates']} | {'; '.join(bank.about['parts'])} | "
        f"{' x '.join(map(str, bins.counts))} | {bank.size} x {bank.size} | {bank.rho:g} | "
        f"{', '.join(f'{each:.2f}' for each in residuals)} | {(samples == 0).sum()} | "
        f"{bank.about['long_side']} |"
    )


def main() -> None:
    """Measure, print rows, and write the README."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", type=Path, required=True)
    parser.add_argument("--long-side", type=int, default=768)
    parser.add_argument("--only", action="append", help="a block, or 'flow_dog sigma 2'; writes nothing")
    parser.add_argument(
        "--pictures", type=int, default=HELD_OUT_COUNT, help="number of held-out pictures to use"
    )
    arguments = parser.parse_args()
    held_out = photographs_in(arguments.images, arguments.long_side)[-HELD_OUT_COUNT:]
    pictures = [luma_of(each.color()) for each in held_out[: arguments.pictures]]
    rows = []
    for case in cases():
        if not arguments.only or any(f"{case.block} {case.name}".startswith(each) for each in arguments.only):
            rows += measure_rows(case, pictures)
            print(*rows[-len(case.outputs) :], sep="\n", flush=True)
    if not arguments.only:
        README.write_text(format_readme(rows, len(pictures), arguments.long_side), encoding="utf-8")


def format_readme(rows: list[str], count: int, long_side: int) -> str:
    """Return the content of filters_bank/README.md."""
    banks = {name: shipped_bank(name) for name in shipped_banks()}
    about = next(iter(banks.values())).about
    learned = PICTURES_SECTION.format(count=len(about["pictures"]))
    return "\n".join(
        [
            README_HEAD,
            *(format_bank(name, bank) for name, bank in banks.items()),
            FIDELITY_SECTION.format(count=count, long_side=long_side),
            *rows,
            learned,
            *(f"| {name} | `{checksum}` |" for name, checksum in about["pictures"]),
            "",
        ]
    )


README_HEAD = """\
# Banks of learned filters

Each file holds a small linear filter for each bin of local structure (orientation x strength x coherence x
curvature), trained on photographs by `python tools/train_banks.py --images DIR`; the same photographs give
the same bytes. `python tools/fidelity.py --images DIR` writes this page. `vidstyle train etf --show etf.png`
draws a bank; [docs/filters.jpg](../docs/filters.jpg) shows their effect. The files are NumPy archives, read
without pickle and checked. *Residual* is the root of the mean squared error of each part on the training
pictures, in levels of 255 (above 1 px before the result is enlarged); *empty* counts bins without pixels,
which have the mean filter of their orientation. *Photographs* is the reduced length of their longer side.

| bank | reference | parts | bins | filters | rho | residual | empty | photographs, px |
|---|---|---|---|---|---|---|---|---|"""
FIDELITY_SECTION = """
## Fidelity

Luma of {count} photographs that no bank has learned from, their longer side reduced to {long_side} pixels,
compared with the reference filter. *Untouched* compares the original photographs with the same reference:
the lower, the stronger the filter. *gain* is the improvement by the block. *linear* is before the soft
threshold, *clipped* as displayed, *threshold* after `soft_threshold` with phi 0.02 and epsilon 130.
`reselect` false keeps the filters of the first pass; the difference is the loss of quality.

The paper gives neither its settings nor the figures of untouched pictures, so the strength of its filters is
unknown. Its PSNR and MSSIM are listed next to each of our settings, with the gain that they would mean at
equal strength. If the gain is below 0, the filter of the paper must have been stronger.

| block | setting | PSNR | MSSIM | untouched PSNR | untouched MSSIM | gain | paper |
|---|---|---|---|---|---|---|---|"""
PICTURES_SECTION = """
## Training pictures

{count} photographs; the next ten by name were held out. They are not part of this repository.

| file | SHA-256 begins with |
|---|---|"""


if __name__ == "__main__":
    main()
