"""Writing: thin strokes are found on even ground, taken off, and drawn over the result."""

from __future__ import annotations

import threading
from dataclasses import replace
from types import ModuleType

import av
import cv2
import numpy as np
import pytest
from media import photograph
from pictures import noise, picture_with_writing, same_bits
from waiting import LONG

from vidstyle.backend import FrameRequest
from vidstyle.comic.output.panel_renderer import cut_out
from vidstyle.core.kernels import dry_run, is_dry_run
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.demo.drawing import film_picture
from vidstyle.media.frame import picture_from_frame
from vidstyle.picture_edit import PictureEdit
from vidstyle.regions import focus
from vidstyle.regions.boxes import Box
from vidstyle.regions.focus import FocusRenderer
from vidstyle.regions.still_faces import KnownFaces
from vidstyle.regions.writing import letters
from vidstyle.regions.writing.finding import find_writing
from vidstyle.regions.writing.lifting import Strokes, lift_writing, luma_in
from vidstyle.renderer import stylize
from vidstyle.style import load_style

WORDS = np.s_[90:210, 120:380]
"""Where `picture_with_writing` has its words."""


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Return the correlation of structure thinner than a letter, for dark and light strokes alike."""
    details = []
    for picture in (one, other):
        luma = cv2.GaussianBlur(picture[WORDS].mean(axis=2), (0, 0), 1)
        details.append((luma - cv2.GaussianBlur(luma, (0, 0), 6)).ravel())
    return abs(float(np.corrcoef(*details)[0, 1]))


@pytest.mark.parametrize("name", ["blueprint", "comic", "ink", "mosaic", "oil", "pixel", "poster"])
@pytest.mark.parametrize("dark", [True, False])
def test_words_stay_legible(name: str, dark: bool) -> None:
    picture, style = picture_with_writing(dark), replace(load_style(name), steady=0.0)
    focused, plain = (
        likeness(picture, stylize(picture, replace(style, focus=each), "cpu")) for each in (1, 0)
    )
    assert focused > 0.4 and 1 - focused < 0.85 * (1 - plain), (focused, plain)


@pytest.mark.parametrize("format", ["yuv420p", "yuv422p10le", "gray", "rgb24", "yuva420p"])
def test_writing_is_taken_off_every_layout_of_planes(format: str) -> None:
    """Works for odd sizes; only the ground remains, and the source is unchanged."""
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture_with_writing()[:479, :639]), "rgb24")
    picture = picture_from_frame(frame.reformat(format=format))
    page = Box(0, 0, 639, 479)
    before = luma_in(picture, page).copy()
    lifted, writing = lift_writing(picture, 1.0)
    after = luma_in(lifted, page)
    assert writing and lifted.encoding == picture.encoding
    assert np.array_equal(luma_in(picture, page), before)
    assert np.ptp(before[WORDS]) > 0.5 and np.ptp(after[WORDS]) < 0.12
    assert np.array_equal(before[250:], after[250:])


def test_half_of_the_focus_leaves_half_of_the_strokes() -> None:
    picture = Picture.from_array(picture_with_writing())
    (half, some), (_, all_) = (lift_writing(picture, amount) for amount in (0.5, 1.0))
    assert np.allclose(2 * some[0].dark, all_[0].dark)
    assert 0.2 < np.ptp(luma_in(half, Box(0, 0, 640, 480))[WORDS]) < 0.5


@pytest.mark.parametrize("name", ["noise", "blobs", "lines", "coffee", "rocket"])
def test_textures_and_edges_are_no_writing(name: str) -> None:
    """Noise of two sizes; parallel lines; wood and porcelain; a night sky."""
    grain = noise(480, 640, seed=3)
    gray = {
        "noise": grain,
        "blobs": cv2.normalize(cv2.GaussianBlur(grain, (0, 0), 2), None, 0, 1, cv2.NORM_MINMAX),
        "lines": np.where(np.arange(480)[:, None] % 24 < 3, 0.2, 0.9) + np.zeros((1, 640)),
        "rocket": photograph("rocket")[200:, 240:400] / 255.0,
        "coffee": photograph("coffee")[:90] / 255.0,
    }[name]
    picture = Picture.from_array(np.asarray(gray, np.float32))
    assert find_writing(picture) == []
    assert lift_writing(picture, 1.0)[0] is picture


def test_a_word_with_an_outline_has_one_polarity() -> None:
    """Bright letters close to each other, with dark outlines, on gray: the letters are drawn."""
    picture = picture_with_writing()
    picture[80:220, 100:500] = 110
    for shade, width in ((20, 9), (230, 3)):
        cv2.putText(picture, "SINGING BEE", (140, 160), cv2.FONT_HERSHEY_SIMPLEX, 0.7, (shade,) * 3, width)
    (found,) = find_writing(Picture.from_array(picture))
    assert found.light.max() == 1 and found.dark.max() == 0


def test_a_thick_title_and_pale_grain_are_left_as_they_are() -> None:
    """Other structure than small letters: a title with some thin parts, and paper grain."""
    picture = picture_with_writing()
    font, smooth = cv2.FONT_HERSHEY_COMPLEX, cv2.LINE_AA
    cv2.putText(picture, "Title", (140, 95), font, 1.8, (30, 30, 40), 12, smooth)
    cv2.putText(picture, ", ; ' : , . ' ;", (140, 240), font, 0.6, (190, 190, 190), 1, smooth)
    page = Picture.from_array(picture)
    lifted, writing = lift_writing(page, 1.0)
    before, after = (luma_in(each, Box(0, 0, 640, 480)) for each in (page, lifted))
    assert writing and np.ptp(after[110:210, 130:380]) < 0.12
    assert np.array_equal(before[30:104], after[30:104])
    assert np.array_equal(before[222:260], after[222:260])


def word(letters: str, gap: int) -> np.ndarray:
    """Return a picture with a word over a spaced one, H x W x 3 uint8."""
    picture = np.full((480, 640, 3), 200, np.uint8)
    picture[300:, :320], picture[300:, 320:] = 5, 250
    cv2.putText(picture, "shipment", (150, 150), cv2.FONT_HERSHEY_SIMPLEX, 1.2, (20, 20, 20), 3, cv2.LINE_AA)
    for place, letter in enumerate(letters):
        at = 150 + place * gap, 196
        cv2.putText(picture, letter, at, cv2.FONT_HERSHEY_SIMPLEX, 0.9, (20, 20, 20), 3, cv2.LINE_AA)
    return picture


def test_spaced_words_are_whole() -> None:
    """Each letter follows from the one before it."""
    picture = word("LONDON", 36)
    lifted, _ = lift_writing(Picture.from_array(picture), 1.0)
    left = luma_in(lifted, Box(140, 160, 400, 205))
    assert left.min() > 0.7 and luma_in(Picture.from_array(picture), Box(140, 160, 400, 205)).min() < 0.2


def test_half_a_word_is_left_to_the_style() -> None:
    """Crisp letters next to painted ones would show where the search ends."""
    kept, strokes = np.zeros((40, 200), bool), np.zeros((40, 200), bool)
    strokes[10:30, 10:190:6] = True
    kept[10:30, 100:190:6] = True
    assert not (kept & letters._whole_words(kept, strokes, 9)).any()
    assert letters._whole_words(strokes, strokes, 9)[strokes].all()


@pytest.mark.parametrize(("time", "width"), [(0.4, 640), (0.4, 400), (3.36, 1114)])
def test_blades_of_grass_are_no_letters(time: float, width: int) -> None:
    """Also in panels of comics, small or sharpened after enlarging."""
    whole = Box(0, 0, 640, 360)
    picture = Picture.from_array(cut_out(film_picture(time), whole, width, width * 9 // 16, is_cleaned=True))
    assert lift_writing(picture, 1.0)[0] is picture


@pytest.mark.parametrize("lines", [False, True])
def test_only_marks_in_lines_are_letters(lines: bool) -> None:
    """The same letters, in a line or scattered as leaves are, each at another height."""
    page = picture_with_writing()
    page[100:200] = 220
    for n, move in enumerate((4, 12, 20, 28, 24, 16, 8, 0)):
        corner = 220 + 14 * n, 140 + move * (not lines)
        cv2.putText(page, "aesnuaes"[n], corner, cv2.FONT_HERSHEY_COMPLEX, 0.6, (30, 30, 40), 1, cv2.LINE_AA)
    assert bool(lift_writing(Picture.from_array(page), 1.0)[1]) == lines


@pytest.mark.parametrize("shape", [(1, 1), (3, 700), (40, 2)])
def test_tiny_pictures(shape: tuple[int, int]) -> None:
    picture = Picture.from_array(np.ascontiguousarray(picture_with_writing()[: shape[0], : shape[1]]))
    assert lift_writing(picture, 1.0)[0] is picture


def test_a_word_is_drawn_in_the_colours_of_the_style() -> None:
    """In its ink; where the ground has that colour, in its paper."""
    picture = picture_with_writing()
    for name, is_dark in (("ink", True), ("blueprint", False), ("neon", False)):
        style = replace(load_style(name), steady=0.0)
        words = stylize(picture, style, "cpu")[WORDS].mean(axis=2)
        rest = stylize(picture, replace(style, focus=0.0), "cpu")[230:300].mean()
        strokes = picture[WORDS].mean(axis=2) < 60
        assert (words[strokes].mean() < rest - 60) == is_dark
        assert (words[strokes].mean() > rest + 60) == (not is_dark)


def test_a_dry_run_leaves_the_writing_of_a_frame_to_be_found() -> None:
    """Also if it takes place while the frame is searched, as a kernel is missing: it must not wait."""
    found = []

    def lift(picture: Picture) -> tuple[Picture, list[Strokes]]:
        if not is_dry_run():
            with dry_run():
                assert edit.kept() == []
        return lift_writing(picture, 1.0)

    edit = PictureEdit(Picture.from_array(picture_with_writing()), lift)
    with dry_run():
        assert edit.kept() == []
    search = threading.Thread(target=lambda: found.append(edit.kept()), daemon=True)
    search.start()
    search.join(LONG)
    assert found and found[0]


@pytest.mark.parametrize(("owner", "name"), [(focus, "lift_writing"), (focus, "draw_writing")])
def test_the_threads_that_restyle_a_film_take_writing_off_and_draw_it(
    owner: ModuleType, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All at the same time, as one thread begins all frames; the result is the same for each number."""
    style, threads = replace(load_style("ink"), steady=0.5), set[str]()
    page = picture_with_writing()
    film = [Picture.from_array(np.roll(page, 3 * number, axis=1)) for number in range(4)]
    function = getattr(owner, name)

    def noted(*arguments: object, **named: object) -> object:
        threads.add(threading.current_thread().name)
        return function(*arguments, **named)

    def restyled(count: int) -> list[Picture]:
        with FocusRenderer(style, lambda each, _: CpuRenderer(each, count), KnownFaces()) as renderer:
            pending = [renderer.begin(FrameRequest(each, n / 25)) for n, each in enumerate(film)]
            return [each.result() for each in pending]

    alone = restyled(1)
    monkeypatch.setattr(owner, name, noted)
    assert all(map(same_bits, alone, restyled(3)))
    assert threads and threading.current_thread().name not in threads
