"""vidstyle train: make a bank of learned filters out of any filter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import UsageError

if TYPE_CHECKING:
    from vidstyle.blade.bank import Bank
    from vidstyle.blade.learn import TrainingConfig
    from vidstyle.blade.reference_filter import ReferenceFilter

SHOWN_EVERY = 5
"""Pictures between two lines of progress."""


@click.command(short_help="Make a bank of learned filters from a filter, a command or pairs of pictures.")
@click.argument("bank", metavar="BANK.npz", type=click.Path(path_type=Path))
@click.option("--images", metavar="DIR", type=click.Path(path_type=Path), help="The pictures to learn from.")
@click.option("--reference", metavar="NAME", help="Imitate one of our references, such as tv_flow.")
@click.option("--set", "settings", metavar="NAME=NUMBER", multiple=True, help="A setting of the reference.")
@click.option("--command", metavar="COMMAND", help="Imitate a program: 'convert {in} -paint 4 {out}'.")
@click.option("--function", metavar="MODULE:NAME", help="Imitate a Python function of an RGB picture, uint8.")
@click.option(
    "--pairs",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Imitate pictures of the same names in DIR.",
)
@click.option("--bins", metavar="OxSxC", default="16x5x3", show_default=True, help="Bins of structure.")
@click.option("--size", type=int, default=7, show_default=True, help="Rows and columns of a filter, odd.")
@click.option("--rho", type=float, default=1.5, show_default=True, help="Window for structure, in pixels.")
@click.option(
    "--hold-out", type=int, default=2, show_default=True, help="Pictures to measure with, the last."
)
@click.option("--long-side", type=int, default=1000, show_default=True, help="Reduce pictures to this.")
@click.option("-y", "--overwrite", is_flag=True, help="Replace BANK.npz if it exists.")
@click.option(
    "--show", metavar="PICTURE", type=click.Path(path_type=Path), help="Draw BANK.npz into a picture."
)
@reporting_options
def train(bank: Path, **options: Any) -> None:
    """Learn BANK.npz, or with --show draw what it holds.

    A style uses it as block = "learned", bank = "BANK.npz", from the style's own folder.
    """
    if options["show"]:
        _show(bank, options["show"])
    else:
        _train(bank, options)


def _train(path: Path, options: dict[str, Any]) -> None:
    from vidstyle.blade.bank import save_bank
    from vidstyle.blade.photographs import photographs_in
    from vidstyle.blade.run import BankRun
    from vidstyle.blade.train import measure
    from vidstyle.blade.train import train as learn

    teacher, lesson = _teacher(options), _lesson(options)
    if path.exists() and not options["overwrite"]:
        raise UsageError(path, "exists", "add -y to replace it")
    if options["images"] is None:
        raise UsageError("--images", "is missing", "name a folder of pictures")
    pictures = photographs_in(options["images"], options["long_side"])
    held = min(options["hold_out"], len(pictures) - 1)
    learned, report = learn(
        _for_teacher(lesson, teacher), teacher, pictures[: len(pictures) - held], _tell_progress
    )
    say(str(report))
    if held > 0:
        weights = (1.0,) * len(teacher.parts)
        fidelity = measure(
            BankRun(learned, weights), teacher, pictures[-held:], weights, on_picture=_tell_progress
        )
        learned.about["fidelity"] = fidelity
        say(_fidelity_text(fidelity, held))
    save_bank(learned, path)
    say(f"{path}: {learned.bins.count} filters of {learned.size} x {learned.size}")


def _teacher(options: dict[str, Any]) -> ReferenceFilter:
    from vidstyle.blade import reference_filter as teachers

    sources = ("reference", "command", "function", "pairs")
    given = [name for name in sources if options[name]]
    if len(given) != 1:
        raise UsageError("train", "learns from one thing", f"give one of --{', --'.join(sources)}")
    if given[0] == "reference":
        return teachers.reference_by_name(options["reference"], **_settings(options["settings"]))
    make = getattr(teachers, f"reference_by_{given[0]}")
    return make(options[given[0]])


def _settings(texts: tuple[str, ...]) -> dict[str, float]:
    try:
        return {name: float(value) for name, value in (text.split("=") for text in texts)}
    except ValueError:
        raise UsageError(" ".join(texts), "is not NAME=NUMBER", "write it so, as --set sigma=2") from None


def _lesson(options: dict[str, Any]) -> TrainingConfig:
    from vidstyle.blade.features import Bins
    from vidstyle.blade.learn import TrainingConfig

    try:
        orientations, strengths, coherences = (int(part) for part in options["bins"].split("x"))
    except ValueError:
        raise UsageError(options["bins"], "is not three numbers", "write 16x5x3") from None
    if orientations < 2 or orientations % 2 or min(strengths, coherences) < 1:
        raise UsageError(
            options["bins"], "has bins that cannot be", "orientations are even, the rest above 0"
        )
    if options["size"] % 2 == 0 or not 3 <= options["size"] <= 15:
        raise UsageError(str(options["size"]), "is no size of a filter", "choose an odd number from 3 to 15")
    if not 0.3 <= options["rho"] <= 8:
        raise UsageError(f"{options['rho']:g}", "is no window", "choose a rho from 0.3 to 8")
    return TrainingConfig(Bins(orientations, strengths, coherences), options["rho"], options["size"])


def _for_teacher(lesson: TrainingConfig, teacher: ReferenceFilter) -> TrainingConfig:
    from dataclasses import replace

    return replace(lesson, sums=teacher.sums)


def _show(path: Path, target: Path) -> None:
    import cv2

    from vidstyle.blade.show import draw_bank

    drawn = draw_bank(_load(path))
    if not cv2.imwrite(str(target), drawn[..., ::-1]):
        raise UsageError(target, "cannot be written", "name a picture file, such as bank.png")


def _load(path: Path) -> Bank:
    from vidstyle.blade.bank import load_bank, shipped_banks
    from vidstyle.errors import InputError

    try:
        return load_bank(shipped_banks().get(str(path), path))
    except (ValueError, OSError) as error:
        raise InputError(path, str(error), "name a bank file, or one of ours") from None


def _fidelity_text(fidelity: dict[str, float], held: int) -> str:
    return (
        f"on {held} pictures not learned from: {fidelity['psnr']:.1f} dB, MSSIM {fidelity['mssim']:.4f} "
        f"(untouched: {fidelity['untouched psnr']:.1f} dB, {fidelity['untouched mssim']:.4f})"
    )


def _tell_progress(what: str, done: int, count: int) -> None:
    if done % SHOWN_EVERY == 0 or done == count:
        say(f"{what}: {done} of {count} pictures")
