"""Give files to commands, and check exit codes, messages, output files and frame counts."""

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
"""Exit codes of commands with damaged input (docs/rules.md); 2 is for sizes that no encoder accepts."""
TARGETS = ("out_%05d.png", "out.mkv", "out.mp4", "out.avi", "out.mov", "out.ts")
"""Output files; the container decides whether sound and subtitles are copied, converted or dropped."""
PAGE_ENDINGS = (".png", ".svg", ".pdf", ".cbz", ".html", ".jpg")
QUIET = ("--progress", "none", "--log-level", "error")

Command = Callable[[Path, Path, str, int], list[str | Path]]
"""Returns arguments of the program for a file, an output folder, a style and a random number."""


def _render(path: Path, folder: Path, style: str, choice: int) -> list[str | Path]:
    target = folder / TARGETS[choice % len(TARGETS)]
    return ["render", path, target, "--style", ("plain", style)[choice % 2], "--json", *QUIET]


def page_command(path: Path, folder: Path, style: str, choice: int) -> list[str | Path]:
    """Return the command for the comic of a page file, which sets size and styles."""
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
    """Run one of the commands in a separate process.

    Raises:
        BrokenPromiseError: the command violates docs/rules.md.
        InputError: the command refused the file.
    """
    arguments = commands[choice % len(commands)](path, folder, style, choice // len(commands))
    ended = run_apart(["-m", "vidstyle", *arguments])
    check_end(ended, folder)
    if arguments[0] == "render" and ended.exit_code == 0:
        check_frames(path, json.loads(ended.output)["frames"])


def check_end(ended: Ended, folder: Path) -> None:
    """Check the end of a command against docs/rules.md.

    Args:
        ended: the finished command.
        folder: its output folder, which was empty before.

    Raises:
        BrokenPromiseError: wrong exit code, more or fewer than one line for an error, or wrong output files.
        InputError: the command refused the file.
    """
    message = ended.lines[-1] if ended.lines else "no message"
    written = sorted(each.name for each in folder.iterdir())
    if ended.exit_code not in ALLOWED_EXIT_CODES:
        raise BrokenPromiseError(f"exit {ended.exit_code}: {message}")
    if ended.exit_code in (0, DAMAGED_EXIT_CODE):
        if not written or any(".partial." in name for name in written):
            raise BrokenPromiseError(f"exit {ended.exit_code} with the files {written}: {message}")
        return
    if len(ended.lines) != 1:
        raise BrokenPromiseError(f"exit {ended.exit_code} with {len(ended.lines)} lines: {ended.lines}")
    if written:
        raise BrokenPromiseError(f"exit {ended.exit_code} with the files {written}: {message}")
    raise InputError("the file", f"was refused: {message}")
