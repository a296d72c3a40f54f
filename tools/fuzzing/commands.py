"""Cases through the commands, with their exit codes, messages, outputs and numbers of frames."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from tools.fuzzing.frame_counts import check_frames
from tools.fuzzing.processes import BrokenPromiseError, Ended, run_apart
from vidstyle.errors import InputError, UsageError
from vidstyle.pipeline.render import DAMAGED_EXIT_CODE

UNUSABLE = InputError.exit_code
ALLOWED_EXIT_CODES = {0, UsageError.exit_code, UNUSABLE, DAMAGED_EXIT_CODE}
"""Of a command with a damaged input (docs/rules.md, Exit codes); 2: of a size that no encoder takes."""
TARGETS = ("out_%05d.png", "out.mkv", "out.mp4", "out.avi", "out.mov", "out.ts")
"""What films and pictures become: sound and subtitles are copied, converted or left out."""
PAGE_ENDINGS = (".png", ".svg", ".pdf", ".cbz", ".html", ".jpg")
QUIET = ("--progress", "none", "--log-level", "error")

Command = Callable[[Path, Path, str, int], list[str | Path]]
"""Arguments of the program for a file, a folder for what it writes, a style and a number that chooses."""


def _render(path: Path, folder: Path, style: str, choice: int) -> list[str | Path]:
    target = folder / TARGETS[choice % len(TARGETS)]
    return ["render", path, target, "--style", ("plain", style)[choice % 2], "--json", *QUIET]


def page_command(path: Path, folder: Path, style: str, choice: int) -> list[str | Path]:
    """The comic of a page file, which has decided size and styles."""
    return ["comic", path, folder / f"page{PAGE_ENDINGS[choice % len(PAGE_ENDINGS)]}", *QUIET]


def _comic(path: Path, folder: Path, style: str, choice: int) -> list[str | Path]:
    made = page_command(path, folder, style, choice)
    return [*made, "--size", "320x240", "--style", style]


def _preview(path: Path, folder: Path, style: str, choice: int) -> list[str | Path]:
    return ["styles", style, "--preview", path, "-o", folder / "preview.png", "--no-open", *QUIET]


def _explore(path: Path, folder: Path, style: str, choice: int) -> list[str | Path]:
    return ["explore", path, "-o", folder / "found", "--count", "1", "--tries", "2", *QUIET]


COMMANDS: tuple[Command, ...] = (_render, _render, _render, _render, _comic, _preview, _explore)


def try_command(
    path: Path, folder: Path, style: str, choice: int, commands: tuple[Command, ...] = COMMANDS
) -> None:
    """Run one of the commands in a process of its own.

    Raises:
        BrokenPromiseError: it does not keep to docs/rules.md.
        InputError: it has refused the file.
    """
    arguments = commands[choice % len(commands)](path, folder, style, choice // len(commands))
    ended = run_apart(["-m", "vidstyle", *arguments])
    check(ended, folder)
    if arguments[0] == "render" and ended.exit_code == 0:
        check_frames(path, json.loads(ended.output)["frames"])


def check(ended: Ended, folder: Path) -> None:
    """Compare how a command has ended with docs/rules.md.

    Args:
        ended: the run.
        folder: what it has written into; empty before.

    Raises:
        BrokenPromiseError: another exit code, other than one line for an error, or a wrong set of files.
        InputError: the command has refused the file.
    """
    said = ended.lines[-1] if ended.lines else "nothing said"
    written = sorted(each.name for each in folder.iterdir())
    if ended.exit_code not in ALLOWED_EXIT_CODES:
        raise BrokenPromiseError(f"exit {ended.exit_code}: {said}")
    if ended.exit_code in (0, DAMAGED_EXIT_CODE):
        if not written or any(".partial." in name for name in written):
            raise BrokenPromiseError(f"exit {ended.exit_code} with the files {written}: {said}")
        return
    if len(ended.lines) != 1:
        raise BrokenPromiseError(f"exit {ended.exit_code} with {len(ended.lines)} lines: {ended.lines}")
    if written:
        raise BrokenPromiseError(f"exit {ended.exit_code} with the files {written}: {said}")
    raise InputError("the file", f"was refused: {said}")
