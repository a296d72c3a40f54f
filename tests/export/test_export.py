"""`vidstyle export`: pages that run from a file, and style files."""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from browser import Browser
from covering import of_the_day
from media import photograph
from stories import write_film

import vidstyle
from vidstyle.cli import main
from vidstyle.export import EXAMPLE_FILE, RUNNER_FOLDER, join_modules
from vidstyle.export.adjust import with_tints
from vidstyle.export.export_style import export_style
from vidstyle.export.page import minify_css, page_data, page_script
from vidstyle.gpu.compile.es import es_plan
from vidstyle.style import Style, load_style, override, set_values, style_file, style_names

STYLE = {
    "format": 1,
    "name": "test",
    "note": "Soft and flat. Tune `gaussian.sigma` and `posterize.levels` <b>.",
    "knobs": ["gaussian.sigma", "posterize.levels"],
    "height": 720,
    "steady": 0.5,
    "background": [{"block": "gaussian", "sigma": 3}, {"block": "posterize", "levels": 4}],
}
ENDLESS_DRAWING = """
WebGL2RenderingContext.prototype.clientWaitSync = () => WebGL2RenderingContext.TIMEOUT_EXPIRED;
"""
"""Nothing that a page draws by WebGL is ever complete."""


def moved(each: dict[str, Any], control: dict[str, Any], position: float) -> list[float]:
    """The values of a plan of a page with one control moved, as the page computes them."""
    (table,) = each["tables"][control["path"]]
    numbers = list(each["plan"]["values"])
    for change in table["set"]:
        numbers[change["index"]] = float(np.interp(position, table["at"], change["numbers"]))
    return numbers


@pytest.mark.parametrize("name", of_the_day(style_names(), 1))
def test_the_tables_of_a_page_hold_what_plans_of_other_values_hold(name: str) -> None:
    style = with_tints(load_style(name))
    data = page_data(style)
    assert data["controls"]
    for each in data["plans"]:
        width, height = each["plan"]["size"]
        for control in data["controls"]:
            if control["kind"] == "slider":
                at = each["tables"][control["path"]][0]["at"]
                for position in (at[0], at[len(at) // 2], at[-1]):
                    value = round(position) if control["whole"] else position
                    plan = es_plan(set_values(style, {control["path"]: value}), width, height)
                    assert np.allclose(plan["values"], moved(each, control, value), rtol=1e-5, atol=1e-7)
            if control["kind"] == "color":
                numbers = np.array(each["plan"]["values"], float)
                codes = bytes.fromhex(control["value"][1:])
                for table, code, wanted in zip(
                    each["tables"][control["path"]], codes, (90, 20, 200), strict=True
                ):
                    for change in table["set"]:
                        low, high = change["numbers"]
                        slope = (high - low) / (table["at"][1] - table["at"][0])
                        numbers[change["index"]] += slope * (wanted - code)
                plan = es_plan(set_values(style, {control["path"]: "#5a14c8"}), width, height)
                assert np.allclose(plan["values"], numbers, rtol=1e-5, atol=1e-6)


def test_what_changes_the_passes_is_no_control_of_a_page() -> None:
    changes = page_data(load_style({"format": 1, "knobs": ["etf.passes"], "base": [{"block": "etf"}]}))
    assert [control["path"] for control in changes["controls"]] == ["paper"]
    assert changes["fixed"] == ["etf.passes"]


@pytest.fixture
def page(tmp_path: Path) -> Path:
    """The page of a style."""
    vidstyle.save_style(load_style(STYLE), tmp_path / "test.toml")
    assert main(["export", str(tmp_path / "test.toml"), str(tmp_path / "test.html")]) == 0
    return tmp_path / "test.html"


def until(browser: Browser, fact: str) -> None:
    browser.run(f"while (!({fact})) await new Promise((done) => setTimeout(done, 10));")


def shown(browser: Browser) -> np.ndarray:
    """The picture on the page, H x W x 3 uint8, once it is rendered."""
    text = browser.run(
        """const busy = document.getElementById("busy");
        for (let frame = 0; frame < 5 || !busy.hidden; frame++) await new Promise(requestAnimationFrame);
        return document.getElementById("picture").toDataURL("image/png").split(",")[1];"""
    )
    content = np.frombuffer(base64.b64decode(text), np.uint8)
    return cv2.imdecode(content, cv2.IMREAD_COLOR)[..., ::-1]


def off(made: np.ndarray, source: np.ndarray, style: Style) -> float:
    """The share of samples that are more than two codes off; the page itself shifts gray by up to one."""
    right = vidstyle.stylize(source, replace(style, steady=0.0), "cpu").astype(int)
    return float((np.abs(made - right) > 2).mean())


def test_the_modules_of_a_page_declare_no_name_twice() -> None:
    """They are joined into one module, where the second one would be a syntax error."""
    names = re.findall(
        r"^(?:async )?(?:export )?(?:function|class|const|let) (\w+)",
        join_modules(RUNNER_FOLDER.with_name("page.js")),
        re.M,
    )
    assert len(names) > 60 and [name for name in names if names.count(name) > 1] == []


def test_casts_and_comments_on_lines_of_their_own_are_removed_from_a_page(tmp_path: Path) -> None:
    cast = "/** @type {HTMLElement} */ "
    lines = '(get("a")).hidden = true;\nlet kept; // Why.\n'
    module = tmp_path / "module.js"
    two = "\n/**\n * Two.\n */\nconst two = 2;\n"
    module.write_text(f"/** One. */\nexport const one = 1;\n  // A reason.\n  {cast}{lines}{two}")
    assert page_script(module) == f"const one = 1;\n{lines}const two = 2;\n"


def test_text_and_regular_expressions_of_scripts_stay(tmp_path: Path) -> None:
    shader = "const shader = `#version 300 es\n// a \\` b\n    color = 1;\n/** c */\n`;\n"
    words = r"""const all = ["// a", '/** c */', `d${"`"}  e`].map((each) => each.replace(/  \/\/|`/, ""));"""
    module = tmp_path / "module.js"
    module.write_text(f"  // A reason.\n{shader}  {words}\n  // Another.\n")
    assert page_script(module) == f"{shader}{words}\n"


def test_strings_and_addresses_of_css_stay() -> None:
    kept = [
        'content:"a ; /* b */ { c }  \\"  ; "',
        "content:' } '",
        "background:url(data:image/svg+xml;utf8,<svg> { } /* d */ </svg>)",
    ]
    css = "".join(f"a > b {{\n  /* Don't. */\n  {each} ;\n  color: red; /* \" */ }}\n" for each in kept)
    assert minify_css(css) == "".join(f"a > b{{{each};color: red;}}" for each in kept)


def test_a_page_restyles_a_picture_from_a_file_and_asks_nobody(
    page: Path, browser: Browser, tmp_path: Path
) -> None:
    source = cv2.resize(photograph("coffee"), (480, 360), interpolation=cv2.INTER_AREA)
    assert cv2.imwrite(str(tmp_path / "source.png"), source[..., ::-1])
    browser.open(f"{page.as_uri()}?side=360")
    until(browser, """document.getElementById("facts").textContent""")
    browser.choose_file("#file", tmp_path / "source.png")
    until(browser, """document.getElementById("picture").width === 480""")
    style = replace(load_style(STYLE), focus=0.0)
    assert off(shown(browser), source, style) <= 0.001
    browser.run(
        """const levels = document.querySelector("input[type=number][max='32']");
        levels.value = 7;
        levels.dispatchEvent(new Event("change"));"""
    )
    assert off(shown(browser), source, override(style, ["posterize.levels=7"])) <= 0.001
    assert off(shown(browser), source, style) > 0.1
    x, y, width, height = browser.place("#picture")
    wide = min(width, height * 480 / 360)
    browser.press("c")
    browser.drag((x, y), (x - wide / 4, y))
    part = shown(browser)
    assert np.abs(part[:, :110].astype(int) - source[:, :110]).max() <= 1
    assert np.abs(part[:, 130:].astype(int) - source[:, 130:]).mean() > 8
    line = browser.place("#divider")
    assert (line[0], line[3]) == pytest.approx((x - wide / 4, wide * 360 / 480), abs=1)
    browser.press("c")
    assert browser.run("return document.getElementById('divider').hidden")
    hold = """const button = document.getElementById("hold");
        button.setPointerCapture = () => {};
        button.dispatchEvent(new PointerEvent(kind));"""
    browser.run(hold, kind="pointerdown")
    assert np.abs(shown(browser).astype(int) - source).max() <= 1
    browser.run(hold, kind="pointerup")
    assert np.abs(shown(browser).astype(int) - source).max() <= 1, "a click stays"
    for kind in ("pointerdown", "pointerup"):
        browser.run(hold, kind=kind)
    assert np.abs(shown(browser)[:, :110].astype(int) - source[:, :110]).mean() > 8
    asked = [
        event["params"]["request"]["url"]
        for event in browser.events
        if event["method"] == "Network.requestWillBeSent"
    ]
    assert {url.partition(":")[0] for url in asked} <= {"file", "blob", "data"}
    assert not [event for event in browser.events if event["method"] == "Runtime.exceptionThrown"]


def test_an_error_covers_no_button_and_ends_with_the_next_file(
    page: Path, browser: Browser, tmp_path: Path
) -> None:
    (tmp_path / "get.py").write_text("print()")
    browser.open(page.as_uri())
    until(browser, """document.body.matches(".example")""")
    browser.choose_file("#file", tmp_path / "get.py")
    message = "document.getElementById('message')"
    until(browser, f"{message}.matches('.shown') && {message}.textContent.startsWith('get.py: ')")
    covered = f"""const said = {message}.getBoundingClientRect();
        return [...document.querySelectorAll("#welcome button")].map((each) => each.getBoundingClientRect())
          .some((each) => each.bottom > said.top && each.top < said.bottom);"""
    assert not browser.run(covered)
    browser.choose_file("#file", EXAMPLE_FILE)
    until(browser, """!document.body.matches(".example")""")
    assert not browser.run(f"return {message}.checkVisibility({{ visibilityProperty: true }})")
    browser.run("document.querySelector('input[type=number]').focus()")
    browser.press("?")
    assert browser.run("return document.getElementById('keys').open")


def test_the_example_is_in_the_style_before_the_page_has_drawn_it(page: Path, browser: Browser) -> None:
    script = browser.call("Page.addScriptToEvaluateOnNewDocument", source=ENDLESS_DRAWING)
    browser.open(page.as_uri())
    browser.call("Page.removeScriptToEvaluateOnNewDocument", **script)
    until(browser, """document.body.matches(".example")""")
    first = shown(browser)
    bare = cv2.imdecode(np.fromfile(EXAMPLE_FILE, np.uint8), cv2.IMREAD_COLOR_RGB)
    large = cv2.resize(bare, first.shape[1::-1], interpolation=cv2.INTER_CUBIC)
    left, right = first[:, : int(0.39 * first.shape[1])], slice(int(0.41 * first.shape[1]), None)
    assert np.abs(first.astype(int) - vidstyle.stylize(large, load_style(STYLE)))[:, right].mean() < 8
    assert np.abs(first.astype(int) - large)[:, right].mean() > 12
    assert np.abs(left.astype(int) - large[:, : left.shape[1]]).mean() < 3, "with the original next to it"
    browser.choose_file("#file", EXAMPLE_FILE)
    until(browser, """!document.body.matches(".example")""")
    said = "return document.getElementById('quality').textContent"
    assert browser.run(said) == "The picture is being drawn.", "there is no draft yet"


def test_a_paused_film_is_drawn_in_full_detail_and_tells_its_time(
    page: Path, browser: Browser, tmp_path: Path
) -> None:
    film = write_film(tmp_path / "film.mp4", [np.full((400, 640, 3), 128, np.uint8)] * 25, rate=25)
    browser.open(page.as_uri())
    until(browser, """document.body.matches(".example")""")
    browser.choose_file("#file", film)
    until(
        browser,
        """!document.body.matches(".example") && document.getElementById("picture").height === 720
        && document.getElementById("busy").hidden""",
    )
    said = [
        browser.run(f"return document.getElementById('{name}').textContent") for name in ("quality", "time")
    ]
    assert said == ["The picture has its full resolution.", "0:00 / 0:01"]
    browser.run("document.getElementById('again').click()")
    assert browser.run("return document.body.matches('.empty')")
    browser.press("Escape")
    assert not browser.run("return document.body.matches('.empty')")


def test_a_picture_is_saved_in_the_size_of_its_source_under_its_name(
    page: Path, browser: Browser, tmp_path: Path
) -> None:
    source = cv2.resize(photograph("coffee"), (600, 400), interpolation=cv2.INTER_AREA)
    assert cv2.imwrite(str(tmp_path / "my cup.png"), source[..., ::-1])
    browser.open(page.as_uri())
    until(browser, """document.body.matches(".example")""")
    browser.run(
        """globalThis.said = [];
        new MutationObserver(() => said.push(document.getElementById("save-label").textContent))
          .observe(document.getElementById("save-label"), { childList: true });
        const address = URL.createObjectURL;
        URL.createObjectURL = (blob) => ((globalThis.blob = blob), address(blob));
        HTMLAnchorElement.prototype.click = function () { globalThis.saved = this; };"""
    )
    browser.choose_file("#file", tmp_path / "my cup.png")
    until(browser, """!document.body.matches(".example")""")
    save = "document.getElementById('save')"
    browser.run(f"{save}.click(); {save}.click();")  # while the draft is drawn
    assert browser.run(f"return {save}.ariaBusy") == "true"
    until(browser, "globalThis.saved")
    name, text, said = browser.run(
        """const content = new Uint8Array(await blob.arrayBuffer());
        const text = Array.from(content, (each) => String.fromCharCode(each)).join("");
        return [saved.download, btoa(text), said];"""
    )
    made = cv2.imdecode(np.frombuffer(base64.b64decode(text), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert (name, made.shape) == ("my cup-test.png", (400, 600, 3))
    large = cv2.resize(source, (1080, 720), interpolation=cv2.INTER_CUBIC)
    right = vidstyle.stylize(large, replace(load_style(STYLE), steady=0.0, focus=0.0), "cpu")
    assert np.abs(cv2.resize(right, (600, 400), interpolation=cv2.INTER_AREA).astype(int) - made).mean() < 4
    parts = [int(each) for label in said for each in re.findall("[0-9]+", label)]
    assert parts and parts == sorted(parts) and parts[-1] == 100
    assert all(label.startswith("Saving… ") for label in said if "%" in label)
    until(browser, f"{save}.ariaBusy === 'false'")
    assert said[-1] == "Save picture" and said.count("Saving…") == 1
    browser.run(
        """globalThis.widths = [];
        globalThis.saved = null;
        const canvas = document.getElementById("picture");
        new MutationObserver(() => widths.push(canvas.width)).observe(canvas, { attributes: true });
        const slider = document.querySelector("#controls input[type=range]");
        slider.dispatchEvent(new KeyboardEvent("keydown", { key: "PageDown" }));
        document.getElementById("save").click();"""
    )
    until(browser, "globalThis.saved")
    assert browser.run("return widths.slice(-2)") == [540, 1080], "the draft shows the choice meanwhile"


def test_a_reduced_picture_is_saved_with_its_size(page: Path, browser: Browser, tmp_path: Path) -> None:
    assert cv2.imwrite(str(tmp_path / "cup.png"), cv2.resize(photograph("coffee"), (600, 400)))
    browser.open(f"{page.as_uri()}?side=360")
    until(browser, """document.body.matches(".example")""")
    browser.choose_file("#file", tmp_path / "cup.png")
    until(browser, """!document.body.matches(".example")""")
    message = "document.getElementById('message')"
    browser.run(
        """HTMLAnchorElement.prototype.click = () => {};
        document.getElementById("save").click();"""
    )
    until(browser, f"{message}.textContent")
    said = "cup-test.png is in your downloads: 540 × 360 pixels. “vidstyle render” draws all 600 × 400."
    assert browser.run(f"return {message}.textContent") == said


def test_a_variant_keeps_values_that_it_does_not_name(browser: Browser, tmp_path: Path) -> None:
    variants = {"flat": {"posterize.levels": 2}, "flatter": {"posterize.levels": 3}}
    vidstyle.save_style(load_style(STYLE | {"variants": variants}), tmp_path / "a.toml")
    assert main(["export", str(tmp_path / "a.toml"), str(tmp_path / "a.html")]) == 0
    browser.open(f"{(tmp_path / 'a.html').as_uri()}?side=360#test&gaussian.sigma=5")
    until(browser, """document.getElementById("facts").textContent""")
    state = """const value = (path) => document.getElementById(`value-${path}`).closest(".control")
          .querySelector("input[type=number]").value;
        document.querySelectorAll("#variants button")[clicked].click();
        const pressed = [...document.querySelectorAll("#variants [aria-pressed=true]")];
        const names = pressed.map((each) => each.textContent);
        return [value("gaussian.sigma"), value("posterize.levels"), names];"""
    for clicked, levels, pressed in ((1, "2", "Flat"), (2, "3", "Flatter"), (0, "4", "Standard")):
        assert browser.run(state, clicked=clicked) == ["5", levels, [pressed]]


def test_the_comparison_is_neither_saved_nor_over_the_invitation(
    page: Path, browser: Browser, tmp_path: Path
) -> None:
    source = cv2.resize(photograph("coffee"), (540, 360), interpolation=cv2.INTER_AREA)
    assert cv2.imwrite(str(tmp_path / "cup.png"), source[..., ::-1])
    browser.open(f"{page.as_uri()}?side=360")
    until(browser, """document.body.matches(".example")""")
    browser.run("document.getElementById('open').focus()")
    browser.choose_file("#file", tmp_path / "cup.png")
    until(browser, """!document.body.matches(".example")""")
    assert browser.run("return document.activeElement.id") == "again"
    browser.run(
        """URL.createObjectURL = (blob) => ((globalThis.blob = blob), "data:,");
        HTMLAnchorElement.prototype.click = () => {};"""
    )
    browser.press("c")
    browser.press("s")
    until(browser, "globalThis.blob")
    text = browser.run(
        """const content = new Uint8Array(await blob.arrayBuffer());
        return btoa(Array.from(content, (each) => String.fromCharCode(each)).join(""));"""
    )
    made = cv2.imdecode(np.frombuffer(base64.b64decode(text), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert np.abs(made[:, :250].astype(int) - source[:, :250]).mean() > 8, "the original is not saved"
    divider = "document.getElementById('divider')"
    assert browser.run(f"return {divider}.checkVisibility()")
    browser.press("o")
    assert browser.run(f"return document.body.matches('.empty') && !{divider}.checkVisibility()")


def test_the_values_of_a_style_are_its_first_variant(browser: Browser, tmp_path: Path) -> None:
    vidstyle.save_style(
        load_style(STYLE | {"variants": {"flat": {"posterize.levels": 2}}}), tmp_path / "a.toml"
    )
    assert main(["export", str(tmp_path / "a.toml"), str(tmp_path / "a.html")]) == 0
    browser.open(f"{(tmp_path / 'a.html').as_uri()}?side=360")
    until(browser, """document.getElementById("facts").textContent""")
    state = """const chips = [...document.querySelectorAll("#variants button")];
        if (clicked !== null) chips[clicked].click();
        const levels = document.querySelector("input[type=number][max='32']").value;
        return [levels, chips.map((chip) => [chip.textContent, chip.ariaPressed])];"""
    for clicked, levels, pressed in ((None, "4", 0), (1, "2", 1), (1, "2", 1), (0, "4", 0)):
        assert browser.run(state, clicked=clicked) == [
            levels,
            [["Standard", str(pressed == 0).lower()], ["Flat", str(pressed == 1).lower()]],
        ]


def test_a_link_holds_the_values_that_the_controls_allow(page: Path, browser: Browser) -> None:
    browser.open(f"{page.as_uri()}?side=360#test&posterize.levels=7&ink=%23zz0000&paper=javascript:1&other=1")
    until(browser, """document.getElementById("facts").textContent""")
    value = """return document.querySelector("input[type=number][max='32']").value"""
    assert browser.run(value) == "7"
    browser.run(
        """Object.defineProperty(navigator, "clipboard", { value: {
          writeText: async (text) => void (globalThis.copied = text) } });
        document.getElementById("link").click();"""
    )
    assert browser.run("return copied") == f"{page.as_uri()}?side=360#test&posterize.levels=7"
    changed = "return document.querySelectorAll('.control.changed').length"
    assert browser.run(changed) == 1
    reset = "document.getElementById('reset')"
    for text, levels in ("Undo reset", "4"), ("Reset", "7"), ("Undo reset", "4"):
        browser.run(f"{reset}.focus(); {reset}.click()")
        assert browser.run(f"return {reset}.textContent") == text and browser.run(value) == levels
        assert browser.run(f"return document.activeElement === {reset}"), "the focus is not lost"
    assert browser.run(changed) == 0
    browser.open("about:blank")
    browser.open(f"{page.as_uri()}?side=360#test&posterize.levels=7000")
    until(browser, """document.getElementById("facts").textContent""")
    assert int(browser.run(value)) <= 32 and browser.run(value) != "7"


def test_the_theme_is_switched(page: Path, browser: Browser) -> None:
    browser.open(page.as_uri())
    until(browser, """document.getElementById("theme").title""")
    ground = "return getComputedStyle(document.body).backgroundColor"
    before = browser.run(ground)
    browser.click("#theme")
    assert browser.run(ground) != before
    browser.click("#theme")
    assert browser.run(ground) == before


def test_a_page_shows_a_camera_alone_upon_nothing(page: Path, browser: Browser) -> None:
    """As OBS shows it: `?camera&bare`. Chromium's own camera is a drawing that moves."""
    browser.open(f"{page.as_uri()}?camera&bare&side=360")
    until(browser, """document.getElementById("picture").width > 100""")
    width, background, panel = browser.run(
        """const picture = document.getElementById("picture");
        const style = (id) => getComputedStyle(document.getElementById(id) ?? document.body);
        return [picture.width, style("").backgroundColor, style("panel").display];"""
    )
    assert (width, background, panel) == (640, "rgba(0, 0, 0, 0)", "none")


def test_a_style_file_holds_what_the_options_change_and_the_comments(tmp_path: Path) -> None:
    target = tmp_path / "mine.toml"
    options = ["--set", "flow_dog.p=22", "--steady", "0.2", "--detail", "1.5"]
    assert main(["export", "ink:dark-blue", str(target), *options]) == 0
    mine, ink = load_style(target), load_style("ink:dark-blue")
    assert (mine.name, mine.ink, mine.steady, mine.height) == ("mine", ink.ink, 0.2, 1080)
    assert mine.steps == override(ink, ["flow_dog.p=22"]).steps
    shipped = style_file("ink")
    assert shipped is not None
    comments = re.findall("^#.*", shipped.read_text(), re.M)
    assert comments and all(each in target.read_text() for each in comments)


def test_an_export_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    taken = tmp_path / "taken.html"
    taken.write_text("mine")
    for arguments, code, reason in (
        (["ink", str(tmp_path / "ink.png")], 2, "is not an export format"),
        (["ink", str(taken)], 2, "already exists"),
        (["inc", str(tmp_path / "ink.html")], 3, "did you mean 'ink'?"),
        (["plain", str(tmp_path / "ink.html"), "--detail", "2"], 2, "has no height"),
    ):
        assert main(["export", *arguments]) == code
        assert reason in capsys.readouterr().err
    assert taken.read_text() == "mine" and list(tmp_path.iterdir()) == [taken]


@pytest.mark.parametrize(("kind", "column"), [(".html", 0), (".hook", 1)])
def test_the_documented_sizes_are_those_of_the_smallest_and_the_largest_style(
    tmp_path: Path, kind: str, column: int
) -> None:
    text = (Path(__file__).parents[2] / "docs" / "everywhere.md").read_text(encoding="utf-8")
    row = re.search(r"^\| size of the file, from `(\w+)` to `(\w+)` \|(.*)\|$", text, re.MULTILINE)
    assert row is not None
    documented = [float(n) for n in re.findall(r"\d+", row[3].split("|")[column].replace(",", ""))]
    size = (1280, 720) if kind == ".hook" else None
    for name, kilobytes in zip(row.groups()[:2], documented, strict=True):
        written = export_style(load_style(name), tmp_path / f"{name}{kind}", size=size)
        assert written / 1000 == pytest.approx(kilobytes, rel=0.02, abs=1), name


@pytest.mark.parametrize(("ending", "is_reported"), [("html", True), ("hook", True), ("toml", False)])
def test_an_export_reports_that_it_has_no_focus(
    ending: str, is_reported: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """In one line; not of a style without focus."""
    style = load_style("poster")
    with caplog.at_level("INFO", "vidstyle"):
        for number, focus in enumerate((1.0, 0.0)):
            export_style(replace(style, focus=focus), tmp_path / f"{number}.{ending}")
    lines = [each.message for each in caplog.records if "focus" in each.message]
    assert len(lines) == is_reported and all("0." + ending in line for line in lines)
