"""The diagram of the designer: where cards stand, and what they show."""

from __future__ import annotations

from itertools import combinations, product

from design_page import Page
from design_page import film as film
from design_page import page as page

from vidstyle.style import Step, Style, load_style, save_style, style_names


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
SMALLEST_FITTING_SPACE = 961, 411
"""What the diagram has by default in a window of 1280 x 800, in which all shipped styles fit."""
LAYOUT = """
const { fold } = await import('/fold.js');
return (await import('/layout.js')).layoutOf(fold(state, null, whole), width, height)
"""


def test_no_style_is_laid_out_with_overlaps(page: Page) -> None:
    for name, (width, height), whole in product(style_names(), SPACES, (True, False)):
        page.server.designer.open(name)
        layout = page.browser.run(
            LAYOUT, state=page.server.designer.state, width=width, height=height, whole=whole,
        )  # fmt: skip
        size = layout["size"]
        cards = [card | {"w": size["w"], "h": size["h"]} for card in layout["cards"]]
        gaps = [{"x": gap["x"] - 9, "y": gap["y"] - 9, "w": 18, "h": 18} for gap in layout["gaps"]]
        count = len(page.server.designer.opened.style.steps) + 2
        assert len(cards) == count if whole else len(cards) <= count
        assert len(gaps) == len(cards) + 1
        assert overlaps(cards + gaps) == [], name
        assert layout["width"] <= width, name


def test_the_diagram_of_every_style_fits_its_pane(page: Page) -> None:
    browser = page.browser
    width, height = SMALLEST_FITTING_SPACE
    for name in style_names():
        page.server.designer.open(name)
        layout = browser.run(
            LAYOUT, state=page.server.designer.state, width=width, height=height, whole=False
        )
        assert layout["height"] <= height and layout["width"] <= width, name
    browser.run(
        "[...document.querySelectorAll('.tile b')].find((each) => each.textContent === 'Ink').click()"
    )
    browser.click("#to-diagram")
    browser.until("document.querySelectorAll('.card').length > 9")
    sides = (
        "const { scrollHeight, clientHeight, scrollWidth, clientWidth } = document.getElementById('diagram');"
    )
    browser.until(
        f"(() => {{ {sides} return scrollHeight <= clientHeight && scrollWidth <= clientWidth }})()"
    )


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
