"""vidstyle train: train a bank of learned filters to approximate any filter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.display import display, progress_option
from vidstyle.cli.options import number, parents_option
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import InputError, UsageError
from vidstyle.pipeline.progress import StepProgress

if TYPE_CHECKING:
    from vidstyle.blade.bins import Feature
    from vidstyle.blade.reference_filter import ReferenceFilter
    from vidstyle.blade.regression import TrainingConfig

LEARNABLE = 0.4
"""The part of a filter's change below which a bank is not worth its name."""


MIN_RHO = 0.3
"""Of the windows by which filters are chosen, in pixels."""


@click.command(short_help="Train a bank of learned filters on a filter or on pairs of pictures.")
@click.argument("bank", metavar="BANK.npz", type=click.Path(path_type=Path))
@click.option("--images", metavar="DIR", type=click.Path(path_type=Path), help="Folder of training pictures.")
@click.option("--reference", metavar="NAME", help="Approximate a built-in reference filter, such as tv_flow.")
@click.option("--set", "settings", metavar="NAME=NUMBER", multiple=True, help="Setting of the reference.")
@click.option(
    "--command", metavar="COMMAND", help="Approximate a program: 'ffmpeg -i {in} -vf nlmeans {out}'."
)
@click.option("--function", metavar="MODULE:NAME",
              help="Approximate a Python function from RGB, uint8, to RGB.")  # fmt: skip
@click.option("--pairs", metavar="DIR", type=click.Path(path_type=Path),
              help="Approximate the pictures of the same names in DIR.")  # fmt: skip
@click.option("--slider", "sliders", metavar="NAME=LOW:HIGH", multiple=True,
              help="Weight of a further picture that the function returns.")  # fmt: skip
@click.option("--bins", metavar="OxSxC[xK]", default="16x5x3",
              help="Bins of orientation, strength, coherence and curvature.")  # fmt: skip
@click.option("--feature", "features", metavar="NAME=BINS@RHO", multiple=True,
              help="Choose by the mean, or by strength or coherence at another scale, too.")  # fmt: skip
@click.option("--chroma", is_flag=True, help="Learn what the filter does to chroma, too.")
@click.option("--size", type=number(3, 15, whole=True), default=7, help="Filter size in pixels, odd.")
@click.option("--rho", type=number(MIN_RHO, 8), default=1.5,
              help="Standard deviation of the structure tensor's window, in pixels.")  # fmt: skip
@click.option("--hold-out", type=number(0, whole=True), default=2,
              help="Number of pictures, the last ones, that only measure fidelity.")  # fmt: skip
@click.option("--long-side", type=number(16, whole=True), default=1000,
              help="Reduce pictures to this length of their longer side.")  # fmt: skip
@click.option("-y", "--overwrite", is_flag=True, help="Overwrite BANK.npz if it exists.")
@parents_option("bank")
@click.option("--show", metavar="PICTURE", type=click.Path(path_type=Path),
              help="Draw the filters of BANK.npz as a picture.")  # fmt: skip
@progress_option
@reporting_options
def train(bank: Path, **options: Any) -> None:
    """Train BANK.npz, or with --show draw its filters.

    A style uses it as block = "learned", bank = "BANK.npz", from the style's own folder.
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
        raise UsageError("--slider", f"is given {len(sliders)} times", f"this reference has room for {most}")
    config = _config(options, reference)
    if path.exists() and not options["overwrite"]:
        raise UsageError(path, "exists", "add -y to replace it")
    if options["images"] is None:
        raise UsageError("--images", "is missing", "name a folder of pictures")
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
        if fidelity["explained"] < LEARNABLE:
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
            raise UsageError(text, "is not NAME=LOW:HIGH", "write it so, as --slider strength=0:2")
        found.append((name, low, high))
    return found


def _features(texts: tuple[str, ...]) -> tuple[Feature, ...]:
    from vidstyle.blade.bank import MAX_FEATURES, MAX_FILTERS, MAX_RHO
    from vidstyle.blade.bins import FEATURES, Feature

    found = []
    for text in texts:
        name, _, scale = text.partition("=")
        try:
            bins, rho = int(scale.partition("@")[0]), float(scale.partition("@")[2])
        except ValueError:
            bins, rho = 0, 0.0
        if name not in FEATURES or not (1 <= bins <= MAX_FILTERS and MIN_RHO <= rho <= MAX_RHO):
            remedy = f"write it so, as --feature mean=4@2; names are {', '.join(FEATURES)}"
            raise UsageError(text, "is not NAME=BINS@RHO", remedy)
        found.append(Feature(name, bins, rho))
    if len(found) > MAX_FEATURES:
        raise UsageError("--feature", f"is given {len(found)} times", f"there is room for {MAX_FEATURES}")
    return tuple(found)


def _reference(options: dict[str, Any], sliders: list[str]) -> ReferenceFilter:
    from vidstyle.blade import reference_filter

    sources = ("reference", "command", "function", "pairs")
    given = [name for name in sources if options[name]]
    if len(given) != 1:
        raise UsageError("train", "learns from one reference", f"give one of --{', --'.join(sources)}")
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
        raise UsageError(" ".join(texts), "is not NAME=NUMBER", "write it so, as --set sigma=2") from None


def _config(options: dict[str, Any], reference: ReferenceFilter) -> TrainingConfig:
    from vidstyle.blade.bank import MAX_FILTERS
    from vidstyle.blade.bins import Bins
    from vidstyle.blade.regression import TrainingConfig

    try:
        orientations, strengths, coherences, *others = (int(part) for part in options["bins"].split("x"))
        (curvatures,) = others or [1]
    except ValueError:
        reason, remedy = f"{options['bins']} is not OxSxC or OxSxCxK", "write 16x5x3"
        raise UsageError("--bins", reason, remedy) from None
    size, rho = options["size"], options["rho"]
    if orientations < 2 or orientations % 2 or min(strengths, coherences, curvatures) < 1:
        reason = f"{options['bins']} cannot be: orientations are even, the rest above 0"
        raise UsageError("--bins", reason)
    if size % 2 == 0:
        raise UsageError("--size", f"{size} is not odd", f"choose {size - 1} or {size + 1}")
    features = _features(options["features"])
    bins = Bins(orientations, strengths, coherences, curvatures=curvatures, features=features)
    if bins.count > MAX_FILTERS:
        raise UsageError("--bins", f"make {bins.count} filters", f"there are at most {MAX_FILTERS}")
    return TrainingConfig(bins, rho, size, reference.sums)


def _show(path: Path, target: Path) -> None:
    import cv2

    from vidstyle.blade.bank import load_bank, shipped_banks
    from vidstyle.blade.draw import draw_bank

    try:
        bank = load_bank(shipped_banks().get(str(path), path))
    except (ValueError, OSError) as error:
        raise InputError(path, str(error), "name a bank file, or a shipped bank") from None
    if not cv2.imwrite(str(target), draw_bank(bank)[..., ::-1]):
        raise UsageError(target, "cannot be written", "name a picture file, such as bank.png")


def _fidelity_text(fidelity: dict[str, float], held_out: int) -> str:
    chroma = ""
    if "chroma psnr" in fidelity:
        found, untouched = fidelity["chroma psnr"], fidelity["untouched chroma psnr"]
        chroma = f", chroma {found:.1f} dB (untouched: {untouched:.1f} dB)"
    return (
        f"on {held_out} pictures not learned from: {fidelity['psnr']:.1f} dB, MSSIM {fidelity['mssim']:.4f} "
        f"(untouched: {fidelity['untouched psnr']:.1f} dB, {fidelity['untouched mssim']:.4f}){chroma}; "
        f"explains {fidelity['explained']:.0%} of the change"
    )
