"""Frames that cannot be read once they are drawn are replaced or left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from stories import story, write_film

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.sharpness import measure_detail
from vidstyle.comic.output.readability import measure_readability
from vidstyle.comic.select.frame_scores import scores, subject_strength
from vidstyle.comic.select.framing import widen_soft_faces
from vidstyle.comic.select.importance import prefer_subjects
from vidstyle.comic.select.key_frame_options import KeyFrameOptions
from vidstyle.comic.select.key_frames import find_key_frames
from vidstyle.comic.select.readable import ReadableSearch
from vidstyle.comic.select.refinement import Refinement
from vidstyle.pipeline.progress import ignore_progress
from vidstyle.regions.boxes import Box


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four shots of one second."""
    return write_film(tmp_path_factory.mktemp("film") / "film.mp4", story(4, 25))


def scene() -> np.ndarray:
    """A sharp picture, H x W x 3 uint8."""
    random = np.random.default_rng(4)
    return cv2.resize(
        random.choice(np.array([70, 250], np.uint8), (12, 16, 3)), (640, 480), interpolation=cv2.INTER_NEAREST
    )


def test_blurred_and_black_panels_are_less_readable_and_soft_surroundings_do_not_count() -> None:
    sharp = scene()
    blurred = cv2.GaussianBlur(sharp, (0, 0), 14)
    focused = blurred.copy()
    focused[160:320, 210:420] = sharp[160:320, 210:420]
    black = sharp.copy()
    black[:, :400] = 20
    values = [
        measure_readability(each, each, None, lambda *_: None) for each in (sharp, focused, blurred, black)
    ]
    assert values[0] == values[1] == 1
    assert values[2] < 0.5
    assert values[3] == pytest.approx(1 - (400 / 640 - 0.25), abs=0.02)


@pytest.mark.parametrize("shape", [(1, 1), (1, 700), (480, 3)])
def test_small_and_narrow_pictures_have_a_detail(shape: tuple[int, int]) -> None:
    assert measure_detail(np.full((*shape, 3), 128, np.uint8)) == 0


@pytest.mark.parametrize(
    ("before", "after", "is_lost"),
    [(0.9, 0.1, True), (0.9, 0.4, False), (0.1, 0.09, False), (None, None, False)],
)
def test_a_face_that_the_drawing_destroys_counts(
    before: float | None, after: float | None, is_lost: bool
) -> None:
    """A face that is none in the source either, such as an animal's, is not lost by drawing it."""
    source, scores = scene(), iter([before, after])
    value = measure_readability(source, source, Box(10, 10, 200, 300), lambda *_: next(scores))
    assert (value < 0.7) == is_lost


def test_other_frames_are_chosen_for_those_that_cannot_be_read(film: Path) -> None:
    def readability(candidates: Sequence[Candidate]) -> list[float]:
        return [0.1 if 1 <= each.time < 2 or each.time in refused else 1.0 for each in candidates]

    refused = set[float]()
    with open_film(film) as opened:
        usual = find_key_frames(opened)
        shown = find_key_frames(opened, readability=readability)
        assert [each.scene for each in usual] == [0, 1, 2, 3]
        assert [each.scene for each in shown] == [0, 2, 3]
        assert len(find_key_frames(opened, KeyFrameOptions(4), readability=readability)) == 4
        requested = find_key_frames(opened, KeyFrameOptions(at=(1.4,)), readability=readability)
        assert 1 in [each.scene for each in requested]


def test_a_soft_face_is_lost_in_a_sharp_room_and_shown_without_enlargement() -> None:
    sharp, face = scene(), Box(200, 100, 360, 320)
    soft = sharp.copy()
    soft[100:320, 200:360] = cv2.GaussianBlur(sharp[100:320, 200:360], (0, 0), 40)
    values = [measure_readability(each, each, face, lambda *_: None) for each in (sharp, soft)]
    assert values[0] == 1 and values[1] < 0.55
    person = Candidate(
        *(0, (480, 640), 1.0, face, (face,), 0), sharpness=1, clarity=1, blank=False, face_detail=3.0,
        thumbnail=np.zeros((32, 48, 3), np.uint8), histogram=np.zeros(64, np.float32),
    )  # fmt: skip
    clear, small = replace(person, face_detail=20.0), replace(person, faces=(Box(0, 0, 20, 30),))
    assert [each.framing for each in widen_soft_faces([person, clear, small])] == ["wide", "usual", "usual"]
    assert subject_strength(person) < subject_strength(clear)
    assert scores([person, clear], np.ones(1)).argmax() == 1


def test_the_second_choice_avoids_what_could_not_be_read(tmp_path: Path) -> None:
    measured = list[Sequence[Candidate]]()

    def readability(candidates: Sequence[Candidate]) -> list[float]:
        measured.append(candidates)
        return [float(len(measured) > 1 or number in (0, 3)) for number, _ in enumerate(candidates)]

    with open_film(write_film(tmp_path / "long.mp4", story(2, 90))) as opened:
        find_key_frames(opened, KeyFrameOptions(5), readability=readability)
    first, second = measured[:2]
    kept, refused = {each.time for each in first[:4:3]}, [*first[1:3], *first[4:]]
    assert kept <= {each.time for each in second}
    for each in second:
        distances = [abs(each.time - other.time) for other in refused if other.scene == each.scene]
        assert each.time in kept or min(distances, default=1.0) > 0.8


@pytest.mark.parametrize("panels", [2, 3])
def test_a_fixed_number_of_panels_has_no_more_for_a_story(film: Path, panels: int) -> None:
    measured = list[Candidate]()

    def readability(candidates: Sequence[Candidate]) -> list[float]:
        measured.extend(candidates)
        return [0.5 if each.scene == measured[0].scene else 1.0 for each in candidates]

    with open_film(film) as opened:
        assert len(find_key_frames(opened, KeyFrameOptions(panels), readability=readability)) == panels


def test_other_frames_are_chosen_for_those_that_tell_nothing_new(tmp_path: Path) -> None:
    def keep(found: Sequence[Candidate]) -> list[Candidate]:
        return [each for each in found if each.time > 2 or each.scene != 0]

    options = KeyFrameOptions()
    with open_film(write_film(tmp_path / "long.mp4", story(2, 90))) as opened:
        survey = opened.survey()
        usual, told = (
            ReadableSearch(
                Refinement(opened, survey, options.skips, ignore_progress), options, readability=None
            ).run(survey, [], selection)
            for selection in (list, keep)
        )
    assert keep(usual) != usual and keep(told) == told
    assert len(told) > len(keep(usual))


def test_a_film_without_a_readable_frame_shows_the_best_one(
    film: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with open_film(film) as opened:
        shown = find_key_frames(
            opened, readability=lambda candidates: [0.4 - 0.1 * each.scene for each in candidates]
        )
    assert [each.scene for each in shown] == [0]
    assert caplog.messages == ["no frame of the film can be drawn clearly; the best one is shown"]


@pytest.mark.parametrize(("value", "count"), [(0.5, 4), (0.3, 1)])
def test_what_can_nearly_be_read_fills_a_page_of_few_panels(film: Path, value: float, count: int) -> None:
    def readability(candidates: Sequence[Candidate]) -> list[float]:
        return [1.0 if each.time < 1 else value for each in candidates]

    with open_film(film) as source:
        assert len(find_key_frames(source, readability=readability)) == count


def test_people_are_more_important_than_places() -> None:
    place, person, asked = (
        Candidate(
            *(time, (360, 640), 0.2 * time + 0.4, Box(0, 0, 640, 360), faces, 0),
            sharpness=0.2, clarity=1, blank=False, forced=time == 3,
            thumbnail=np.zeros((32, 48, 3), np.uint8), histogram=np.zeros(64, np.float32),
        )
        for time, faces in ((2, ()), (1, (Box(200, 100, 280, 200),)), (3, ()))
    )  # fmt: skip
    assert [each.importance for each in prefer_subjects([place, person, asked])] == pytest.approx(
        [0.8 * 0.6, 0.6, 1.0]
    )
    assert prefer_subjects([place]) == [place]
