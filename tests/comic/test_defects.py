"""Frames with defects are found, and no panel shows them while there are others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from media import photograph
from stories import PLACES, RATE, shot, story, view, write_film

from vidstyle.comic.analyze.features import Candidate, extract_features
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.flaws.combs import is_combed
from vidstyle.comic.analyze.flaws.defect_limits import DefectLimits, damaged_spans, fill_damage, spread_damage
from vidstyle.comic.analyze.flaws.defects import is_test_picture, measure_blockiness
from vidstyle.comic.select.choose import choose
from vidstyle.comic.select.key_frames import KeyFrameOptions, find_key_frames
from vidstyle.errors import InputError
from vidstyle.media.read.sampler import FilmSampler

LARGE = (640, 360)


def candidate(picture: np.ndarray, **values: object) -> Candidate:
    return replace(extract_features(picture, 0, picture.shape[:2]), **values)  # type: ignore[arg-type]


def with_damaged_packets(source: Path, target: Path, numbers: range) -> Path:
    """Copy a film; the content of these packets is overwritten with noise after their first quarter."""
    random = np.random.default_rng(5)
    with av.open(str(source)) as opened, av.open(str(target), "w") as copy:
        video = opened.streams.video[0]
        stream = copy.add_stream_from_template(video)
        for number, packet in enumerate(opened.demux(video)):
            if packet.dts is None:
                continue
            if number in numbers:
                content = bytearray(bytes(packet))
                start = len(content) // 4
                content[start:] = random.integers(0, 255, len(content) - start, np.uint8).tobytes()
                changed = av.Packet(bytes(content))
                changed.pts, changed.dts, changed.time_base = packet.pts, packet.dts, packet.time_base
                packet = changed
            packet.stream = stream
            copy.mux(packet)
    return target


@pytest.fixture(scope="module")
def damaged_film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two shots of two seconds, with a key frame each second; a frame in the first shot is damaged."""
    folder = tmp_path_factory.mktemp("damage")
    shots = [view(PLACES[place], step, 0, LARGE) for place in (0, 1) for step in range(2 * RATE)]
    whole = write_film(folder / "whole.mp4", shots, options={"bf": "0"})
    return with_damaged_packets(whole, folder / "damaged.mp4", range(RATE + 5, RATE + 6))


def test_frames_are_damaged_until_the_next_key_frame(damaged_film: Path) -> None:
    with FilmSampler(damaged_film) as sampler:
        damaged = [round(each.time * RATE) for each in sampler.frames() if each.is_damaged]
    assert damaged == list(range(damaged[0], 2 * RATE)) and damaged[0] in (RATE + 5, RATE + 6)


def test_no_panel_shows_a_damaged_part(damaged_film: Path) -> None:
    for panels in (1, 4, 6):
        key_frames = find_key_frames(open_film(damaged_film), KeyFrameOptions(panels=panels))
        assert key_frames
        assert not any(1.2 <= each.time < 2 for each in key_frames)


def test_displaced_blocks_are_damage_and_textures_are_not() -> None:
    for name in ("astronaut", "coffee", "chelsea", "rocket"):
        luma = cv2.cvtColor(cv2.resize(photograph(name), LARGE), cv2.COLOR_RGB2GRAY)
        broken = luma.copy()
        random = np.random.default_rng(1)
        for row, column in random.integers(4, 12, (40, 2)):
            place = slice(16 * row, 16 * row + 16), slice(16 * column, 16 * column + 16)
            broken[place] = luma[16:32, 400:416] // 2 + 60 * (row % 2) + 20 * (column % 3)
        whole, damaged = (candidate(luma[..., None].repeat(3, 2), blockiness=measure_blockiness(each))
                          for each in (luma, broken))  # fmt: skip
        limits = DefectLimits.of([whole] * 8 + [damaged])
        assert not limits.mark(whole).damaged, name
        assert limits.mark(damaged).damaged, name


def test_small_pictures_have_no_blocks() -> None:
    assert measure_blockiness(np.zeros((8, 8), np.uint8)) == (0.0, 0.0)
    assert not is_combed(np.zeros((4, 1), np.uint8))
    assert not is_test_picture(np.zeros((1, 1, 3), np.uint8))


def test_damage_spreads_to_the_frames_predicted_from_it() -> None:
    picture = view(PLACES[0])
    frames = [candidate(picture, time=float(time), key_run=time // 3) for time in range(9)]
    frames[4] = replace(frames[4], damaged=True)
    spread = spread_damage(frames)
    assert [each.time for each in spread if each.damaged] == [4, 5]
    assert damaged_spans(spread) == [(3.5, 5)]


def test_damage_of_a_film_that_was_encoded_again_ends_with_the_last_damaged_frame() -> None:
    picture = view(PLACES[0])
    frames = [
        candidate(picture, time=time / 2, scene=time // 9, damaged=time in (2, 6, 9)) for time in range(12)
    ]
    assert [each.time for each in fill_damage(frames) if each.damaged] == [1, 1.5, 2, 2.5, 3, 4.5]


def test_interlaced_fields_of_a_moving_picture_are_combed() -> None:
    first, second = (cv2.cvtColor(view(PLACES[0], move), cv2.COLOR_RGB2GRAY) for move in (0, 6))
    woven = first.copy()
    woven[1::2] = second[1::2]
    assert is_combed(woven) and not is_combed(first) and not is_combed(second)


def bars(colors: int = 8) -> np.ndarray:
    codes = np.arange(colors)[::-1]
    row = np.stack([(codes >> bit & 1) * 191 for bit in (1, 2, 0)], axis=1).repeat(32, axis=0)
    return np.ascontiguousarray(np.broadcast_to(row, (144, *row.shape)).astype(np.uint8))


def test_test_pictures_are_recognized() -> None:
    assert is_test_picture(bars())
    gray_steps = np.linspace(0, 255, 9).astype(np.uint8).repeat(30)
    assert is_test_picture(np.repeat(np.broadcast_to(gray_steps, (144, 270))[..., None], 3, axis=2))
    assert not any(is_test_picture(view(place)) for place in PLACES)


def test_a_scene_without_a_good_frame_gets_no_panel(tmp_path: Path) -> None:
    """A test picture, a black part, and two shots, of which the camera's motion blurs the second."""
    blurred = [
        np.mean([view(PLACES[2], 12 * number + part) for part in range(0, 24, 2)], axis=0).astype(np.uint8)
        for number in range(RATE)
    ]
    parts = [[bars()] * RATE, [np.zeros((144, 256, 3), np.uint8)] * RATE, shot(PLACES[0], 2 * RATE), blurred]
    path = write_film(tmp_path / "film.mp4", [frame for part in parts for frame in part])
    for panels in (None, 4):
        times = [each.time for each in find_key_frames(open_film(path), KeyFrameOptions(panels=panels))]
        assert times and all(2 <= time < 4 for time in times), times


def test_frames_at_a_cut_are_not_chosen(tmp_path: Path) -> None:
    """They are mixed with the shot before, as by the blending of converted films."""
    frames = list(story(3, 25))
    for cut in (25, 50):
        frames[cut] = cv2.addWeighted(frames[cut], 0.6, frames[cut - 1], 0.4, 0)
    path = write_film(tmp_path / "film.mp4", frames)
    for each in find_key_frames(open_film(path), KeyFrameOptions(panels=9)):
        assert all(abs(each.time - cut / RATE) > 0.05 for cut in (25, 50))


FLAWS: dict[str, Callable[[Candidate], Candidate]] = {
    name: lambda each, name=name: replace(each, **{name: True})  # type: ignore[misc]
    for name in ("damaged", "blurred", "combed", "in_transition", "broken", "blank", "test_picture")
}


@pytest.mark.parametrize("flaw", FLAWS)
def test_flawed_frames_are_chosen_only_if_a_film_has_no_others(flaw: str, tmp_path: Path) -> None:
    """A scene in which all frames look combed is chosen, too: it has fine lines."""
    path = write_film(tmp_path / "film.mp4", story(3, 30))
    with open_film(path) as film:
        survey = film.survey()
    partly = [FLAWS[flaw](each) if each.scene == 1 else each for each in survey.candidates]
    others = {0, 1, 2} if flaw == "combed" else {0, 2}
    assert {each.scene for each in choose(replace(survey, candidates=partly), [], 5)} == others
    mixed = [FLAWS[flaw](each) if number % 2 else each for number, each in enumerate(survey.candidates)]
    assert not any(getattr(each, flaw) for each in choose(replace(survey, candidates=mixed), [], 5))
    wholly = choose(replace(survey, candidates=list(map(FLAWS[flaw], survey.candidates))), [], 2)
    assert len(wholly) == (2 if flaw in ("damaged", "blurred", "combed") else 0)


def test_a_film_without_a_printable_frame_gets_no_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    film = open_film(write_film(tmp_path / "film.mp4", story(2, 20)))
    survey = film.survey()
    broken = [FLAWS["broken"](each) for each in survey.candidates]
    monkeypatch.setattr(film, "_found", replace(survey, candidates=broken))
    with film, pytest.raises(InputError, match=r"film.mp4 holds no frame without damage.*--at SECONDS$"):
        find_key_frames(film)


def test_an_interlaced_film_without_the_flag_is_deinterlaced(tmp_path: Path) -> None:
    fields = [view(PLACES[0], 9.0 * number) for number in range(2 * 40)]
    woven = [first.copy() for first in fields[::2]]
    for frame, second in zip(woven, fields[1::2], strict=True):
        frame[1::2] = second[1::2]
    assert is_combed(cv2.cvtColor(woven[20], cv2.COLOR_RGB2GRAY))
    with open_film(write_film(tmp_path / "film.mp4", woven)) as film:
        candidates = film.survey().candidates
        shown = next(film.frames_at([candidates[4].time]))
        near = film.around(candidates[4])
    assert not any(each.combed for each in [*candidates, *near])
    assert not is_combed(cv2.cvtColor(shown, cv2.COLOR_RGB2GRAY))


def test_a_film_of_combed_frames_shows_those_that_are_not_blurred(tmp_path: Path) -> None:
    with open_film(write_film(tmp_path / "film.mp4", story(2, 30))) as film:
        survey = film.survey()
    combed = [replace(each, combed=True, blurred=each.scene == 0) for each in survey.candidates]
    assert {each.scene for each in choose(replace(survey, candidates=combed), [], 4)} == {1}


def test_frames_are_blurred_compared_with_the_film_or_with_those_around_them() -> None:
    """A still frame that is soft is so on purpose, unless there is a sharp one of its scene nearby."""
    picture = view(PLACES[0])
    sharp = [candidate(picture, sharpness=0.3, scene=0, time=0.25 * number) for number in range(5)]
    soft = candidate(picture, sharpness=0.1, scene=1, time=9.0)
    limits = DefectLimits.of([*sharp, soft])
    assert not limits.mark(soft).blurred
    assert limits.mark(replace(soft, motion=0.6)).blurred
    assert not limits.mark(replace(soft, motion=0.6, sharpness=0.25)).blurred
    assert limits.mark(replace(soft, motion=0.7, sharpness=0.25)).blurred
    assert limits.mark(replace(soft, scene=0, time=1.1)).blurred
    assert not limits.mark(replace(soft, scene=0, time=5.0)).blurred
