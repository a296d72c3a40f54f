"""The page of the designer in a browser: a style is built by mouse, and once more by keyboard alone."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from browser import Browser
from design_page import CHOSEN, FRAMES, Page, open_style, shown
from design_page import film as film
from design_page import page as page
from media import make_picture
from waiting import eventually

import vidstyle
from vidstyle.preview.clip import open_clip
from vidstyle.style import Step, Style, save_style


def by_hand(page: Page, **values: float) -> None:
    """The style that the steps make, and its film, are those that the page has written."""
    hatching = Step("pattern", {"spacing": values["spacing"]})
    lines = Step("flow_dog", {"sigma": values["sigma"]})
    threshold = Step("soft_threshold", {"epsilon": values["epsilon"]})
    style = Style("hatched", background=(hatching,), lines=(lines, threshold))
    save_style(style, page.folder / "by-hand.toml")
    assert (page.folder / "hatched.toml").read_bytes() == (page.folder / "by-hand.toml").read_bytes()
    vidstyle.render(page.folder / "film.mp4", page.folder / "by-hand.mp4", style, frames=FRAMES)
    assert (page.folder / "film-hatched.mp4").read_bytes() == (page.folder / "by-hand.mp4").read_bytes()


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
    page.told("film-hatched.mp4")
    by_hand(page, **values)


def test_the_step_that_puts_the_picture_behind_lines_gets_the_focus(page: Page) -> None:
    page.begin()
    page.add("[data-layer=lines]", "threshold", "Black and white")
    page.browser.click("#diagram .paper button")
    page.undone("Put the picture behind the lines")
    page.browser.until("document.activeElement.matches('.card.selected[aria-label^=Picture]')")
    layers = "return [...document.querySelectorAll('#cards .layer')].map((each) => each.textContent)"
    assert page.browser.run(layers) == ["Prepare", "Colour", "Lines"]


def test_the_result_is_compared_with_the_style_as_opened(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    """The style as opened is gray; without any strength, the result is the coloured film."""
    browser = page.browser
    open_style(page, "Noir")
    page.is_drawn()
    weaken = """const slider = document.querySelector(".style-panel [data-path=strength] input[type=range]");
    slider.value = "0";
    slider.dispatchEvent(new Event("input"));"""
    browser.run(weaken)
    browser.until("document.getElementById('undo').title.includes('strength')")
    page.is_drawn()
    browser.click("#tabs [value=history]")
    browser.click("#history-tab-content > div > button")
    tag, against = "document.getElementById('before').textContent", "document.getElementById('against')"
    browser.until(f"{tag} === 'As opened' && !{against}.hidden && {against}.value === 'opened'")
    assert page.server.designer.opened.style.strength == 0, "the style stays"
    saturation = """const picture = document.getElementById("picture");
    const context = picture.getContext("2d");
    return [-60, 20].map((x) => {
      const { data } = context.getImageData(picture.width / 2 + x, picture.height / 2 - 20, 40, 40);
      const levels = [0, 1, 2].map((channel) => data.filter((_, at) => at % 4 === channel));
      return Math.max(...levels[0].map((red, at) => Math.abs(red - levels[2][at])));
    });"""
    opened, result = browser.run(saturation)
    assert opened < 20 < result, "as opened left of the divider, the result right of it"
    clip, number = page.server.designer.clip, "document.getElementById('place').value"
    decode = clip.frame

    def decode_slowly(*values: int) -> np.ndarray:
        """At a pause, the server has gone on to a frame that the page has not received."""
        time.sleep(0.3)
        return decode(*values)

    monkeypatch.setattr(clip, "frame", decode_slowly)
    for _ in range(2):
        before = browser.run(f"return {number}")
        browser.click("#play")
        browser.until(f"{number} !== {before!r} && {tag} === 'Original'")
        browser.click("#play")
        browser.until(f"{tag} === 'As opened'")
    browser.run(f"{against}.value = 'source'; {against}.dispatchEvent(new Event('change'))")
    browser.until(f"{tag} === 'Original'")
    assert browser.run(saturation)[0] > 20


def test_the_first_step_comes_to_the_row_of_its_kind_and_a_dragged_step_is_named(page: Page) -> None:
    browser = page.browser
    page.begin()
    browser.click("#tabs [value=style]")
    browser.click(".first button")
    browser.until("document.activeElement.id === 'search'")
    browser.type("ink lines")
    browser.press("Enter")
    page.shows("Ink lines")
    assert (page.steps("base"), page.steps("lines")) == ([], ["flow_xdog"])
    lines = f"#{browser.run(f'return document.querySelector({CHOSEN!r}).id')}"
    page.add("[data-layer=background]", "posterize", "Posterize")
    browser.drag(*(browser.still(each)[:2] for each in (lines, ".gap[data-layer=base]")))
    page.told("Ink lines moved to Prepare, position 1 of 1")


def test_another_style_is_shown_from_the_top_of_its_panel(page: Page) -> None:
    browser = page.browser
    panel = "document.getElementById('style-tab-content')"
    open_style(page, "Engraving")
    browser.run("document.querySelector('.style-panel details').open = true")
    browser.run(f"{panel}.scrollTop = 9999")
    assert browser.run(f"return {panel}.scrollTop") > 100
    browser.click("#to-styles")
    browser.click(".tile:not(.new)")  # from the keyboard, the first value would get the focus
    browser.until("document.getElementById('name').value !== 'Engraving'")
    assert browser.run(f"return {panel}.scrollTop") == 0


def test_the_result_of_another_style_is_labelled_while_both_are_shown(page: Page) -> None:
    browser = page.browser
    open_style(page, "Engraving")
    browser.click("#modes [value=side]")
    label = "document.getElementById('after')"
    browser.until(f"!{label}.hidden")
    open_style(page, "Poster")
    page.is_drawn()
    browser.until(f"!{label}.hidden")


def test_a_setting_is_shown_once_and_a_found_step_next_to_its_button(page: Page) -> None:
    browser = page.browser
    open_style(page, "Engraving")
    rows = "document.querySelectorAll('#style-tab-content [data-path=ink]')"
    assert browser.run(f"return {rows}.length") == 1
    browser.run(f"{rows}[0].querySelector('.pin[aria-pressed]').click()")
    browser.until(f"{rows}.length === 1 && {rows}[0].closest('details')")
    browser.click(".gap[data-layer=base][data-index='1']")
    browser.until("document.activeElement.id === 'search'")
    browser.type("fewer colours")
    browser.until("document.getElementById('blocks').dataset.asked === 'fewer colours'")
    names = "return [...document.querySelectorAll('#blocks .option b')].map((each) => each.textContent)"
    assert browser.run(names) == ["Posterize"]
    apart = """const [list, button] = ["#palette", ".gap[data-layer=base][data-index='1']"].map((each) =>
      document.querySelector(each).getBoundingClientRect());
      return [list.height, Math.max(list.left - button.right, button.left - list.right)];"""
    height, distance = browser.run(apart)
    assert height < 180 and 0 < distance < 30
    browser.press("Escape")
    assert not browser.run("return document.getElementById('palette').open")


def test_a_letter_saves_only_outside_of_text_fields(page: Page) -> None:
    browser = page.browser
    open_style(page, "Poster")
    browser.run("document.getElementById('name').focus()")
    browser.press("s")
    assert not browser.run("return document.getElementById('save-dialog').open")
    browser.run("document.activeElement.blur()")
    browser.press("s")
    browser.until("document.getElementById('save-dialog').open")
    browser.press("Escape")


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
    page.told("Sharpen along lines moved to Lines, position 1 of 2")
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
    page.told("film-hatched.mp4")
    by_hand(page, spacing=9.0, sigma=1.5, epsilon=55.0)


def test_the_browser_restyles_and_a_dragged_value_compiles_nothing(page: Page) -> None:
    browser = page.browser
    page.begin()
    browser.run(
        """const where = document.getElementById("where");
        where.value = "page";
        where.dispatchEvent(new Event("change"));"""
    )
    browser.until("document.getElementById('who').textContent === 'Without a graphics card'")
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
    page.told("no colour value differs by more than one level")


def test_a_click_on_original_stays_and_a_longer_press_ends(page: Page) -> None:
    browser = page.browser
    page.begin()
    press = """const button = document.getElementById("hold");
    button.setPointerCapture = () => {};
    button.dispatchEvent(new PointerEvent("pointerdown"));
    const shown = button.ariaPressed;
    await new Promise((done) => setTimeout(done, time));
    button.dispatchEvent(new PointerEvent("pointerup"));
    return [shown, button.ariaPressed];"""
    assert browser.run(press, time=0) == ["true", "true"], "a click"
    assert not browser.run("return document.getElementById('before').hidden")
    assert browser.run(press, time=0) == ["true", "false"], "the next one"
    assert browser.run(press, time=900) == ["true", "false"], "held"


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
    page.browser.until("document.getElementById('who').textContent === 'Without a graphics card'")
    page.drop(file)
    page.browser.until("document.getElementById('name').value === 'Keyed'")
    page.browser.until(
        "document.getElementById('who').textContent ?.startsWith('The frames come from vidstyle')"
    )
    page.is_drawn()


def test_files_are_dropped_on_the_page(page: Page) -> None:
    browser = page.browser

    page.drop(make_picture(page.folder / "picture.png", size=(96, 64)))
    browser.until("document.getElementById('previews').textContent.includes('picture.png')")
    save_style(Style("dropped", background=(Step("hue", {"angle": 90.0}),)), page.folder / "dropped.toml")
    page.drop(page.folder / "dropped.toml")
    browser.until("document.getElementById('name').value === 'Dropped'")
    browser.until("document.querySelector('#card-source .main').textContent === '96 × 64'")
    assert page.steps("background") == ["hue"]
    (page.folder / "wrong.toml").write_text("format = 1\n[[lines]]\nblock = 'nothing'\n")
    browser.until("document.getElementById('saved').textContent === 'Edited'")
    browser.press("Ctrl+z")
    page.drop(page.folder / "wrong.toml")
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
        browser.until("document.querySelector('#looks .to-drafts:not([hidden])')")
        browser.click("#looks .to-drafts")
        browser.click("#drafts button")
        browser.until("document.querySelector('.card[aria-label^=Hatching]')")
        browser.until("document.getElementById('saved').textContent === 'Edited'")
        assert page.steps("background") == ["pattern"]


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
    page.told("Pasted into Colour, position 1")
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


@pytest.mark.thorough
def test_a_second_of_film_is_shown_steadied(page: Page) -> None:
    page.begin()
    page.add("[data-layer=background]", "posterize", "Posterize")
    page.browser.click("#view")
    page.browser.click("#steady")
    page.moves()


def test_a_camera_is_shown_as_it_moves(browser: Browser, tmp_path: Path) -> None:
    """A source that replaces a missing camera."""
    with shown(browser, open_clip("test"), tmp_path) as page:
        page.begin()
        page.add("[data-layer=background]", "posterize", "Posterize")
        page.moves()
        assert browser.run("return document.getElementById('film').hidden")
