"""Use a file according to the ending of its name."""

from __future__ import annotations

import contextlib
import shutil
import zlib
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from media import moving_frames
from PIL import Image

from tools.fuzzing.arrays import VIEWS, to_native
from tools.fuzzing.commands import (
    ALLOWED_EXIT_CODES,
    PAGE_ENDINGS,
    TARGETS,
    UNUSABLE,
    page_command,
    try_command,
)
from tools.fuzzing.frame_counts import check_frames, check_refusal
from tools.fuzzing.kernel_caches import try_cache
from tools.fuzzing.originals import PICTURE_SIZE
from tools.fuzzing.processes import BrokenPromiseError, run_here
from vidstyle.comic.make import ComicOptions, make_comic
from vidstyle.cues.cue_file import read_cue_file
from vidstyle.errors import UsageError, VidstyleError
from vidstyle.media.options import ReadOptions
from vidstyle.pipeline.render import render
from vidstyle.regions.chosen_files import MODEL_VARIABLE, use_file
from vidstyle.renderer import Renderer, stylize
from vidstyle.style import load_style, save_style, style_names

DELIBERATE_REFUSALS = ("its colours are coded with",)
"""Errors for films that FFmpeg decodes with wrong colours."""
COMMAND_RATIO = 12
"""One in this many films, pictures and page files is given to a command in a separate process."""

FLOAT_TOLERANCE = 1e-4
"""Channels that share memory are processed together, with other rounding; integers must be equal."""


def attempt(path: Path, folder: Path) -> None:
    """Use a file according to its ending.

    Args:
        folder: an empty folder for the output.

    Raises:
        VidstyleError: the file is refused.
        BrokenPromiseError: the program violates a promise of docs/reliability.md.
    """
    ending = path.name[path.name.index(".") :]
    ATTEMPTS.get(ending, _try_media)(path, folder, zlib.crc32(path.read_bytes()))


def _try_media(path: Path, folder: Path, choice: int) -> None:
    """Restyle a film or picture; make comics of some; give some to a command."""
    style = _style_for(choice)
    if choice // 64 % COMMAND_RATIO == 0:
        return try_command(path, folder, style, choice // 1024)
    try:
        summary = render(path, folder / TARGETS[(choice >> 8) % len(TARGETS)], style)
    except VidstyleError as error:
        if error.exit_code not in ALLOWED_EXIT_CODES:
            raise BrokenPromiseError(f"exit {error.exit_code}: {error}") from error
        if error.exit_code == UNUSABLE and not any(each in str(error) for each in DELIBERATE_REFUSALS):
            check_refusal(path)
        raise
    if summary.exit_code == 0:
        check_frames(path, summary.frames)
    if choice % 8 == 0:
        make_comic(path, folder / "page.png", ComicOptions(size="320x240"))


def _style_for(choice: int) -> str:
    names = style_names()
    return names[choice % len(names)]


def _try_array(path: Path, folder: Path, choice: int) -> None:
    """Restyle a view of the array and its contiguous copy: both must be refused or give the same picture."""
    array = np.load(path)
    view = array if array.ndim < 3 or not array.size else VIEWS[(choice >> 8) % len(VIEWS)](array)
    before, results = view.copy(), [_try_stylize(each, choice) for each in (to_native(view), view)]
    if not np.array_equal(before, view, equal_nan=view.dtype.kind in "fc"):
        raise BrokenPromiseError("the array was changed")
    native, other = results
    if isinstance(native, VidstyleError) and isinstance(other, VidstyleError):
        raise native
    if isinstance(native, VidstyleError) or isinstance(other, VidstyleError):
        raise BrokenPromiseError(f"one layout is refused: {results}"[:200])
    if native.shape != other.shape or not np.allclose(native, other, rtol=0, atol=FLOAT_TOLERANCE):
        raise BrokenPromiseError("another result for another layout")


def _try_stylize(array: np.ndarray, choice: int) -> np.ndarray | VidstyleError:
    try:
        return stylize(array, _style_for(choice))
    except VidstyleError as error:
        return error


def _try_style(path: Path, folder: Path, choice: int) -> None:
    """Load, save and reload a style, and restyle three frames in it and its variants."""
    style = load_style(path)
    save_style(style, shutil.copy(path, folder / "copy.toml"))
    load_style(folder / "copy.toml")
    for name in ("", *(f":{variant}" for variant in style.variants)):
        with Renderer(load_style(f"{path}{name}"), device="cpu") as renderer:
            for picture in moving_frames(3, PICTURE_SIZE):
                renderer(picture)


def _try_bank(path: Path, folder: Path, choice: int) -> None:
    """Use a bank in a style file in the same folder."""
    style = folder / "style.toml"
    step = f'block = "learned"\nbank = "bank.npz"\npasses = {choice % 8 + 1}'
    style.write_text(f"format = 1\n[[base]]\n{step}\n[[background]]\nblock = 'posterize'\n")
    shutil.copy(path, folder / "bank.npz")
    _try_style(style, folder, choice)


def _try_network(path: Path, folder: Path, choice: int) -> None:
    """Use a network in a style file in the same folder."""
    style = folder / "style.toml"
    style.write_text("format = 1\n[[background]]\nblock = 'network'\nmodel = 'model.onnx'\n")
    shutil.copy(path, folder / "model.onnx")
    _try_style(style, folder, choice)


def _try_people(path: Path, folder: Path, choice: int) -> None:
    """Restyle three frames with `only = "people"` and the model, as with `--model`."""
    model = Path(shutil.copy(path, folder / f"model{path.suffix}"))
    style = load_style({"format": 1, "only": "people", "background": [{"block": "posterize"}]})
    with use_file(MODEL_VARIABLE, model), Renderer(style, device="cpu") as renderer:
        for picture in moving_frames(3, PICTURE_SIZE):
            renderer(picture)


def _try_cues(path: Path, folder: Path, choice: int) -> None:
    """Render three pictures with a cue file."""
    cues, target = folder / "case.toml", folder / TARGETS[choice % len(TARGETS)]
    shutil.copy(path, cues)
    render(
        _write_pictures(folder) / "*.png", target, read_cue_file(cues), read=ReadOptions(rate=Fraction(10))
    )


def _try_subtitles(path: Path, folder: Path, choice: int) -> None:
    """Make a comic of three pictures with a subtitle file."""
    options = ComicOptions(size="480x360", subtitles=str(path))
    make_comic(_write_pictures(folder), folder / "page.png", options)


def _try_page(path: Path, folder: Path, choice: int) -> None:
    """Make the comic of a page file with three pictures."""
    page, made = folder / "case.toml", folder / "made"
    shutil.copy(path, page)
    made.mkdir()
    _write_pictures(folder)
    if choice // 64 % COMMAND_RATIO == 0:
        return try_command(page, made, "", choice // 1024, (page_command,))
    make_comic(page, made / f"page{PAGE_ENDINGS[choice % len(PAGE_ENDINGS)]}", ComicOptions())
    for drawing in made.glob("*.svg"):
        ElementTree.parse(drawing)


def _try_config(path: Path, folder: Path, choice: int) -> None:
    """Run a command with a configuration file."""
    made = folder / "made"
    made.mkdir()
    picture = _write_pictures(folder) / "0.png"
    arguments = (
        ["styles", "plain"],
        ["render", picture, made / "out.png"],
        ["comic", picture, made / "page.png"],
    )
    with contextlib.chdir(made):
        ended = run_here(["--config", path.absolute(), *arguments[choice % 3]])
    if ended.exit_code not in ALLOWED_EXIT_CODES:
        raise BrokenPromiseError(f"exit {ended.exit_code}: {ended.lines[-1]}")
    if ended.exit_code:
        raise UsageError("the configuration", ended.lines[-1])


def _write_pictures(folder: Path) -> Path:
    (pictures := folder / "pictures").mkdir()
    for number, picture in enumerate(moving_frames(3, (160, 120))):
        Image.fromarray(picture).save(pictures / f"{number}.png")
    return pictures


ATTEMPTS: dict[str, Callable[[Path, Path, int], None]] = {
    ".npy": _try_array,
    ".toml": _try_style,
    ".npz": _try_bank,
    ".onnx": _try_network,
    ".people.onnx": _try_people,
    ".people.tflite": _try_people,
    ".page.toml": _try_page,
    ".cues.toml": _try_cues,
    ".config.toml": _try_config,
    ".cache": lambda path, folder, _: try_cache(path, folder),
    **dict.fromkeys((".srt", ".vtt", ".ass"), _try_subtitles),
}
"""Functions by file ending; all other endings use `_try_media`."""
