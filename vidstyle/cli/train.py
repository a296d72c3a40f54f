"""vidstyle train: train a bank of learned filters to approximate any filter."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import number, threads_option
from vidstyle.cli.parsing.path_arguments import PATH, parents_option
from vidstyle.cli.parsing.training_options import MIN_RHO, parse_configs, parse_reference, parse_sliders
from vidstyle.cli.terminal.display import display, progress_option
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.errors import InputError, UsageError
from vidstyle.pipeline.progress import StepProgress

if TYPE_CHECKING:
    from vidstyle.blade.bank import Bank
    from vidstyle.blade.photographs import Photograph
    from vidstyle.blade.reference_filter import ReferenceFilter
    from vidstyle.blade.training import TrainingReport

GOOD_SHARE = 0.95
"""The part of a filter's change below which the rest is explained."""
MAX_CLIPPED_SHARE = 0.01
"""The share of values that a filter may make black or white without a notice."""


@command(
    "Train a bank of learned filters on a filter or on pairs of pictures.",
    examples=(
        "vidstyle train mine.npz --images photographs/ --reference tv_flow",
        "vidstyle train mine.npz --images photographs/ --pairs painted/",
        "vidstyle train mine.npz --show filters.png",
    ),
    epilog="Guide: docs/training.md in the source folder.",
)
@click.argument("bank", metavar="BANK.npz", type=PATH)
@option("--images", metavar="DIR", type=PATH, group=Group.REFERENCE, help="Folder of training pictures.")
@option("--reference", metavar="NAME", group=Group.REFERENCE,
        help="Approximate a built-in reference filter, such as tv_flow.")  # fmt: skip
@option("--set", "settings", metavar="NAME=NUMBER", multiple=True, group=Group.REFERENCE,
        help="Override a setting of the reference filter; may be repeated.")  # fmt: skip
@option("--command", metavar="COMMAND", group=Group.REFERENCE,
        help="Approximate a program: 'ffmpeg -i {in} -vf nlmeans {out}'.")  # fmt: skip
@option("--depth", type=click.Choice(["8", "16"]), default="8", group=Group.REFERENCE,
        help="Bits per channel of the PNG pictures that the program receives.")  # fmt: skip
@option("--function", metavar="MODULE:NAME", group=Group.REFERENCE,
        help="Approximate a Python function from RGB to RGB (uint8).")  # fmt: skip
@option("--pairs", metavar="DIR", type=PATH, group=Group.REFERENCE,
        help="Approximate the pictures in DIR, which have the same names as in --images.")  # fmt: skip
@option("--slider", "sliders", metavar="NAME=LOW:HIGH", multiple=True, group=Group.FILTERS,
        help="Weight of an additional picture that the function returns; may be repeated.")  # fmt: skip
@option("--bins", metavar="auto|OxSxC[xK]", default="auto", group=Group.FILTERS,
        help="Bins of orientation, strength, coherence and curvature; auto tries some.")  # fmt: skip
@option("--feature", "features", metavar="NAME=BINS@RHO", multiple=True, group=Group.FILTERS,
        help="Also select filters by mean, difference, strength or coherence at scale RHO.")  # fmt: skip
@option("--clip", "clips", metavar="LEVELS", type=number(0.1, 255), multiple=True, group=Group.FILTERS,
        help="Also weight differences clipped to +/-LEVELS of 255; may be repeated.")  # fmt: skip
@option("--chroma", is_flag=True, group=Group.FILTERS, help="Also learn filters for chroma.")
@option("--size", type=number(3, 15, whole=True), default=7, group=Group.FILTERS,
        help="Filter size in pixels, odd.")  # fmt: skip
@option("--rho", type=number(MIN_RHO, 8), default=1.5, group=Group.FILTERS,
        help="Standard deviation of the structure tensor's window, in pixels.")  # fmt: skip
@option("--stages", type=number(1, 2, whole=True), default=2, group=Group.FILTERS,
        help="Maximum number of stages; 1 also prevents a local mode before the bank.")  # fmt: skip
@option("--scale", type=number(0.05, 1), default=1, group=Group.FILTERS,
        help="Size of the picture at which the bank runs; below 1 for wide filters.")  # fmt: skip
@option("--hold-out", type=number(0, whole=True), default=2, group=Group.REFERENCE,
        help="Hold out the last N pictures for validation.")  # fmt: skip
@option("--long-side", type=number(16, whole=True), default=1000, group=Group.REFERENCE,
        help="Scale larger pictures down to this length of the longer side, in pixels.")  # fmt: skip
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite BANK.npz if it exists.")
@parents_option("bank")
@option("--show", metavar="PICTURE", type=PATH, group=Group.OUTPUT,
        help="Draw the filters of BANK.npz as a picture instead.")  # fmt: skip
@threads_option
@progress_option
@reporting_options
def train(bank: Path, **options: Any) -> None:
    """Train BANK.npz, or with --show draw its filters.

    A style in the same folder uses it with block = "learned", bank = "BANK.npz".
    """
    if options["show"]:
        _show(bank, options["show"])
    else:
        _train(bank, options)


def _train(path: Path, options: dict[str, Any]) -> None:
    from vidstyle.blade.bank import MAX_SLIDERS
    from vidstyle.blade.bank_file import save_bank
    from vidstyle.blade.photographs import photographs_in
    from vidstyle.blade.search.best_bank import train_best

    sliders = parse_sliders(options["sliders"])
    reference = parse_reference(options, [name for name, *_ in sliders])
    if len(sliders) > min(len(reference.parts) - 1, MAX_SLIDERS):
        most = min(len(reference.parts) - 1, MAX_SLIDERS)
        raise UsageError(
            "--slider", f"is given {len(sliders)} times", f"use it at most {most} times with this reference"
        )
    configs = parse_configs(options, reference)
    if path.exists() and not options["overwrite"]:
        raise UsageError(path, "already exists", "add -y to overwrite it, or choose another name")
    if options["images"] is None:
        raise UsageError("--images", "is missing", "add --images and a folder of pictures")
    pictures = photographs_in(options["images"], options["long_side"])
    held_out = min(options["hold_out"], len(pictures) - 1)
    with display(options["progress"]) as show:
        on_picture = StepProgress(show)
        learned_from = pictures[: len(pictures) - held_out]
        chroma, stages = options["chroma"], options["stages"]
        bank, report = train_best(configs, reference, learned_from, on_picture, chroma, stages)
        bank.about["sliders"] = [list(slider) for slider in sliders]
        _measure(bank, reference, pictures[len(pictures) - held_out :], on_picture)
    save_bank(bank, path)
    _report(bank, report, held_out, reference, pictures, path, len(configs))


def _measure(
    bank: Bank, reference: ReferenceFilter, pictures: list[Photograph], on_picture: StepProgress
) -> None:
    """Record the fidelity on held-out pictures in the description of a bank."""
    from vidstyle.blade.inference import BankRun
    from vidstyle.blade.training import measure

    if not pictures:
        return
    sliders = len(bank.about["sliders"])
    middle = bank.weights_at([0.5] * sliders) if sliders else (1.0,) * len(reference.parts)
    run = BankRun(bank, middle, scale=bank.scale)
    bank.about["fidelity"] = measure(run, reference, pictures, middle, on_picture=on_picture)


def _report(
    bank: Bank,
    report: TrainingReport,
    held_out: int,
    reference: ReferenceFilter,
    pictures: list[Photograph],
    path: Path,
    layouts: int,
) -> None:
    """Print the layout of the bank, its fidelity, and the causes of the remaining error."""
    from vidstyle.blade.search.layouts import layout_text

    say(str(report))
    best = f", the best of {layouts} layouts" if layouts > 1 else ""
    kind = "filters that keep flat areas" if bank.constants is None else "affine filters"
    say(f"{layout_text(bank.bins, bank.clips)}{best}; {kind}")
    for step in _steps_before(bank):
        say(f"{step} is applied before the filters")
    if bank.next:
        say(f"second stage: {layout_text(bank.next.bins, bank.next.clips)}")
    fidelity = bank.about.get("fidelity")
    if report.clipped > MAX_CLIPPED_SHARE:
        say(f"the filter clips {report.clipped:.0%} more of the values to black or white")
    if fidelity:
        say(_fidelity_text(fidelity, held_out))
        if fidelity["explained"] < GOOD_SHARE:
            say(_rest_text(bank, reference, pictures, layouts))
        elif _leaves_color(bank, reference, pictures[0]):
            say("the filter also changes colour; the bank does not (add --chroma)")
    text = f"{path}: {sum(each.bins.count for each in bank.stages)} filters of {bank.size} x {bank.size}"
    say(text, {"files": [str(path)], "filters": bank.bins.count, "fidelity": fidelity})


def _steps_before(bank: Bank) -> Iterator[str]:
    """Yield the steps before the filters of a bank, as text."""
    if bank.matrix is not None:
        yield "a colour matrix"
    if bank.curve is not None:
        percentages = ", ".join(f"{each:.3g}" for each in bank.curve[:, 0])
        yield f"a tone curve through the percentiles {percentages} of each picture"
    if bank.mode is not None:
        side = 2 * bank.mode[0] + 1
        yield f"a local mode of {side} x {side} pixels, with exponent {bank.mode[1]},"


def _leaves_color(bank: Bank, reference: ReferenceFilter, photograph: Photograph) -> bool:
    """Whether a filter changes chroma, which its bank leaves unchanged."""
    from vidstyle.blade.search.dependence import changes_color

    return bank.chroma is None and reference.is_testable and changes_color(reference, photograph)


def _rest_text(bank: Bank, reference: ReferenceFilter, pictures: list[Photograph], layouts: int) -> str:
    """Return why a bank does not reproduce the rest of the change, by tests of the filter."""
    from vidstyle.blade.search.dependence import find_dependence

    if not reference.is_testable:
        return "the cause of the rest is unknown: pairs of pictures cannot be tested like a filter"
    unexplained = 1 - bank.about["fidelity"]["explained"]
    found = find_dependence(reference, pictures)
    return f"the rest: the filter {'; '.join(found.reasons(bank, unexplained, layouts))}"


def _show(path: Path, target: Path) -> None:
    import cv2

    from vidstyle.blade.bank_file import load_bank, shipped_banks
    from vidstyle.blade.draw import draw_bank

    try:
        bank = load_bank(shipped_banks().get(str(path), path))
    except (ValueError, OSError) as error:
        raise InputError(path, str(error), "use a bank file, or the name of a shipped bank") from None
    if not cv2.imwrite(str(target), draw_bank(bank)[..., ::-1]):
        raise UsageError(target, "cannot be written", "use a picture file, such as bank.png")


def _fidelity_text(fidelity: dict[str, float], held_out: int) -> str:
    chroma = ""
    if "chroma psnr" in fidelity:
        found, untouched = fidelity["chroma psnr"], fidelity["untouched chroma psnr"]
        chroma = f", chroma {found:.1f} dB (untouched: {untouched:.1f} dB)"
    return (
        f"on {held_out} held-out pictures: {fidelity['psnr']:.1f} dB, MSSIM {fidelity['mssim']:.4f} "
        f"(untouched: {fidelity['untouched psnr']:.1f} dB, {fidelity['untouched mssim']:.4f}){chroma}; "
        f"explains {max(fidelity['explained'], 0):.0%} of the change"
    )
