"""Faces of films: found, followed, faded, and forgotten at scene cuts."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from media import photograph
from pictures import FACE, film_with_face, picture_with_face

from vidstyle.core.picture import Encoding, Picture
from vidstyle.media.frame import picture_from_frame
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import (
    DELAY_SECONDS,
    FADE_SECONDS,
    MAX_MISSES,
    SEARCH_SECONDS,
    Face,
    FaceFollower,
)
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features.landmarks import MarkedFaces


@pytest.fixture
def follower() -> Iterator[FaceFollower]:
    with FaceFollower(FaceFinder()) as follower:
        yield follower


def distance(face: Face, left: float) -> float:
    """Distance of the middle of a face from its true place, in pixels."""
    (x, y), (right_x, right_y) = face.box.center, FACE.moved(left, 150).center
    return math.hypot(x - right_x, y - right_y)


def test_a_moving_face_is_followed(follower: FaceFollower) -> None:
    """One track, within a tenth of the face's height, between searches too."""
    for picture, time in film_with_face(lambda number: 100 + 4 * number, 60):
        (face,) = follower.follow(picture, time)
        assert (face.track, face.opacity) == (0, 1.0)
        assert distance(face, 100 + 100 * time) < 0.1 * FACE.height


def test_a_large_face_is_followed_in_a_reduced_copy(follower: FaceFollower) -> None:
    """Within a fiftieth of its height, though a pixel of the copy is larger."""
    still, place = picture_with_face(), FACE.moved(250, 150)
    errors = []
    for number in range(25):
        left, top = round(place.left) - 60 + number, round(place.top) - 35
        seen = cv2.resize(still[top : top + 120, left : left + 160], None, fx=4, fy=4)
        (face,) = follower.follow(Picture.from_array(seen), number / 25)
        errors.append(face.box.center[0] - 4 * (place.center[0] - left))
    assert np.ptp(errors) < 0.02 * 4 * FACE.height


def test_a_still_face_rests(follower: FaceFollower) -> None:
    """In a noisy film it moves by less than a pixel from frame to frame."""
    random, places = np.random.default_rng(5), list[Box]()
    still = picture_with_face().astype(np.float32)
    for number in range(40):
        noisy = np.clip(still + random.normal(0, 5, still.shape), 0, 255).astype(np.uint8)
        (face,) = follower.follow(Picture.from_array(noisy), number / 25)
        places.append(face.box)
    assert np.abs(np.diff(np.array(places), axis=0)).max() < 1


def test_faces_fade_when_they_enter_and_leave(follower: FaceFollower) -> None:
    """Opacity changes slowly from frame to frame, to 1 and back to 0."""
    opacities = []
    for picture, time in film_with_face(lambda number: 250 if 10 <= number < 60 else None, 110):
        opacities.append(max((face.opacity for face in follower.follow(picture, time)), default=0.0))
    assert opacities[9] == 0 and opacities[59] == 1 and opacities[-1] == 0
    assert max(abs(np.diff(opacities))) <= 0.04 / FADE_SECONDS + 1e-9


def test_a_face_that_turns_away_fades_after_some_searches() -> None:
    """The networks no longer find it, though it still looks alike."""

    class Forgetful(FaceFinder):
        searches = 0

        def find(self, color: np.ndarray, least: float = 0.05) -> dict[Box, tuple[float, float]]:
            self.searches += 1
            return super().find(color, least) if self.searches == 1 else {}

    last = SEARCH_SECONDS * MAX_MISSES + DELAY_SECONDS
    with FaceFollower(Forgetful()) as follower:
        seen = [
            (time, len(follower.follow(picture, time))) for picture, time in film_with_face(lambda _: 250, 75)
        ]
    assert all(count == 1 for time, count in seen if time < last)
    assert all(count == 0 for time, count in seen if time > last + FADE_SECONDS + 0.08)


def test_landmarks_move_half_way_to_those_of_a_new_search() -> None:
    """As the box does, so that eyes do not jump each second."""

    class Doubtful(FaceFinder):
        searches = 0

        def find(self, color: np.ndarray, least: float = 0.05) -> MarkedFaces:
            self.searches += 1
            low = 0.5 if self.searches == 1 else 0.6
            return {box: marks._replace(nose=(0.5, low)) for box, marks in super().find(color, least).items()}

    with FaceFollower(Doubtful()) as follower:
        noses = [
            follower.follow(picture, time)[0].landmarks.nose[1]
            for picture, time in film_with_face(lambda _: 250, 60)
        ]
    assert noses[0] == 0.5 and noses[-1] == pytest.approx(0.55) and set(noses) == {noses[0], noses[-1]}


def test_a_scene_cut_starts_again(follower: FaceFollower) -> None:
    """Faces of a new scene appear immediately; faces of the previous scene leave no trace."""
    astronaut = Picture.from_array(np.ascontiguousarray(photograph("astronaut")[:480]))
    for number in range(5):
        assert [
            face.track for face in follower.follow(Picture.from_array(picture_with_face()), number / 25)
        ] == [0]
    for number in range(5, 10):
        assert follower.follow(Picture.from_array(picture_with_face(None)), number / 25)[1:] == ()
    assert [(face.track, face.opacity) for face in follower.follow(astronaut, 0.4)] == [(1, 1.0)]


def test_results_do_not_depend_on_the_time_of_a_search() -> None:
    class Slow(FaceFinder):
        def find(self, color: np.ndarray, least: float = 0.05) -> dict[Box, tuple[float, float]]:
            threading.Event().wait(0.05)
            return super().find(color, least)

    frames, found = film_with_face(lambda number: 100 + 3 * number, 45), []
    for finder in (FaceFinder(), Slow()):
        with FaceFollower(finder) as follower:
            found.append([follower.follow(*frame) for frame in frames])
    assert found[0] == found[1]


def test_every_kind_of_picture_is_searched(follower: FaceFollower) -> None:
    """RGB, gray, subsampled, 10-bit and float pictures; too small ones have no faces."""
    import av

    color = picture_with_face()
    pictures = [Picture.from_array(color), Picture.from_array(color.astype(np.float32) / 255)]
    pictures.append(
        Picture(Encoding(full_range=True), luma=color @ np.float32([0.2, 0.7, 0.1]) // 1).map_planes(
            lambda plane, _: plane.astype(np.uint8)
        )
    )
    for name in ("yuv420p", "yuv422p10le", "yuv444p"):
        pictures.append(picture_from_frame(av.VideoFrame.from_ndarray(color, "rgb24").reformat(format=name)))
    for picture in pictures:
        (face,) = follower.follow(picture, None)
        assert distance(face, 250) < 6, picture.encoding
    small = Picture.from_array(np.ascontiguousarray(color[::4, ::4]))
    assert follower.follow(small, None) == ()


def test_a_picture_is_searched_once() -> None:
    """A slider restyles the same picture again and again."""

    class Counting(FaceFinder):
        searches = 0

        def find(self, color: np.ndarray, least: float = 0.05) -> dict[Box, tuple[float, float]]:
            self.searches += 1
            return super().find(color, least)

    finder, picture = Counting(), Picture.from_array(picture_with_face())
    with FaceFollower(finder) as follower:
        assert follower.follow(picture, None) == follower.follow(picture, None)
        assert finder.searches == 1
        follower.follow(Picture.from_array(picture_with_face(None)), None)
    assert finder.searches == 2
