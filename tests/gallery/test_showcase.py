"""`vidstyle export --all`: a page of many styles."""

from __future__ import annotations

import base64
import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from browser import Browser
from covering import of_the_day
from media import photograph

import vidstyle
from vidstyle.cli import main
from vidstyle.errors import UsageError
from vidstyle.export.page import page_data
from vidstyle.gallery.showcase import TILE_SIDE_PX, ExamplePicture, write_showcase
from vidstyle.style import load_style, override, style_from_table, style_names

NAMES = ("dither", "watercolor")


def data_of(folder: Path, path: str) -> Any:
    """The value in a file of data."""
    text = (folder / "data" / f"{path}.js").read_text(encoding="utf-8")
    return json.loads(text.removeprefix(f'vidstyleData("{path}",').removesuffix(");\n"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page of two styles with two examples."""
    made = tmp_path_factory.mktemp("page") / "looks"
    examples = [
        ExamplePicture(name, name, cv2.resize(photograph(name), (96, 64))) for name in ("coffee", "cat")
    ]
    size = write_showcase(made, [load_style(name) for name in NAMES], examples, "Looks <b>")
    assert size == sum(file.stat().st_size for file in made.rglob("*") if file.is_file())
    return made


def test_styles_share_their_texts_and_textures_without_loss(folder: Path) -> None:
    pieces = data_of(folder, "shaders")
    for name in NAMES:
        found, wanted = (
            data_of(folder, f"styles/{name}"),
            page_data(load_style(name), (TILE_SIDE_PX, 360, 720, 1080)),
        )
        texts = ["\n".join(pieces[number] for number in numbers) for numbers in found["shaders"]]
        assert texts == wanted["shaders"]
        assert {key: data_of(folder, f"textures/{key}") for key in found["textures"]} == wanted["textures"]
        assert pieces[found["vertex"]] == wanted["plans"][0]["plan"]["vertex"]
        assert [each["plan"]["values"] for each in found["plans"]] == [
            each["plan"]["values"] for each in wanted["plans"]
        ]


@pytest.mark.parametrize("name", of_the_day([name for name in style_names() if name != "plain"], 3))
def test_each_control_has_its_place_in_the_style_file(name: str, tmp_path: Path) -> None:
    """A page writes a changed value into this line, or after it."""
    style = load_style(name)
    picture = ExamplePicture("flat", "Flat", np.full((24, 32, 3), 128, np.uint8))
    write_showcase(tmp_path, [style], [picture], "Looks")
    data = data_of(tmp_path, f"styles/{name}")
    written = style_from_table(
        tomllib.loads(data["file"]["text"]), style.name, style.name, folder=style.folder
    )
    assert set(data["file"]["places"]) == {control["path"] for control in data["controls"]}
    for control in data["controls"]:
        if control["kind"] != "slider":
            continue
        value = control["low"] if control["value"] != control["low"] else control["high"]
        rows = data["file"]["text"].split("\n")
        number, is_there = data["file"]["places"][control["path"]]
        row = f"{control['path'].rpartition('.')[2]} = {value}"
        rows[number] = row if is_there else f"{rows[number]}\n{row}"
        changed = style_from_table(
            tomllib.loads("\n".join(rows)), style.name, style.name, folder=style.folder
        )
        assert changed == override(written, [f"{control['path']}={value}"]), control["path"]


def test_the_first_view_is_small_and_names_are_escaped(folder: Path) -> None:
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert "Looks &lt;b&gt;" in page and "Looks <b>" not in page
    assert not re.search(r"https?://", page.replace("http-equiv", ""))
    first = sum((folder / name).stat().st_size for name in ("index.html", "showcase.css", "showcase.js"))
    assert first < 100_000


def until(browser: Browser, fact: str) -> None:
    browser.run(f"while (!({fact})) await new Promise((done) => setTimeout(done, 10));")


def test_a_visitor_sees_all_looks_of_a_photograph_and_takes_one(
    folder: Path, browser: Browser, tmp_path: Path
) -> None:
    source = cv2.resize(photograph("coffee"), (320, 240), interpolation=cv2.INTER_AREA)
    assert cv2.imwrite(str(tmp_path / "source.png"), source[..., ::-1])
    browser.open((folder / "index.html").as_uri())
    until(browser, "document.querySelectorAll('.tile img[src*=coffee]').length === 2")
    until(browser, "document.getElementById('file')")
    browser.choose_file("#file", tmp_path / "source.png")
    until(browser, "[...document.querySelectorAll('.tile canvas')].every((each) => !each.hidden)")
    for name in NAMES:
        text = browser.run(
            "return document.querySelector(`a[href='#${name}'] canvas`).toDataURL().split(',')[1];", name=name
        )
        tile = cv2.imdecode(np.frombuffer(base64.b64decode(text), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
        right = vidstyle.stylize(source, replace(load_style(name), steady=0.0, focus=0.0), "cpu").astype(int)
        assert (np.abs(tile - right) > 2).mean() <= 0.002, name
    browser.click("a[href='#watercolor']")
    until(browser, "document.getElementById('command').textContent")
    browser.run(
        """const radius = document.querySelector("input[type=number][max='8']");
        radius.value = 7;
        radius.dispatchEvent(new Event("change", { bubbles: true }));"""
    )
    until(browser, "document.getElementById('command').textContent.includes('radius=7')")
    text = browser.run(
        """const made = new Promise((done) => {
          URL.createObjectURL = (blob) => (done(blob.text()), "data:,");
        });
        document.getElementById("style-file").click();
        return await made;"""
    )
    saved = style_from_table(
        tomllib.loads(text), "watercolor", "watercolor", folder=load_style("watercolor").folder
    )
    assert saved == override(load_style("watercolor"), ["kuwahara.radius=7"])
    browser.click("#close")
    until(browser, "!document.getElementById('viewer').open && !location.hash")
    asked = [
        each["params"]["request"]["url"]
        for each in browser.events
        if each["method"] == "Network.requestWillBeSent"
    ]
    assert asked and all(url.startswith((folder.as_uri(), "data:", "blob:")) for url in asked)


def test_an_address_opens_a_look_before_anything_is_loaded(folder: Path, browser: Browser) -> None:
    browser.open("about:blank")
    browser.open(f"{(folder / 'index.html').as_uri()}#watercolor")
    browser.run("location.hash = '#dither'; location.hash = '#watercolor'; location.hash = '#dither';")
    until(browser, "document.getElementById('facts').textContent")
    until(browser, "document.querySelector('#viewer h2, #viewer h1').textContent === 'dither'")
    assert not [event for event in browser.events if event["method"] == "Runtime.exceptionThrown"]


def test_a_page_is_not_overwritten_unasked(folder: Path, tmp_path: Path) -> None:
    picture = ExamplePicture("flat", "Flat", np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(UsageError, match="already exists"):
        write_showcase(folder, [load_style("dither")], [picture], "Looks")


@pytest.mark.parametrize(
    "words",
    [
        ["ink", "out.html", "--all", "looks"],
        ["--all", "looks", "--size", "64x64"],
        ["ink"],
        ["ink", "a.html", "--example", "b.png"],
    ],
)
def test_contradicting_arguments_are_usage_errors(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["export", *words]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []
