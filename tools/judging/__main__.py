"""Restyle photographs and clips at full size, and write a page for judging the results by eye.

    python -m tools.judging FOLDER [-o PAGE_FOLDER] [--styles ink ...] [--height 1080]

The page has a column for each style and a row for each picture. All cells show the same crop at 1:1: drag one
to move all, double-click one for the full picture. Clips have the frames n, n + 1 and n + 5: keys 1, 2 and 3
switch between them, which makes flicker visible. Key 0 shows the source.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path

import cv2
import numpy as np

from vidstyle.errors import VidstyleError
from vidstyle.preview.clip import open_clip
from vidstyle.renderer import Renderer, stylize
from vidstyle.style import load_style, style_names

OFFSETS_FRAMES = (0, 1, 5)
"""Positions of the frames of a clip that are shown, from the middle frame on."""
PAGE = Path(__file__).with_name("page.html")


def main() -> None:
    """Write the pictures and the page, and print the path of the page."""
    options = _parse_options()
    folder: Path = options.output
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for path in sorted(options.folder.iterdir()):
        try:
            frames = read_frames(path, options.height)
        except VidstyleError as error:
            print(error, file=sys.stderr)
            continue
        print(path.name, file=sys.stderr, flush=True)
        rows.append(write_row(path.name, frames, options.styles, folder))
    head = "".join(f"<th>{escape(name)}</th>" for name in options.styles)
    page = folder / "index.html"
    page.write_text(PAGE.read_text().replace("$head", head).replace("$rows", "\n".join(rows)))
    print(page)


def _parse_options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder of photographs and clips")
    parser.add_argument("-o", "--output", type=Path, default=Path("build/judging"))
    parser.add_argument("--styles", nargs="+", default=[name for name in style_names() if name != "plain"])
    parser.add_argument("--height", type=int, help="length of the shorter side; default: unchanged")
    return parser.parse_args()


def read_frames(path: Path, side: int | None) -> list[np.ndarray]:
    """Return the frames of a clip at `OFFSETS_FRAMES`, or a single photograph, H x W x 3 uint8 RGB each.

    Args:
        side: length of the shorter side in pixels; None: unchanged.

    Raises:
        VidstyleError: the file is neither a clip nor a photograph.
    """
    clip = open_clip(path)
    try:
        middle = clip.count // 2
        numbers = sorted({min(middle + step, clip.count - 1) for step in OFFSETS_FRAMES})
        return [clip.frame(number, side) for number in numbers]
    finally:
        clip.close()


def restyle_frames(frames: list[np.ndarray], name: str) -> Iterator[np.ndarray]:
    """Restyle frames as in a film of 24 frames per second; the frames between them are skipped.

    The noise of a single photograph is removed first, as by `render`.
    """
    if len(frames) == 1:
        yield stylize(frames[0], name, "cpu")
        return
    with Renderer(load_style(name), "cpu") as renderer:
        for number, frame in enumerate(frames):
            yield renderer(frame, OFFSETS_FRAMES[number] / 24)


def write_row(name: str, frames: list[np.ndarray], styles: list[str], folder: Path) -> str:
    """Write the pictures of one row of the page and return its HTML."""
    sources = _write_pictures(frames, folder, f"{name}-source")
    cells = []
    for style in styles:
        pictures = _write_pictures(restyle_frames(frames, style), folder, f"{name}-{style}")
        cells.append(f'<td><img data-frames="{" ".join(pictures)}" data-source="{" ".join(sources)}"></td>')
    return f"<tr><th>{escape(name)}</th>{''.join(cells)}</tr>"


def _write_pictures(pictures: Iterator[np.ndarray] | list[np.ndarray], folder: Path, stem: str) -> list[str]:
    names = []
    for number, picture in enumerate(pictures):
        names.append(f"{stem}-{number}.webp".replace(" ", "_"))
        cv2.imwrite(str(folder / names[-1]), picture[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, 95])
    return names


if __name__ == "__main__":
    main()
