"""Subjects of frames: faces, speakers, moving objects, damage and letterbox bars."""

from __future__ import annotations

import gc
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from face_network import FACE, red_finder
from media import photograph
from stories import PLACES, shot, view, write_film

from vidstyle.comic.analyze.faces.face_search import add_faces, follow_faces
from vidstyle.comic.analyze.features import Foreground, Survey, add_saliency, extract_features
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.flaws.defects import is_smeared
from vidstyle.comic.analyze.letterbox import content_area
from vidstyle.comic.analyze.moving.action import add_actions, cut_share
from vidstyle.comic.analyze.moving.poses import has_other_pose
from vidstyle.comic.select.choose import choose
from vidstyle.comic.select.key_frames import KeyFrameOptions, find_key_frames
from vidstyle.errors import InputError
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_detection.face_networks import load_networks, weights_folder
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS

CASCADE = "lbpcascade_frontalface_opencv.xml"


def save_cascade(folder: Path) -> Path:
    """Save the cascade that scikit-image ships, with a typo in two of its tags corrected."""
    import skimage

    text = (Path(skimage.__file__).parent / "data" / CASCADE).read_text(encoding="utf-8")
    path = folder / "faces.xml"
    path.write_text(text.replace("featuhre", "feature"), encoding="utf-8")
    return path


def test_faces_are_found_with_a_model(tmp_path: Path) -> None:
    finder = FaceFinder(save_cascade(tmp_path))
    (face,) = finder.find(photograph("astronaut"))
    assert Box(150, 40, 300, 230).contains(face)
    assert not finder.find(photograph("coffee"))
    assert not FaceFinder(save_cascade(tmp_path)).find(np.zeros((90, 160, 3), np.uint8))


def rotate(picture: np.ndarray, angle: float) -> np.ndarray:
    height, width = picture.shape[:2]
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), angle, 1)
    return cv2.warpAffine(picture, turn, (width, height), borderMode=cv2.BORDER_REFLECT)


def test_faces_are_found_without_a_model() -> None:
    """Small, mirrored, rotated, gray and dark faces are found with mouths; other objects give no faces."""
    finder, astronaut = FaceFinder(), photograph("astronaut")
    face, mouth = Box(165, 50, 285, 190), Box(205, 120, 245, 150)
    gray = np.repeat(astronaut.mean(axis=2, keepdims=True), 3, axis=2).astype(np.uint8)
    small = cv2.copyMakeBorder(astronaut, 0, 700, 300, 800, cv2.BORDER_REFLECT)[:600]
    for picture, place, at in (
        (astronaut, face, mouth),
        (np.ascontiguousarray(astronaut[:, ::-1]), face.mirrored(512), mouth.mirrored(512)),
        (rotate(astronaut, 20), face.padded(40, 40, 40), Box(181, 152, 191, 166)),
        (gray, face, mouth),
        ((astronaut * 0.16 + 6).astype(np.uint8), face, mouth),
        (cv2.resize(small, None, fx=0.3, fy=0.3, interpolation=cv2.INTER_AREA), None, None),
    ):
        found = finder.find(picture)
        assert found
        if place and at:
            ((box, marks),) = found.items()
            across, down = marks.mouth(box)
            assert place.contains(box)
            assert at.contains(Box(across, down, across, down))
    for name in ("coffee", "chelsea", "rocket"):
        assert not finder.find(photograph(name))


def test_the_networks_are_read_without_leaving_a_file_open(
    monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder
) -> None:
    ignored: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", ignored.append)
    folder = weights_folder()
    assert folder is not None
    networks = load_networks.__wrapped__(folder)
    gc.collect()
    assert [len(weights) for weights in networks] == [13, 16, 21]
    assert not ignored and not recwarn.list


def test_a_face_is_preferred_during_speech() -> None:
    """Among frames of a shot with the same face, the frame during speech is chosen."""
    astronaut, box = photograph("astronaut"), Box(180.0, 60.0, 270.0, 170.0)
    faces = [replace(extract_features(astronaut, time, (512, 512)), faces=(box,)) for time in (1, 2, 3)]
    survey = Survey(faces, [0.0], 4.0)
    for time in (1, 3):
        assert [each.time for each in choose(survey, [], 1, spoken=[(time - 0.2, time + 0.2)])] == [time]
    mute = Survey([replace(each, faces=()) for each in faces], [0.0], 4.0)
    assert choose(mute, [], 1, spoken=[(2.8, 3.2)])[0].time == choose(mute, [], 1)[0].time


def test_a_large_face_needs_confirmation_by_nearby_frames() -> None:
    """Two nearby frames without the face refute it; one may have missed it."""
    picture, finder = photograph("astronaut"), FaceFinder()
    seen = add_faces(extract_features(picture, 0, picture.shape[:2]), finder)
    none = replace(seen, faces=())
    for others, faces in (([], 1), ([none], 1), ([none, none], 0), ([none, seen], 1)):
        assert len(add_faces(seen, finder, others=others).faces) == faces


def test_a_face_that_is_smeared_away_is_none() -> None:
    """Its detector proposes it, but it does not look like a face any more."""
    picture, box = photograph("astronaut"), Box(182.0, 63.0, 268.0, 173.0)
    smeared = cv2.blur(picture, (60, 1))
    finder = FaceFinder()
    finder.find = lambda *_: {box: USUAL_LANDMARKS}  # type: ignore[method-assign]
    seen, lost = (extract_features(each, 0, picture.shape[:2]) for each in (picture, smeared))
    assert [len(add_faces(each, finder).faces) for each in (seen, lost)] == [1, 0]


def test_a_face_that_one_frame_misses_is_followed() -> None:
    """To its new position. One other frame with the face is not enough, and other pictures have no match."""
    picture = photograph("astronaut")
    shifted = np.roll(picture, (-12, 20), axis=(0, 1))
    frames = [extract_features(each, 0, picture.shape[:2]) for each in (picture, picture, shifted)]
    box, marks = Box(180.0, 60.0, 270.0, 170.0), USUAL_LANDMARKS._replace(nose=(0.4, 0.6))
    one, other = (replace(each, faces=(box,), landmarks={box: marks}) for each in frames[:2])
    ((face, found),) = follow_faces(frames[2], [one, other]).items()
    assert face == pytest.approx(box.moved(20, -12), abs=2) and found == marks
    assert not follow_faces(frames[2], [one, replace(other, faces=())])
    coffee = cv2.resize(photograph("coffee"), (512, 512))
    assert not follow_faces(extract_features(coffee, 0, (512, 512)), [one, other])
    blind = type("Blind", (), {"find": lambda *_: {}})()
    assert add_faces(frames[2], blind, others=[one, other]).faces == (face,)


def test_the_moving_object_in_front_of_a_still_camera_is_its_subject() -> None:
    """Not if the camera moves; a change of light is no subject. A frame without the subject is recognized."""
    wall = cv2.resize(photograph("rocket"), (320, 240)) // 3 + 60
    places = [None, None, 40, 100, 160, 270, None, None, None]
    pictures = []
    for number, left in enumerate(places):
        picture = (wall * (0.9 + 0.02 * number)).astype(np.uint8)
        if left is not None:
            picture[90:170, left : left + 60] = (220, 30, 30)
        pictures.append(picture)
    shot = [extract_features(each, number, (480, 640)) for number, each in enumerate(pictures)]
    actions = [each.action for each in add_actions(shot, shot)]
    assert [each is not None and each.is_gone for each in actions] == [each is None for each in places]
    whole, cut = actions[3], actions[5]
    assert whole and cut and cut.cut > 0.5 > whole.cut == 0
    assert whole.box.contains(Box(200, 180, 320, 340)) and whole.box.width < 200
    moving = add_actions(shot, shot)
    assert has_other_pose(moving[3], moving[5]) and not has_other_pose(moving[3], moving[3])
    seen = add_saliency(add_actions(shot, shot)[3])
    assert seen.saliency.width < 220
    chosen = choose(Survey(add_actions(shot, shot), [0.0], 9.0), [], 4)
    assert sorted(each.time for each in chosen) == [2, 3, 4]  # neither gone nor cut off
    panned = [
        extract_features(np.roll(photograph("coffee"), 40 * each, axis=1), each, (400, 600))
        for each in range(6)
    ]
    assert all(each.action is None for each in add_actions(panned, panned))


def test_who_stays_most_of_the_time_is_found_though_the_exposure_changes() -> None:
    """The median of such a shot is no background, and the lightness of a picture is not the exposure."""
    place = cv2.resize(photograph("coffee"), (320, 180))
    frames = []
    for number in range(20):
        frame = place.copy()
        if number % 10 >= 4:  # somebody else each time, at one place
            color = (20, 20, 20) if number < 10 else (110, 20, 20)
            cv2.rectangle(frame, (120, 30), (180, 170), color, -1)
        frames.append(np.clip(frame * (0.8 + 0.02 * number), 0, 255).astype(np.uint8))
    shot = [extract_features(each, number, (180, 320)) for number, each in enumerate(frames)]
    for number, each in enumerate(add_actions(shot, shot)):
        assert each.action
        assert each.action.is_gone == (number % 10 < 4)
        if not each.action.is_gone:
            assert each.action.box.contains(Box(125, 35, 175, 165)) and each.action.box.width < 110


def test_a_subject_does_not_grow_by_the_ground() -> None:
    picture = np.full((180, 320, 3), 90, np.uint8)
    cv2.rectangle(picture, (0, 112), (319, 126), (20, 190, 30), -1)
    seen = extract_features(picture, 0, (180, 320))
    action = Foreground(np.zeros((32, 48), bool), Box(145.0, 50.0, 175.0, 120.0), 1.0, 0.0, False)
    found = add_saliency(replace(seen, action=action)).subject
    assert found and found.width < 60


def test_a_damaged_picture_is_no_subject() -> None:
    """Fewer than a fifth of the pictures differ, as where a cluster of a film is damaged."""
    wall = cv2.resize(photograph("rocket"), (320, 240)) // 3 + 60
    damaged = wall.copy()
    damaged[60:180, 80:240] = 255 - damaged[60:180, 80:240]
    shot = [extract_features(damaged if each == 3 else wall, each, (480, 640)) for each in range(9)]
    assert all(each.action is None for each in add_actions(shot, shot))


def test_smeared_pictures_are_damaged() -> None:
    """Below its middle a picture repeats one of its rows, as decoders do; a plain wall is not smeared."""
    for name in ("coffee", "astronaut", "rocket"):
        luma = photograph(name).mean(axis=2).astype(np.uint8)
        assert not is_smeared(luma)
        luma[200:] = luma[200]
        assert is_smeared(luma)
    assert not is_smeared(np.full((360, 640), 90, np.uint8))
    damaged = replace(extract_features(photograph("coffee"), 0, (400, 600)), damaged=True)
    good = replace(damaged, time=1.0, damaged=False, clarity=0.1)
    assert choose(Survey([damaged, good], [0.0], 2.0), [], 1) == [good]
    assert choose(Survey([damaged], [0.0], 2.0), [], 1) == [damaged]


def test_faces_are_found_with_a_network(tmp_path: Path) -> None:
    """A model in the format of YuNet finds faces at the position and with the colours of the picture."""
    (tmp_path / "faces.onnx").write_bytes(red_finder())
    finder = FaceFinder(tmp_path / "faces.onnx")
    for middle, size in (((240, 208), (640, 360)), ((80, 336), (200, 400))):
        for color, found in (((230, 20, 20), True), ((20, 20, 230), False)):
            picture = np.full((size[1], size[0], 3), 90, np.uint8)
            faces = finder.find(cv2.circle(picture, middle, 48, color, -1))
            assert len(faces) == found
            half = FACE / 2
            for face in faces:
                ends = middle[0] - half, middle[1] - half, middle[0] + half, middle[1] + half
                assert (face.left, face.top, face.right, face.bottom) == pytest.approx(ends, abs=1)


@pytest.mark.parametrize("name", ["no.xml", "no.onnx", "other.onnx"])
def test_files_that_are_no_face_models_are_refused(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Text, and a network with other outputs; nothing else is printed."""
    other = red_finder().replace(b"bbox_16", b"text_16")
    (tmp_path / name).write_bytes(other if name == "other.onnx" else b"no model")
    remedy = r"use an OpenCV cascade \(.xml\) or a YuNet model \(.onnx\)$"
    with pytest.raises(InputError, match=f"{name} is not a face detection model; {remedy}"):
        FaceFinder(tmp_path / name)
    assert capfd.readouterr().err == ""


def test_a_missing_model_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: No such file"):
        FaceFinder(tmp_path / "none.xml")


def test_a_face_scores_high(tmp_path: Path) -> None:
    """Of two shots of equal length, the one with a face is chosen for a single panel."""
    crop = cv2.resize(photograph("astronaut")[:288], (256, 144), interpolation=cv2.INTER_AREA)
    frames = [view(PLACES[2])] * 25 + [crop] * 25
    path = write_film(tmp_path / "film.mp4", frames)
    (key_frame,) = find_key_frames(
        open_film(path, FaceFinder(save_cascade(tmp_path))), KeyFrameOptions(panels=1)
    )
    assert key_frame.scene == 1
    assert len(key_frame.faces) == 1
    assert key_frame.saliency.intersection(key_frame.faces[0]).area > 0.9 * key_frame.faces[0].area


def test_letterbox_bars_are_removed(tmp_path: Path) -> None:
    """Horizontal and vertical bars, thin ones included; a night sky and a dark floor are not bars."""
    for name, size in (("wide", (256, 104)), ("upright", (120, 144))):
        frames = [cv2.resize(frame, size) for frame in shot(PLACES[2], 30)]
        down, across = (144 - size[1]) // 2, (256 - size[0]) // 2
        barred = [
            cv2.copyMakeBorder(each, down, down, across, across, cv2.BORDER_CONSTANT) for each in frames
        ]
        path = write_film(tmp_path / f"{name}.mp4", barred)
        (key_frame,) = find_key_frames(open_film(path), KeyFrameOptions(panels=1))
        assert key_frame.shape == pytest.approx((size[1], size[0]), abs=4)
        (frame,) = open_film(path).frames_at([key_frame.time])
        picture = key_frame.picture(frame)
        assert picture.shape[:2] == key_frame.shape
        assert min(picture.max(axis=2).mean(axis=0).min(), picture.max(axis=2).mean(axis=1).min()) > 30
        assert Box(0, 0, *reversed(key_frame.shape)).contains(key_frame.saliency)
    night = view(PLACES[0])
    night[:40] = 0
    assert content_area(night) == (slice(0, 144), slice(0, 256))
    assert content_area(np.zeros_like(night)) == (slice(0, 144), slice(0, 256))
    thin = view(PLACES[0])
    thin[:2] = thin[-2:] = 0
    assert content_area(thin) == (slice(3, 141), slice(0, 256))
    assert content_area(night, is_photograph=True) == (slice(41, 144), slice(0, 256))
    rim = view(PLACES[0])
    rim[:, :2] //= 4
    assert content_area(rim) == (slice(0, 144), slice(3, 256))
    object_at_edge = view(PLACES[0])
    object_at_edge[:2, :160] //= 4
    assert content_area(object_at_edge) == (slice(0, 144), slice(0, 256))


def test_an_edge_that_takes_the_head_counts_more() -> None:
    person = np.zeros((32, 48), bool)
    person[0:18, 20:24] = True
    upside_down = person[::-1]
    assert cut_share(person) == pytest.approx(2 * cut_share(upside_down))
    assert cut_share(np.roll(person, 5, axis=0)) == 0
