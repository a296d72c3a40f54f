"""Comics from end to end: output files are valid and reproducible, and existing files are safe."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from base64 import b64decode
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZIP_STORED, ZipFile

import cv2
import numpy as np
import pytest
from faults import remux
from media import make_clip, photograph
from PIL import Image
from stories import PLACES, shot, story, view, write_film

from vidstyle.cli import main
from vidstyle.cli.comic import comic
from vidstyle.comic.lettering import fonts
from vidstyle.comic.lettering.bubble import Bubble, break_text, bubble_size
from vidstyle.comic.lettering.fonts import Letters
from vidstyle.comic.output.paper_scale import scale_to_paper
from vidstyle.comic.output.raster import page_image
from vidstyle.comic.output.sheet import Label, RenderedPanel, Sheet
from vidstyle.comic.output.svg import svg
from vidstyle.comic.output.write import _PAGE_ENCODERS, Output
from vidstyle.errors import OutputError, UsageError
from vidstyle.media.read.subtitles import read_subtitles
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.style import load_style
from vidstyle.style.resolve import resolve

WORDS = (
    "1\n00:00:00,000 --> 00:00:00,900\nHello <b>you</b> & me.\n\n2\n00:00:01,100 --> 00:00:01,900\n[knocks]\n"
)
NAMES = "{urn:oasis:names:tc:opendocument:xmlns:container}"
SUFFIXES = "png jpg jpeg svg pdf cbz epub html".split()


@pytest.fixture(autouse=True)
def no_fonts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ignore installed fonts, so that pages are the same on every machine."""
    monkeypatch.setattr(fonts, "FONT_FOLDERS", ())


def test_every_format_is_tested_and_named_in_the_help() -> None:
    assert {f".{suffix}" for suffix in SUFFIXES} == _PAGE_ENCODERS.keys()
    assert comic.help is not None
    assert all(f".{suffix}" in comic.help for suffix in SUFFIXES if suffix != "jpeg")


def sheet(number: int) -> Sheet:
    """Return a page with a panel, a balloon with a tail, a caption and a label."""
    letters = Letters()
    block = break_text(letters, f"Is this page {number}?", 14, 90)[-1]
    width, height = bubble_size("balloon", block)
    panel = Rectangle(10, 10, 190, 130)
    bubbles = (
        Bubble("balloon", Box(20, 20, 20 + width, 20 + height), block, (150.0, 110.0)),
        Bubble("caption", Box(20, 100, 110, 122), break_text(letters, "Yes & <no>", 12, 90)[0]),
    )
    picture = Rectangle(12, 12, 188, 128)
    color = cv2.resize(photograph("coffee"), (picture.width, picture.height))
    return Sheet(
        *(200, 160, 100.0, letters),
        [RenderedPanel(panel, picture, color, bubbles, "0:01.0: <b>")],
        [Label(f"{number}", 100, 150, 10, is_bold=True)],
    )


def write_sheets(target: Path, count: int, title: str = 'A & "B"', overwrite: bool = False) -> list[Path]:
    return Output(target, "film.mp4", overwrite).write(
        (sheet(number) for number in range(count)), count, title
    )


@pytest.mark.parametrize("ending", SUFFIXES)
@pytest.mark.parametrize("count", [1, 3])
def test_every_format_can_be_opened(ending: str, count: int, tmp_path: Path) -> None:
    files = write_sheets(tmp_path / f"page.{ending}", count)
    assert sorted(files) == sorted(tmp_path.iterdir())
    if ending in ("png", "jpg", "jpeg", "svg") and count == 3:
        assert [file.name for file in files] == [f"page-{number}.{ending}" for number in (1, 2, 3)]
    else:
        assert [file.name for file in files] == [f"page.{ending}"]
    assert pages_in(files) == [(200, 160)] * count


def test_a_strip_embeds_one_font_and_numbers_its_panels(tmp_path: Path) -> None:
    (file,) = write_sheets(tmp_path / "strip.html", 3)
    text = file.read_text(encoding="utf-8")
    assert re.findall(r'id="(panel-\d+)"', text) == ["panel-1", "panel-2", "panel-3"]
    assert text.count("@font-face") == 1


def pages_in(files: Sequence[Path]) -> list[tuple[int, int]]:
    """Return width and height of all pages, in pixels."""
    found: list[tuple[int, int]] = []
    for file in files:
        content = file.read_bytes()
        if file.suffix in (".png", ".jpg", ".jpeg"):
            with Image.open(file) as image:
                image.load()
                assert image.info["dpi"] == pytest.approx((100, 100), abs=0.1)
                found.append(image.size)
        elif file.suffix == ".pdf":
            assert b"Date" not in content
            assert content.startswith(b"%PDF") and content.rstrip().endswith(b"%%EOF")
            # 200 x 160 pixels, 100 to the inch, in points.
            found += [(200, 160)] * content.count(b"/MediaBox [ 0 0 144.0 115.2 ]")
        elif file.suffix == ".cbz":
            with ZipFile(file) as archive:
                assert archive.testzip() is None
                *names, info = sorted(archive.namelist(), key=lambda name: (name.endswith("xml"), name))
                found += [Image.open(BytesIO(archive.read(name))).size for name in names]
                root = ElementTree.fromstring(archive.read(info))
                info_texts = [root.findtext(name) for name in ("Title", "PageCount", "Manga")]
                assert info_texts == ['A & "B"', str(len(found)), "No"]
        elif file.suffix == ".epub":
            found += pages_in_epub(content)
        else:
            found += [tuple(map(int, each.attrib["viewBox"].split()[2:])) for each in drawings(content)]  # type: ignore[misc]
    return found


def pages_in_epub(content: bytes) -> list[tuple[int, int]]:
    """Return the sizes of the pages in the order of reading, by following the references as readers do."""
    package, pages = "{http://www.idpf.org/2007/opf}", list[tuple[int, int]]()
    with ZipFile(BytesIO(content)) as archive:
        first = archive.infolist()[0]
        assert (first.filename, first.compress_type, archive.read(first)) == (
            *("mimetype", ZIP_STORED, b"application/epub+zip"),
        )
        container = ElementTree.fromstring(archive.read("META-INF/container.xml"))
        root = ElementTree.fromstring(
            archive.read(next(container.iter(f"{NAMES}rootfile")).attrib["full-path"])
        )
        items = {each.attrib["id"]: each.attrib for each in root.iter(f"{package}item")}
        assert {each["href"] for each in items.values()} | {
            "mimetype",
            "META-INF/container.xml",
            "comic.opf",
        } == {*archive.namelist()}
        for reference in root.iter(f"{package}itemref"):
            page = ElementTree.fromstring(archive.read(items[reference.attrib["idref"]]["href"]))
            (picture,) = page.iter("{http://www.w3.org/1999/xhtml}img")
            assert "Is this" not in picture.attrib["alt"] and "0:01.0: <b>" in picture.attrib["alt"]
            pages.append(Image.open(BytesIO(archive.read(picture.attrib["src"]))).size)
    return pages


def drawings(content: bytes) -> list[ElementTree.Element]:
    text = content.decode()
    if text.startswith("<?xml"):
        return [ElementTree.fromstring(text)]
    return [
        ElementTree.fromstring(f"<svg{part.partition('</svg>')[0]}</svg>") for part in text.split("<svg")[1:]
    ]


@pytest.mark.parametrize("ending", SUFFIXES)
def test_the_same_pages_are_the_same_bytes(ending: str, tmp_path: Path) -> None:
    one, other = (write_sheets(tmp_path / f"{name}.{ending}", 1)[0].read_bytes() for name in "ab")
    assert one == other


def test_balloons_in_svg_are_shapes_and_text(tmp_path: Path) -> None:
    (root,) = drawings(write_sheets(tmp_path / "page.svg", 1)[0].read_bytes())
    name = "{http://www.w3.org/2000/svg}"
    assert len(root.findall(f".//{name}image")) == 1
    assert len(root.findall(f".//{name}polygon")) == 2
    texts = ["".join(each.itertext()) for each in root.findall(f".//{name}text")]
    assert [" ".join(text.split()) for text in texts] == ["Is this page 0?", "Yes & <no>", "0"]
    assert (root.findtext(f"{name}title")) == 'A & "B"'


def test_a_balloon_is_white_with_ink_and_the_picture_is_around_it() -> None:
    drawn, plain = np.asarray(page_image(sheet(1))), sheet(1)
    balloon = plain.panels[0].bubbles[0].box
    inside = drawn[
        int(balloon.top) + 2 : int(balloon.bottom) - 2, int(balloon.left) + 8 : int(balloon.right) - 8
    ]
    assert np.median(inside) == 255 and inside.min() < 60
    assert (drawn[125, 170] == plain.panels[0].color[113, 158]).all()
    assert drawn[10, 100].max() == 0 and drawn[5, 100].min() == 255


@pytest.mark.parametrize("ending", ["jpg", "cbz", "epub", "pdf", "png", "svg", "html"])
def test_pages_full_of_noise_are_written(ending: str, tmp_path: Path) -> None:
    """Noise needs more bytes than photographs."""
    color = np.random.default_rng(1).choice(np.array([0, 255], np.uint8), (700, 700, 3))
    whole = Rectangle(0, 0, 700, 700)
    dots = Sheet(700, 700, 150, Letters(), [RenderedPanel(whole, whole, color)])
    (file,) = Output(tmp_path / f"dots.{ending}", "film.mp4", False).write([dots], 1, "")
    assert file.stat().st_size > 100_000


def test_pdf_pages_have_the_resolution_of_print(tmp_path: Path) -> None:
    """Halftone dots at the resolution of a screen form a second screen in print."""
    for name, dpi in (("page.pdf", 300), ("page.PDF", 300), ("page.png", 150), ("page.cbz", 150)):
        assert Output(tmp_path / name, "film.mp4", False).dpi == dpi


def test_names_with_a_pattern_are_numbered(tmp_path: Path) -> None:
    files = write_sheets(tmp_path / "page%03d.png", 2)
    assert [file.name for file in files] == ["page001.png", "page002.png"]


def test_existing_files_are_kept(tmp_path: Path) -> None:
    kept = tmp_path / "page-2.png"
    kept.write_bytes(b"mine")
    with pytest.raises(UsageError, match="already exists"):
        write_sheets(tmp_path / "page.png", 3)
    assert list(tmp_path.iterdir()) == [kept] and kept.read_bytes() == b"mine"
    write_sheets(tmp_path / "page.png", 3, overwrite=True)
    assert kept.read_bytes() != b"mine"


def test_a_missing_folder_is_reported_at_once(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="its folder does not exist"):
        Output(tmp_path / "none" / "page.pdf", "film.mp4", False)


@pytest.mark.parametrize(("height", "width"), [(20, 30), (70, 90), (120, 180)])
def test_dots_have_the_same_size_on_paper_in_every_panel(height: int, width: int) -> None:
    cells = []
    for dpi in (300, 600):
        size = round(height * dpi / 25.4), round(width * dpi / 25.4)
        steps = resolve(scale_to_paper(load_style("comic"), *size, dpi), *size)["background"]
        cells.append(
            next(step.values["cell"] for step in steps if step.block and step.block.name == "halftone")
        )
    assert cells == pytest.approx([0.2625 * dpi / 25.4 for dpi in (300, 600)], rel=0.01)


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four shots of half a second each."""
    return write_film(tmp_path_factory.mktemp("film") / "film.mp4", story(4, 13))


def run(*arguments: object) -> int:
    return main(["comic", *map(str, arguments)])


def test_damage_of_a_film_is_reported_with_its_comic(
    film: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 4, as in `render`; for a page file the film is not analysed."""
    page, saved = tmp_path / "page.png", tmp_path / "comic.toml"
    damaged = tmp_path / "damaged.mkv"
    damaged.write_bytes(remux(film, tmp_path / "whole.mkv").read_bytes()[:-20000])
    assert run(damaged, page, "--size", "300x400", "--save", saved) == 4
    assert "damaged.mkv: the input is damaged: " in capsys.readouterr().err
    assert page.stat().st_size > 1000
    assert run(saved, page, "-y") == 0
    assert "is damaged" not in capsys.readouterr().err


def test_a_film_of_two_seconds_becomes_a_comic(film: Path, tmp_path: Path) -> None:
    (tmp_path / "words.srt").write_text(WORDS, encoding="utf-8")
    for name in ("one", "two"):
        assert 0 == run(
            *(film, tmp_path / f"{name}.svg", "--subtitles", tmp_path / "words.srt", "--size", "400x560"),
            *("--panels", 2, "--title", "Été", "--style", "comic,plain", "--pages", 1, "--device", "cpu"),
            *("--frames", tmp_path / name),
        )
    one, two = ((tmp_path / f"{name}.svg").read_bytes() for name in ("one", "two"))
    assert one == two
    (root,) = drawings(one)
    name = "{http://www.w3.org/2000/svg}"
    assert len(root.findall(f".//{name}image")) == 2
    shown = " ".join("".join(each.itertext()) for each in root.findall(f".//{name}text"))
    assert " ".join(shown.split()) == "HELLO YOU & ME. KNOCKS ÉTÉ"
    with (tmp_path / "one" / "frames.csv").open() as table:
        rows = list(csv.DictReader(table))
    times = [float(row["seconds"]) for row in rows]
    assert len(times) == 2 and times == sorted(set(times))
    for row in rows:
        with Image.open(tmp_path / "one" / row["file"]) as frame:
            assert frame.size == (256, 144)


def test_another_seed_is_another_page(film: Path, tmp_path: Path) -> None:
    for seed in (0, 1):
        assert 0 == run(
            *(film, tmp_path / f"{seed}.png", "--seed", seed, "--panels", 4),
            *("--size", "300x420", "--style", "plain"),
        )
    assert (tmp_path / "0.png").read_bytes() != (tmp_path / "1.png").read_bytes()


def test_panels_end_at_slanted_edges(tmp_path: Path) -> None:
    """As pixels and in SVG: paper beyond the edge, then ink, then the picture."""
    panel = RenderedPanel(
        Rectangle(10, 10, 90, 90),
        Rectangle(14, 14, 86, 86),
        np.full((72, 72, 3), 128, np.uint8),
        leans=(0, -8),
    )
    sheet = Sheet(100, 100, 72, Letters(), [panel])
    picture = np.asarray(page_image(sheet))[..., 0]
    # The right edge goes from 74 at the top to 90 at the bottom.
    for row, edge in ((20, 76), (80, 88)):
        assert picture[row, edge + 3] == 255 and picture[row, edge - 8] == 128
        assert (picture[row, edge - 4 : edge + 2] == 0).any()
    (root,) = drawings(svg([sheet], ""))
    name = "{http://www.w3.org/2000/svg}"
    (polygon, clip) = root.findall(f".//{name}polygon")
    assert polygon.get("points") == "10.0,10.0 74.0,10.0 90.0,90.0 10.0,90.0"
    assert root.find(f".//{name}clipPath") is not None and clip.get("points") != polygon.get("points")


def test_a_storyboard_shows_whole_pictures_with_times(film: Path, tmp_path: Path) -> None:
    assert 0 == run(film, tmp_path / "board.svg", "--storyboard", "--panels", 3, "--size", "600x400")
    (root,) = drawings((tmp_path / "board.svg").read_bytes())
    name = "{http://www.w3.org/2000/svg}"
    texts = [each.text or "" for each in root.findall(f".//{name}text")]
    assert len(texts) == 3 and texts == sorted(texts) and texts[0].startswith("0:00.")
    for image in root.findall(f".//{name}image"):
        width, height = (int(image.attrib[side]) for side in ("width", "height"))
        assert width / height == pytest.approx(256 / 144, rel=0.03)


def test_single_frames_and_folders_become_pages(tmp_path: Path) -> None:
    one = write_film(tmp_path / "one.mp4", shot(PLACES[0], 1))
    assert 0 == run(one, tmp_path / "one.pdf", "--size", "300x300", "--style", "plain")
    folder = tmp_path / "pictures"
    folder.mkdir()
    for number in range(3):
        cv2.imwrite(str(folder / f"{number}.png"), view(PLACES[number]))
    assert 0 == run(folder, tmp_path / "strip.html", "--style", "plain")
    (root,) = drawings((tmp_path / "strip.html").read_bytes())
    images = root.findall(".//{http://www.w3.org/2000/svg}image")
    assert len(images) == 3
    for image in images:  # twice the pixels of the page, as panels can be enlarged
        data = np.frombuffer(b64decode(image.attrib["href"].partition(",")[2]), np.uint8)
        height, width = cv2.imdecode(data, cv2.IMREAD_COLOR).shape[:2]
        assert (width, height) == tuple(2 * int(image.attrib[side]) for side in ("width", "height"))


@pytest.mark.parametrize("name", ["film.mkv", "film.mp4"])
def test_subtitles_in_the_film_are_used_by_default(name: str, tmp_path: Path) -> None:
    film = make_clip(tmp_path / name, frames=30, subtitles=["eng"], size=(160, 90))
    events = read_subtitles(film)
    assert [(event.start, event.end, event.text) for event in events] == [
        *[(0, 0.4, "eng line 1"), (0.5, 0.9, "eng line 2")]
    ]
    counts = []
    for more in ([], ["--subtitles", "none"]):
        target = tmp_path / f"{len(more)}.svg"
        assert 0 == run(film, target, "--size", "400x300", "--style", "plain", "--pages", 1, *more)
        counts.append(target.read_text().count("<text"))
    assert counts[0] > counts[1] == 0


def test_every_subtitle_is_placed_or_reported_with_its_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """More panels are added for many words; a requested number of panels is kept, and the rest reported."""
    film = write_film(tmp_path / "film.mp4", story(3, 50))
    texts = [f"These are the words number {number} of this film." for number in range(12)]
    (tmp_path / "words.srt").write_text(
        "".join(
            f"00:00:0{number / 2:.3f} --> 00:00:0{number / 2 + 0.4:.3f}\n{text}\n\n"
            for number, text in enumerate(texts)
        )
    )
    arguments = ["--subtitles", tmp_path / "words.srt", "--style", "plain"]
    assert 0 == run(film, tmp_path / "page.html", *arguments)
    svg = "{http://www.w3.org/2000/svg}"
    roots = drawings((tmp_path / "page.html").read_bytes())
    found = " ".join(text for root in roots for each in root.iter(f"{svg}text") for text in each.itertext())
    shown = " ".join(found.lower().split())
    assert [number for number in range(12) if f"number {number} of" not in shown] == []
    assert "not shown" not in capsys.readouterr().err
    assert 0 == run(film, tmp_path / "page.png", *arguments, "--panels", 1, "--size", "a5")
    said = capsys.readouterr().err
    omitted = said.partition("not shown, at ")[2].partition(";")[0].split(", ")
    assert 9 <= len(omitted) <= 12 and set(omitted) <= {f"0:{number / 2:04.1f}" for number in range(12)}


@pytest.mark.parametrize(
    ("places", "text"),
    [
        (1, "one panel: the film has 1.0 s, and its other frames show the same view;"),
        (2, "one panel: the film has 2.0 s, and its other views were rated lower;"),
        (3, "two panels: the film has 3.0 s,"),
    ],
)
def test_a_short_film_says_why_it_gets_few_panels(
    places: int, text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = [frame for place in PLACES[:places] for frame in shot(place, 25)]
    film = write_film(tmp_path / "film.mp4", frames)
    assert 0 == run(film, tmp_path / "page.png", "--style", "plain", "--size", "a5")
    assert text in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "code", "line"),
    [
        (["none.mp4", "a.png"], 3, "none.mp4: no such file"),
        (["empty", "a.png"], 3, "empty holds no pictures"),
        (["-", "a.png"], 2, "standard input can be read only once; save the film to a file"),
        (["words.srt", "a.bmp"], 2, "a.bmp cannot be a comic page; end its name in .png, .jpg, .jpeg, .pdf, "
         ".cbz, .epub, .svg or .html"),
        (["words.srt", "kept.png"], 2, "kept.png already exists; add -y to overwrite it, or choose another "
         "name"),
        (["none.mp4", "a.png", "--subtitles", "none.srt"], 3, "none.srt cannot be read: No such file"),
        (["none.mp4", "a.png", "--subtitles", "empty.srt"], 3, "empty.srt holds no subtitles"),
        (["none.mp4", "a.png", "--font", "words.srt"], 3, "words.srt is not a font; give a .ttf "
         "or .otf file"),
        (["none.mp4", "a.png", "--size", "b7"], 2, "b7 is not a paper size; give a3, a4, a5, letter, "
         "square, screen, strip, webtoon, 1200x1800 or 210x297mm"),
        (["none.mp4", "a.png", "--style", "nope"], 3, "nope"),
        (["none.mp4", "a.png", "--panels", "none"], 2, "'none' is not a number of panels or auto"),
        (["none.mp4", "a.png", "--skip", "12"], 2, "'12' is not a time range such as 0:10-0:25"),
        (["none.mp4", "a.png", "--at", "1,x"], 2, "'x' is not a time such as 12.5 or 1:02:03.5"),
    ],
)  # fmt: skip
def test_errors_are_one_line(
    arguments: list[str],
    code: int,
    line: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    for name, text in (("words.srt", WORDS), ("empty.srt", ""), ("kept.png", "mine")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    assert run(*arguments) == code
    (said,) = capsys.readouterr().err.splitlines()
    assert line in said
    assert sorted(tmp_path.rglob("*")) == before and (tmp_path / "kept.png").read_text() == "mine"


def test_without_pillow_the_error_names_the_package(tmp_path: Path) -> None:
    program = (
        "import sys\nsys.modules['PIL'] = None\nfrom vidstyle.cli import main\n"
        f"sys.exit(main(['comic', 'film.mp4', {str(tmp_path / 'a.png')!r}]))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == "vidstyle: comic needs Pillow; pip install 'vidstyle[comic]'\n"
