"""Properties of balloons on many random panels and pages: clear of faces, in order, inside their panels."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from covering import of_the_day

from vidstyle.comic.analyze.saliency import attention_map, box_attention, crop_attention, mean_under
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.crop import map_to_page
from vidstyle.comic.layout.layout import PageLayout, lay_out
from vidstyle.comic.layout.paper import paper
from vidstyle.comic.layout.slant import upright_area
from vidstyle.comic.lettering.balloons import FreeSpace, Wording, _is_read_after, place_bubbles
from vidstyle.comic.lettering.bubble import (
    Bubble,
    BubbleKind,
    add_face_margin,
    add_tail,
    break_text,
    bubble_size,
)
from vidstyle.comic.lettering.fonts import Letters, letter_size
from vidstyle.comic.lettering.letter import PanelText, TextStyle, letter_panels
from vidstyle.comic.lettering.subtitle_lines import Line
from vidstyle.comic.lettering.title import move_below_title
from vidstyle.demo.drawing import film_picture
from vidstyle.regions.boxes import Box

LETTERS = Letters()
WORDS = (
    "the robot says that you have to follow our passions in space awesome incomprehensibilities a I".split()
)


def is_in_order(earlier: Box, later: Box, right_to_left: bool) -> bool:
    """Whether one of two balloons is read before the other: above it, or next to it and no lower."""
    is_next = later.right <= earlier.left if right_to_left else later.left >= earlier.right
    return later.top >= earlier.bottom or (is_next and later.top >= earlier.top)


def box_in(random: np.random.Generator, width: float, height: float, least: float, most: float) -> Box:
    side = random.uniform(least, most) * min(width, height)
    left, top = random.uniform(0, width - side), random.uniform(0, height - side)
    return Box(left, top, left + side, top + side)


def sentence(random: np.random.Generator, most: int) -> str:
    return " ".join(random.choice(WORDS, random.integers(1, most)))


def touches(box: Box, other: Box) -> bool:
    return box.intersection(other).area > 1e-6


def crosses(bubble: Bubble, face: Box) -> bool:
    """Whether the outline with its tail crosses a face."""
    corners = np.array([*bubble.outline, bubble.outline[0]])
    steps = np.linspace(0, 1, 50)[:, None, None]
    points = (corners[:-1] * (1 - steps) + corners[1:] * steps).reshape(-1, 2)
    inside = (points > (face.left, face.top)) & (points < (face.right, face.bottom))
    return bool(inside.all(axis=1).any())


def check_bubbles(bubbles: list[Bubble], area: Box, faces: list[Box], right_to_left: bool) -> None:
    for number, bubble in enumerate(bubbles):
        assert area.contains(bubble.box)
        for face in faces:
            assert not touches(bubble.box, face)
            assert not crosses(bubble, face)
        for earlier in bubbles[:number]:
            assert not touches(bubble.box, earlier.box)
            assert is_in_order(earlier.box, bubble.box, right_to_left)
            assert not is_in_order(bubble.box, earlier.box, right_to_left)


def room_of(width: float, height: float, faces: tuple[Box, ...], seen: Box) -> FreeSpace:
    whole, shape = Box(0, 0, width, height), (round(height), round(width))
    return FreeSpace(whole, whole, faces, box_attention(KeyFrame(0, shape, 1, seen, faces, 0)))


def random_room(random: np.random.Generator) -> FreeSpace:
    width, height = random.uniform(120, 900, 2)
    faces = tuple(box_in(random, width, height, 0.1, 0.5) for _ in range(random.integers(0, 4)))
    return room_of(width, height, faces, box_in(random, width, height, 0.2, 0.9))


@pytest.mark.parametrize("seed", of_the_day(range(150), 30))
def test_balloons_cover_no_face_and_are_in_order(seed: int) -> None:
    random = np.random.default_rng(seed)
    room, right_to_left = random_room(random), bool(seed % 2)
    wordings = [
        Wording(
            "caption" if random.random() < 0.3 else "balloon",
            break_text(LETTERS, sentence(random, 12), 16, room.area.width - 30),
            room.faces[int(random.integers(len(room.faces)))] if room.faces else None,
        )
        for _ in range(random.integers(1, 4))
    ]
    if not all(wording.blocks for wording in wordings):
        return
    bubbles = place_bubbles(wordings, room, right_to_left)
    if bubbles is not None:
        assert [bubble.kind for bubble in bubbles] == [wording.kind for wording in wordings]
        check_bubbles(bubbles, room.area, list(room.faces), right_to_left)


@pytest.mark.parametrize(("kind", "seen_rows"), [("caption", 230), ("balloon", 200)])
def test_words_below_what_is_seen_touch_the_lower_edge(kind: BubbleKind, seen_rows: int) -> None:
    room = room_of(400, 300, (), Box(0, 0, 400, seen_rows))
    blocks = break_text(LETTERS, "the robot says", 16, 300)
    bubbles = place_bubbles([Wording(kind, blocks, None)], room, False)
    assert bubbles is not None and bubbles[0].box.bottom == 300


@pytest.mark.parametrize("sizes", [(16, 24), (24, 16)])
def test_the_smaller_of_two_balloons_is_chosen(sizes: tuple[int, int]) -> None:
    blocks = [break_text(LETTERS, "the robot says", size, 300)[0] for size in sizes]
    bubbles = place_bubbles(
        [Wording("balloon", blocks, None)], room_of(800, 600, (), Box(0, 550, 800, 600)), False
    )
    assert bubbles is not None and bubbles[0].block.size == 16


def test_most_random_panels_have_room_for_a_balloon() -> None:
    """Otherwise the test above would check little."""
    placed = 0
    for seed in range(60):
        random = np.random.default_rng(seed)
        room = random_room(random)
        blocks = break_text(LETTERS, sentence(random, 8), 16, room.area.width - 30)
        placed += bool(blocks) and place_bubbles([Wording("balloon", blocks)], room) is not None
    assert placed > 40


def test_a_tail_points_to_the_speaker() -> None:
    face = Box(300, 150, 380, 250)
    room = room_of(500, 300, (face,), face)
    (bubble,) = (
        place_bubbles([Wording("balloon", break_text(LETTERS, "Hello there.", 16, 300), face)], room) or []
    )
    assert bubble.tip is not None
    mouth = 340, 225
    assert math.dist(bubble.tip, mouth) < math.dist(bubble.box.center, mouth)
    assert len(bubble.outline) != len(Bubble("balloon", bubble.box, bubble.block).outline)


def test_a_tail_that_would_cross_another_balloon_is_omitted() -> None:
    face = Box(300, 100, 380, 200)
    near = Box(200, 130, 280, 170)
    block = break_text(LETTERS, "Yes.", 16, 300)[0]
    bubble = Bubble("balloon", Box(60, 130, 120, 170), block)
    mouth = face.center
    assert add_tail(bubble, face, mouth, [add_face_margin(face)]).tip is not None
    assert add_tail(bubble, face, mouth, [add_face_margin(face), near]).tip is None


def test_a_balloon_is_close_to_its_speaker() -> None:
    """Even if only distant parts of the picture are calm."""
    face = Box(60, 150, 140, 250)
    room = replace(room_of(900, 300, (face,), face), attention=np.repeat([[1.3, 1.3, 0.5, 0.5]], 3, axis=0))
    (bubble,) = (
        place_bubbles([Wording("balloon", break_text(LETTERS, "Hello there.", 16, 300), face)], room) or []
    )
    assert bubble.tip is not None
    assert math.dist(bubble.tip, (100, 225)) < 1.25 * face.height


@pytest.mark.parametrize("calm_side", ["left", "right"])
def test_a_balloon_covers_even_areas_rather_than_half_of_an_object(calm_side: str) -> None:
    """Covered attention counts by its mean square: stripes of the same mean cost more."""
    stripes, even = np.tile([0.0, 0.9], (12, 12)), np.full((12, 24), 0.5)
    sides = [even, stripes] if calm_side == "left" else [stripes, even]
    room = replace(room_of(600, 300, (), Box(0, 0, 600, 300)), attention=np.hstack(sides))
    (bubble,) = place_bubbles([Wording("balloon", break_text(LETTERS, "Hello there.", 16, 200))], room) or []
    assert (bubble.box.center[0] < 300) == (calm_side == "left")


def test_circles_lead_from_a_thought_to_its_head() -> None:
    face = Box(300, 150, 380, 250)
    block = break_text(LETTERS, "Is it he?", 16, 300)[0]
    bubble = Bubble("cloud", Box(60, 30, 160, 80), block)
    thought = add_tail(bubble, face, (340, 230), [add_face_margin(face)])
    *circles, cloud = thought.outlines
    assert len(circles) == 3
    assert np.array_equal(cloud, bubble.outline)
    far = [math.dist(circle.mean(axis=0), (340, 230)) for circle in circles]
    wide = [np.ptp(circle[:, 0]) for circle in circles]
    assert far == sorted(far, reverse=True)
    assert wide == sorted(wide, reverse=True)
    assert not any(face.contains(Box(*point, *point)) for circle in circles for point in circle)


def test_the_third_balloon_is_not_below_the_first_of_two_in_a_line() -> None:
    """Readers would take it for the second."""
    boxes = np.array([[10.0, 60, 50, 80], [70, 60, 110, 80]])
    taken = np.array([[10.0, 10, 50, 30], [60, 10, 100, 30]])
    assert list(_is_read_after(boxes, taken, follows=True)) == [False, True]
    assert list(_is_read_after(boxes, taken, follows=False)) == [True, True]


def test_a_panel_full_of_faces_has_no_room() -> None:
    room = room_of(200, 200, (Box(5, 5, 195, 195),), Box(0, 0, 200, 200))
    assert place_bubbles([Wording("balloon", break_text(LETTERS, "Hello there.", 16, 180))], room) is None


def test_lines_are_inside_their_outline() -> None:
    random = np.random.default_rng(1)
    for _ in range(60):
        for block in break_text(LETTERS, sentence(random, 25), 20, 400):
            width, height = bubble_size("balloon", block)
            bubble = Bubble("balloon", Box(0, 0, width, height), block)
            for _, left, foot, across in bubble.lines:
                for x in (left, left + across):
                    for y in (foot - 0.7 * block.size, foot):
                        off = (abs(x - width / 2) / (width / 2)) ** 3.2
                        assert off + (abs(y - height / 2) / (height / 2)) ** 3.2 < 1


def test_line_breaks_keep_the_whole_text() -> None:
    random = np.random.default_rng(2)
    for _ in range(60):
        text = sentence(random, 25)
        for block in break_text(LETTERS, text, 20, 130):
            assert "".join(block.lines).replace(" ", "") == text.replace(" ", "")
            assert block.width <= 130


@pytest.mark.parametrize("count", [400, 100_000])
def test_long_words_are_measured_only_a_few_times(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    width = Letters.width
    monkeypatch.setattr(Letters, "width", lambda *args: measured.append(len(args[1])) or width(*args))
    blocks = break_text(LETTERS, "mop" * (count // 3), 16, 300)
    assert all(block.width <= 300 for block in blocks) and bool(blocks) == (count == 400)
    assert sum(measured) < 30_000


def random_key_frames(random: np.random.Generator, count: int) -> list[KeyFrame]:
    shape = (360, 640)
    return [
        KeyFrame(
            *(float(number), shape, float(random.random()), box_in(random, 640, 360, 0.3, 0.9)),
            tuple(box_in(random, 640, 360, 0.1, 0.45) for _ in range(random.integers(0, 3))),
            number // 2,
        )
        for number in range(count)
    ]


def panel_texts(key_frames: list[KeyFrame], words: list[list[Line]]) -> list[PanelText]:
    return [
        PanelText(each, lines, box_attention(each)) for each, lines in zip(key_frames, words, strict=True)
    ]


@pytest.mark.parametrize("seed", of_the_day(range(24), 6))
def test_balloons_of_whole_pages_cover_no_face(seed: int) -> None:
    random = np.random.default_rng(seed)
    size = ("a5", "strip", "700x900", "square")[seed % 4]
    sheet, right_to_left = paper(size, 90), bool(seed % 3 == 0)
    key_frames = random_key_frames(random, int(random.integers(1, 9)))
    words = [
        [Line(0, 1, sentence(random, 10), random.random() < 0.2) for _ in range(random.integers(0, 4))]
        for _ in key_frames
    ]

    def pages(area_scales: list[float]) -> PageLayout:
        laid = lay_out(
            *(key_frames, sheet),
            seed=seed,
            right_to_left=right_to_left,
            bleeding=seed % 2 == 1,
            kind="classic" if seed % 5 == 0 else "dynamic",
            area_scales=area_scales,
        )
        return move_below_title(laid, key_frames, sheet, 30)

    hand = TextStyle(LETTERS, letter_size(sheet), sheet.border, right_to_left, sheet.safe)
    layout = letter_panels(pages, panel_texts(key_frames, words), hand)
    assert sum(len(each.bubbles) for each in layout.panels) >= sum(map(len, words)) * 2 / 3
    for each in layout.panels:
        key_frame, picture = key_frames[each.key_frame], each.picture
        assert each.crop.width / each.crop.height == pytest.approx(picture.aspect, rel=1e-6)
        assert Box(0, 0, 640, 360.001).contains(each.crop)
        faces = [map_to_page(face, each.crop, picture) for face in key_frame.faces]
        seen = [face for face in faces if face.area > 0]
        over = [bubble for bubble in each.bubbles if bubble.kind != "band"]
        check_bubbles(over, picture, seen, right_to_left)
        for bubble in over:
            assert sheet.safe.contains(bubble.box)
            assert upright_area(picture, each.leans).contains(bubble.box)
        for band in each.bubbles if len(over) < len(each.bubbles) else ():
            assert band.box.bottom <= picture.top and band.box.top >= each.rectangle.top


def kinds_of(lines: list[Line], *faces: Box) -> list[tuple[str, bool]]:
    """Return the kind of each bubble in a large panel with these faces, and whether it has a tail."""
    key_frame = KeyFrame(0.0, (360, 640), 1.0, Box(0, 0, 640, 360), faces, 0)

    def pages(area_scales: list[float]) -> PageLayout:
        return lay_out([key_frame], paper("900x520", 90), area_scales=area_scales)

    layout = letter_panels(pages, panel_texts([key_frame], [lines]), TextStyle(LETTERS, 16, 2))
    return [(bubble.kind, bubble.tip is not None) for bubble in layout.panels[0].bubbles]


def test_words_without_a_speaker_are_captions() -> None:
    """Nobody is visible, or two faces of one size, of which either may be speaking."""
    line, left, right = Line(0, 1, "Who is there?"), Box(200, 150, 270, 240), Box(400, 150, 470, 240)
    assert kinds_of([line]) == [("caption", False)]
    assert kinds_of([line], left) == [("balloon", True)]
    assert kinds_of([line], left, right) == [("caption", False)]
    assert kinds_of([line], left, Box(400, 150, 440, 200)) == [("balloon", True)]
    both = [Line(0, 1, "Who is it?", speaker="1"), Line(0, 1, "Me.", speaker="2")]
    assert kinds_of(both, left, right) == [("balloon", True)] * 2
    unknown = [replace(each, speaker="") for each in both]
    assert kinds_of(unknown, left) == [("balloon", True), ("balloon", False)]
    assert kinds_of(unknown[1:] * 2, left) == [("balloon", True)] * 2


def test_a_much_smaller_face_is_no_speaker() -> None:
    """It is far away, or no face; with fewer people than speakers, only the first one has a tail."""
    main, small = Box(180, 100, 300, 240), Box(480, 140, 510, 175)
    both = [Line(0, 1, "Who is it?", speaker="1"), Line(0, 1, "Me.", speaker="2")]
    assert kinds_of(both, main, small) == [("balloon", True), ("caption", False)]


def test_sounds_have_no_tail() -> None:
    face = Box(280, 150, 350, 240)
    sound = Line(0, 1, "door slams", narrated=True, manner="sound")
    assert kinds_of([sound], face) == [("caption", False)]
    assert kinds_of([Line(0, 1, "Get out!", manner="shouted")]) == [("burst", False)]


def test_text_keeps_clear_of_a_moving_subject() -> None:
    for left in (60.0, 260.0, 460.0):
        subject = Box(left, 20.0, left + 110, 300.0)
        key_frame = KeyFrame(0.0, (360, 640), 1.0, subject, (), 0, subject=subject)

        def pages(area_scales: list[float], key_frame: KeyFrame = key_frame) -> PageLayout:
            return lay_out([key_frame], paper("900x520", 90), area_scales=area_scales)

        words = [[Line(0, 1, "There it is."), Line(1, 2, "I can see it.")]]
        panel = letter_panels(pages, panel_texts([key_frame], words), TextStyle(LETTERS, 16, 2)).panels[0]
        shown = map_to_page(subject, panel.crop, panel.picture)
        assert len(panel.bubbles) == 2
        assert all(bubble.box.intersection(shown).area == 0 for bubble in panel.bubbles)


def growing_pages() -> tuple[list[KeyFrame], list[list[float]], Callable[[list[float]], PageLayout]]:
    """Return six key frames, a list of the requested area scales, and a function that lays them out."""
    key_frames = random_key_frames(np.random.default_rng(3), 6)
    asked: list[list[float]] = []

    def pages(area_scales: list[float]) -> PageLayout:
        asked.append(list(area_scales))
        return lay_out(key_frames, paper("500x700", 90), area_scales=area_scales)

    return key_frames, asked, pages


def test_a_panel_grows_for_its_text() -> None:
    key_frames, asked, pages = growing_pages()
    words = [[] if number != 2 else [Line(0, 1, " ".join(WORDS * 2))] for number in range(6)]
    letter_panels(pages, panel_texts(key_frames, words), TextStyle(LETTERS, 16, 2))
    assert asked[0] == [1.0] * 6
    assert len(asked) > 1 and asked[1][2] > 1 and asked[1].count(1.0) == 5


def test_titles_keep_the_width_of_gutters() -> None:
    key_frames, sheet = random_key_frames(np.random.default_rng(4), 7), paper("a5", 90)
    plain = lay_out(key_frames, sheet, pages=1)
    titled = move_below_title(plain, key_frames, sheet, 60)
    tops = {each.rectangle.top for each in titled.panels}
    assert min(tops) == sheet.inside.top + 60
    assert max(each.rectangle.bottom for each in titled.panels) == sheet.inside.bottom
    bottoms = {each.rectangle.bottom for each in titled.panels}
    for top in tops - {min(tops)}:
        assert top - sheet.row_gutter in bottoms


def test_missing_letters_are_reported_and_substituted() -> None:
    letters = Letters()
    assert letters.make_writable("Été — ♪ „so“") == 'Ete - "so“'
    assert list(letters.lacking) == ["É", "é"]


def test_a_balloon_is_placed_over_empty_areas() -> None:
    """It avoids conspicuous areas even without a detected face, in every crop of the panel."""
    color = np.full((240, 400, 3), (90, 140, 200), np.uint8)
    color[20:220, 20:200] = np.random.default_rng(5).integers(0, 255, (200, 180, 3))
    seen = attention_map(color)
    key_frame = KeyFrame(0, (240, 400), 1, Box(0, 0, 400, 240), (), 0)
    for left in (0, 100):
        window = Box(left, 0, 400, 240)
        whole = Box(0, 0, 400 - left, 240)
        room = FreeSpace(whole, whole, (), crop_attention(seen, key_frame, window))
        (bubble,) = (
            place_bubbles([Wording("balloon", break_text(LETTERS, "Hello there.", 16, 300))], room) or []
        )
        assert bubble.box.left + left > 195


def test_a_caption_hides_no_part_of_a_small_object() -> None:
    """The blue ball of the demo is in front of dark grass; the sky next to it has more contrast."""
    picture, ball = Box(0, 0, 640, 360), Box(380, 226, 440, 288)
    area, seen = picture.padded(-14, -14, -14), attention_map(film_picture(0.28))
    room = FreeSpace(area, picture, (Box(0, 2, 230, 272),), seen)
    text = break_text(LETTERS, "Early in the morning", 40, 600)
    (bubble,) = place_bubbles([Wording("caption", text)], room) or []
    assert not bubble.box.intersection(ball).area


def test_means_under_boxes_are_means_of_their_cells() -> None:
    cells = np.arange(12, dtype=np.float32).reshape(3, 4)
    boxes = np.array([[0, 0, 40, 30], [10, 10, 20, 20], [30, 20, 40, 30], [5, 5, 15, 15]])
    found = mean_under(cells, Box(0, 0, 40, 30), boxes)
    assert found.tolist() == [5.5, 5.0, 11.0, 2.5]


def test_a_panel_grows_if_text_would_cover_its_subject() -> None:
    """On a calm picture the first layout is kept; on a busy one the last layout contains the text."""
    key_frames, asked, pages = growing_pages()
    words = [[Line(0, 1, "Where is everybody?")] if number == 2 else [] for number in range(6)]
    busy = np.full((54, 96), 2.0, np.float32)
    calm = [replace(each, attention=np.full_like(busy, 0.5)) for each in panel_texts(key_frames, words)]
    for attention, rounds in ((busy, 3), (calm[2].attention, 1)):
        asked.clear()
        calm[2] = replace(calm[2], attention=attention)
        layout = letter_panels(pages, calm, TextStyle(LETTERS, 16, 2))
        assert len(asked) == rounds
        assert len(layout.panels[2].bubbles) == 1
        assert (asked[-1][2] > 1) == (rounds > 1)
