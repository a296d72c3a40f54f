"""Key frames that look alike are shown as wide views and close-ups in turn."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from media import photograph

from vidstyle.comic.analyze.features import Foreground, extract_features
from vidstyle.comic.layout.crop import crop
from vidstyle.comic.select.framing import (
    alternate_framing,
    approach_faces,
    merge_equal,
    remove_repeats,
)
from vidstyle.regions.boxes import Box


def test_similar_key_frames_are_wide_views_and_close_ups_in_turn() -> None:
    """The close-up contains the head, larger than in the wide views; a different picture stays unchanged."""
    astronaut, coffee = (photograph(name) for name in ("astronaut", "coffee"))
    person = replace(
        extract_features(astronaut, 0, astronaut.shape[:2]), faces=(Box(200.0, 90.0, 250.0, 150.0),)
    )
    key_frames = alternate_framing([person, person, person, extract_features(coffee, 3, coffee.shape[:2])])
    assert [each.framing for each in key_frames] == ["wide", "near", "wide", "usual"]
    wide, near = (crop(each, 1.5) for each in key_frames[:2])
    assert near.contains(person.faces[0]) and near.width < 0.8 * wide.width
    assert alternate_framing(key_frames[3:]) == key_frames[3:]


def test_a_large_face_and_scattered_objects_get_no_close_up() -> None:
    picture = photograph("coffee")
    seen = extract_features(picture, 0, picture.shape[:2])
    large = replace(seen, faces=(Box(100.0, 50.0, 300.0, 300.0),))
    across = replace(seen, blobs=(Box(10.0, 150.0, 590.0, 250.0),))
    one = replace(seen, saliency=Box(250.0, 150.0, 350.0, 250.0), blobs=(Box(280.0, 180.0, 320.0, 220.0),))
    for each, framing in ((large, "usual"), (across, "usual"), (one, "near")):
        assert alternate_framing([each, each])[1].framing == framing
    window = crop(alternate_framing([one, one])[1], 1.5)
    assert window.contains(one.blobs[0]) and window.area < 0.6 * np.prod(picture.shape[:2])


def test_after_a_wide_view_of_several_movers_each_close_up_shows_one() -> None:
    """It contains the whole of the largest one, with room for what its mask misses, and not the other."""
    picture = cv2.resize(photograph("rocket")[:400, :600], (1200, 800))
    places = np.zeros((32, 48), bool)
    places[18:26, 6:9] = places[4:8, 40:42] = True
    action = Foreground(places, Box(140.0, 90.0, 1060.0, 660.0), 1.0, 0.0, False)
    square = replace(extract_features(picture, 0, (800, 1200)), action=action, subject=action.box)
    shown = alternate_framing([square] * 3)
    assert [each.framing for each in shown] == ["wide", "near", "near"]
    window, walker, other = crop(shown[1], 1.5), Box(150, 450, 225, 650), Box(1000, 100, 1050, 200)
    assert window.contains(walker.padded(40, 40, 40)) and not window.intersection(other).area


def test_small_movers_get_no_close_up() -> None:
    """They have too few pixels to be drawn large, so that each picture is shown whole."""
    picture = photograph("rocket")[:400, :600]
    places = np.zeros((32, 48), bool)
    places[18:24, 6:9] = True
    action = Foreground(places, Box(70.0, 220.0, 120.0, 330.0), 1.0, 0.0, False)
    street = replace(extract_features(picture, 0, (400, 600)), action=action, subject=action.box)
    assert [each.framing for each in alternate_framing([street] * 3)] == ["wide"] * 3
    assert alternate_framing([street] * 2, enlarges_small=True)[1].framing == "near"


def test_repeats_are_removed() -> None:
    """Except for close-ups and requested frames."""
    astronaut, coffee = (photograph(name) for name in ("astronaut", "coffee"))
    seen, other = (extract_features(each, 0, each.shape[:2]) for each in (astronaut, coffee))
    near, forced = replace(seen, framing="near"), replace(seen, forced=True)
    assert remove_repeats([seen, seen, other, other, seen]) == [seen, other, seen]
    assert remove_repeats([seen, near, seen, forced]) == [seen, near, seen, forced]


def test_a_film_of_one_picture_is_shown_once() -> None:
    """Not if it has a face, other pictures, or more than two key frames."""
    picture = photograph("coffee")
    one = extract_features(picture, 0, picture.shape[:2])
    for shown in ([one], [one, one]):
        assert merge_equal(shown) == [replace(one, framing="wide")]
    compact = replace(one, saliency=Box(100.0, 90.0, 300.0, 280.0))
    assert crop(merge_equal([compact])[0], 1.5).area < 0.5 * np.prod(picture.shape[:2])
    faced = replace(one, faces=(Box(0.0, 0.0, 99.0, 99.0),))
    other = extract_features(photograph("astronaut"), 1, (512, 512))
    for kept in ([faced], [one, other], [one, one, one]):
        assert merge_equal(kept) == kept


def test_a_small_local_change_is_no_repeat() -> None:
    picture = photograph("coffee")
    changed = picture.copy()
    changed[100:160, 100:180] = (255, 0, 0)
    seen, other = (extract_features(each, 0, each.shape[:2]) for each in (picture, changed))
    assert remove_repeats([seen, other, other]) == [seen, other]


def test_small_sharp_faces_are_shown_nearer_except_in_an_establishing_view() -> None:
    picture = photograph("astronaut")
    seen = extract_features(picture, 0, picture.shape[:2])
    sharp = replace(seen, faces=(Box(200.0, 90.0, 250.0, 150.0),), face_detail=20.0)
    soft, large = replace(sharp, face_detail=3.0), replace(sharp, faces=(Box(150.0, 60.0, 300.0, 260.0),))
    framings = [each.framing for each in approach_faces([sharp, sharp, soft, large])]
    assert framings == ["usual", "near", "usual", "usual"]
    assert approach_faces([sharp])[0].framing == "near"
