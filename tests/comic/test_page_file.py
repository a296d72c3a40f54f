"""Editable comics: a saved comic is reproduced byte for byte, and edits change only what they concern."""

from __future__ import annotations

import base64
import json
import os
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from browser import Browser
from stories import story, write_film
from waiting import eventually

from vidstyle.comic.lettering.characters import xml_text
from vidstyle.comic.lettering.fonts import Letters
from vidstyle.comic.make import ComicOptions, make_comic
from vidstyle.comic.output.sheet import RenderedPanel, Sheet
from vidstyle.comic.output.svg import html
from vidstyle.comic.select.key_frames import KeyFrameOptions
from vidstyle.errors import InputError, UsageError
from vidstyle.regions.boxes import Rectangle

LABEL = '[[page.label]]\ntext = "MMMMMM"\nat = [9, 9]\nsize = 60\nbold = false\n'
WORDS = '1\n00:00:00,200 --> 00:00:00,900\n[knocks]\n\n2\n00:00:01,400 --> 00:00:02,000\nWho is "it"?\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a folder with a film, its comic, and the comic's page file."""
    path = tmp_path_factory.mktemp("comic")
    write_film(path / "film.mp4", story(4, 25))
    (path / "words.srt").write_text(WORDS)
    os.mkfifo(path / "pipe.mp4")
    make_comic(
        path / "film.mp4",
        path / "page.png",
        ComicOptions(
            KeyFrameOptions(4),
            styles=("plain",),
            size="420x600",
            title="Été",
            subtitles=str(path / "words.srt"),
            save=path / "comic.toml",
        ),
    )
    return path


def drawn(folder: Path, text: str, name: str) -> np.ndarray:
    """Return the page of an edited file, H x W."""
    (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    make_comic(folder / f"{name}.toml", folder / f"{name}.png")
    page = cv2.imread(str(folder / f"{name}.png"), cv2.IMREAD_GRAYSCALE)
    assert page is not None
    return page


def test_a_saved_comic_is_reproduced_byte_for_byte(folder: Path) -> None:
    drawn(folder, (folder / "comic.toml").read_text(encoding="utf-8"), "same")
    assert (folder / "same.png").read_bytes() == (folder / "page.png").read_bytes()


def test_only_edited_values_change_the_page(folder: Path) -> None:
    text, page = (folder / "comic.toml").read_text(encoding="utf-8"), cv2.imread(str(folder / "page.png"), 0)
    assert page is not None and text.count("[[page.panel]]") == 4
    (bubble,) = (part for part in text.split("[[") if 'text = "KNOCKS' in part)
    left, top, right, bottom = map(float, bubble.partition("place = [")[2].partition("]")[0].split(","))
    x, y = (left + right) / 2, (top + bottom) / 2
    changed = drawn(folder, text.replace("KNOCKS", "bang"), "words") != page
    rows, columns = np.nonzero(changed)
    assert rows.size and abs(rows - y).max() < bottom - top and abs(columns - x).max() < right - left
    longer = drawn(folder, text.replace("KNOCKS", "bang bang"), "longer") != page
    columns = np.nonzero(longer)[1]
    assert columns.min() < left - 4 and columns.max() > right + 4
    first = text.index("time = ")
    later = text[:first] + "time = 0.08" + text[text.index("\n", first) :]
    place = text.partition("place = [")[2].partition("]")[0]
    left, top, right, bottom = map(int, place.split(","))
    moved = drawn(folder, later, "time") != page
    assert moved[top:bottom, left:right].any()
    moved[top:bottom, left:right] = False
    assert not moved.any()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("format = 1", "format = ", "is not TOML: "),
        ("format = 1", "format = 2", "format is an unknown version; the known version is 1"),
        ("window = [", "window = [0, ", "page 1: panel 1: window is not 4 numbers"),
        ("place = [", "place = [-", "page 1: panel 1: place "),
        ("time = ", "# time = ", "page 1: panel 1: time is missing or not a number"),
        ("time = ", "time = 1e", "has no picture at|not a number|is outside|is not TOML"),
        ('kind = "caption"', 'kind = "bust"', "words 1: kind is not one of balloon, burst"),
        ("[[page]]", "[[sheet]]", "."),
        ("dpi = 150.0", "dip = 150.0", "wrong.toml: dip is an unknown key; did you mean 'dpi'?"),
        ("size = [420", "siez = 1\nsize = [420", "page 1: siez is an unknown key; did you mean 'size'?"),
        ("window = [", "widow = 1\nwindow = [", "panel 1: widow is an unknown key; did you mean 'window'?"),
        (
            'kind = "caption"',
            'kind = "caption"\ntips = 1',
            "words 1: tips is an unknown key; did you mean 'tip'",
        ),
        ("at = [210.0", "loud = true\nat = [210.0", "label 1: loud is an unknown key; there are text, at"),
        ("dpi = 150.0", r'"\u001b[1m" = 1', r"\\x1b\[1m is an unknown key"),
        ("dpi = 150.0", "dpi = " + "9" * 200, "line 7 has an integer of more than 64 bits"),
        ("format = 1", "x = " + "[" * 20000, "line 3 is nested too deeply; 16 levels are possible"),
        ("format = 1", "a." * 20000 + "b = 1", "line 3 is nested too deeply; 16 levels are possible"),
        ('font = "comic"', r'font = "a\u0000b"', r"font holds the control character \\x00; remove it"),
        ('font = "comic"', f'font = "{os.devnull}"', "is not a file; give a .ttf or .otf file"),
        ('source = "film.mp4"', 'source = "/dev/zero"', "/dev/zero is neither a file nor a folder; save"),
        ('source = "film.mp4"', 'source = "pipe.mp4"', "pipe.mp4 is neither a file nor a folder; save"),
        ('reading = "ltr"', 'reading = "up"', "reading is neither ltr nor rtl"),
        ("KNOCKS", r"\u001b[31m", r"words 1: text holds the control character \\x1b; remove it"),
        ("KNOCKS", "W" * 100_000, "words 1: text has more than 4000 characters; shorten it"),
        ("KNOCKS", "W" * 300, "words 1: text is larger than its page; give fewer words or a smaller size"),
        ("[[page]]", "[[page]]\nsize = [64, 64]\n" * 301 + "[[page]]", "page has 302 entries; give 1 to 300"),
        ("size = [420, 600]", "size = [16385, 16385]", "page 1: size is more than 268435456 pixels"),
        ("window = [", "window = [9e5, 0, 9.1e5, 9] # ", "lies outside its frame of 256x144 pixels"),
        ("[[page.label]]", LABEL * 4001 + "[[page.label]]", "words and label have more than 4000 entries"),
        (
            "[[page.label]]",
            LABEL * 900 + "[[page.label]]",
            "words entries cover their page more than 2 times",
        ),
        ('text = "ÉTÉ"', r'text = "a\rb"', r"label 1: text holds the control character \\r; remove it"),
        ('text = "ÉTÉ"', r'text = "a\nb"', r"label 1: text holds the control character \\n; remove it"),
        (
            'text = "ÉTÉ"',
            'text = "a\u2029b"',
            r"holds the control character \\u2029; remove it",
        ),
        ("at = [210.0", "at = [1e300", "page 1: label 1: at is not on its page"),
    ],
)
def test_errors_in_a_page_file_are_reported(folder: Path, old: str, new: str, message: str) -> None:
    text = (folder / "comic.toml").read_text(encoding="utf-8")
    assert old in text
    with pytest.raises(InputError, match=message):
        drawn(folder, text.replace(old, new, 1), "wrong")
    assert not (folder / "wrong.png").exists()


@pytest.mark.parametrize("value", ["3", "[3]", "{}"])
def test_pages_are_tables(folder: Path, value: str) -> None:
    head, _, _ = (folder / "comic.toml").read_text(encoding="utf-8").partition("[[page]]")
    with pytest.raises(InputError, match="page is not a list of tables"):
        drawn(folder, f"{head}page = {value}\n", "pages")


def test_a_page_file_that_is_no_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "zero.toml").symlink_to("/dev/zero")
    (tmp_path / "large.toml").write_bytes(b"#" * ((1 << 20) + 1))
    for name, reason in ("pipe", "not a file"), ("zero", "not a file"), ("large", "larger than 1024 KiB"):
        with pytest.raises(InputError, match=f"{name}.toml is {reason}"):
            make_comic(tmp_path / f"{name}.toml", tmp_path / "page.png")


def test_pages_are_not_drawn_larger_than_memory_holds(folder: Path, tmp_path: Path) -> None:
    text = (folder / "comic.toml").read_text(encoding="utf-8").replace("film.mp4", f"{folder}/film.mp4")
    for name, size in ("large", "[9000, 9000]"), ("long", "[420, 65600]"):
        page = text.replace("size = [420, 600]", f"size = {size}")
        (tmp_path / f"{name}.toml").write_text(page, "utf-8")
    with pytest.raises(UsageError, match=r"has a page of 9000x9000 pixels; 70 megapixels are possible"):
        make_comic(tmp_path / "large.toml", tmp_path / "page.png")
    with pytest.raises(UsageError, match=r"has a page of 420x65600 pixels; .* and 65500 pixels a side"):
        make_comic(tmp_path / "long.toml", tmp_path / "page.jpg")
    make_comic(tmp_path / "large.toml", tmp_path / "page.svg")


def test_control_characters_do_not_reach_a_document(folder: Path, tmp_path: Path) -> None:
    """Characters of subtitles are replaced; characters of options are refused."""
    assert Letters().make_writable("a\x01\x7f\ufffe\udcff b\t") == "a\ufffd\ufffd\ufffd\ufffd b"
    assert xml_text("a\x1b<b>") == "a\ufffd&lt;b&gt;"
    words, saved = tmp_path / "words.srt", tmp_path / "comic.toml"
    words.write_text("1\n00:00:00,200 --> 00:00:00,900\nBe\x01ep\x1b[31m \ufffe!\n", "utf-8")
    options = ComicOptions(
        KeyFrameOptions(2), styles=("plain",), size="420x600", subtitles=str(words), save=saved
    )
    make_comic(folder / "film.mp4", tmp_path / "page.svg", options)
    assert "EP" in "".join(ElementTree.parse(tmp_path / "page.svg").getroot().itertext())
    make_comic(saved, tmp_path / "again.svg")
    assert (tmp_path / "again.svg").read_bytes() == (tmp_path / "page.svg").read_bytes()
    with pytest.raises(UsageError, match=r"--title holds the control character \\x01; remove it"):
        make_comic(folder / "film.mp4", tmp_path / "title.svg", ComicOptions(title="a\x01"))
    (tmp_path / "n\udcff.mp4").write_bytes((folder / "film.mp4").read_bytes())
    with pytest.raises(UsageError, match=r"--save cannot write the name .*n\\udcff.mp4"):
        make_comic(tmp_path / "n\udcff.mp4", tmp_path / "n.png", ComicOptions(save=tmp_path / "n.toml"))


def test_options_that_a_page_file_sets_are_refused(folder: Path) -> None:
    with pytest.raises(UsageError, match="is a page file that sets the option seed; change the file instead"):
        make_comic(folder / "comic.toml", folder / "other.png", ComicOptions(seed=3))
    with pytest.raises(UsageError, match="cannot be a page file; end its name in .toml"):
        make_comic(folder / "film.mp4", folder / "other.png", ComicOptions(save=folder / "page.txt"))


def test_a_page_file_reproduces_a_panel_without_its_empty_sky(tmp_path: Path) -> None:
    roofs = next(story(1, 1))
    picture = np.full((200, 256, 3), 200, np.uint8)
    picture[-roofs.shape[0] + 40 :] = roofs[40:]
    film = write_film(tmp_path / "film.mp4", [picture] * 20)
    options = ComicOptions(styles=("plain",), size="420x600", save=tmp_path / "comic.toml")
    comic = make_comic(film, tmp_path / "page.png", options)
    assert comic.key_frames[0].trimmed > 20
    again = make_comic(tmp_path / "comic.toml", tmp_path / "again.png")
    assert again.files[0].read_bytes() == comic.files[0].read_bytes()


@pytest.mark.parametrize("is_folder", [False, True])
def test_a_film_on_its_side_is_turned_and_its_page_file_keeps_that(
    folder: Path, tmp_path: Path, is_folder: bool
) -> None:
    source = folder / "film.mp4"
    if is_folder:
        source = tmp_path / "pictures"
        source.mkdir()
        cv2.imwrite(str(source / "a.png"), next(story(1, 1))[..., ::-1])
    turns = {
        angle: ComicOptions(
            KeyFrameOptions(1), ("plain",), size="420x600", rotate=angle, save=tmp_path / f"{angle}.toml"
        )
        for angle in (None, 90)
    }
    upright, turned = (make_comic(source, tmp_path / f"{angle}.png", turns[angle]) for angle in turns)
    assert turned.key_frames[0].shape == upright.key_frames[0].shape[::-1]
    again = make_comic(tmp_path / "90.toml", tmp_path / "again.png")
    assert again.files[0].read_bytes() == turned.files[0].read_bytes() != upright.files[0].read_bytes()
    with pytest.raises(UsageError, match="--rotate: 45 is not a quarter turn; give 90, 180 or 270"):
        make_comic(source, tmp_path / "a.png", ComicOptions(rotate=45))


def test_pictures_are_reduced_smoothly_and_stacked_panels_have_equal_borders(
    tmp_path: Path, browser: Browser
) -> None:
    dots = np.full((400, 1560, 3), 255, np.uint8)
    dots[:, ::3] = 0  # a fine screen, which beats with the pixels of a window
    panels = [
        RenderedPanel(
            Rectangle(16, top, 24 + width, top + 408),
            Rectangle(20, top + 4, 20 + width, top + 404),
            dots[:, :width],
        )
        for top, width in ((16, 1560), (440, 780))
    ]
    (tmp_path / "page.html").write_bytes(html([Sheet(1600, 900, 150, Letters(), panels)], "", ""))
    browser.open((tmp_path / "page.html").as_uri())
    browser.run(
        "while (document.querySelectorAll('.reduced').length < 2) await new Promise(requestAnimationFrame)"
    )
    href, scale = browser.run(
        """const picture = document.querySelector('.reduced');
        return [picture.href.baseVal, picture.getScreenCTM().a * devicePixelRatio]"""
    )
    data = np.frombuffer(base64.b64decode(href.split(",")[1]), np.uint8)
    shown = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    assert shown.shape[1] == round(1560 * scale) < 1560
    assert np.ptp(shown[50:-50, 50:-50]) < 50
    browser.call(
        "Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True
    )
    borders = browser.run(
        """while (!document.body.matches('.stacked')) await new Promise(requestAnimationFrame);
        return [...document.querySelectorAll('.frame')].map((frame) => {
          const covered = parseFloat(getComputedStyle(frame).strokeWidth) / 2;
          return (frame.parentElement.dataset.border - covered) * frame.getScreenCTM().a;
        })"""
    )
    assert borders[0] == pytest.approx(borders[1], rel=0.02) and borders[0] > 0.5


def test_slanted_panels_are_upright_on_a_phone(tmp_path: Path, browser: Browser) -> None:
    color = np.full((200, 400, 3), 128, np.uint8)
    panel = RenderedPanel(Rectangle(16, 16, 424, 224), Rectangle(20, 20, 420, 220), color, leans=(0, 12))
    (tmp_path / "page.html").write_bytes(html([Sheet(800, 400, 150, Letters(), [panel])], "", ""))
    browser.open((tmp_path / "page.html").as_uri())
    shapes = """return [...document.querySelectorAll("polygon")].map((each) =>
        new Set([...each.points].map(({ x }) => x)).size)"""
    size = {"height": 844, "deviceScaleFactor": 1, "mobile": False}
    for width, count in ((1280, 3), (390, 2), (1280, 3)):
        browser.call("Emulation.setDeviceMetricsOverride", width=width, **size)
        browser.until(f"document.body.matches('.stacked') === {'true' if width == 390 else 'false'}")
        assert browser.run(shapes) == [count, count], "the frame and the edge of the picture"


def test_the_ring_around_a_panel_has_its_slanted_shape(tmp_path: Path, browser: Browser) -> None:
    color = np.full((200, 400, 3), 128, np.uint8)
    panel = RenderedPanel(Rectangle(16, 16, 424, 224), Rectangle(20, 20, 420, 220), color, leans=(0, 12))
    (tmp_path / "page.html").write_bytes(html([Sheet(800, 400, 150, Letters(), [panel])], "", ""))
    browser.open((tmp_path / "page.html").as_uri())
    browser.press("ArrowRight")
    ring = """const panel = document.activeElement;
        const { stroke, strokeWidth } = getComputedStyle(panel.querySelector(".frame"));
        const isWide = stroke !== "none" && parseFloat(strokeWidth) > 5;
        return [panel.id, getComputedStyle(panel).outlineStyle, isWide];"""
    assert browser.run(ring) == ["panel-1", "none", True]
    browser.call("Emulation.setEmulatedMedia", media="print")
    assert browser.run(ring) == ["panel-1", "none", False], "it is not printed"
    browser.call("Emulation.setEmulatedMedia", media="")


def test_a_comic_is_edited_in_a_browser(folder: Path, browser: Browser) -> None:
    """A balloon is dragged and a word changed by mouse and keyboard; the saved file has only these edits."""
    text = (folder / "comic.toml").read_text(encoding="utf-8")
    make_comic(folder / "comic.toml", folder / "page.html")
    browser.download_to(folder / "downloads")
    browser.open((folder / "page.html").as_uri())
    browser.press("e")
    assert browser.run("return document.activeElement.matches('g[data-place]')"), "the first balloon"
    browser.press("Tab")
    assert browser.run("return document.activeElement.matches('g[data-place]')"), "the next one"
    labels = "return [...document.querySelectorAll('g[data-place]')].map((each) => each.ariaLabel)"
    assert not [label for label in browser.run(labels) if ".." in label]
    assert browser.run("return document.body.matches('.whole')")
    assert browser.run("return document.documentElement.scrollHeight <= innerHeight")
    over = """const [bar, page] = [".bar", "main > svg"]
          .map((each) => document.querySelector(each).getBoundingClientRect());
        return [bar.bottom <= page.top, page.width];"""
    is_above, wide = browser.run(over)
    browser.press("e")
    assert is_above and browser.run(over)[1] == wide, "the page keeps its size, and nothing covers it"
    browser.press("e")
    outlines = """return [...document.querySelectorAll("g[data-place]")]
        .map((each) => getComputedStyle(each.querySelector("polygon") ?? each))
        .every(({ stroke, outlineColor }) => [stroke, outlineColor].includes("rgb(178, 60, 5)"))"""
    assert browser.run(outlines), "what can be changed is marked"
    burst, balloon = "g.caption", "g[data-place]:not(.caption)"
    (x, y, *_), scale = (
        browser.place(burst),
        browser.run("return document.querySelector('g.caption').getScreenCTM().a"),
    )
    browser.drag((x, y), (x + 12 * scale, y + 6 * scale))
    browser.click(balloon)
    browser.until("document.activeElement.matches('textarea.words')")
    high = "return document.activeElement.getBoundingClientRect().height"
    browser.type("other")
    once = browser.run(high)
    assert "Enter accepts" in browser.run("return document.querySelector('.bar p').textContent")
    for letter in "wise":
        browser.type(letter)
    assert browser.run(high) == once, "each letter leaves the height of the field"
    browser.press("Escape")
    assert browser.run("return document.querySelector('.bar p').textContent").startswith("Cancelled")
    browser.run("document.querySelector(balloon).focus()", balloon=balloon)
    browser.press("Enter")
    browser.type("Who was *that*?")
    browser.press("Enter")
    sides = """const [words, outline] = ["text", "polygon"].map((name) =>
          document.querySelector(`${balloon} ${name}`).getBoundingClientRect());
        return [outline.left, words.left, words.right, outline.right];"""
    inside = browser.run(sides, balloon=balloon)
    assert inside == sorted(inside), "the words are in the balloon"
    font = "return getComputedStyle(document.querySelector('main text')).fontFamily"
    assert "Helvetica" in browser.run(font), "the font of the comic, not of the page"
    # An accidental edit can be undone.
    browser.press("Shift+ArrowLeft")
    browser.click(".bar button:nth-of-type(1)")
    browser.click(".bar button:nth-of-type(3)")
    file = folder / "downloads" / "comic.toml"
    eventually(file.exists, "no file is saved")
    eventually(lambda: file.read_text(encoding="utf-8").count("[[page.panel]]") == 4, "the file is truncated")
    saved = file.read_text(encoding="utf-8")
    changed = [pair for pair in zip(text.splitlines(), saved.splitlines(), strict=True) if pair[0] != pair[1]]
    (before, after), *others = [pair for pair in changed if pair[0].startswith("place")]
    moved = np.subtract(*(json.loads(line.partition("=")[2]) for line in (after, before)))
    assert moved == pytest.approx([12, 6, 12, 6], abs=1)
    assert [pair[1] for pair in changed if pair[0].startswith("text")] == [r'text = "Who was\n*that*?"']
    assert len(changed) == len(others) + 2 <= 3, "all other lines are unchanged"
    page = cv2.imread(str(folder / "page.png"), 0)
    assert (drawn(folder, saved, "edited") != page).any()
    assert not [event for event in browser.events if event["method"] == "Runtime.exceptionThrown"]


def test_a_caption_that_grows_stays_in_its_panel(folder: Path, browser: Browser) -> None:
    """It grows away from the nearer edge; what does not fit even so gets smaller letters."""
    make_comic(folder / "comic.toml", folder / "caption.html")
    browser.open((folder / "caption.html").as_uri())
    browser.press("e")
    shown = """const group = document.querySelector("g.caption");
        const [, top, , bottom] = group.dataset.place.split(" ").map(Number);
        const frame = group.parentElement.querySelector(".frame").getBBox();
        const box = group.querySelector("polygon").getBBox();
        const border = Number(group.parentElement.dataset.border);
        const isInside = box.x > frame.x + border && box.x + box.width < frame.x + frame.width - border
          && box.y > frame.y + border && box.y + box.height < frame.y + frame.height - border;
        const isUpper = (top + bottom) / 2 < frame.y + frame.height / 2;
        const drift = isUpper ? box.y - top : box.y + box.height - bottom;
        const size = group.querySelector("text").getAttribute("font-size");
        return [isInside, drift, box.height, Number(size)];"""
    _, _, height, size = browser.run(shown)
    texts = [
        "One more line of words, and then another one",
        "and " * 300 + "more words than there is room for",
    ]
    for number, text in enumerate(texts):
        browser.run("document.querySelector('g.caption').focus()")
        browser.press("Enter")
        browser.run("document.querySelector('textarea.words').select()")
        browser.type(text)
        browser.press("Enter")
        is_inside, drift, grown, letters = browser.run(shown)
        assert is_inside and grown > height
        assert (letters < size) == (number == 1)
        assert number or drift == pytest.approx(0, abs=0.5)
    browser.run("document.querySelector('.bar button').click()")
    assert browser.run(shown)[3] == size, "undo restores the size, too"
    browser.run(
        "document.querySelector('.bar button').click()"
    )  # no unsaved change asks before the next page


def test_double_clicked_words_are_broken_like_the_old_ones_and_saved_with_the_page(
    folder: Path, browser: Browser
) -> None:
    make_comic(folder / "comic.toml", folder / "words.html")
    browser.download_to(folder / "downloads")
    browser.open((folder / "words.html").as_uri())
    browser.press("e")
    fonts = "await document.fonts.ready; return [...document.fonts].map((each) => each.status)"
    assert browser.run(fonts) == ["loaded"]
    shown = """const group = document.querySelector("g[data-place]:not(.caption)");
        const rows = [...group.querySelectorAll("text > tspan")];
        const frame = group.parentElement.querySelector(".frame").getBBox();
        const box = group.querySelector("polygon").getBBox();
        const isInside = box.x >= frame.x && box.x + box.width <= frame.x + frame.width;
        return [rows.map((row) => row.textContent), isInside];"""
    x, y, *_ = browser.still("g[data-place]:not(.caption)")
    for kind in ("mousePressed", "mouseReleased") * 2:
        browser.mouse(kind, x, y)
    assert browser.run("return document.querySelector('textarea.words').value") == 'WHO IS\n"IT"?'
    browser.run("document.querySelector('textarea.words').select()")
    browser.type("Nobody knows who it is, and nobody will ever ask again")
    browser.press("Enter")
    lines, is_inside = browser.run(shown)
    assert " ".join(lines) == "NOBODY KNOWS WHO IT IS, AND NOBODY WILL EVER ASK AGAIN"
    assert len(lines) > 2 and max(map(len, lines)) < 1.5 * min(map(len, lines)) and is_inside
    leave = "return !dispatchEvent(new Event('beforeunload', { cancelable: true }))"
    assert browser.run(leave), "unsaved changes are not lost unasked"
    hint = "return document.querySelector('.bar p').textContent"
    assert "not saved yet" in browser.run(hint)
    browser.press("Escape")
    assert browser.run("return document.getElementById('edit').textContent") == "Edit, not saved"
    browser.press("e")
    browser.click(".bar button:nth-of-type(2)")
    assert "words.html is in your downloads" in browser.run(
        "return document.querySelector('.bar p').textContent"
    )
    assert not browser.run(leave)
    browser.click(".bar button:nth-of-type(4)")
    assert not browser.run("return document.querySelector('.bar').checkVisibility()")
    saved = folder / "downloads" / "words.html"
    eventually(lambda: saved.exists() and saved.read_bytes().endswith(b"</html>"), "no page is saved")
    browser.open(saved.as_uri())
    assert browser.run(shown)[0] == lines
    assert browser.run("return document.querySelectorAll('#print svg').length") == 1
    data = browser.run("return JSON.parse(document.getElementById('page-file').textContent)")
    assert "\\n".join(lines).lower() in data.lower()
    assert not [event for event in browser.events if event["method"] == "Runtime.exceptionThrown"]


def test_a_phone_has_all_actions_in_a_menu(folder: Path, browser: Browser) -> None:
    make_comic(folder / "comic.toml", folder / "phone.html")
    size = {"height": 740, "deviceScaleFactor": 1, "mobile": True}
    browser.call("Emulation.setDeviceMetricsOverride", width=360, **size)
    browser.open((folder / "phone.html").as_uri())
    names = ["read", "edit", "print", "full", "ask"]
    visible = "return names.filter((name) => document.getElementById(name).checkVisibility())"
    assert browser.run(visible, names=names) == []
    browser.click("#more")
    assert browser.run(visible, names=names) == names
    browser.click("#edit")
    assert browser.run(visible, names=names) == [] and browser.run("return document.body.matches('.editing')")
    browser.call("Emulation.clearDeviceMetricsOverride")


def enlarged_width(browser: Browser) -> float:
    return float(
        browser.run("return document.querySelector('#panel-picture > svg').getBoundingClientRect().width")
    )


def test_a_comic_is_read_panel_by_panel(folder: Path, browser: Browser) -> None:
    make_comic(folder / "comic.toml", folder / "read.html")
    browser.open((folder / "read.html").as_uri())
    number = "return document.getElementById('panel-number').textContent"
    is_open = "return document.getElementById('reading').open"
    browser.press("ArrowRight")
    browser.press("Enter")
    assert browser.run(is_open) and browser.run(number) == "1 of 4"
    beside = """document.documentElement.style.overflowY = "scroll";
        const { right } = document.getElementById("reading").getBoundingClientRect();
        return right <= document.documentElement.clientWidth;"""
    assert browser.run(beside), "no scrollbar covers the buttons"
    browser.press("ArrowRight")
    browser.press("End")
    browser.press("ArrowRight")
    assert browser.run(number) == "4 of 4", "it ends with the last panel"
    whole = """const view = document.getElementById("panel-picture");
        return view.scrollWidth <= view.clientWidth && view.scrollHeight <= view.clientHeight;"""
    assert browser.run(whole), "no head is cut off"
    browser.press("Escape")
    assert not browser.run(is_open)
    browser.until("document.activeElement.id === 'panel-4'")
    # On a phone, panels stand one below the other.
    browser.call(
        "Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=False
    )
    browser.until("document.body.classList.contains('stacked')")
    lefts = browser.run(
        "return [...document.querySelectorAll('.panel')].map((each) => each.getBoundingClientRect().top)"
    )
    assert sorted(set(lefts)) == lefts
    # There, an enlarged panel is whole first, then twice as large; a drag moves it before it turns.
    on_page = browser.run("return document.querySelector('#panel-2 .frame').getBoundingClientRect().width")
    browser.run("document.querySelectorAll('.panel')[1].dispatchEvent(new MouseEvent('click'))")
    assert enlarged_width(browser) <= 390
    browser.run("document.getElementById('panel-whole').click()")
    assert enlarged_width(browser) > 1.9 * on_page
    browser.drag((300, 400), (40, 400))
    assert browser.run(number) == "2 of 4"
    browser.drag((300, 400), (40, 400))
    assert browser.run(number) == "3 of 4"
    browser.run("document.getElementById('panel-before').click()")
    browser.run("document.getElementById('panel-whole').click()")
    assert enlarged_width(browser) <= 390
    browser.drag((300, 400), (40, 400))
    assert browser.run(number) == "3 of 4", "a whole panel has no hidden part"
    # A panel that is enlarged stays in view when the phone is turned.
    browser.call(
        "Emulation.setDeviceMetricsOverride", width=844, height=390, deviceScaleFactor=1, mobile=False
    )
    browser.until("!document.body.classList.contains('stacked')")
    shown, viewed = browser.run("""
        const box = document.querySelector('#panel-picture use').getBoundingClientRect();
        const view = document.getElementById('panel-picture').getBoundingClientRect();
        return [[box.left, box.top, box.right, box.bottom], [view.left, view.top, view.right, view.bottom]];
    """)
    assert browser.run(number) == "3 of 4"
    assert shown[0] >= viewed[0] and shown[1] >= viewed[1]
    assert shown[2] <= viewed[2] and shown[3] <= viewed[3]
    assert (
        shown[3] - shown[1] > (viewed[3] - viewed[1]) / 2 or shown[2] - shown[0] > (viewed[2] - viewed[0]) / 2
    )
