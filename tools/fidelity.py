"""Measures every learned block over its range and writes filters_bank/README.md.

`nice python tools/fidelity.py --images DIR` takes the last pictures of the folder, by name, which no bank has
learned from.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
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
HELD_OUT = 10
"""The last pictures of the folder that no bank learns from."""
P = 20.0
"""Strength of the sharpening with which lines are measured."""
PAPER = {
    "etf": (34.85, 0.9619),
    "tvf": (35.86, 0.9683),
    "detail -20": (38.38, 0.9845),
    "detail +20": (41.36, 0.9895),
}
"""PSNR and MSSIM in the paper's figures 8 and 11, whose settings and untouched pictures it does not give."""

Picture = np.ndarray


@dataclass(frozen=True)
class Case:
    """One setting of a block, and what it approximates.

    Attributes:
        values: of the block's parameters.
        target: from luma to what the reference makes of it.
        shown: what is compared of result and target: see `shown_as`.
        paper: the key of the paper's figures.
    """

    block: str
    values: dict[str, object]
    target: Callable[[Picture], Picture]
    shown: tuple[str, ...] = ("",)
    paper: str = ""

    @property
    def run(self) -> BankRun:
        """The bank with these values."""
        block = all_blocks()[self.block]
        made: BankRun = block.function(**block.arguments_for(self.values))
        return made

    @property
    def name(self) -> str:
        """The values as text, as a style file has them."""
        return ", ".join(f"{key} {toml_text(value)}" for key, value in self.values.items())


def cases() -> Iterator[Case]:
    """All that is measured."""
    for passes in (1, 3, 6, 12):
        for reselect in (True, False):
            yield strokes(passes, 2, 2, reselect=reselect, paper="etf" if reselect else "")
    for brush in ("broad",):
        for passes, rho in ((1, 4), (3, 4), (6, 4), (6, 8)):
            yield strokes(passes, rho, 4, brush=brush, reselect=True, paper="etf")
    for passes in (1, 2, 6, 12):
        yield Case("tvf", {"passes": passes}, lambda z, n=passes: tv_flow(z, 2.0 * n), paper="tvf")
    yield Case("tvf", {"passes": 2}, lambda z: second_order_tv_flow(z, 4.0), ("paper's scheme",), "tvf")
    for passes, time in ((1, 3), (2, 6), (4, 6), (4, 12), (8, 12)):
        values = {"flow": "variation", "passes": passes, "time": time}
        for accurate in ({}, {"accurate": True}) if passes > 1 else ({},):
            yield Case("tvf", values | accurate, lambda z, t=passes * time: tv_flow(z, t, 0), paper="tvf")
    for delta in (-100, -60, -20, 20, 60, 100):
        paper = f"detail {delta:+d}" if abs(delta) == 20 else ""
        for accurate in ({}, {"accurate": True}) if delta > FULL_DELTA else ({},):
            values = {"delta": delta} | accurate
            yield Case("detail", values, lambda z, d=delta: detailed(z, d), paper=paper)
    for sigma in (0.5, 0.7, 1, 1.4, 2, 2.8, 4, 5.6, 8):
        shown = ("linear", "clipped", "threshold")
        yield Case("flow_dog", {"sigma": sigma, "p": P}, lambda z, s=sigma: lines(z, s), shown)


def strokes(passes: int, rho: float, sigma: float, paper: str, **values: object) -> Case:
    """Edge tangent flow, whose reference takes the tensor anew in each step, as the paper does."""

    def target(luma: Picture) -> Picture:
        return painted(luma, sigma, rho, passes)

    return Case("etf", {"passes": passes, "rho": rho, **values}, target, paper=paper)


def kept(reference: Callable[..., Picture]) -> Callable[..., Picture]:
    """The reference, which is computed once for each picture and settings."""
    results: dict[tuple[object, ...], Picture] = {}

    def recalled(luma: Picture, *settings: float) -> Picture:
        key = hash(luma.tobytes()), *settings
        if key not in results:
            results[key] = reference(luma, *settings)
        return results[key]

    return recalled


@kept
def painted(luma: Picture, sigma: float, rho: float, passes: int) -> Picture:
    """Edge tangent flow, each step from what the one before has made."""
    before = painted(luma, sigma, rho, passes - 1) if passes > 1 else luma
    return edge_tangent_flow(before, sigma, rho)


base = kept(detail_base)


def detailed(luma: Picture, delta: float) -> Picture:
    """Detail control by its reference: each layer of detail by its own factor."""
    block = all_blocks()["detail"]
    run: BankRun = block.function(**block.arguments_for({"delta": delta}))
    bases = (base(luma, contrast) for contrast in CONTRAST_LEVELS)
    return sum((weight * base for weight, base in zip(run.weights, bases, strict=True)), run.identity * luma)


def lines(luma: Picture, sigma: float) -> Picture:
    """The flow-guided difference of Gaussians by its reference."""
    smooth, difference = flow_dog_parts(luma, sigma)
    return smooth + np.float32(P) * difference


def toml_text(value: object) -> str:
    """A value as text: 2, 0.5, true, broad."""
    return str(value).lower() if isinstance(value, bool | str) else f"{value:g}"


def shown_as(picture: Picture, shown: str) -> Picture:
    """The picture itself, clipped to 0..1, or after the soft threshold."""
    if shown == "threshold":
        return all_blocks()["soft_threshold"](picture, np.empty_like(picture), phi=0.02, epsilon=130)
    return np.clip(picture, 0, 1) if shown == "clipped" else picture


def rows_of(case: Case, pictures: Sequence[Picture]) -> list[str]:
    """Lines of the table: means of PSNR and MSSIM against the target, and of the untouched pictures'."""
    measured = []
    for luma in pictures:
        target, result = case.target(luma), case.run.whole(luma)
        for shown in case.shown:
            wanted = shown_as(target, shown)
            pairs = ((each, wanted) for each in (shown_as(result, shown), luma))
            measured.append([measure(*pair) for pair in pairs for measure in (psnr, mssim)])
    means = np.reshape(measured, (len(pictures), len(case.shown), 4)).mean(axis=0)
    return [
        f"| `{case.block}` | {case.name}{shown and ', '}{shown} | {found:.2f} dB | {similar:.4f} | "
        f"{untouched:.2f} dB | {alike:.4f} | {found - untouched:.2f} dB | {paper_at(case, untouched)} |"
        for shown, (found, similar, untouched, alike) in zip(case.shown, means, strict=True)
    ]


def paper_at(case: Case, untouched: float) -> str:
    """The paper's figures, and the gain that they would be where pictures change as much as with ours."""
    if not case.paper:
        return ""
    found, similar = PAPER[case.paper]
    return f"{found:.2f} dB, {similar:.4f}; {found - untouched:+.2f} dB"


def bank_row(name: str, bank: Bank) -> str:
    """What a bank is."""
    bins, samples = bank.bins, np.array(bank.about["samples"])
    residuals = np.sqrt((np.square(bank.about["residuals"]) * samples).sum(axis=1) / max(samples.sum(), 1))
    return (
        f"| `{name}` | {bank.about['imitates']} | {'; '.join(bank.about['parts'])} | "
        f"{' x '.join(map(str, bins.counts))} | {bank.size} x {bank.size} | {bank.rho:g} | "
        f"{', '.join(f'{each:.2f}' for each in residuals)} | {(samples == 0).sum()} | "
        f"{bank.about['long_side']} |"
    )


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", type=Path, required=True)
    parser.add_argument("--long-side", type=int, default=768)
    parser.add_argument("--only", action="append", help="a block, or 'flow_dog sigma 2'; writes nothing")
    parser.add_argument("--pictures", type=int, default=HELD_OUT, help="how many of the held-out ones")
    arguments = parser.parse_args()
    held_out = photographs_in(arguments.images, arguments.long_side)[-HELD_OUT:]
    pictures = [luma_of(each.color()) for each in held_out[: arguments.pictures]]
    rows = []
    for case in cases():
        if not arguments.only or any(f"{case.block} {case.name}".startswith(each) for each in arguments.only):
            rows += rows_of(case, pictures)
            print(*rows[-len(case.shown) :], sep="\n", flush=True)
    if not arguments.only:
        README.write_text(page(rows, len(pictures), arguments.long_side), encoding="utf-8")


def page(rows: list[str], count: int, long_side: int) -> str:
    """The README."""
    banks = {name: shipped_bank(name) for name in shipped_banks()}
    about = next(iter(banks.values())).about
    learned = PICTURES.format(count=len(about["pictures"]))
    return "\n".join(
        [
            HEAD,
            *(bank_row(name, bank) for name, bank in banks.items()),
            FIDELITY.format(count=count, long_side=long_side),
            *rows,
            learned,
            *(f"| {name} | `{checksum}` |" for name, checksum in about["pictures"]),
            "",
        ]
    )


HEAD = """\
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
FIDELITY = """
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
PICTURES = """
## Training pictures

{count} photographs; the next ten by name were held out. They are not part of this repository.

| file | SHA-256 begins with |
|---|---|"""


if __name__ == "__main__":
    main()
