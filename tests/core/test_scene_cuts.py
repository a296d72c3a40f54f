"""Scene cuts: new scenes are detected; motion, noise, flashes and fades are not."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import cv2
import numpy as np
import pytest
from media import moving_frames, photograph
from pictures import noise

from vidstyle.core.block_matching import SEARCH_RADIUS_PX, block_shape, match_blocks
from vidstyle.core.kernels import dry_run
from vidstyle.core.picture import Picture
from vidstyle.core.scene_cuts import MAX_BLANKS, SceneCutDetector

PAIRS = [("astronaut", "rocket"), ("rocket", "coffee"), ("coffee", "chelsea"), ("chelsea", "astronaut")]
WHITE, BLACK = np.ones((144, 256), np.float32), np.zeros((144, 256), np.float32)


def small(name: str) -> np.ndarray:
    return photograph(name)[::4, ::4, 1][:64, :96].astype(np.float32) / 255


def view(name: str, across: float = 0, down: float = 0, zoom: float = 1) -> np.ndarray:
    """A photograph as a film's small luma, seen from another place: 144 x 256."""
    green = np.ascontiguousarray(photograph(name)[..., 1])
    still = cv2.resize(green, (332, 188), interpolation=cv2.INTER_AREA)
    seen = np.array([[zoom, 0, 128 - zoom * (166 + across)], [0, zoom, 72 - zoom * (94 + down)]], np.float64)
    moved = cv2.warpAffine(still, seen, (256, 144), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return moved.astype(np.float32) / 255


def grainy(frames: Iterable[np.ndarray], deviation: float) -> list[np.ndarray]:
    """With another noise in each; in 8 bits."""
    random = np.random.default_rng(3)
    noisy = (frame + random.normal(0, deviation / 255, frame.shape) for frame in frames)
    return [(np.clip(np.rint(frame * 255), 0, 255) / 255).astype(np.float32) for frame in noisy]


def cuts(frames: Iterable[np.ndarray]) -> list[int]:
    """The numbers of the frames that are cuts, but for the first, which always is."""
    detector = SceneCutDetector()
    found = [number for number, frame in enumerate(frames) if detector.is_cut(frame)]
    assert found[0] == 0
    return found[1:]


def test_the_first_frame_begins_a_scene_and_the_same_again_does_not() -> None:
    detector = SceneCutDetector()
    assert [detector.is_cut(small("astronaut")) for _ in range(3)] == [True, False, False]


@pytest.mark.parametrize("pair", PAIRS)
def test_another_picture_is_a_cut(pair: tuple[str, str]) -> None:
    detector = SceneCutDetector()
    cuts = [detector.is_cut(small(name)) for name in (pair[0], pair[0], pair[1], pair[1], pair[0])]
    assert cuts == [True, False, True, False, True]


def test_another_size_is_a_cut() -> None:
    detector = SceneCutDetector()
    detector.is_cut(small("coffee"))
    assert detector.is_cut(small("coffee")[:32])


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("light", [1, 0.3])
def test_a_cut_within_movement_and_noise_is_found_and_nothing_else(
    pair: tuple[str, str], light: float
) -> None:
    frames = [light * view(name, 6 * step, -3 * step, 1.03**step) for name in pair for step in range(6)]
    assert cuts(grainy(frames, 4)) == [6]


@pytest.mark.parametrize("pair", PAIRS)
def test_a_cut_between_pictures_of_the_same_tones_is_found(pair: tuple[str, str]) -> None:
    """With their histograms made equal, so that only what they show differs."""
    ramp = np.linspace(0, 1, WHITE.size, dtype=np.float32)
    first, second = (ramp[view(name).ravel().argsort().argsort()].reshape(WHITE.shape) for name in pair)
    assert cuts([first, first, second, second]) == [2]


@pytest.mark.parametrize("pair", PAIRS)
def test_black_bars_do_not_hide_a_cut(pair: tuple[str, str]) -> None:
    frames = [view(name, 4 * step) for name in pair for step in range(4)]
    for frame in frames:
        frame[:28], frame[-28:] = 0, 0
    assert cuts(grainy(frames, 2)) == [4]
    assert cuts(np.ascontiguousarray(frame.T) for frame in grainy(frames, 2)) == [4]


def test_narrow_pictures_with_a_black_half_have_no_cuts() -> None:
    """Reduced, such a picture is two pixels wide, and one of them is the bar."""
    detector = SceneCutDetector()
    for width in (1, 2, 3, 40):
        picture = np.ones((2000, width), np.float32)
        picture[:, : width // 2] = 0
        assert [detector.is_cut(picture) for _ in range(2)] == [True, False]


def test_movement_is_no_cut() -> None:
    assert cuts(frame[..., 1].astype(np.float32) / 255 for frame in moving_frames(40, (160, 90))) == []
    assert cuts(view("coffee", 20 * step - 50) for step in range(6)) == []


def test_wild_action_is_not_all_cuts() -> None:
    """Half of every picture is new; among still pictures one such is a cut."""
    coffee, new = view("coffee")[:, :128], (noise(24, 21, seed=seed) for seed in range(12))
    wild = [np.hstack([coffee, cv2.resize(each, (128, 144), interpolation=cv2.INTER_CUBIC)]) for each in new]
    assert cuts(wild) == [1]
    assert cuts([wild[0]] * 6 + [wild[1]] * 6) == [6]
    assert cuts([*wild, view("astronaut")]) == [1, 12]


@pytest.mark.parametrize("light", [1, 0.05])
def test_noise_is_no_cut(light: float) -> None:
    assert cuts(grainy([light * view("astronaut")] * 10, 6)) == []
    assert cuts(grainy([light * WHITE / 2] * 10, 6)) == []


@pytest.mark.parametrize("name", ["astronaut", "coffee", "chelsea"])
def test_light_is_no_cut(name: str) -> None:
    """A flash of one frame, a white one, a stroboscope, and a light that is switched on and stays."""
    still = view(name, zoom=1.2)
    flash = np.minimum(1, still + 0.5)
    assert cuts([still, still, flash, still, still]) == []
    assert cuts([still, still, WHITE, still, still]) == []
    assert cuts([still, 0.3 * still] * 4) == []
    assert cuts([0.2 * still] * 3 + [still] * 3) == []


def test_light_so_bright_that_little_shows_in_it_is_one_cut_at_most() -> None:
    still = view("chelsea", zoom=1.2)
    flash = np.minimum(1, still + 0.8)
    assert cuts(grainy([still, still, flash, still, still], 2)) == [2]


def test_a_cut_behind_a_flash_is_found() -> None:
    assert cuts([view("astronaut"), WHITE, view("coffee"), view("coffee")]) == [2]


@pytest.mark.parametrize("pair", [("coffee", "astronaut"), ("chelsea", "rocket"), ("rocket", "coffee")])
def test_fades_are_no_cuts_and_the_next_scene_is_one(pair: tuple[str, str]) -> None:
    """To black in one second, and out of it, at 25 frames a second."""
    out, back = ([view(name) * (number / 25) for number in range(26)] for name in pair)
    assert cuts(grainy(out[::-1], 1)) == []
    (begin,) = cuts(grainy(out[::-1] + back, 1))
    assert 26 <= begin < 32


def test_what_comes_after_a_pause_is_a_scene() -> None:
    """The same one too; a film that opens with a single black frame has no scene of one frame."""
    still = view("coffee")
    assert cuts([still] * 3 + [BLACK] * MAX_BLANKS + [still] * 3) == [3 + MAX_BLANKS]
    assert cuts([still] * 3 + [BLACK] * (MAX_BLANKS - 1) + [still] * 3) == []
    assert cuts([BLACK] + [still] * 3) == []


@pytest.mark.parametrize("shape", [(1, 1), (1, 320), (9, 7), (320, 4)])
def test_pictures_of_any_size_are_taken(shape: tuple[int, int]) -> None:
    assert cuts([noise(*shape, seed=1)] * 3) == []


def test_a_buffer_that_is_used_again_does_not_hide_a_cut() -> None:
    detector = SceneCutDetector()
    buffer = small("astronaut").copy()
    detector.is_cut(buffer)
    buffer[:] = small("rocket")
    assert detector.is_cut(buffer)


def test_every_scene_begins_with_a_cut() -> None:
    assert cuts(map(view, ["coffee"] * 3 + ["rocket"] + ["chelsea"] * 2)) == [3, 4]


@pytest.mark.parametrize("shape", [(54, 96), (17, 40), (9, 33), (40, 5)])
def test_blocks_are_matched_as_by_opencv(shape: tuple[int, int]) -> None:
    picture, before = noise(*shape, seed=1), noise(*shape, seed=2)
    before[:-2, 3:] += picture[2:, :-3]
    side, (tall, wide) = SEARCH_RADIUS_PX, block_shape(shape)
    wider = cv2.copyMakeBorder(before, side, side, side, side, cv2.BORDER_REPLICATE)
    tops, lefts = (
        range(length % size // 2, length - size + 1, size)
        for length, size in zip(shape, (tall, wide), strict=True)
    )

    wanted = []
    for top, left in itertools.product(tops, lefts):
        block = np.ascontiguousarray(picture[top : top + tall, left : left + wide])
        around = wider[top : top + tall + 2 * side, left : left + wide + 2 * side]
        wanted.append(cv2.matchTemplate(around, block, cv2.TM_CCOEFF_NORMED).max())

    count, match = match_blocks(picture, before, 0)
    assert count == len(wanted) == (shape[0] // tall) * (shape[1] // wide)
    np.testing.assert_allclose(match, np.mean(wanted), atol=1e-4)
    with dry_run():
        assert match_blocks(picture, before, 0) == (count, 1), "a rehearsal has no cuts"


def test_only_blocks_that_show_something_are_matched() -> None:
    picture = np.full((32, 48), 0.5, np.float32)
    picture[:16, :16] += noise(16, 16, seed=1)
    assert match_blocks(picture, picture, 0.01) == (1, pytest.approx(1, abs=1e-4))
    assert match_blocks(picture, picture, 2)[0] == 0


def test_renderers_that_share_a_detector_get_one_answer_for_a_frame() -> None:
    detector = SceneCutDetector()
    frames = [Picture.from_array(photograph(name)) for name in ("astronaut", "astronaut", "rocket")]
    found = [[detector.begins_scene(frame, n / 25) for _ in range(2)] for n, frame in enumerate(frames)]
    assert found == [[True, True], [False, False], [True, True]]
