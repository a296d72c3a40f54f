"""The graph of a style: its edges, and both drawings."""

from __future__ import annotations

import random
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import pytest
from covering import in_one_test

from vidstyle.block import SavedRef
from vidstyle.blocks import all_blocks
from vidstyle.cli import main
from vidstyle.diagram.graph import DiagramNode, graph_of
from vidstyle.diagram.svg import graph_svg
from vidstyle.diagram.text import graph_text
from vidstyle.style import LAYERS, Step, Style, load_style, save_style, style_names, table_from_style

SVG = "{http://www.w3.org/2000/svg}"
TWO_LAYERS = Style(
    "two",
    ink="#203040",
    base=(Step("to_gray"), Step("gaussian", {"sigma": 3.0}, save="smooth")),
    background=(Step("posterize", {"levels": 10}), Step("to_color")),
    lines=(Step("sobel"), Step("", save="edges"), Step("blend", {"other": "smooth"}, source="source")),
)


def random_graph(chance: random.Random, most: int = 7) -> Style:
    """A valid style with many names, and at most N steps in a layer."""
    names, layers = ["source"], {}
    for layer in LAYERS:
        steps = []
        for _ in range(chance.randint(0, most)):
            block = chance.choice(
                ["posterize", "gaussian", "blend", "to_gray", "to_color", "soft_threshold", ""]
            )
            known = [*names, *(["chroma"] if "chroma" in names else [])]
            values = {"other": chance.choice(known)} if block == "blend" else {}
            if block == "blend" and chance.random() < 0.3:
                values["mask"] = chance.choice(known)
            if block == "to_color":
                values["chroma"] = chance.choice(known)
            source = chance.choice(known) if chance.random() < 0.3 or not block else ""
            save = f"s{len(names)}" if chance.random() < 0.4 else ""
            steps.append(Step(block, values, save, source))
            names += [save] * bool(save) + ["chroma"] * (block == "to_gray" and "chroma" not in names)
        layers[layer] = tuple(steps)
    style = Style("random", paper=chance.choice(["#ffffff", "#fff0e0"]), **layers)
    return load_style(table_from_style(style))


STYLES = [
    *map(load_style, style_names()),
    TWO_LAYERS,
    *(random_graph(random.Random(seed)) for seed in range(80)),
    *(random_graph(random.Random(seed), most=30) for seed in range(10)),
]

every_style = in_one_test("style", STYLES)


def expected_inputs(style: Style) -> list[list[int]]:
    """What each block is given, by its place among all; the source is 0. Found by running names alone."""
    inputs: list[list[int]] = [[]]
    named, ends = {"source": 0}, {"base": 0}
    for layer in LAYERS:
        current = ends["base"]
        for step in getattr(style, layer):
            current = named[step.source] if step.source else current
            if step.block:
                block, given = all_blocks()[step.block], [current]
                for name, parameter in block.parameters.items():
                    if isinstance(parameter.control, SavedRef):
                        wanted = step.values.get(name, parameter.default)
                        given += [named[wanted]] if wanted else []
                inputs.append(list(dict.fromkeys(given)))
                current = len(inputs) - 1
                named |= {block.saves: current} if block.saves else {}
            named |= {step.save: current} if step.save else {}
        ends[layer] = current
    colors = [ends["background"]] if style.background or not style.lines else []
    inputs.append(list(dict.fromkeys([*colors, *([ends["lines"]] if style.lines else [])])))
    return inputs


@every_style
def test_every_block_is_given_what_it_is_given_when_it_runs(style: Style) -> None:
    nodes = graph_of(style)
    assert [[edge.start for edge in node.edges] for node in nodes] == expected_inputs(style)
    assert [node.block.title for node in nodes[1:-1]] == [step.block for step in style.steps if step.block]


@every_style
def test_no_line_goes_through_a_block_or_another_line(style: Style) -> None:
    nodes = graph_of(style)
    taken: dict[tuple[int, int], object] = {(node.row, node.lane): "block" for node in nodes}
    assert len(taken) == len(nodes)
    for edge in (edge for node in nodes for edge in node.edges):
        row, lane = nodes[edge.start].row + 1, nodes[edge.start].lane
        for move in [*edge.moves, None]:
            until = nodes[edge.end].row if move is None else move.row
            assert move is None or (move.lane == lane and move.row >= row)
            for passed in range(row, until):
                assert taken.setdefault((passed, lane), edge.start) == edge.start
            row, lane = until, lane if move is None else move.to
        assert (row, lane) == (nodes[edge.end].row, nodes[edge.end].lane)


def inputs_drawn(lines: list[str], lanes: int) -> Iterator[list[int]]:
    """What each block is given, read off the drawing; there, the picture of the block above comes first."""
    held: dict[int, int] = {}
    joined: list[int] = []
    count = 0
    for line in lines:
        drawn = line[12:].ljust(3 * lanes)
        row = drawn[: 3 * lanes : 3]
        if "●" in row:
            lane = row.index("●")
            yield [*([held[lane]] if lane in held else []), *joined]
            held[lane], joined, count = count, [], count + 1
        elif arrow := re.search("[◄►]", drawn[: 3 * lanes]):
            to_right = arrow[0] == "►"
            run = re.search("[╰├][─┼]*►" if to_right else "◄[─┼]*[╯┤]", drawn)
            assert run
            start = (run.start() if to_right else run.end() - 1) // 3
            joined.append(held[start])
            if row[start] in "╯╰":
                del held[start]
        elif run := re.search("├[─┼]*╮|╭[─┼]*┤", drawn):
            ends = run.start() // 3, (run.end() - 1) // 3
            start, end = ends if run[0][0] == "├" else ends[::-1]
            held[end] = held[start]
        shown = {lane for lane, character in enumerate(row) if character in "●│├┤┼╮╭"}
        assert shown <= set(held)
        held = {lane: picture for lane, picture in held.items() if lane in shown}


@every_style
def test_the_lines_in_the_terminal_lead_from_block_to_block(style: Style) -> None:
    nodes = graph_of(style)
    lanes = 1 + max(max(node.lane, node.aside or 0) for node in nodes)
    lines = graph_text(nodes, width=500)
    assert list(inputs_drawn(lines, lanes)) == expected_inputs(style)


def test_the_drawing_in_the_terminal_names_what_matters() -> None:
    expected = """\
            ●              source
            ├──╮
base        ●  │           to_gray  → chroma
            ├──┼──╮
            ●  │  │        gaussian  sigma = 3  → smooth
            ├──┼──┼──╮
background  ●  │  │  │     posterize
            │◄─┼──╯  │
            ●  │     │     to_color
            │  │     ├──╮
lines       │  │     ●  │  sobel  → edges
            │  │◄───────╯
            │  ●           blend  from source, other = smooth
            │◄─╯
            ●              ink over colour  ink = #203040"""
    assert graph_text(graph_of(TWO_LAYERS)) == expected.splitlines()


@in_one_test("style", STYLES[:20])
def test_a_terminal_without_box_characters_gets_ascii(style: Style) -> None:
    nodes = graph_of(style)
    plain, drawn = graph_text(nodes, encoding="ascii"), graph_text(nodes, encoding="utf-8")
    assert "\n".join(plain).isascii()
    for line, same in zip(plain, drawn, strict=True):
        assert len(line) == len(same) + same.count("→")
        assert line.count("*") == same.count("●") and line.count("|") == same.count("│")


def test_long_lines_are_wrapped_beside_their_lanes() -> None:
    values = {"levels": 3, "spacing": 7.0, "width": 0.3, "angle": 20.0, "wobble": 0.9}
    style = Style("long", base=(Step("pattern", values),), background=(Step("hue"),), lines=(Step("sobel"),))
    lines = graph_text(graph_of(style), width=50)
    assert max(map(len, lines)) <= 50
    (wrapped,) = [line for line in lines if "wobble" in line]
    assert wrapped.startswith("            │     ")


@every_style
def test_the_picture_shows_every_block_and_no_arrow_crosses_one(style: Style) -> None:
    nodes = graph_of(style)
    drawing = ElementTree.fromstring(graph_svg(nodes, style.name))
    width, height = (float(drawing.get(side, 0)) for side in ("width", "height"))
    boxes = [
        numbers(box, "x", "y", "width", "height")
        for box in drawing.iter(f"{SVG}rect")
        if box.get("rx") == "6"
    ]
    titles = [text.text for text in drawing.iter(f"{SVG}text") if text.get("font-weight") == "600"]
    assert titles == [node.block.title for node in nodes]
    for left, top, across, down in boxes:
        assert 0 <= left and left + across <= width and 0 <= top and top + down <= height
    arrows = [path for path in drawing.iter(f"{SVG}path") if path.get("marker-end")]
    edges = [edge for node in nodes for edge in node.edges]
    for arrow, edge in zip(arrows, edges, strict=True):
        points = list(corners(str(arrow.get("d"))))
        assert on_edge(points[0], boxes[edge.start], lower=True) and on_edge(
            points[-1], boxes[edge.end], lower=False
        )
        for one, other in zip(points, points[1:], strict=False):
            assert not any(crosses(one, other, box) for box in boxes)


def numbers(element: ElementTree.Element, *names: str) -> tuple[float, ...]:
    return tuple(float(element.get(name, 0)) for name in names)


def corners(path: str) -> Iterator[tuple[float, float]]:
    x = y = 0.0
    for letter, first, second in re.findall(r"([MVH])([\d.]+)(?: ([\d.]+))?", path):
        x = float(first) if letter in "MH" else x
        y = float(second) if letter == "M" else float(first) if letter == "V" else y
        yield x, y


def on_edge(point: tuple[float, float], box: tuple[float, ...], lower: bool) -> bool:
    left, top, across, down = box
    return left < point[0] < left + across and abs(point[1] - (top + down if lower else top)) <= 1


def crosses(one: tuple[float, float], other: tuple[float, float], box: tuple[float, ...]) -> bool:
    left, top, across, down = box
    (first_x, last_x), (first_y, last_y) = sorted((one[0], other[0])), sorted((one[1], other[1]))
    return first_x < left + across and last_x > left and first_y < top + down - 0.5 and last_y > top + 0.5


def test_nothing_of_a_stranger_becomes_part_of_the_picture() -> None:
    evil = '</text><script>alert("1")</script>&\'"]]>'
    style = Style(evil, base=(Step("learned", {"bank": evil[:40]}, save="x"), Step("blend", {"other": "x"})))
    drawing = graph_svg(graph_of(style), evil + "\x1b\0")
    elements = {element.tag for element in ElementTree.fromstring(drawing).iter()}
    assert elements == {SVG + name for name in ("svg", "title", "defs", "marker", "path", "rect", "text")}
    assert "\x1b" not in drawing and "href" not in drawing


def test_the_result_says_how_the_layers_meet() -> None:
    step = (Step("posterize"),)
    for layers, title, settings in (
        ({}, "result", {}),
        ({"base": step, "background": step}, "result", {}),
        ({"base": step, "paper": "#eeeeee"}, "result", {"paper": "#eeeeee"}),
        ({"base": step, "lines": step}, "ink on paper", {"ink": "#000000"}),
        ({"background": step, "lines": step}, "ink over colour", {"ink": "#000000"}),
    ):
        result = graph_of(Style("x", **layers))[-1].block
        assert (result.title, result.settings) == (title, settings)


def named(nodes: tuple[DiagramNode, ...], title: str) -> DiagramNode:
    return next(node for node in nodes if node.block.title == title)


def test_blocks_tell_their_names_and_what_differs_from_defaults() -> None:
    nodes = graph_of(TWO_LAYERS)
    assert named(nodes, "gaussian").block.settings == {"sigma": "3"}
    assert named(nodes, "gaussian").block.saves == ["smooth"]
    assert named(nodes, "posterize").block.settings == {}
    assert named(nodes, "to_gray").block.saves == ["chroma"]
    assert named(nodes, "sobel").block.saves == ["edges"]
    assert (named(nodes, "blend").block.source, named(nodes, "blend").block.settings) == (
        "source",
        {"other": "smooth"},
    )
    assert [edge.names for edge in named(nodes, "blend").edges] == [("source",), ("smooth",)]
    unused = graph_of(Style("x", base=(Step("to_gray"),)))
    assert named(unused, "to_gray").block.saves == []


def test_the_command_draws_above_the_details(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    save_style(TWO_LAYERS, tmp_path / "two.toml")
    assert main(["styles", str(tmp_path / "two.toml")]) == 0
    out = capfd.readouterr().out
    assert out.index("\n            ●") < out.index("ink over colour") < out.index('  ink = "#203040"')


def test_the_command_writes_the_picture(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    save_style(TWO_LAYERS, "two.toml")
    assert main(["styles", "two.toml", "--svg"]) == 0
    out, err = capfd.readouterr()
    assert err == "" and ElementTree.fromstring(out).tag == f"{SVG}svg"
    assert main(["styles", "two.toml", "--svg", "-o", "two.svg"]) == 0
    assert Path("two.svg").read_text(encoding="utf-8") == out
    assert capfd.readouterr() == ("", "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["two.svg", "two.toml"]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--svg"], 2, "--svg needs the NAME of a style"),
        (["ink", "-o", "x.svg"], 2, "--output needs --preview INPUT, --svg or"),
        (["plain", "--svg", "-o", "x.png"], 2, "x.png cannot be an SVG file; end it in .svg"),
        (["plain", "--svg", "-o", "there.svg"], 2, "there.svg already exists; add -y"),
        (["plain", "--svg", "-o", "none/x.svg"], 5, "its folder does not exist"),
        (["plian", "--svg"], 3, "there is no style 'plian'; did you mean 'plain'?"),
    ],
)
def test_what_cannot_be_drawn_is_one_line(
    arguments: list[str],
    code: int,
    words: str,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("there.svg").write_text("there", encoding="utf-8")
    assert main(["styles", *arguments]) == code
    out, err = capfd.readouterr()
    assert out == "" and err.count("\n") == 1 and words in err
    assert [path.name for path in tmp_path.iterdir()] == ["there.svg"]
