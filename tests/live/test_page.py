"""The live page: frames one at a time, always the newest, and validation of every message."""

from __future__ import annotations

import logging
import re
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from browser import Browser
from live import generated
from live_page import Visitor, live_frame, showing
from waiting import LONG, eventually
from websockets.exceptions import ConnectionClosed

from vidstyle.core.picture import Picture
from vidstyle.errors import StyleError
from vidstyle.gallery.thumbnail import THUMBNAIL_HEIGHT_PX, THUMBNAIL_WIDTH_PX, restyle_thumbnail
from vidstyle.live.control import Controls, LiveOptions, Status
from vidstyle.live.page import PageTarget, frame_feed, page_target
from vidstyle.live.page.frame_feed import MAX_SIZE, encode_jpeg
from vidstyle.live.page.page_target import STATIC_FOLDER
from vidstyle.live.page.viewer import JpegQuality
from vidstyle.live.session import LiveSession
from vidstyle.live.target import LiveFrame
from vidstyle.style import Style, load_style, set_values, user_styles


def test_a_picture_arrives_as_it_was_offered() -> None:
    frame = live_frame(7, (320, 180))
    with showing() as (page, _, visitor), visitor.look() as window:
        page.offer(frame)
        number, data = window.picture()
        while number != 7:
            window.say(do="shown", number=number)
            number, data = window.picture()
    shown = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(shown.astype(float) - frame.video.to_ndarray(format="bgr24")).mean() < 2


def test_one_picture_is_under_way_and_then_the_newest_follows() -> None:
    with showing() as (page, _, visitor), visitor.look() as window:
        assert window.picture()[0] == 0
        for number in range(1, 6):
            page.offer(live_frame(number))
        for _ in range(3):  # other messages arrive in between
            assert window.ask(do="bypass", on=False) == ""
            window.news("status")
        assert window.pictures == 0
        window.say(do="shown", number=0)
        assert window.picture()[0] == 5
        window.say(do="shown", number=5)
        eventually(lambda: (page.delivered, page.dropped) == (2, 4))


def test_a_browser_that_does_not_look_holds_up_no_other() -> None:
    with showing() as (page, _, visitor), visitor.look() as slow, visitor.look() as quick:
        slow.picture()
        for number in range(1, 20):
            window_number, _ = quick.picture()
            quick.say(do="shown", number=window_number)
            page.offer(live_frame(number))
        assert quick.picture()[0] >= 18


def test_offering_never_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not for the pictures to be encoded, nor for the browsers."""
    held, go = threading.Event(), threading.Event()

    def hold(frame: LiveFrame, quality: int) -> bytes:
        held.set()
        assert go.wait(LONG)
        return encode_jpeg(frame, quality)

    monkeypatch.setattr(frame_feed, "encode_jpeg", hold)
    with showing() as (page, _, visitor), visitor.look():
        assert held.wait(LONG)
        frame = live_frame(1, (1920, 1080))
        for _ in range(200):
            page.offer(frame)
        assert not go.is_set()
        go.set()
    page.offer(frame)  # after the end it is left out
    assert page.state == "no browser"


def test_its_end_is_told_to_browsers_and_leaves_no_thread() -> None:
    with showing() as (page, _, visitor), visitor.look() as window:
        window.picture()
        page.close()
        with pytest.raises(ConnectionClosed) as caught:
            window.news("never")
        assert caught.value.rcvd is not None and caught.value.rcvd.code == 1001
    eventually(lambda: not [t for t in threading.enumerate() if t.name.startswith("vidstyle page")])


def test_a_slider_changes_the_style_and_all_browsers_are_told() -> None:
    with showing() as (_, controls, visitor), visitor.look() as mover, visitor.look() as other:
        assert other.news("panel")["text"] == "--style ink"
        assert mover.ask(do="set", values={"flow_dog.p": 31.5, "ink": "#102030"}) == ""
        assert controls.style.ink == "#102030"
        told = other.news("panel")
        assert told["text"] == "--style ink --set 'ink=#102030' --set flow_dog.p=31.5"
        assert {entry["path"]: entry["value"] for entry in told["entries"]}["flow_dog.p"] == 31.5


def test_what_keys_in_the_terminal_change_is_told_too() -> None:
    with showing() as (_, controls, visitor), visitor.look() as window:
        window.news("panel")
        controls.steady(0.9)
        assert window.news("panel")["text"] == "--style ink --set steady=0.9"


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("flow_dog.p", 999),
        ("nothing.p", 1),
        ("ink", "rde"),
        ("ink", 5),
        ("steady", float("nan")),
        ("steady", "0.5"),
        ("steady", 10**400),
        ("x", True),
        ("a=b", "c"),
    ],
)
def test_a_value_that_cannot_be_is_answered_and_changes_nothing(path: str, value: object) -> None:
    with showing() as (_, controls, visitor), visitor.look() as window:
        before = controls.style
        assert "\n" not in window.ask(do="set", values={path: value}) != ""
        assert controls.style is before
        assert window.ask(do="set", values={"steady": 0.25}) == ""


def test_styles_and_variants_are_chosen_and_put_back() -> None:
    with showing() as (_, controls, visitor), visitor.look() as window:
        assert window.news("names") == controls.names
        assert [look["name"] for look in window.news("looks")] == controls.names
        assert window.news("panel")["variant"] == ""
        assert window.ask(do="choose", style="ink:green") == ""
        assert window.news("panel")["text"] == "--style ink:green"
        assert controls.style == load_style("ink:green") and controls.status().style == "ink:green"
        assert window.ask(do="set", values={"ink": "#102030"}) == ""
        told = window.news("panel")
        assert (told["name"], told["variant"]) == ("ink", "green")
        assert told["text"] == "--style ink:green --set 'ink=#102030'"
        assert [each["name"] for each in told["variants"]] == list(load_style("ink").variants)
        assert window.ask(do="choose", style="ink") == ""
        assert controls.style.ink == load_style("ink").ink
        assert window.ask(do="next") == ""
        assert controls.style.name == controls.names[controls.names.index("ink") + 1]
        assert "is not a style" in window.ask(do="choose", style="inc")
        assert "no variant" in window.ask(do="choose", style="ink:purple")


def test_a_variant_keeps_values_that_it_does_not_name() -> None:
    with showing() as (_, controls, visitor), visitor.look() as window:
        assert window.ask(do="set", values={"flow_dog.p": 31.5}) == ""
        for variant in ("green", "orange", ""):
            assert window.ask(do="vary", variant=variant) == ""
            name = f"ink:{variant}" if variant else "ink"
            assert controls.style == set_values(load_style(name), {"flow_dog.p": 31.5})
        assert window.ask(do="set", values={"ink": "#102030"}) == ""
        assert window.ask(do="vary", variant="") == ""
        assert controls.style.ink == load_style("ink").ink, "what variants set is put back"
        assert "no variant" in window.ask(do="vary", variant="purple")


def test_a_session_that_began_with_a_variant_shows_the_others() -> None:
    with showing("ink:green") as (_, controls, visitor), visitor.look() as window:
        told = window.news("panel")
        assert (told["name"], told["variant"], told["text"]) == ("ink", "green", "--style ink:green")
        assert window.ask(do="choose", style="ink:blue") == ""
        assert window.news("panel")["variant"] == "blue"
        assert controls.style == load_style("ink:blue")


def test_switches_reach_the_session() -> None:
    with showing() as (_, controls, visitor), visitor.look() as window:
        for on in (True, False):
            assert window.ask(do="bypass", on=on) == window.ask(do="record", on=on) == ""
            assert window.ask(do="keep_size", on=on) == ""
            assert window.ask(do="compare", at=0.25 * on) == ""
            assert (controls.bypassed, controls.recording, controls.full_size) == (on, on, on)
            assert controls.split == 0.25 * on
        assert window.ask(do="quit") == ""
        assert controls.quitting.is_set()


def test_a_bypass_ends_when_its_browser_goes_away() -> None:
    with showing() as (page, controls, visitor), visitor.look() as stays:
        with visitor.look() as goes:
            assert goes.ask(do="bypass", on=True) == goes.ask(do="compare", at=0.5) == ""
        eventually(lambda: not controls.bypassed and not controls.split)
        with visitor.look() as goes:
            assert goes.ask(do="bypass", on=True) == ""
            assert stays.ask(do="bypass", on=False) == stays.ask(do="bypass", on=True) == ""
        eventually(lambda: page.state == "1 browser")
        assert controls.bypassed, "another browser holds it"


def test_the_status_is_told_as_it_changes() -> None:
    with showing() as (_, controls, visitor), visitor.look() as window:
        controls.status = lambda: Status(
            "ink", source="camera", source_state="waiting", degraded="smaller picture: 8 × 8"
        )
        while (told := window.news("status"))["source_state"] != "waiting" or not told["degraded"]:
            pass
        assert (told["source"], told["shown_ms"]) == ("camera", 0)
        window.say(do="shown", number=window.picture()[0])
        while not window.news("status")["shown_ms"]:
            pass


@pytest.mark.parametrize(
    "text",
    ["", "x", "[]", "1", "null", "[" * 5000, '{"id": 1, "do": "shout"}', '{"id": 1, "do": ["set"]}',
     '{"do": "next"}', '{"id": 1, "do": "next", "more": 1}', b"\0", '{"id": 1, "do": "choose", "style": ""}',
     '{"id": 1, "do": "set"}', '{"id": 1, "do": "set", "values": {}}',
     '{"id": 1, "do": "set", "values": {"a": [1]}}',
     '{"id": 1, "do": "set", "values": {"": 1}}', '{"id": 1, "do": "set", "values": {"a": null}}',
     '{"id": 1, "do": "set", "values": "a=1"}', '{"id": 1, "do": "bypass", "on": "yes"}',
     '{"id": 1, "do": "shown", "number": -1}',
     '{"id": 1, "do": "shown", "number": true}', '{"id": 1, "do": "shown", "number": 12345}'],
)  # fmt: skip
def test_a_message_that_the_page_does_not_send_ends_the_socket_with_one_line(
    text: str | bytes, caplog: pytest.LogCaptureFixture
) -> None:
    with showing() as (page, controls, visitor), visitor.look() as window:
        before = controls.style
        window.picture()
        with caplog.at_level(logging.WARNING, "vidstyle"):
            caplog.clear()
            window.socket.send(text)
            with pytest.raises(ConnectionClosed) as caught:
                window.news("never")
        assert caught.value.rcvd is not None and caught.value.rcvd.code == 1008
        assert ["was disconnected" in record.getMessage() for record in caplog.records] == [True]
        assert (controls.style is before, page.error) == (True, None)


def test_a_kept_picture_is_the_frame_without_loss() -> None:
    frame = live_frame(3, (321, 181))
    with showing() as (page, _, visitor):
        page.offer(frame)
        eventually(lambda: "-3.png" in visitor.ask("/picture.png")[1]["content-disposition"])
        kept = cv2.imdecode(np.frombuffer(visitor.ask("/picture.png")[2], np.uint8), cv2.IMREAD_COLOR)
    assert np.array_equal(kept, frame.video.to_ndarray(format="bgr24"))


def test_a_kept_picture_is_not_divided() -> None:
    divided, whole = live_frame(4), live_frame(90)
    with showing() as (page, _, visitor):
        page.offer(replace(divided, undivided=whole.picture))
        eventually(lambda: "-4.png" in visitor.ask("/picture.png")[1]["content-disposition"])
        kept = cv2.imdecode(np.frombuffer(visitor.ask("/picture.png")[2], np.uint8), cv2.IMREAD_COLOR)
    assert np.array_equal(kept, whole.video.to_ndarray(format="bgr24"))


def test_each_style_has_its_thumbnail(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The shipped ones, one with a value of the user's, one of the user's own, and one with mistakes."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    own = user_styles()
    own.mkdir(parents=True)
    (own / "mine.toml").write_text('format = 1\n[[background]]\nblock = "luma_posterize"\n')
    (own / "bad.toml").write_text("format = 2\n")
    changed = set_values(load_style("ink"), {"ink": "#0000ff"})
    with showing(changed) as (_, controls, visitor):
        found = {name: visitor.ask(f"/thumbnail.jpg?of={name}") for name in controls.names}
        assert {name for name, (status, _, _) in found.items() if status != 200} == {"bad"}
        assert [visitor.ask(f"/thumbnail.jpg{query}")[0] for query in ("", "?of=../x")] == [404, 404]
        pictures = {
            name: cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
            for name, (status, _, data) in found.items()
            if status == 200
        }
    assert {picture.shape for picture in pictures.values()} == {(THUMBNAIL_HEIGHT_PX, THUMBNAIL_WIDTH_PX, 3)}
    assert len({picture.tobytes() for picture in pictures.values()}) == len(pictures)
    blue, _, red = pictures["ink"].mean((0, 1))
    assert blue > red


def test_all_looks_show_the_example_or_the_own_picture(browser: Browser) -> None:
    with showing(names=["ink", "poster"]) as (page, _, _):
        browser.open(page.url)
        images = "[...document.querySelectorAll('#styles img')]"
        shown = f"{images}.map((each) => each.src.match(/([a-z]+).jpg/)[1])"
        browser.until(f"{shown}.length > 1")
        assert set(browser.run(f"return {shown}")) == {"thumbnail"}
        browser.until("document.getElementById('shown-on').textContent === 'on your picture'")
        assert set(browser.run(f"return {shown}")) == {"look"}


def test_a_look_that_cannot_be_drawn_keeps_its_thumbnail(
    browser: Browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    def restyle(style: Style, picture: np.ndarray) -> np.ndarray:
        if style.name == "poster":
            raise StyleError("poster", ["a block is missing"])
        return restyle_thumbnail(style, picture)

    monkeypatch.setattr(page_target, "restyle_thumbnail", restyle)
    image = "document.querySelector('#styles [data-name=poster] img')"
    with showing(names=["ink", "poster"]) as (page, _, _):
        browser.open(page.url)
        browser.until("document.getElementById('shown-on').textContent === 'on your picture'")
        browser.until(f"{image}.src.includes('thumbnail.jpg') && !{image}.matches('.waiting')")


def test_the_look_that_runs_is_listed_in_its_usual_place(browser: Browser) -> None:
    pressed = "document.querySelector('#styles [data-name=vhs][aria-pressed=true]')"
    names = ["ink", "poster", "comic", "cartoon", "watercolor", "sketch", "oil", "vhs"]
    with showing("vhs", names=names) as (page, _, _):
        browser.call(
            "Emulation.setDeviceMetricsOverride", width=1280, height=800, deviceScaleFactor=1, mobile=False
        )
        browser.open(page.url)
        browser.until(pressed)
        listed, is_visible = browser.run(
            f"""const looks = [...document.querySelectorAll("#styles button")];
            return [looks.map((each) => each.dataset.name), {pressed}.checkVisibility()];"""
        )
        assert listed == names and is_visible
        browser.call("Emulation.clearDeviceMetricsOverride")


def test_all_looks_are_seen_without_a_box_that_scrolls(browser: Browser) -> None:
    with showing() as (page, controls, _):
        browser.call(
            "Emulation.setDeviceMetricsOverride", width=1280, height=800, deviceScaleFactor=1, mobile=False
        )
        browser.open(page.url)
        browser.until("!document.getElementById('more').hidden")
        label = browser.run("return document.getElementById('more').textContent")
        assert label == f"All {len(controls.names) - 1} looks and Plain", "the unchanged picture is no look"
        width = "return document.querySelector('#styles button').getBoundingClientRect().width"
        narrow = browser.run(width)
        browser.run("document.getElementById('more').click()")
        assert browser.run(width) == pytest.approx(narrow, abs=0.1), "they keep their width"
        whole = "const { scrollHeight, clientHeight } = document.getElementById('styles');"
        assert browser.run(f"{whole} return scrollHeight <= clientHeight"), "the panel scrolls"
        browser.call(
            "Emulation.setDeviceMetricsOverride", width=360, height=740, deviceScaleFactor=1, mobile=True
        )
        columns = """const tops = [...document.querySelectorAll("#styles button")]
              .map((each) => each.getBoundingClientRect().top);
            return tops.filter((top) => top === tops[0]).length;"""
        assert browser.run(columns) == 3, "a phone lists them, too"
        assert browser.run(f"{whole} return scrollHeight <= clientHeight"), "and the page scrolls"
        browser.run("document.getElementById('more').click()")
        assert browser.run(columns) > 6, "and one row without it"
        browser.call("Emulation.clearDeviceMetricsOverride")


def test_the_style_itself_is_the_first_of_its_variants(browser: Browser) -> None:
    first = "document.querySelector('#variants button')"
    with showing("ink:green") as (page, controls, _):
        browser.open(page.url)
        browser.until(f"{first}?.ariaPressed === 'false'")
        controls.set_values({"flow_dog.p": 31.5})
        browser.run(f"{first}.click()")
        eventually(lambda: controls.style == set_values(load_style("ink"), {"flow_dog.p": 31.5}))
        browser.until(f"{first}.ariaPressed === 'true'")
        assert browser.run(f"return {first}.textContent") == "Standard"


def test_a_reduced_size_is_reported_below_the_picture(browser: Browser) -> None:
    """The report covers no part of the picture, and a phone has all buttons."""
    with showing() as (page, controls, _):
        controls.status = lambda: Status(
            "ink:dark-blue",
            preparing="ink:green",
            degraded="half",
            recording=True,
            message="a.mp4: recording",
        )
        for width in (1280, 360):
            browser.call(
                "Emulation.setDeviceMetricsOverride",
                width=width,
                height=740,
                deviceScaleFactor=1,
                mobile=False,
            )
            browser.open(page.url)
            browser.until("document.getElementById('detail').checkVisibility()")
            top, bottom, right, is_full = browser.run(
                """const boxOf = (id) => document.getElementById(id).getBoundingClientRect();
                return [boxOf("detail").top, boxOf("picture").bottom, boxOf("full").right,
                  document.getElementById("full").checkVisibility()];"""
            )
            assert top >= bottom and right <= width and is_full
            names = (
                "return ['style-name', 'divider-look'].map((id) => document.getElementById(id).textContent)"
            )
            assert browser.run(names) == ["Ink, dark blue"] * 2
            sentence = browser.run("return document.getElementById('sentence').textContent")
            assert sentence.startswith("Preparing Ink, green;")
            browser.until("document.getElementById('message').textContent === 'a.mp4: recording'")
        browser.until("document.getElementById('record-label').textContent === 'Stop, 0:01'")
        browser.call("Emulation.clearDeviceMetricsOverride")


def test_a_recording_can_be_shown_and_downloaded(browser: Browser, tmp_path: Path) -> None:
    film = tmp_path / "vidstyle-1.mp4"
    film.write_bytes(b"film")
    with showing() as (page, controls, visitor):
        browser.open(page.url)
        browser.until("document.getElementById('style-name').textContent === 'Ink'")
        controls.recorded.append(film)
        controls.status = lambda: Status(
            "ink", recorded=(film.name,), message=f"{film.name}: 9 frames, saved"
        )
        links = "[...document.querySelectorAll('#message.shown a')]"
        browser.until(f"{links}.length === 2")
        found = browser.run(
            f"return {links}.map((each) => [each.textContent, each.getAttribute('href'), each.download])"
        )
        assert found == [["Show", "rendered?of=0", ""], ["Download", "rendered?of=0", film.name]]
        assert visitor.ask("/rendered?of=0")[2] == b"film" and visitor.ask("/rendered?of=1")[0] == 404


def test_a_search_shows_the_best_look_first_on_a_phone(browser: Browser) -> None:
    strip = "document.getElementById('styles')"
    with showing("oil") as (page, _, _):
        browser.call(
            "Emulation.setDeviceMetricsOverride", width=360, height=740, deviceScaleFactor=1, mobile=True
        )
        browser.open(page.url)
        browser.until(f"{strip}.children.length > 10")
        moved = """const [strip, finder] = ["styles", "find-look"].map((id) => document.getElementById(id));
            strip.scrollLeft = strip.scrollWidth;
            finder.value = text;
            finder.dispatchEvent(new Event("input"));
            await new Promise((done) => setTimeout(done, 600)); // a smooth movement would have ended
            return [strip.scrollLeft, strip.scrollWidth > strip.clientWidth + 120];"""
        assert browser.run(moved, text="drawing") == [0, True]
        browser.call("Emulation.clearDeviceMetricsOverride")


def test_a_look_that_is_chosen_by_keyboard_ends_the_search(browser: Browser) -> None:
    with showing("oil") as (page, controls, _):
        browser.open(page.url)
        browser.until("document.getElementById('styles').children.length > 10")
        browser.run("document.getElementById('find-look').focus()")
        browser.type("noir")
        browser.press("ArrowDown")
        browser.press("Enter")
        eventually(lambda: controls.style.name == "noir")
        assert browser.run("return document.getElementById('find-look').value") == ""
        assert browser.run("return document.activeElement.dataset.name") == "noir"
        browser.until("document.querySelectorAll('#variants button').length === 2")
        swatches = "return document.querySelectorAll('#variants .swatch').length"
        assert browser.run(swatches) == 0, "both would look the same"


def test_a_look_is_being_prepared_until_its_first_frame_is_seen(browser: Browser) -> None:
    with showing() as (page, controls, _):
        page.offer(replace(live_frame(1), style="ink"))
        browser.open(page.url)
        name, note = (f"document.getElementById('{each}').textContent" for each in ("style-name", "note"))
        browser.until(f"{name} === 'Ink'")
        controls.status = lambda: Status("noir", source_state="running")
        browser.until(
            f"{note} === 'Preparing Noir…' && document.getElementById('panel').matches('.preparing')"
        )
        assert browser.run(f"return {name}") == "Ink", "the picture is still the one before"
        page.offer(replace(live_frame(2), style="noir"))
        browser.until(f"{note} === '' && {name} === 'Noir'")


def test_looks_are_shown_on_the_middle_of_an_early_picture_that_is_not_blank() -> None:
    blank = replace(live_frame(0, (320, 60)), original=Picture.from_array(np.zeros((60, 320, 3), np.uint8)))
    halves = np.zeros((60, 320, 3), np.uint8)
    halves[:, 160:] = 255, 0, 0
    with showing() as (page, _, visitor):
        page.offer(blank)
        with ThreadPoolExecutor(1) as pool:
            answer = pool.submit(visitor.ask, "/look.jpg?of=plain")
            wait([answer], 0.2)
            page.offer(replace(live_frame(1, (320, 60)), original=Picture.from_array(halves)))
        status, _, data = answer.result()
        assert (status, visitor.ask("/look.jpg?of=other")[0]) == (200, 404)
    look = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR_RGB)
    assert look.shape == (THUMBNAIL_HEIGHT_PX, THUMBNAIL_WIDTH_PX, 3)
    for part, color in ((look[20:-20, 20:100], (0, 0, 0)), (look[20:-20, 140:-20], (255, 0, 0))):
        assert np.abs(part.mean((0, 1)) - color).max() < 6


def test_pictures_are_no_larger_than_windows() -> None:
    for size, sent in (((3840, 2160), MAX_SIZE), ((1080, 3840), (304, 1080)), ((63, 31), (63, 31))):
        data = np.frombuffer(encode_jpeg(live_frame(size=size), 80), np.uint8)
        height, width = cv2.imdecode(data, cv2.IMREAD_COLOR).shape[:2]
        assert (width, height) == sent


def test_the_quality_follows_what_a_browser_manages() -> None:
    quality = JpegQuality()
    best = quality.value
    for _ in range(40):
        quality.shown(0.5)
    assert quality.value < best
    for _ in range(400):
        quality.shown(0.01)
    assert quality.value == best


def test_a_session_shows_itself_on_the_page() -> None:
    """From the source through the style to a browser, and back from a slider to the picture."""
    controls = Controls(load_style("plain"), ["plain", "noir"])
    pages: list[PageTarget] = []
    stop = threading.Event()
    session = LiveSession(
        generated(),
        controls,
        [lambda context: pages.append(PageTarget(context.controls, 0, context.meter)) or pages[0]],  # type: ignore[func-returns-value]
        LiveOptions(rate=Fraction(30), device="cpu"),
    )
    thread = threading.Thread(target=session.run, args=(stop,), daemon=True)
    thread.start()
    try:
        eventually(lambda: pages)
        with Visitor(pages[0]).look() as window:
            number, _ = window.picture()
            window.say(do="shown", number=number)
            assert window.ask(do="set", values={"paper": "#ff0000"}) == ""

            def is_red() -> bool:
                number, data = window.picture()
                window.say(do="shown", number=number)
                pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
                return bool(pixels[..., 0].max() < 60)

            eventually(is_red)
            assert controls.status().latency_ms[0] > 0
            assert window.ask(do="quit") == ""
    finally:
        stop.set()
        thread.join(LONG)
    assert not thread.is_alive()


def test_every_part_that_the_scripts_name_is_there() -> None:
    scripts = "".join(path.read_text(encoding="utf-8") for path in STATIC_FOLDER.glob("*.js"))
    page = (STATIC_FOLDER / "page.html").read_text(encoding="utf-8")
    ids = re.findall(r'\bid="([\w-]+)"', page)
    assert len(ids) == len(set(ids))
    assert set(re.findall(r'\$\("([\w-]+)"\)', scripts)) <= set(ids)


@pytest.mark.parametrize("words", [["live", "test"], ["design", "test"]], ids=" ".join)
def test_without_its_library_a_page_says_what_to_install(words: list[str]) -> None:
    program = (
        f"import sys; sys.modules['aiohttp'] = None\nfrom vidstyle.cli import main\nsys.exit(main({words}))"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    told = "vidstyle: page cannot be shown: it needs aiohttp; pip install 'vidstyle[web]'\n"
    assert (run.stderr, run.returncode) == (told, 2)
