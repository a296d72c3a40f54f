"""The page of the designer in a browser: a style is built by mouse, and once more by keyboard alone."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import combinations, product
from pathlib import Path

import pytest
from browser import Browser
from browser import browser as browser
from media import make_clip, make_picture
from waiting import eventually

import vidstyle
from vidstyle.design.designer import Designer
from vidstyle.design.drafts import Drafts
from vidstyle.design.page import open_page
from vidstyle.design.page.design_server import DesignServer
from vidstyle.preview.clip import Clip, open_clip
from vidstyle.style import Step, Style, load_style, save_style, style_names

WATCH = """
globalThis.faults = [];
globalThis.compiled = 0;
addEventListener("error", (event) => faults.push(event.message));
addEventListener("unhandledrejection", (event) => faults.push(String(event.reason)));
addEventListener("securitypolicyviolation", (event) => faults.push(event.violatedDirective));
addEventListener("beforeunload", (event) => event.stopImmediatePropagation());
const compile = WebGL2RenderingContext.prototype.compileShader;
WebGL2RenderingContext.prototype.compileShader = function (...all) {
  globalThis.compiled += 1;
  return compile.apply(this, all);
};
"""
"""Counts shaders, notes what a page does wrong, and leaves it without a question."""
FRAMES = 10
CHOSEN = ".card.selected"


class Page:
    """A designer, and the browser that shows it."""

    def __init__(self, browser: Browser, server: DesignServer, folder: Path) -> None:
        self.browser, self.server, self.folder = browser, server, folder

    def steps(self, layer: str) -> list[str]:
        document = self.server.designer.opened
        return [step.table["block"] for step in document.content.layers[layer]]

    @property
    def history(self) -> list[str]:
        """The labels of the edits that can be undone, the last one last."""
        return [each["label"] for each in self.server.designer.state["history"]]

    def add(self, gap: str, block: str, name: str) -> None:
        """Add a step by mouse."""
        self.browser.click(f".gap{gap}")
        self.browser.until("document.activeElement.id === 'search'")
        self.browser.type(block)
        self.browser.until(f"document.getElementById('blocks').dataset.asked === {block!r}")
        self.browser.click("#blocks .option")
        self.shows(name)

    def slide(self, name: str, part: float) -> float:
        """Drag a slider to a part of its length; the value that it then has."""
        slider = f".inspector [data-path$='.{name}'] input[type=range]"
        x, y, width, _ = self.browser.still(slider)
        part_of = "return Number(document.querySelector(slider).style.getPropertyValue('--part'))"
        now = self.browser.run(part_of, slider=slider)
        self.browser.drag((x + (now - 0.5) * (width - 16), y), (x + (part - 0.5) * (width - 16), y))
        number = slider.replace("range", "number")
        return float(self.browser.run("return document.querySelector(number).value", number=number))

    def drop(self, path: Path) -> None:
        """Drop a file on the page."""
        self.browser.run(
            """const data = new DataTransfer();
            data.items.add(new File([Uint8Array.from(atob(text), (each) => each.charCodeAt(0))], name));
            dispatchEvent(new DragEvent("drop", { dataTransfer: data }));""",
            text=base64.b64encode(path.read_bytes()).decode(), name=path.name,
        )  # fmt: skip

    def begin(self) -> None:
        """Begin a style from nothing."""
        self.browser.click(".tile.new")
        self.browser.until("document.querySelectorAll('.gap').length === 3")

    def moves(self) -> None:
        """Wait until the picture has changed twice by itself."""
        seen: set[str] = set()

        def has_moved() -> bool:
            seen.add(self.browser.run("return document.getElementById('picture').toDataURL()"))
            return len(seen) > 2

        eventually(has_moved, "the picture stands still")

    def is_drawn(self) -> None:
        """Wait until the picture is that of the present style."""
        revision = self.server.designer.opened.revision
        self.browser.until(f"document.getElementById('picture').dataset.revision >= {revision}")

    def shows(self, text: str) -> None:
        """Wait until the chosen card has this name, and the server has no more to say."""
        self.browser.until(f"document.querySelector('{CHOSEN} .name')?.textContent === {text!r}")

    def told(self, text: str) -> None:
        """Wait for what a screen reader hears."""
        self.browser.until(f"document.getElementById('toast').textContent.includes({text!r})")

    def undone(self, label: str) -> None:
        """Wait until undo would take this back."""
        self.browser.until(f"document.getElementById('undo').title.includes({label!r})")


@contextmanager
def shown(browser: Browser, clip: Clip, folder: Path) -> Iterator[Page]:
    """The page of a designer that writes into a folder."""
    server = open_page(Designer(clip, folder, Drafts(folder / "draft.json")), 0, "cpu")
    browser.call(
        "Emulation.setDeviceMetricsOverride", width=1440, height=900, deviceScaleFactor=1, mobile=False
    )
    browser.call("Network.disable")  # it tells every message of every socket
    watching = browser.call("Page.addScriptToEvaluateOnNewDocument", source=WATCH)["identifier"]
    try:
        browser.open(server.url)
        browser.until("document.querySelector('.tile')")
        yield Page(browser, server, folder)
        assert browser.run("return faults") == []
        browser.open("about:blank")
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=watching)
        server.close()


@pytest.fixture
def film(tmp_path: Path) -> Path:
    return make_clip(tmp_path / "film.mp4", size=(128, 72), frames=FRAMES + 2)


@pytest.fixture
def page(browser: Browser, film: Path, tmp_path: Path) -> Iterator[Page]:
    with shown(browser, open_clip(film), tmp_path) as page:
        yield page


def by_hand(page: Page, **values: float) -> None:
    """The style that the steps make, and its film, are those that the page has written."""
    hatching = Step("pattern", {"spacing": values["spacing"]})
    lines = Step("flow_dog", {"sigma": values["sigma"]})
    threshold = Step("soft_threshold", {"epsilon": values["epsilon"]})
    style = Style("hatched", background=(hatching,), lines=(lines, threshold))
    save_style(style, page.folder / "by-hand.toml")
    assert (page.folder / "hatched.toml").read_bytes() == (page.folder / "by-hand.toml").read_bytes()
    vidstyle.render(page.folder / "film.mp4", page.folder / "by-hand.mp4", style, frames=FRAMES)
    assert (page.folder / "hatched.mp4").read_bytes() == (page.folder / "by-hand.mp4").read_bytes()


def test_no_moving_card_catches_a_click_on_the_button_of_a_gap(page: Page) -> None:
    """A card that covers the button between press and release takes the click from it."""
    browser = page.browser
    page.begin()
    browser.run("""globalThis.moved = new Set();
    addEventListener("transitionrun", (event) => moved.add(event.target.id));""")
    page.add("[data-layer=background]", "pattern", "Hatching")
    page.add("[data-layer=background][data-index='0']", "threshold", "Black and white")
    pattern, threshold = page.server.designer.opened.content.layers["background"][::-1]
    browser.until(f"moved.has('card-{pattern.number}')")
    assert not browser.run(f"return moved.has('card-{threshold.number}')"), "a new card appears in its place"
    hit = """const card = document.querySelector(".card.selected");
    Object.assign(card.style, { transition: "none", margin: "-30px" });
    return [...document.querySelectorAll(".gap")].map((gap) => {
      card.style.translate = gap.style.translate;
      const { left, top } = gap.getBoundingClientRect();
      return document.elementFromPoint(left + 12, top + 12).closest(".gap") === gap;
    });"""
    assert browser.run(hit) == [True] * 5


def test_a_style_is_built_by_mouse(page: Page) -> None:
    browser = page.browser

    def choose(name: str) -> None:
        number = browser.run(
            "return document.querySelector(`.card[aria-label^='${name}']`).id",
            name=name,
        )
        browser.click(f"#{number}")

    page.begin()
    page.add("[data-layer=background]", "pattern", "Hatching")
    page.add("[data-layer=lines]", "threshold", "Black and white")
    page.add("[data-layer=base]", "flow dog", "Sharpen along lines")
    # The lines of the paper's third style: the filter belongs in front of the threshold.
    start, end = (browser.still(each)[:2] for each in (CHOSEN, ".gap[data-layer=lines][data-index='0']"))
    browser.drag(start, end)
    page.undone("Move")
    assert (page.steps("base"), page.steps("background")) == ([], ["pattern"])
    assert page.steps("lines") == ["flow_dog", "soft_threshold"]
    values = {"sigma": page.slide("sigma", 0.4)}
    choose("Black and white")
    values["epsilon"] = page.slide("epsilon", 0.3)
    choose("Hatching")
    values["spacing"] = page.slide("spacing", 0.6)
    page.undone("Stroke distance")
    for name, pressed in (("Mute", "true"), ("Unmute", "false")):
        browser.click(".actions button[aria-label=Mute]")
        browser.until(f"document.querySelector('.actions [aria-label=Mute]').ariaPressed === '{pressed}'")
        page.undone(name)
    for name, label, part in (
        ("levels", "Number of tones", 0.9), ("angle", "Stroke direction", 0.2), ("wobble", "Hand wobble", 0.9)
    ):  # fmt: skip
        page.slide(name, part)
        page.undone(label)
    for label in ("Stroke direction", "Number of tones", "Unmute", ": Mute", "Stroke distance"):
        browser.click("#undo")
        page.undone(label)
    browser.click("#save")
    browser.type("hatched")
    browser.click("#save-dialog .strong")
    page.told("hatched.toml")
    browser.click("#render")
    browser.click("#render-frames")
    browser.type(str(FRAMES))
    browser.click("#render-go")
    page.told("hatched.mp4")
    by_hand(page, **values)


def test_values_that_change_before_an_answer_are_undone_in_order(page: Page) -> None:
    """A user is faster than a busy server: the second slider moves while values of the first wait."""
    page.begin()
    page.add("[data-layer=background]", "pattern", "Hatching")
    before, revision = len(page.history), page.server.designer.opened.revision
    last = page.browser.run(
        """return names.map((name) => {
          const [number, range] = document.querySelectorAll(`.inspector [data-path$='.${name}'] input`);
          for (const part of [0.2, 0.4, 0.8]) {
            range.value = part * range.max;
            range.dispatchEvent(new Event("input"));
          }
          return `${labels[name]}: ${number.value}`;
        });""",
        names=["levels", "angle", "wobble"],
        labels={"levels": "Number of tones", "angle": "Stroke direction", "wobble": "Hand wobble"},
    )
    page.undone(last[-1])
    assert page.history[before:] == last
    assert page.server.designer.opened.revision == revision + len(last), "only the newest values are sent"


def test_a_style_is_built_by_keyboard_alone(page: Page) -> None:
    browser = page.browser

    def add(block: str, name: str) -> None:
        browser.press("a")
        browser.until("document.activeElement.id === 'search'")
        browser.type(block)
        browser.press("Enter")
        page.shows(name)
        browser.until(f"document.activeElement === document.querySelector('{CHOSEN}')")

    def enter(label: str, *numbers: float) -> None:
        """Values of the step, from its first on; None goes past one."""
        browser.press("Enter")
        for number in numbers:
            if number is not None:
                browser.press("Enter")
                browser.type(str(number))
                browser.press("Enter")
            browser.press("Tab", "Tab")
        page.undone(label)
        browser.press("Escape")

    browser.until("document.activeElement.classList.contains('new')")
    browser.press("Enter")
    browser.until("document.activeElement.id === 'card-source'")
    browser.press("ArrowRight")
    add("pattern", "Hatching")
    enter("Stroke distance", None, 9)
    browser.press("ArrowRight")
    add("soft threshold", "Black and white")
    enter("Amount of black", None, 55)
    browser.press("ArrowLeft", "ArrowLeft")
    page.shows("Source")
    add("flow dog", "Sharpen along lines")
    browser.press("Alt+ArrowDown", "Alt+ArrowDown")
    page.told("Sharpen along lines moved to lines, position 1 of 2")
    enter("Line width", 1.5)
    for label in ("Mute", "Unmute"):
        browser.press("m")
        page.undone(label)
    enter("Line strength", None, 30)
    enter("Line width", 2)
    enter("Line strength", None, 31)
    for label in ("Line width", "Line strength", "Unmute", ": Mute", "Line width"):
        browser.press("Ctrl+z")
        page.undone(label)
    browser.press("Ctrl+s")
    browser.type("hatched")
    browser.press("Enter")
    page.told("hatched.toml")
    browser.press("Ctrl+Enter")
    browser.press("Tab")
    browser.type(str(FRAMES))
    browser.press("Enter")
    page.told("hatched.mp4")
    by_hand(page, spacing=9.0, sigma=1.5, epsilon=55.0)


def test_the_browser_restyles_and_a_dragged_value_compiles_nothing(page: Page) -> None:
    browser = page.browser
    page.begin()
    browser.run(
        """const where = document.getElementById("where");
        where.value = "page";
        where.dispatchEvent(new Event("change"));"""
    )
    browser.until("document.getElementById('who').textContent === 'Preview in software'")
    page.add("[data-layer=background]", "pattern", "Hatching")
    page.is_drawn()
    before = browser.run("return [compiled, document.getElementById('picture').toDataURL()]")
    assert before[0] > 1
    value = page.slide("spacing", 0.8)
    page.undone(f"Stroke distance: {value:g}")
    page.is_drawn()
    compiled, picture = browser.run("return [compiled, document.getElementById('picture').toDataURL()]")
    assert compiled == before[0]
    assert picture != before[1]
    browser.press("Escape", "k")
    page.told("no value differs by more than 1")


def test_the_server_renders_styles_with_masks(page: Page, tmp_path: Path) -> None:
    """A browser cannot compute masks."""
    style = Style(
        "keyed", keep="screen", masks={"screen": {"color": "#00b140"}}, background=(Step("posterize"),)
    )
    file = tmp_path / "keyed.toml"
    save_style(style, file)
    page.begin()
    page.browser.run(
        """const where = document.getElementById("where");
        where.value = "page";
        where.dispatchEvent(new Event("change"));"""
    )
    page.browser.until("document.getElementById('who').textContent === 'Preview in software'")
    page.drop(file)
    page.browser.until("document.getElementById('name').value === 'keyed'")
    page.browser.until("document.getElementById('who').textContent === 'Preview by vidstyle'")
    page.is_drawn()


def test_files_are_dropped_on_the_page(page: Page) -> None:
    browser = page.browser

    page.drop(make_picture(page.folder / "picture.png", size=(96, 64)))
    browser.until("document.getElementById('previews').textContent.includes('picture.png')")
    save_style(Style("dropped", background=(Step("hue", {"angle": 90.0}),)), page.folder / "dropped.toml")
    page.drop(page.folder / "dropped.toml")
    browser.until("document.getElementById('name').value === 'dropped'")
    browser.until("document.querySelector('#card-source .main').textContent === '96 × 64'")
    assert page.steps("background") == ["hue"]
    (page.folder / "wrong.toml").write_text("format = 1\n[[lines]]\nblock = 'nothing'\n")
    browser.until("document.getElementById('saved').textContent === 'Edited'")
    browser.press("Ctrl+z")
    page.drop(page.folder / "wrong.toml")
    browser.until("document.getElementById('leave-dialog').open")
    browser.click("#leave-dialog [value=discard]")
    page.told("nothing")
    assert page.steps("background") == ["hue"]
    (page.folder / "noise.mp4").write_bytes(bytes(range(256)))
    page.drop(page.folder / "noise.mp4")
    page.told("noise.mp4: not a readable video")


@pytest.mark.thorough
def test_a_draft_is_resumed(browser: Browser, film: Path, tmp_path: Path) -> None:
    with shown(browser, open_clip(film), tmp_path) as page:
        page.begin()
        page.add("[data-layer=background]", "pattern", "Hatching")
        eventually((tmp_path / "draft.json").exists)
    with shown(browser, open_clip(film), tmp_path) as page:
        browser.click("#draft .strong")
        browser.until("document.querySelector('.card[aria-label^=Hatching]')")
        browser.until("document.getElementById('saved').textContent === 'Edited'")
        assert page.steps("background") == ["pattern"]


def open_style(page: Page, name: str) -> None:
    """Open a shipped style, and show its diagram."""
    page.browser.run(
        "document.getElementById('to-styles').click();"
        "[...document.querySelectorAll('.tile b')].find((each) => each.textContent === name).click()",
        name=name,
    )
    page.browser.until(f"document.getElementById('name').value === {name.lower()!r}")
    if not page.browser.run("return document.body.classList.contains('building')"):
        page.browser.click("#to-diagram")


def test_steps_are_copied_between_styles(page: Page) -> None:
    browser = page.browser
    open_style(page, "Thermal")
    browser.click(".card[aria-label^=Gradient]")
    page.shows("Gradient of colours")
    gradient = dict(page.server.designer.opened.content.place_of(
        browser.run("return Number(document.querySelector('.card.selected').dataset.card)")
    )[2].table)  # fmt: skip
    browser.press("Ctrl+c")
    page.told("Gradient of colours copied")
    open_style(page, "Blueprint")
    before = page.steps("background")
    browser.click(".gap[data-layer=background][data-index='0']")
    browser.click("#paste")
    page.told("Pasted into background, position 1")
    assert page.steps("background") == ["gradient", *before]
    assert page.server.designer.opened.content.layers["background"][0].table == gradient
    browser.run(
        """const clipboardData = new DataTransfer();
        clipboardData.setData("text/plain", text);
        const pasted = new ClipboardEvent("paste", { clipboardData, bubbles: true });
        document.activeElement.dispatchEvent(pasted);""",
        text="[[lines]]\nblock = 'posterize'\nlevels = 4\n",
    )
    page.shows("Posterize")
    assert page.steps("background") == ["gradient", "posterize", *before]


def test_the_help_of_a_block_has_pictures_before_and_after(page: Page) -> None:
    browser = page.browser
    open_style(page, "Thermal")
    browser.click(".card[aria-label^=Gradient]")
    page.shows("Gradient of colours")
    browser.click(".example summary")
    loaded = "[...document.querySelectorAll('.example img')].filter((each) => each.naturalWidth)"
    browser.until(f"{loaded}.length === 2")
    means = browser.run(
        """return [...document.querySelectorAll(".example img")].map((each) => {
          const canvas = new OffscreenCanvas(1, 1).getContext("2d");
          canvas.drawImage(each, 0, 0, 1, 1);
          return [...canvas.getImageData(0, 0, 1, 1).data].join();
        });"""
    )
    assert means[0] != means[1]


def test_a_knob_is_renamed_by_keyboard(page: Page) -> None:
    browser = page.browser
    open_style(page, "Ink")
    browser.click("#tabs [value=style]")
    browser.run("document.querySelector('[aria-label=\"Rename Hatching\"]').focus()")
    browser.press("Enter")
    browser.until("document.activeElement.matches('.rename')")
    browser.type("Shadows")
    browser.press("Enter")
    page.undone("Rename Thickest line: Shadows")
    browser.until("document.querySelector('[aria-label=\"Rename Shadows\"]')")
    labels = page.server.designer.opened.style.labels.values()
    assert any(label.startswith("Shadows:") for label in labels)
    browser.press("Ctrl+z")
    browser.until("document.querySelector('[aria-label=\"Rename Hatching\"]')")


def test_a_mistake_stands_at_its_card_and_goes_with_undo(page: Page) -> None:
    browser = page.browser
    steps = (Step("gaussian", save="soft"), Step("blend", {"other": "soft"}))
    save_style(Style("soft", background=steps), page.folder / "soft.toml")
    page.drop(page.folder / "soft.toml")
    browser.until("document.querySelectorAll('.card').length === 4")
    page.is_drawn()
    browser.click(".card[aria-label^=Blur]")
    browser.until("document.activeElement.matches('.card.selected[aria-label^=Blur]')")
    browser.press("Delete")
    browser.until("document.querySelector('.card.wrong[aria-label^=Blend] .badge.wrong')")
    assert "'soft'" in browser.run("return document.querySelector('.card.wrong').title")
    browser.click(".card.wrong")
    browser.until("document.querySelector('.inspector .error').textContent.includes('soft')")
    browser.press("Escape")
    browser.press("Ctrl+z")
    browser.until("!document.querySelector('.card.wrong')")


@pytest.mark.thorough
def test_a_second_of_film_is_shown_steadied(page: Page) -> None:
    page.begin()
    page.add("[data-layer=background]", "posterize", "Posterize")
    page.browser.click("#view")
    page.browser.click("#steady")
    page.moves()


def test_a_camera_is_shown_as_it_moves(browser: Browser, tmp_path: Path) -> None:
    """The source that stands for a camera where there is none."""
    with shown(browser, open_clip("test"), tmp_path) as page:
        page.begin()
        page.add("[data-layer=background]", "posterize", "Posterize")
        page.moves()
        assert browser.run("return document.getElementById('film').hidden")


def overlaps(boxes: list[dict[str, float]]) -> list[tuple[float, ...]]:
    """Pairs of boxes that share some of the page."""
    edges = [(box["x"], box["y"], box["x"] + box["w"], box["y"] + box["h"]) for box in boxes]
    return [
        (*one, *other)
        for one, other in combinations(edges, 2)
        if one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
    ]


SPACES = [(1153, 450), (772, 380), (820, 400)]
"""What the diagram has in windows of 1440 x 900, 1024 x 768 and 820 x 1180."""


def test_no_style_is_laid_out_with_overlaps(page: Page) -> None:
    for name, (width, height), whole in product(style_names(), SPACES, (True, False)):
        page.server.designer.open(name)
        layout = page.browser.run(
            """const { fold } = await import('/fold.js');
            return (await import('/layout.js')).layoutOf(fold(state, null, whole), width, height)""",
            state=page.server.designer.state, width=width, height=height, whole=whole,
        )  # fmt: skip
        size = layout["size"]
        cards = [card | {"w": size["w"], "h": size["h"]} for card in layout["cards"]]
        gaps = [{"x": gap["x"] - 9, "y": gap["y"] - 9, "w": 18, "h": 18} for gap in layout["gaps"]]
        count = len(page.server.designer.opened.style.steps) + 2
        assert len(cards) == count if whole else len(cards) <= count
        assert len(gaps) == len(cards) + 1
        assert overlaps(cards + gaps) == [], name
        assert layout["width"] <= width, name


def test_a_step_that_only_saves_has_a_name(page: Page) -> None:
    steps = [
        {"block": "soft_threshold", "label": "Black and white", "save": "kept"},
        {"block": "", "save": "kept"},
        {"block": "", "save": ""},
    ]
    named = page.browser.run("return steps.map((await import('/types.js')).nameOf)", steps=steps)
    assert named == ["Black and white", "Kept", "Saved picture"]


def test_cards_stand_where_the_layout_places_them(page: Page) -> None:
    browser = page.browser
    browser.run(
        "[...document.querySelectorAll('.tile b')].find((each) => each.textContent === 'Oil').click()"
    )
    steps = len(load_style("oil").steps)
    browser.click("#to-diagram")
    browser.until("document.querySelector('.card.fold')")
    browser.click(".whole")
    browser.until(f"document.querySelectorAll('.card').length === {steps + 2}")
    browser.run("await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    boxes = browser.run(
        """document.getAnimations().forEach((each) => each.finish());
        return [...document.querySelectorAll(".card")].map((card) => {
          const { x, y, width: w, height: h } = card.getBoundingClientRect();
          return { x, y, w, h };
        });"""
    )
    assert len(boxes) == steps + 2
    assert overlaps(boxes) == []
    sides = "const { scrollWidth, clientWidth } = document.getElementById('diagram');"
    assert browser.run(f"{sides} return scrollWidth <= clientWidth")


def test_helper_steps_are_folded_until_one_is_selected(page: Page) -> None:
    """The chain of a mask is one card; the step after it starts from the one before it in a straight line."""
    page.server.designer.open("ink")
    state = page.server.designer.state
    helpers = [step["step"] for step in state["layers"]["base"] if step["aside"]]
    script = "return (await import('/fold.js')).fold(state, selected, false)"
    folded = page.browser.run(script, state=state, selected=None)
    names = [item["step"] for item in folded["items"]["base"]]
    assert any(str(name).startswith("fold-") for name in names) and not set(helpers) <= set(names)
    shown = {item["step"] for items in folded["items"].values() for item in items}
    assert {edge["from"] for edge in folded["edges"]} <= shown | {"source"}
    opened = page.browser.run(script, state=state, selected=helpers[0])
    assert helpers[0] in [item["step"] for item in opened["items"]["base"]]
