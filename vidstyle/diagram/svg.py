"""The graph of a style as a picture: labelled blocks coloured by their kind, and arrows between them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import accumulate, groupby

from vidstyle.diagram.graph import DiagramEdge, DiagramNode, Move
from vidstyle.diagram.shapes import rect, safe, words_at

WIDTH = 210
"""Of a block, in pixels."""
NARROW = 20
"""Of a lane in which no block stands."""
ACROSS = 40
"""Between two lanes."""
MARGIN = 28
LINE = 17
"""Height of a line of words."""
GAP = 40
"""Between two rows, where lines move from lane to lane."""
TRACK = 9
"""Between two lines in a gap."""
SIDE, NEXT_SIDE = 30, 45
"""From where a block's first arrow ends to the second, and from that to the next, with room for a name."""
LONGEST = 31
"""Characters of words that a block has room for."""
KIND = 100
"""Width of a kind in the legend."""

COLORS = {
    "source": "#e8e6e1",
    "pixel": "#fde5bd",
    "filter": "#cfe4f8",
    "measured": "#e3d7f6",
    "resize": "#d8e0e3",
    "learned": "#cbebce",
    "recipe": "#fad6dc",
    "result": "#e8e6e1",
}
"""Of the blocks, by kind."""

_HEAD = """\
<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}"
 viewBox="0 0 {width:g} {height:g}" role="img" font-size="12"
 font-family="system-ui, 'DejaVu Sans', Arial, sans-serif">
<title>{title}</title>
<defs><marker id="arrow" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7"
 orient="auto"><path d="M0 0 10 5 0 10z" fill="#555"/></marker></defs>
<rect width="100%" height="100%" fill="#fff"/>
"""
_LINE = 'fill="none" stroke="#555" stroke-width="1.3" stroke-linejoin="round" marker-end="url(#arrow)"'
_SMALL = 'fill="#777" font-size="10"'


def svg_of(nodes: Sequence[DiagramNode], name: str) -> str:
    """The picture as the text of an SVG file.

    Args:
        nodes: of the graph.
        name: of the style.
    """
    page = _Page(nodes)
    legend = _Legend(nodes, page.width - 2 * MARGIN)
    parts = [_HEAD.format(width=page.width, height=page.height + legend.height, title=safe(name))]
    parts += [page.arrow(edge) for node in nodes for edge in node.edges]
    parts += [part for node in nodes for part in page.block(node)]
    parts += legend.draw(page.height)
    return "".join(parts) + "</svg>\n"


class _Page:
    """Knows where everything lies, in pixels."""

    def __init__(self, nodes: Sequence[DiagramNode]) -> None:
        self._nodes = nodes
        rows = 1 + max(node.row for node in nodes)
        lanes = 1 + max(max(node.lane, node.aside or 0) for node in nodes)
        self._tracks = _tracks(nodes)
        crowds = Counter(row for _, row in self._tracks)
        heights = [max(_height(node) for node in nodes if node.row == row) for row in range(rows)]
        ends = accumulate(GAP + TRACK * crowds[row] + height for row, height in enumerate(heights))
        self._tops = [end - height for end, height in zip(ends, heights, strict=True)]
        inhabited = {node.lane for node in nodes}
        widths = [WIDTH if lane in inhabited else NARROW for lane in range(lanes)]
        rights = list(accumulate(width + ACROSS for width in widths))
        self._middles = [
            MARGIN + right - ACROSS - width / 2 for right, width in zip(rights, widths, strict=True)
        ]
        self.width = 2 * MARGIN + rights[-1] - ACROSS
        self.height = self._tops[-1] + heights[-1] + MARGIN

    def block(self, node: DiagramNode) -> Iterator[str]:
        """The box of a block with its words."""
        left, top = self._middles[node.lane] - WIDTH / 2, self._tops[node.row]
        lines = _words(node)
        yield rect(left, top, WIDTH, _height(node), COLORS[node.block.kind], radius=6)
        yield words_at(left + 10, top + LINE, node.block.title, 'font-weight="600" font-size="13"')
        if node.block.layer:
            yield words_at(left + WIDTH - 8, top + LINE - 1, node.block.layer, f'text-anchor="end" {_SMALL}')
        for number, words in enumerate(lines, 2):
            yield words_at(left + 10, top + number * LINE, words, 'fill="#333"')
            if color := re.search("#[0-9a-f]{6}$", words):
                yield rect(left + WIDTH - 24, top + number * LINE - 11, 14, 13, color[0])

    def arrow(self, edge: DiagramEdge) -> str:
        """The way of a picture, and the names by which it is asked for."""
        start, end = self._nodes[edge.start], self._nodes[edge.end]
        x = self._middles[start.lane]
        path = f"M{x:g} {self._tops[start.row] + _height(start):g}"
        turns = _turns(edge)
        for turn in turns:
            x = self._middles[turn.to] + (_aside(edge, end) if turn is turns[-1] else 0)
            path += f"V{self._track(edge.start, turn.row):g}H{x:g}"
        top = self._tops[end.row]
        return f'<path d="{path}V{top - 1:g}" {_LINE}/>\n' + _names(edge, end, x, top - 9)

    def _track(self, picture: int, row: int) -> float:
        """The height at which a picture's line crosses the gap above a row."""
        return self._tops[row] - GAP / 2 - TRACK * self._tracks[picture, row]


def _tracks(nodes: Sequence[DiagramNode]) -> dict[tuple[int, int], int]:
    """For each picture and row that its line moves above: which track it takes, the lowest being 0."""
    tracks: dict[tuple[int, int], int] = {}
    crowds: Counter[int] = Counter()
    for edge in (edge for node in nodes for edge in node.edges):
        for move in edge.moves:
            if (edge.start, move.row) not in tracks:
                tracks[edge.start, move.row] = crowds[move.row]
                crowds[move.row] += 1
    return tracks


def _turns(edge: DiagramEdge) -> list[Move]:
    """Its moves, those in one gap taken together."""
    gaps = [list(moves) for _, moves in groupby(edge.moves, key=lambda move: move.row)]
    return [Move(moves[0].row, moves[0].lane, moves[-1].to) for moves in gaps]


def _aside(edge: DiagramEdge, end: DiagramNode) -> float:
    """How far right of the middle of a block an arrow ends: all but the first on the side they come from."""
    position = [each.start for each in end.edges].index(edge.start)
    if position == 0:
        return 0
    distance = SIDE + (position - 1) * NEXT_SIDE
    return distance if _turns(edge)[-1].lane > end.lane else -distance


def _names(edge: DiagramEdge, end: DiagramNode, x: float, y: float) -> str:
    """The names beside an arrow's head, on the side where no other arrow ends."""
    if not edge.names:
        return ""
    others = max((_aside(each, end) for each in end.edges), default=0)
    on_left = _aside(edge, end) < 0 or (_aside(edge, end) == 0 and others > 0)
    anchor = 'text-anchor="end" ' * on_left
    how = f'{anchor}{_SMALL} font-style="italic"'
    return words_at(x + (-5 if on_left else 5), y, ", ".join(edge.names), how)


def _words(node: DiagramNode) -> list[str]:
    """What stands under the title of a block."""
    block = node.block
    words = [f"from {block.source}"] * bool(block.source)
    words += [f"{name} = {text}" for name, text in block.settings.items()]
    words += [f"→ {', '.join(block.saves)}"] * bool(block.saves)
    return [text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…" for text in words]


def _height(node: DiagramNode) -> float:
    return LINE * (1 + len(_words(node))) + 10


class _Legend:
    """What the colours mean, in rows that fit into a width."""

    def __init__(self, nodes: Sequence[DiagramNode], width: float) -> None:
        self._kinds = list(dict.fromkeys(node.block.kind for node in nodes if node.block.layer))
        self._columns = max(1, int(width // KIND))
        self.height = LINE * -(-len(self._kinds) // self._columns) + LINE

    def draw(self, top: float) -> Iterator[str]:
        """The rows, from a height on."""
        for number, kind in enumerate(self._kinds):
            row, column = divmod(number, self._columns)
            left, upper = MARGIN + column * KIND, top + row * LINE
            yield rect(left, upper, 12, 12, COLORS[kind], radius=2)
            yield words_at(left + 17, upper + 10, kind, 'fill="#555" font-size="11"')
