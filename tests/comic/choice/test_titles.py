"""Titles that were burned into a film are found and avoided."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.comic.analyze.features import Survey, extract_features
from vidstyle.comic.analyze.titles import has_title
from vidstyle.comic.select.choose import choose

PLACE = cv2.GaussianBlur(cv2.resize(photograph("coffee"), (640, 360)), (0, 0), 4)


def write(text: str, share: float = 1.0, left: int = 70) -> np.ndarray:
    """A picture with a title that has faded in by a share."""
    titled = cv2.putText(
        PLACE.copy(), text, (left, 190), cv2.FONT_HERSHEY_DUPLEX, 1.0, (255,) * 3, 2, cv2.LINE_AA
    )
    return cv2.addWeighted(titled, share, PLACE, 1 - share, 0)


@pytest.mark.parametrize(("share", "is_found"), [(1.0, True), (0.0, False)])
def test_a_line_of_letters_is_a_title(share: float, is_found: bool) -> None:
    assert (
        has_title(cv2.cvtColor(write("A slightly overweight bunny", share), cv2.COLOR_RGB2GRAY)) == is_found
    )


@pytest.mark.parametrize("name", ["coffee", "chelsea", "rocket", "grass", "brick"])
def test_texture_is_no_title(name: str) -> None:
    picture = photograph(name)
    assert not has_title(picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))


def test_a_frame_without_a_title_is_preferred_in_its_scene() -> None:
    seen = [extract_features(PLACE, number, (360, 640)) for number in range(9)]
    shown = [replace(each, titled=each.time < 7) for each in seen]
    (chosen,) = choose(Survey(shown, [0.0], 9.0), [], 1)
    assert not chosen.titled
    titled = [replace(each, titled=True) for each in seen]
    (same,), (only,) = (choose(Survey(each, [0.0], 9.0), [], 1) for each in (seen, titled))
    assert only.time == same.time < 7
