"""Previews: a picture in every style, as a page or a sheet."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from base64 import b64decode
from dataclasses import replace
from fractions import Fraction
from html.parser import HTMLParser
from pathlib import Path

import cv2
import numpy as np
import pytest
from covering import of_the_day
from media import alpha_ramp, make_clip, make_picture, moving_frames, rms_error
from PIL import Image
from waiting import eventually

from tools.pictures.progression import render_progression
from vidstyle.assets import asset_folder
from vidstyle.cli import browser, main
from vidstyle.errors import InputError
from vidstyle.gallery.preview import preview_page, read_still, write_preview
from vidstyle.gallery.style_samples import (
    BORDER_PX,
    LABEL_HEIGHT_PX,
    StyleSample,
    restyle_picture,
    samples_of,
    sheet_of_samples,
)
from vidstyle.gallery.thumbnail import (
    THUMBNAIL_FOLDER,
    THUMBNAIL_HEIGHT_PX,
    THUMBNAIL_WIDTH_PX,
    restyle_thumbnail,
    thumbnail,
)
from vidstyle.media.read.reader import ReadOptions
from vidstyle.style import PLAIN, Step, Style, load_style, popular_first, style_names

FLAT = Style("flat", note="Two tones; tune `posterize.levels`.", base=(Step("posterize", {"levels": 2}),))


def picture(size: tuple[int, int] = (320, 180)) -> np.ndarray:
    return next(moving_frames(1, size))


class Elements(HTMLParser):
    """The parts of a page, as parsed by a browser."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attributes)))

    def handle_data(self, data: str) -> None:
        self.text += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.found if name == tag]


def test_the_page_shows_every_style_the_source_first(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    source, target = make_picture(tmp_path / "in.png"), tmp_path / "out.html"
    assert main(["styles", "--preview", str(source), "-o", str(target), "--progress", "none"]) == 0
    out, err = capfd.readouterr()
    assert (out, err) == ("", f"vidstyle: {target}: in.png in {len(style_names()) - 1} styles\n")
    page = Elements(target.read_text(encoding="utf-8"))
    images = [image for image in page.all("img") if "src" in image]
    assert [image["alt"] for image in images] == ["plain", *(n for n in popular_first() if n != "plain")]
    for image in images:
        kind, _, content = str(image["src"]).partition(",")
        decoded = cv2.imdecode(np.frombuffer(b64decode(content), np.uint8), cv2.IMREAD_COLOR)
        assert kind == "data:image/jpeg;base64" and decoded.shape == (180, 320, 3)
        style = load_style(str(image["alt"]))
        expected = restyle_picture(picture(), style, seen_side=180)
        assert rms_error(decoded[..., ::-1].astype(float), expected.astype(float)) < 12
        assert re.sub("`", "", style.about) in page.text and " Tune " not in page.text


def test_the_page_needs_nothing_from_elsewhere() -> None:
    page = preview_page(
        "in.png", "in.png", [StyleSample(Style("plain"), picture()), StyleSample(FLAT, picture())]
    )
    for _, attributes in Elements(page).found:
        for name in ("src", "href", "srcset", "action"):
            assert str(attributes.get(name, "data:")).startswith("data:")
    assert "url(" not in page and "@import" not in page and "default-src 'none'" in page
    assert not re.search(r"\$\w", page)
    assert "<h1>1 look<span>in.png</span></h1>" in page, "the original is no look"


def test_nothing_of_a_stranger_becomes_part_of_the_page() -> None:
    evil = '<script>alert("1")</script>&amp;"\' onerror=x $source'
    plain = Elements(preview_page("in.png", "in.png", [StyleSample(Style("plain", note="x"), picture())]))
    page = Elements(
        preview_page(evil + "\n\x1b", evil, [StyleSample(Style(evil, note=f"`{evil}`"), picture())])
    )
    assert [tag for tag, _ in page.found if tag != "code"] == [tag for tag, _ in plain.found if tag != "code"]
    assert [*map(len, page.all("img"))] == [*map(len, plain.all("img"))]
    assert page.all("img")[0]["alt"] == evil
    assert page.text.count(evil) >= 3 and "\x1b" not in page.text


@pytest.mark.parametrize("name", ["sheet.png", "sheet.JPG"])
def test_the_sheet_holds_the_pictures_under_their_names(name: str, tmp_path: Path) -> None:
    source = make_picture(tmp_path / "in.png")
    write_preview(source, tmp_path / name, [load_style("plain"), FLAT])
    with Image.open(tmp_path / name) as image:
        sheet = np.asarray(image.convert("RGB")).astype(float)
    assert sheet.shape == (2 * (180 + LABEL_HEIGHT_PX + BORDER_PX), 320 + 2 * BORDER_PX, 3)
    assert sheet[:LABEL_HEIGHT_PX].min() < 100
    for number, expected in enumerate([picture(), restyle_picture(picture(), FLAT)]):
        top = number * (180 + LABEL_HEIGHT_PX + BORDER_PX) + LABEL_HEIGHT_PX
        assert rms_error(sheet[top : top + 180, BORDER_PX:-BORDER_PX], expected.astype(float)) < (
            6 if "J" in name else 0.01
        )


@pytest.mark.parametrize("size", [(1920, 1080), (1080, 1920), (200, 200), (3000, 10), (10, 3000)])
def test_a_sheet_is_neither_a_ribbon_nor_too_large(size: tuple[int, int]) -> None:
    sheet = sheet_of_samples([("x", np.zeros((size[1], size[0], 3), np.uint8))] * 14)
    assert max(sheet.shape) < 8000
    if max(size) < 3000:
        assert 0.5 < sheet.shape[1] / sheet.shape[0] < 3


def test_a_style_may_be_named(tmp_path: Path) -> None:
    target = tmp_path / "out.html"
    source = make_picture(tmp_path / "in.png")
    assert main(["styles", "sketch", "--preview", str(source), "-o", str(target)]) == 0
    images = Elements(target.read_text(encoding="utf-8")).all("img")
    assert [image["alt"] for image in images if "src" in image] == ["plain", "sketch"]


def test_of_a_film_the_middle_or_a_given_time_is_shown(tmp_path: Path) -> None:
    film = make_clip(tmp_path / "film.mkv", codec="ffv1", pix_fmt="yuv444p", frames=40, rate=10)
    frames = [frame.astype(float) for frame in moving_frames(40, (160, 90))]
    for at, number in ((None, 20), (Fraction(3), 30), (Fraction(0), 0)):
        still = read_still(film, ReadOptions(start=at)).astype(float)
        errors = [rms_error(still, frame) for frame in frames]
        assert int(np.argmin(errors)) == number and errors[number] < 2
    with pytest.raises(InputError, match="has no frame"):
        read_still(film, ReadOptions(start=Fraction(9)))


def test_a_page_is_opened_at_a_desktop_unless_declined(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("vidstyle.cli.browser.is_wanted", lambda no_open: not no_open)
    source = make_picture(tmp_path / "in.png")
    for name, *more in (["declined.html", "--no-open"], ["sheet.png"], ["a page.html"]):
        assert main(["styles", "plain", "--preview", str(source), "-o", str(tmp_path / name), *more]) == 0
    eventually(lambda: opened == [(tmp_path / "a page.html").as_uri()])


@pytest.mark.parametrize(
    ("environment", "is_wanted"),
    [
        ({"DISPLAY": ":0"}, True),
        ({"WAYLAND_DISPLAY": "wayland-0"}, True),
        ({}, False),
        ({"DISPLAY": ":0", "CI": "true"}, False),
        ({"DISPLAY": ":10", "SSH_CONNECTION": "10.0.0.1 1 10.0.0.2 22"}, False),
    ],
)
def test_a_desktop_is_told_by_its_environment(
    environment: dict[str, str], is_wanted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "CI", "SSH_CONNECTION"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert not browser.is_wanted(no_open=False), "standard error is no terminal"
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert browser.is_wanted(no_open=False) == is_wanted
    assert not browser.is_wanted(no_open=True)


def test_a_film_that_is_shorter_than_it_says_shows_its_first(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    film = make_clip(tmp_path / "film.mkv", codec="ffv1", pix_fmt="yuv444p", frames=10, rate=10)
    monkeypatch.setattr("vidstyle.gallery.preview._middle", lambda *_: Fraction(50))
    still = read_still(film).astype(float)
    assert rms_error(still, picture((160, 90)).astype(float)) < 2
    assert "showing the first" in caplog.text


def test_pictures_are_upright_square_and_small(tmp_path: Path) -> None:
    wide = make_clip(tmp_path / "wide.mp4", sample_aspect=Fraction(2), frames=3)
    assert read_still(wide).shape == (90, 320, 3)
    turned = make_clip(tmp_path / "turned.mp4", rotation=90, frames=3)
    assert read_still(turned).shape == (160, 90, 3)
    large = make_picture(tmp_path / "large.png", size=(2400, 1201))
    assert read_still(large).shape == (480, 960, 3)


def test_what_is_transparent_lies_on_white(tmp_path: Path) -> None:
    still = read_still(make_picture(tmp_path / "in.png", mode="RGBA")).astype(float)
    alpha = alpha_ramp(180, 320)[..., np.newaxis] / 255
    assert rms_error(still, picture() * alpha + 255 * (1 - alpha)) < 1


UNUSABLE = {
    2: {
        "--preview in.png": "--preview needs -o FILE.html",
        "--at 3": "--at needs --preview",
        "--preview in.png -o out.gif": "out.gif cannot be a preview; end its name in .html",
        "--preview in.png -o there.html": "there.html already exists; add -y",
        "--preview in.png -o in.png -y": "is the input itself",
        "--preview in.png -o pipe.html -y": "pipe.html is a device or a pipe",
        "--preview http://x/y.png -o out.html": "allow it with --allow-url",
    },
    3: {
        "--preview none.png -o out.html": "none.png: no such file",
        "--preview there.html -o out.html": "there.html: not a readable video",
        "--preview in.png --at 5 -o out.html": "in.png has no frame",
        "none --preview in.png -o out.html": "there is no style 'none'",
    },
    5: {
        "--preview in.png -o none/out.html": "its folder does not exist",
    },
}
"""Arguments and messages by exit code."""


@pytest.mark.parametrize(
    ("code", "arguments", "words"),
    [(code, *each) for code, faults in UNUSABLE.items() for each in faults.items()],
)
def test_what_cannot_be_done_is_one_line(
    code: int,
    arguments: str,
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    make_picture(Path("in.png"))
    Path("there.html").write_text("there", encoding="utf-8")
    os.mkfifo("pipe.html")
    assert main(["styles", *arguments.split()]) == code
    out, err = capfd.readouterr()
    assert out == "" and err.count("\n") == 1 and words in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.png", "pipe.html", "there.html"]
    assert Path("there.html").read_text(encoding="utf-8") == "there"


def test_an_older_preview_is_replaced_when_asked(tmp_path: Path) -> None:
    source, target = make_picture(tmp_path / "in.png"), tmp_path / "out.html"
    target.write_text("old", encoding="utf-8")
    write_preview(source, target, [load_style("plain")], overwrite=True)
    assert "<!DOCTYPE html>" in target.read_text(encoding="utf-8")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.png", "out.html"]


def test_samples_come_in_the_order_of_their_styles() -> None:
    styles = [replace(FLAT, name=str(number)) for number in range(7)]
    samples = list(samples_of(picture((64, 36)), [load_style("plain"), *styles]))
    assert [sample.style.name for sample in samples] == ["plain", *"0123456"]
    assert (samples[0].picture == picture((64, 36))).all()


def test_the_thumbnail_that_is_shipped_is_what_the_style_makes() -> None:
    """After a style has changed, `python -m tools.pictures.contact_sheet` renews it."""
    shipped = {file.stem for file in asset_folder("styles").glob("*.toml")}
    assert {file.stem for file in THUMBNAIL_FOLDER.glob("*")} == shipped | {PLAIN}
    for style in map(load_style, shipped):
        kept, made = (
            cv2.resize(
                each(style), (THUMBNAIL_WIDTH_PX // 8, THUMBNAIL_HEIGHT_PX // 8), interpolation=cv2.INTER_AREA
            ).astype(float)
            for each in (thumbnail, restyle_thumbnail)
        )
        assert np.abs(kept - made).mean() < 3, style.name


def test_a_style_is_shown_step_by_step() -> None:
    source = picture((96, 54))
    bright, gray = Step("brightness", save="kept"), Step("to_gray")
    tones, lines = (
        Step("posterize", {"levels": 3}, save="tones"),
        (Step("sobel"), Step("blend", {"other": "tones"})),
    )
    style = Style(
        "s", paper="#ffeedd", base=(bright, gray), background=(tones,), lines=(Step("", save="x"), *lines)
    )
    stages = list(render_progression(source, style))
    assert [(stage.layer, stage.name) for stage in stages] == [
        ("", "source"),
        ("base", "brightness"),
        ("base", "to_gray"),
        ("background", "posterize"),
        ("lines", "sobel"),
        ("lines", "blend"),
        ("", "result"),
    ]
    expected = [
        source,
        restyle_picture(source, Style("s", base=(bright,))),
        restyle_picture(source, Style("s", base=(bright, gray))),
        restyle_picture(source, Style("s", base=(bright, gray, tones))),
        restyle_picture(source, Style("s", base=(bright, gray, Step("sobel")))),
    ]
    for stage, wanted in zip(stages, expected, strict=False):
        assert (stage.picture == wanted).all(), stage.name
    assert (stages[-1].picture == restyle_picture(source, style)).all()
    assert (stages[5].picture != stages[4].picture).any()


@pytest.mark.parametrize("name", of_the_day(style_names(), 8))
def test_every_shipped_style_can_be_shown_step_by_step(name: str) -> None:
    style = load_style(name)
    stages = list(render_progression(picture((96, 54)), style))
    assert len(stages) == 2 + sum(bool(step.block) for step in style.steps)


def test_an_animation_is_a_film_and_standard_input_shows_its_first(tmp_path: Path) -> None:
    frames = [Image.fromarray(np.full((40, 60, 3), tone, np.uint8)) for tone in (0, 60, 120, 180, 240)]
    film = tmp_path / "a.gif"
    frames[0].save(film, save_all=True, append_images=frames[1:], duration=100)
    for number, frame in enumerate(frames):
        frame.save(tmp_path / f"{number}.png")
    for source in (film, tmp_path / "%d.png"):
        assert abs(read_still(source).mean() - 120) < 5
    command = [
        sys.executable,
        "-m",
        "vidstyle",
        "styles",
        "plain",
        "--preview",
        "-",
        "-o",
        tmp_path / "out.png",
    ]
    done = subprocess.run(command, input=film.read_bytes(), capture_output=True, check=True)
    assert b"standard input in 0 styles" in done.stderr
    assert (
        np.asarray(Image.open(tmp_path / "out.png"))[LABEL_HEIGHT_PX:-BORDER_PX, BORDER_PX:-BORDER_PX].mean()
        < 5
    )
