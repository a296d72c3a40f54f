"""Draws styles on photographs and clips at full size, as a page for judging them.

    python -m tools.judging FOLDER [-o PAGE_FOLDER] [--styles ink ...] [--height 1080]

The page shows styles across and pictures down, each as a part at 1:1 that all cells share: drag one to move
all, and double-click it for the whole picture. Of a clip there are the frames n, n + 1 and n + 5: 1, 2 and 3
change between them, and flicker is seen at once. 0 shows the source.
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

STEPS = (0, 1, 5)
"""Frames of a clip that are kept, from the one in its middle."""
PAGE = Path(__file__).with_name("page.html")


def main() -> None:
    """Write the pictures and the page, and say where it is."""
    options = _options()
    folder: Path = options.output
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for path in sorted(options.folder.iterdir()):
        try:
            frames = frames_of(path, options.height)
        except VidstyleError as error:
            print(error, file=sys.stderr)
            continue
        print(path.name, file=sys.stderr, flush=True)
        rows.append(row(path.name, frames, options.styles, folder))
    head = "".join(f"<th>{escape(name)}</th>" for name in options.styles)
    page = folder / "index.html"
    page.write_text(PAGE.read_text().replace("$head", head).replace("$rows", "\n".join(rows)))
    print(page)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="photographs and clips")
    parser.add_argument("-o", "--output", type=Path, default=Path("build/judging"))
    parser.add_argument("--styles", nargs="+", default=[name for name in style_names() if name != "plain"])
    parser.add_argument("--height", type=int, help="the shorter side; without it pictures stay as they are")
    return parser.parse_args()


def frames_of(path: Path, side: int | None) -> list[np.ndarray]:
    """The frames of a clip that are judged, or a photograph alone.

    Raises:
        VidstyleError: it is neither.
    """
    clip = open_clip(path)
    try:
        middle = clip.count // 2
        numbers = sorted({min(middle + step, clip.count - 1) for step in STEPS})
        return [clip.frame(number, side) for number in numbers]
    finally:
        clip.close()


def restyled(frames: list[np.ndarray], name: str) -> Iterator[np.ndarray]:
    """The frames one after another, as in a film of 24 frames a second, those between left out.

    A photograph has no time: its noise is flattened, as in `render`.
    """
    if len(frames) == 1:
        yield stylize(frames[0], name, "cpu")
        return
    with Renderer(load_style(name), "cpu") as renderer:
        for number, frame in enumerate(frames):
            yield renderer(frame, STEPS[number] / 24)


def row(name: str, frames: list[np.ndarray], styles: list[str], folder: Path) -> str:
    """Write the pictures of one row and return its cells."""
    sources = _write(frames, folder, f"{name}-source")
    cells = []
    for style in styles:
        pictures = _write(restyled(frames, style), folder, f"{name}-{style}")
        cells.append(f'<td><img data-frames="{" ".join(pictures)}" data-source="{" ".join(sources)}"></td>')
    return f"<tr><th>{escape(name)}</th>{''.join(cells)}</tr>"


def _write(pictures: Iterator[np.ndarray] | list[np.ndarray], folder: Path, stem: str) -> list[str]:
    names = []
    for number, picture in enumerate(pictures):
        names.append(f"{stem}-{number}.webp".replace(" ", "_"))
        cv2.imwrite(str(folder / names[-1]), picture[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, 95])
    return names


if __name__ == "__main__":
    main()
