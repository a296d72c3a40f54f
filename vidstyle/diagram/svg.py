"""The graph of a style as SVG: labelled blocks, coloured by kind, with arrows between them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from html import escape
from itertools import accumulate, groupby

from vidstyle.diagram.graph import DiagramEdge, DiagramNode, Move
from vidstyle.errors import printable

BLOCK_WIDTH_PX = 210
"""Width of a block in pixels."""
EMPTY_LANE_WIDTH_PX = 20
"""Width of a lane without blocks."""
LANE_GAP_PX = 40
"""Gap between two lanes."""
MARGIN_PX = 28
LINE_HEIGHT_PX = 17
"""Height of a line of text."""
ROW_GAP_PX = 40
"""Gap between two rows, where lines change lanes."""
TRACK_PITCH_PX = 9
"""Distance of two lines in a gap."""
FIRST_HEAD_OFFSET_PX, HEAD_PITCH_PX = 30, 45
"""Distance of a block's second arrow head from its first, and of further ones from the second."""
MAX_CHARACTERS = 31
"""The longest line of text in a block, in characters."""
LEGEND_ENTRY_PX = 100
"""Width of an entry of the legend."""

KIND_COLORS = {
    "source": "#e8e6e1",
    "pixel": "#fde5bd",
    "filter": "#cfe4f8",
    "measured": "#e3d7f6",
    "resize": "#d8e0e3",
    "learned": "#cbebce",
    "network": "#f6e3f3",
    "recipe": "#fad6dc",
    "result": "#e8e6e1",
}
"""Colours of the blocks by kind."""

_SVG_HEAD = """\
<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}"
 viewBox="0 0 {width:g} {height:g}" role="img" font-size="12"
 font-family="system-ui, 'DejaVu Sans', Arial, sans-serif">
<title>{title}</title>
<defs><marker id="arrow" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7"
 orient="auto"><path d="M0 0 10 5 0 10z" fill="#555"/></marker></defs>
<rect width="100%" height="100%" fill="#fff"/>
"""
_ARROW_ATTRIBUTES = (
    'fill="none" stroke="#555" stroke-width="1.3" stroke-linejoin="round" marker-end="url(#arrow)"'
)
_SMALL_TEXT = 'fill="#777" font-size="10"'


def graph_svg(nodes: Sequence[DiagramNode], name: str) -> str:
    """Return the graph as the text of an SVG file.

    Args:
        nodes: from `graph_of`.
        name: the name of the style.
    """
    page = _Drawing(nodes)
    legend = _Legend(nodes, page.width - 2 * MARGIN_PX)
    parts = [_SVG_HEAD.format(width=page.width, height=page.height + legend.height, title=_escape(name))]
    parts += [page.arrow(edge) for node in nodes for edge in node.edges]
    parts += [part for node in nodes for part in page.block(node)]
    parts += legend.draw(page.height)
    return "".join(parts) + "</svg>\n"


class _Drawing:
    """The layout of the drawing, in pixels."""

    def __init__(self, nodes: Sequence[DiagramNode]) -> None:
        self._nodes = nodes
        rows = 1 + max(node.row for node in nodes)
        lanes = 1 + max(max(node.lane, node.aside or 0) for node in nodes)
        self._tracks = _tracks(nodes)
        counts = Counter(row for _, row in self._tracks)
        heights = [max(_height(node) for node in nodes if node.row == row) for row in range(rows)]
        ends = accumulate(
            ROW_GAP_PX + TRACK_PITCH_PX * counts[row] + height for row, height in enumerate(heights)
        )
        self._tops = [end - height for end, height in zip(ends, heights, strict=True)]
        occupied = {node.lane for node in nodes}
        widths = [BLOCK_WIDTH_PX if lane in occupied else EMPTY_LANE_WIDTH_PX for lane in range(lanes)]
        rights = list(accumulate(width + LANE_GAP_PX for width in widths))
        self._middles = [
            MARGIN_PX + right - LANE_GAP_PX - width / 2 for right, width in zip(rights, widths, strict=True)
        ]
        self.width = 2 * MARGIN_PX + rights[-1] - LANE_GAP_PX
        self.height = self._tops[-1] + heights[-1] + MARGIN_PX

    def block(self, node: DiagramNode) -> Iterator[str]:
        """Yield the box of a block with its text."""
        left, top = self._middles[node.lane] - BLOCK_WIDTH_PX / 2, self._tops[node.row]
        lines = _words(node)
        yield _rect(left, top, BLOCK_WIDTH_PX, _height(node), KIND_COLORS[node.block.kind], radius=6)
        yield _text(left + 10, top + LINE_HEIGHT_PX, node.block.title, 'font-weight="600" font-size="13"')
        if node.block.layer:
            yield _text(
                left + BLOCK_WIDTH_PX - 8,
                top + LINE_HEIGHT_PX - 1,
                node.block.layer,
                f'text-anchor="end" {_SMALL_TEXT}',
            )
        for number, words in enumerate(lines, 2):
            yield _text(left + 10, top + number * LINE_HEIGHT_PX, words, 'fill="#333"')
            if color := re.search("#[0-9a-f]{6}$", words):
                yield _rect(left + BLOCK_WIDTH_PX - 24, top + number * LINE_HEIGHT_PX - 11, 14, 13, color[0])

    def arrow(self, edge: DiagramEdge) -> str:
        """Return the path of a picture, and the names by which it is read."""
        start, end = self._nodes[edge.start], self._nodes[edge.end]
        x = self._middles[start.lane]
        path = f"M{x:g} {self._tops[start.row] + _height(start):g}"
        turns = _turns(edge)
        for turn in turns:
            x = self._middles[turn.to] + (_aside(edge, end) if turn is turns[-1] else 0)
            path += f"V{self._track(edge.start, turn.row):g}H{x:g}"
        top = self._tops[end.row]
        return f'<path d="{path}V{top - 1:g}" {_ARROW_ATTRIBUTES}/>\n' + _names(edge, end, x, top - 9)

    def _track(self, picture: int, row: int) -> float:
        """Return the y coordinate of the line of a picture in the gap above a row."""
        return self._tops[row] - ROW_GAP_PX / 2 - TRACK_PITCH_PX * self._tracks[picture, row]


def _tracks(nodes: Sequence[DiagramNode]) -> dict[tuple[int, int], int]:
    """Return the track of each line in the gap above each row; 0 is the lowest."""
    tracks: dict[tuple[int, int], int] = {}
    counts: Counter[int] = Counter()
    for edge in (edge for node in nodes for edge in node.edges):
        for move in edge.moves:
            if (edge.start, move.row) not in tracks:
                tracks[edge.start, move.row] = counts[move.row]
                counts[move.row] += 1
    return tracks


def _turns(edge: DiagramEdge) -> list[Move]:
    """Return the moves of an edge, merged within each gap."""
    gaps = [list(moves) for _, moves in groupby(edge.moves, key=lambda move: move.row)]
    return [Move(moves[0].row, moves[0].lane, moves[-1].to) for moves in gaps]


def _aside(edge: DiagramEdge, end: DiagramNode) -> float:
    """Return the offset of an arrow head from the middle of the block; only the first ends in the middle."""
    position = [each.start for each in end.edges].index(edge.start)
    if position == 0:
        return 0
    distance = FIRST_HEAD_OFFSET_PX + (position - 1) * HEAD_PITCH_PX
    return distance if _turns(edge)[-1].lane > end.lane else -distance


def _names(edge: DiagramEdge, end: DiagramNode, x: float, y: float) -> str:
    """Return the names next to an arrow head, on its free side."""
    if not edge.names:
        return ""
    others = max((_aside(each, end) for each in end.edges), default=0)
    on_left = _aside(edge, end) < 0 or (_aside(edge, end) == 0 and others > 0)
    anchor = 'text-anchor="end" ' * on_left
    how = f'{anchor}{_SMALL_TEXT} font-style="italic"'
    return _text(x + (-5 if on_left else 5), y, ", ".join(edge.names), how)


def _words(node: DiagramNode) -> list[str]:
    """Return the lines under the title of a block."""
    words = node.block.words + [f"→ {', '.join(node.block.saves)}"] * bool(node.block.saves)
    return [text if len(text) <= MAX_CHARACTERS else f"{text[: MAX_CHARACTERS - 1]}…" for text in words]


def _height(node: DiagramNode) -> float:
    return LINE_HEIGHT_PX * (1 + len(_words(node))) + 10


class _Legend:
    """The legend of the colours, in rows of a given width."""

    def __init__(self, nodes: Sequence[DiagramNode], width: float) -> None:
        self._kinds = list(dict.fromkeys(node.block.kind for node in nodes if node.block.layer))
        self._columns = max(1, int(width // LEGEND_ENTRY_PX))
        self.height = LINE_HEIGHT_PX * -(-len(self._kinds) // self._columns) + LINE_HEIGHT_PX

    def draw(self, top: float) -> Iterator[str]:
        """Yield the rows below a y coordinate."""
        for number, kind in enumerate(self._kinds):
            row, column = divmod(number, self._columns)
            left, upper = MARGIN_PX + column * LEGEND_ENTRY_PX, top + row * LINE_HEIGHT_PX
            yield _rect(left, upper, 12, 12, KIND_COLORS[kind], radius=2)
            yield _text(left + 17, upper + 10, kind, 'fill="#555" font-size="11"')


def _rect(left: float, top: float, width: float, height: float, color: str, radius: float = 0) -> str:
    """Return a filled box with an outline."""
    size = f'x="{left:g}" y="{top:g}" width="{width:g}" height="{height:g}" rx="{radius:g}"'
    return f'<rect {size} fill="{color}" stroke="#8a8a8a"/>\n'


def _text(x: float, y: float, words: str, how: str) -> str:
    """Return text with its baseline at x, y; `how` holds further attributes."""
    return f'<text x="{x:g}" y="{y:g}" {how}>{_escape(words)}</text>\n'


def _escape(words: str) -> str:
    """Escape text, since styles are untrusted."""
    return escape(printable(words))
