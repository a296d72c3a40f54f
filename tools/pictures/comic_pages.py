"""Make the comic pages of the documentation: `python -m tools.pictures.comic_pages [docs]`.

comic.jpg is the comic page of the demo film; comic-photographs.jpg is made from public-domain photographs of
scikit-image and a subtitle file.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import skimage.data

from vidstyle.comic.make import ComicOptions, make_comic
from vidstyle.demo.make_demo import make_film, make_page

STORY = (
    ("coffee", "<i>Seven o'clock. One coffee.</i>", ""),
    ("rocket", "<i>Ten past seven. One rocket.</i>", "<i>[WHOOOSH]</i>"),
    ("astronaut", "What a view!", "Wait. Who is feeding the cat?"),
    ("chelsea", "Nobody is.", "<i>She will hear of this.</i>"),
)
"""Names of photographs, and the subtitles of each."""
PAGE_TITLE = "Ten past seven"
PAGE_STYLE, PAGE_SIZE = "watercolor", "a5"
PICTURE_WIDTH_PX, JPEG_QUALITY = 827, 88


def main() -> None:
    """Write both pictures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("docs", nargs="?", type=Path, default=Path("docs"), help="the folder to write to")
    docs = parser.parse_args().docs
    with TemporaryDirectory() as name:
        folder = Path(name)
        make_film(folder / "film.mp4")
        write_smaller(make_page(folder / "film.mp4", folder / "film.png"), docs / "comic.jpg")
        write_smaller(make_photograph_page(folder), docs / "comic-photographs.jpg")


def make_photograph_page(folder: Path) -> Path:
    """Make the page of `STORY` with photographs and subtitles in the same folder, and return its path."""
    (folder / "photographs").mkdir()
    events: list[str] = []
    for number, (name, *said) in enumerate(STORY):
        picture = getattr(skimage.data, name)()
        cv2.imwrite(str(folder / "photographs" / f"{number}-{name}.png"), picture[..., ::-1])
        for part, text in enumerate(filter(None, said)):
            # Each picture of a folder is shown for one second.
            times = (f"00:00:{number:02},{milliseconds}" for milliseconds in (f"{part}00", f"{part + 1}99"))
            events.append(f"{len(events) + 1}\n{' --> '.join(times)}\n{text}\n")
    (folder / "story.srt").write_text("\n".join(events), encoding="utf-8")
    options = ComicOptions(
        styles=(PAGE_STYLE,),
        size=PAGE_SIZE,
        title=PAGE_TITLE,
        subtitles=str(folder / "story.srt"),
    )
    return make_comic(folder / "photographs", folder / "photographs.png", options).files[0]


def write_smaller(page: Path, target: Path) -> None:
    """Save a comic page at the size used in the documentation."""
    picture = cv2.imread(str(page))
    assert picture is not None
    size = PICTURE_WIDTH_PX, round(PICTURE_WIDTH_PX * picture.shape[0] / picture.shape[1])
    smaller = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(target), smaller, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])


if __name__ == "__main__":
    main()
