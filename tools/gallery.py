"""Shows what every style does: `python tools/gallery.py [docs]` writes gallery.md, gallery/ and styles.webp.

Each style on three photographs, its variants, the picture after each of its steps, and its graph; styles.webp
is animated: our own film, the style changing every second.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from textwrap import fill

import cv2
import numpy as np
import skimage.data
from animation import animation
from progression import progression

from vidstyle.bench.paper_figures import figure_for
from vidstyle.diagram.graph import graph_of
from vidstyle.diagram.svg import graph_svg
from vidstyle.gallery.samples import encoded, labelled, samples_of, sheet_of
from vidstyle.style import PLAIN, Style, load_style, style_names

PHOTOGRAPHS = {
    "astronaut": skimage.data.astronaut()[:384],
    "coffee": skimage.data.coffee()[:, 33:566],
    "rocket": skimage.data.rocket()[:, 35:604],
}
"""Parts of public-domain photographs, 4 : 3."""
FACE = np.s_[20:340, 265:585]
"""Where the astronaut's face is when the photograph has the full size: what is shown of each step."""

FULL = 960, 720
"""The size at which pictures are restyled, in pixels; lengths of styles are meant for it."""
SHOWN, STEP, VARIANT = (480, 360), (176, 176), (256, 192)
"""The sizes to which results, steps and variants are then reduced."""
COLUMNS = 6
"""Of a sheet of steps."""

HEAD = """\
# The styles

Each style on three photographs ({photographs}; in the public domain, from scikit-image), restyled at
{width} x {height} and shown smaller; click one to see it larger. Below them is a part of the first after each
step of the style, from the source to the result; lines are shown before they become ink. Some were made after
styles that a paper describes in words: Garcia-Dorado et al., IET Computer Vision 2020. Drawn by
`tools/gallery.py`.

{contents}

## source

{row}
"""

SECTION = """
## {name}

{note}

{about}

{row}

![{name}, step by step]({folder}/{name}-steps.jpg)
{variants}
<details>
<summary>The graph of {name}</summary>

![The blocks of {name} and what goes from one to the other]({folder}/{name}.svg)

</details>
"""


def main() -> None:
    """Draw everything, and say how large it is."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("docs", type=Path, nargs="?", default=Path("docs"))
    docs: Path = parser.parse_args().docs
    folder = docs / "gallery"
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    styles = sorted(map(load_style, set(style_names()) - {PLAIN}), key=_order)
    for name, content in drawings(styles):
        (folder / name).write_bytes(content)
    (docs / "gallery.md").write_text(page(styles, folder.name), encoding="utf-8")
    (docs / "styles.webp").write_bytes(animation())
    size = sum(made.stat().st_size for made in folder.iterdir())
    print(f"{docs / 'gallery.md'}, {folder} ({size / 1e6:.1f} MB), {docs / 'styles.webp'}")


def drawings(styles: list[Style]) -> Iterator[tuple[str, bytes]]:
    """All files of the gallery's folder, with their names."""
    photographs = {
        name: cv2.resize(photograph, FULL, interpolation=cv2.INTER_CUBIC)
        for name, photograph in PHOTOGRAPHS.items()
    }
    for name, photograph in photographs.items():
        yield f"source-{name}.jpg", _jpeg(photograph, SHOWN)
        for sample in samples_of(photograph, styles):
            yield f"{sample.style.name}-{name}.jpg", _jpeg(sample.picture, SHOWN)
    first = photographs["astronaut"]
    for style in styles:
        yield f"{style.name}.svg", graph_svg(graph_of(style), style.name).encode()
        yield f"{style.name}-steps.jpg", encoded(_steps(first, style), ".jpg")
        if style.variants:
            yield f"{style.name}-variants.jpg", encoded(_variants(first, style), ".jpg")


def page(styles: list[Style], folder: str) -> str:
    """The text of the page.

    Args:
        styles: in the order in which they are shown.
        folder: where the pictures are, as seen from the page.
    """
    sentences = {style.name: style.note.partition(". ")[0].rstrip(".") for style in styles}
    contents = "\n".join(f"- [{name}](#{name}): {sentence}." for name, sentence in sentences.items())
    width, height = FULL
    head = HEAD.format(
        photographs=", ".join(PHOTOGRAPHS),
        width=width,
        height=height,
        contents=contents,
        row=_row("source", folder),
    )
    return head + "".join(_section(style, folder) for style in styles)


def _section(style: Style, folder: str) -> str:
    figure = figure_for(style.name)
    origin = f"Made after the paper's style {figure.style}." if figure else "Our own."
    names = _variant_names(style)
    variants = f"\n![{', '.join(names)}]({folder}/{style.name}-variants.jpg)\n" if names else ""
    told = f" Variants: {', '.join(f'`{name}`' for name in names)}." if names else ""
    return SECTION.format(
        name=style.name,
        note=fill(style.note, 110, break_on_hyphens=False),
        about=f"{origin} `--style {style.name}`.{told}",
        row=_row(style.name, folder),
        folder=folder,
        variants=variants,
    )


def _row(name: str, folder: str) -> str:
    return "\n".join(
        f'<img src="{folder}/{name}-{photograph}.jpg" alt="{name}: {photograph}" width="32%">'
        for photograph in PHOTOGRAPHS
    )


def _order(style: Style) -> tuple[int, str]:
    """Those of the paper first, by its numbers."""
    figure = figure_for(style.name)
    return figure.style if figure else 99, style.name


def _steps(photograph: np.ndarray, style: Style) -> np.ndarray:
    """A part of the picture after each step, from left to right and down."""
    return sheet_of(
        (
            labelled(_reduced(stage.picture[FACE], STEP), f"{stage.layer} {stage.name}".strip())
            for stage in progression(photograph, style)
        ),
        COLUMNS,
    )


def _variants(photograph: np.ndarray, style: Style) -> np.ndarray:
    samples = samples_of(photograph, (load_style(name) for name in _variant_names(style)))
    pictures = [labelled(_reduced(sample.picture, VARIANT), sample.style.name) for sample in samples]
    return sheet_of(pictures, len(pictures))


def _variant_names(style: Style) -> list[str]:
    return [f"{style.name}:{variant}" for variant in style.variants]


def _jpeg(picture: np.ndarray, size: tuple[int, int]) -> bytes:
    return encoded(_reduced(picture, size), ".jpg")


def _reduced(picture: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


if __name__ == "__main__":
    main()
