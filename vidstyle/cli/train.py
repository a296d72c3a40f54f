"""vidstyle train: train a bank of learned filters to approximate any filter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.display import display, progress_option
from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import number, threads_option
from vidstyle.cli.parsing.path_arguments import PATH, parents_option
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import InputError, UsageError
from vidstyle.pipeline.progress import StepProgress

if TYPE_CHECKING:
    from vidstyle.blade.bins import Feature
    from vidstyle.blade.reference_filter import ReferenceFilter
    from vidstyle.blade.regression import TrainingConfig

MIN_LEARNED_SHARE = 0.4
"""The part of a filter's change below which a bank is not worth its name."""


MIN_RHO = 0.3
"""Of the windows by which filters are chosen, in pixels."""


@command(
    "Train a bank of learned filters on a filter or on pairs of pictures.",
    examples=(
        "vidstyle train mine.npz --images photographs/ --reference tv_flow",
        "vidstyle train mine.npz --images photographs/ --pairs painted/",
        "vidstyle train mine.npz --show filters.png",
    ),
    epilog="Guide: README.md in the source folder.",
)
@click.argument("bank", metavar="BANK.npz", type=PATH)
@option("--images", metavar="DIR", type=PATH, group=Group.REFERENCE, help="Folder of training pictures.")
@option("--reference", metavar="NAME", group=Group.REFERENCE,
        help="Approximate a built-in reference filter, such as tv_flow.")  # fmt: skip
@option("--set", "settings", metavar="NAME=NUMBER", multiple=True, group=Group.REFERENCE,
        help="Override a setting of the reference filter; may be repeated.")  # fmt: skip
@option("--command", metavar="COMMAND", group=Group.REFERENCE,
        help="Approximate a program: 'ffmpeg -i {in} -vf nlmeans {out}'.")  # fmt: skip
@option("--function", metavar="MODULE:NAME", group=Group.REFERENCE,
        help="Approximate a Python function from RGB to RGB (uint8).")  # fmt: skip
@option("--pairs", metavar="DIR", type=PATH, group=Group.REFERENCE,
        help="Approximate the pictures in DIR that have the same names as those of --images.")  # fmt: skip
@option("--slider", "sliders", metavar="NAME=LOW:HIGH", multiple=True, group=Group.FILTERS,
        help="Weight of an additional picture that the function returns; may be repeated.")  # fmt: skip
@option("--bins", metavar="OxSxC[xK]", default="16x5x3", group=Group.FILTERS,
        help="Bins of orientation, strength, coherence and curvature.")  # fmt: skip
@option("--feature", "features", metavar="NAME=BINS@RHO", multiple=True, group=Group.FILTERS,
        help="Also select filters by mean, strength or coherence at scale RHO; may be repeated.")  # fmt: skip
@option("--chroma", is_flag=True, group=Group.FILTERS, help="Also learn filters for chroma.")
@option("--size", type=number(3, 15, whole=True), default=7, group=Group.FILTERS,
        help="Filter size in pixels, odd.")  # fmt: skip
@option("--rho", type=number(MIN_RHO, 8), default=1.5, group=Group.FILTERS,
        help="Standard deviation of the structure tensor's window, in pixels.")  # fmt: skip
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
    from vidstyle.blade.bank import MAX_SLIDERS, save_bank
    from vidstyle.blade.inference import BankRun
    from vidstyle.blade.photographs import photographs_in
    from vidstyle.blade.training import measure
    from vidstyle.blade.training import train as train_bank

    sliders = _sliders(options["sliders"])
    reference = _reference(options, [name for name, *_ in sliders])
    if len(sliders) > min(len(reference.parts) - 1, MAX_SLIDERS):
        most = min(len(reference.parts) - 1, MAX_SLIDERS)
        raise UsageError(
            "--slider", f"is given {len(sliders)} times", f"use it at most {most} times with this reference"
        )
    config = _config(options, reference)
    if path.exists() and not options["overwrite"]:
        raise UsageError(path, "exists already", "add -y to overwrite it, or choose another name")
    if options["images"] is None:
        raise UsageError("--images", "is missing", "add --images and a folder of pictures")
    pictures = photographs_in(options["images"], options["long_side"])
    held_out = min(options["hold_out"], len(pictures) - 1)
    with display(options["progress"]) as show:
        on_picture = StepProgress(show)
        learned_from = pictures[: len(pictures) - held_out]
        bank, report = train_bank(config, reference, learned_from, on_picture, options["chroma"])
        fidelity = None
        bank.about["sliders"] = [list(slider) for slider in sliders]
        if held_out > 0:
            middle = bank.weights_at([0.5] * len(sliders)) if sliders else (1.0,) * len(reference.parts)
            run = BankRun(bank, middle)
            fidelity = measure(run, reference, pictures[-held_out:], middle, on_picture=on_picture)
            bank.about["fidelity"] = fidelity
    say(str(report))
    if fidelity:
        say(_fidelity_text(fidelity, held_out))
        if fidelity["explained"] < MIN_LEARNED_SHARE:
            say(
                f"explains {fidelity['explained']:.0%} of the change: this filter is not local "
                f"(a result depends on more than {config.size} x {config.size} pixels and their direction)"
            )
    save_bank(bank, path)
    text = f"{path}: {bank.bins.count} filters of {bank.size} x {bank.size}"
    say(text, {"files": [str(path)], "filters": bank.bins.count, "fidelity": fidelity})


def _sliders(texts: tuple[str, ...]) -> list[tuple[str, float, float]]:
    from vidstyle.blade.bank import MAX_WEIGHT

    found = []
    for text in texts:
        name, _, ends = text.partition("=")
        try:
            low, high = (float(end) for end in ends.split(":"))
        except ValueError:
            low = high = 0.0
        if not name or not -MAX_WEIGHT <= low < high <= MAX_WEIGHT:
            raise UsageError(text, "is not NAME=LOW:HIGH", "for example --slider strength=0:2")
        found.append((name, low, high))
    return found


def _features(texts: tuple[str, ...]) -> tuple[Feature, ...]:
    from vidstyle.blade.bank import MAX_FEATURES, MAX_FILTERS, MAX_RHO
    from vidstyle.blade.bins import FEATURE_RANGES, Feature

    found = []
    for text in texts:
        name, _, scale = text.partition("=")
        try:
            bins, rho = int(scale.partition("@")[0]), float(scale.partition("@")[2])
        except ValueError:
            bins, rho = 0, 0.0
        if name not in FEATURE_RANGES or not (1 <= bins <= MAX_FILTERS and MIN_RHO <= rho <= MAX_RHO):
            remedy = f"for example --feature mean=4@2; names are {', '.join(FEATURE_RANGES)}"
            raise UsageError(text, "is not NAME=BINS@RHO", remedy)
        found.append(Feature(name, bins, rho))
    if len(found) > MAX_FEATURES:
        raise UsageError("--feature", f"is given {len(found)} times", f"use it at most {MAX_FEATURES} times")
    return tuple(found)


def _reference(options: dict[str, Any], sliders: list[str]) -> ReferenceFilter:
    from vidstyle.blade import reference_filter

    sources = ("reference", "command", "function", "pairs")
    given = [name for name in sources if options[name]]
    if len(given) != 1:
        raise UsageError("train", "needs exactly one reference", f"add one of --{', --'.join(sources)}")
    if given[0] == "reference":
        return reference_filter.reference_by_name(options["reference"], **_settings(options["settings"]))
    if given[0] == "function":
        return reference_filter.reference_by_function(options["function"], sliders)
    make = getattr(reference_filter, f"reference_by_{given[0]}")
    return make(options[given[0]])


def _settings(texts: tuple[str, ...]) -> dict[str, float]:
    try:
        return {name: float(value) for name, value in (text.split("=") for text in texts)}
    except ValueError:
        raise UsageError(" ".join(texts), "is not NAME=NUMBER", "for example --set sigma=2") from None


def _config(options: dict[str, Any], reference: ReferenceFilter) -> TrainingConfig:
    from vidstyle.blade.bank import MAX_FILTERS
    from vidstyle.blade.bins import Bins
    from vidstyle.blade.regression import TrainingConfig

    try:
        orientations, strengths, coherences, *others = (int(part) for part in options["bins"].split("x"))
        (curvatures,) = others or [1]
    except ValueError:
        reason, remedy = f"{options['bins']} is not OxSxC or OxSxCxK", "for example --bins 16x5x3"
        raise UsageError("--bins", reason, remedy) from None
    size, rho = options["size"], options["rho"]
    if orientations < 2 or orientations % 2 or min(strengths, coherences, curvatures) < 1:
        reason = f"{options['bins']} is invalid: orientations must be even, the others at least 1"
        raise UsageError("--bins", reason, "for example --bins 16x5x3")
    if size % 2 == 0:
        raise UsageError("--size", f"{size} is even", f"use {size - 1} or {size + 1}")
    features = _features(options["features"])
    bins = Bins(orientations, strengths, coherences, curvatures=curvatures, features=features)
    if bins.count > MAX_FILTERS:
        raise UsageError("--bins", f"{bins.count} filters are too many", f"use at most {MAX_FILTERS}")
    return TrainingConfig(bins, rho, size, reference.sums)


def _show(path: Path, target: Path) -> None:
    import cv2

    from vidstyle.blade.bank import load_bank, shipped_banks
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
        f"explains {fidelity['explained']:.0%} of the change"
    )
