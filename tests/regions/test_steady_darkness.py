"""Drawings of faces in films: noise does not move them, and motion is seen at once."""

from __future__ import annotations

import numpy as np
import pytest
from focus import PLACE

from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.areas import Areas
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.steady_darkness import SteadyDarkness

WINDOW = Box(100, 50, 160, 130)
FORM = np.random.default_rng(1).random((80, 60), np.float32)


def drawn(darkness: np.ndarray, right: int = 0, track: int = 0) -> Features:
    return Features(
        WINDOW.moved(right, 0),
        np.ones_like(darkness),
        np.asarray(darkness, np.float32),
        Areas(*[np.zeros_like(darkness)] * 4),
        Face(track, PLACE),
        1.0,
    )


def test_noise_does_not_move_a_face() -> None:
    noise, steady = np.random.default_rng(2), SteadyDarkness()
    noisy = [FORM + noise.normal(0, 0.08, FORM.shape) for _ in range(12)]
    shown = [steady.follow([drawn(each)])[0].darkness for each in noisy]
    assert np.abs(np.diff(shown[4:], axis=0)).mean() < 0.4 * np.abs(np.diff(noisy[4:], axis=0)).mean()
    assert np.abs(shown[-1] - FORM).mean() < 0.05


def test_motion_is_seen_at_once() -> None:
    """An eye that closes, a face that moves on, and another face."""
    steady, closed = SteadyDarkness(), FORM.copy()
    steady.follow([drawn(FORM)])
    closed[20:30, 10:30] += 0.8
    (shown,) = steady.follow([drawn(closed)])
    assert np.abs(shown.darkness - closed)[22:28, 13:27].max() < 1e-6
    for other in (drawn(1 - FORM, right=3), drawn(FORM / 2, track=1)):
        assert steady.follow([other]) == [other]


@pytest.mark.parametrize("moves", [False, True])
def test_a_window_that_moves_by_a_pixel_keeps_the_face(moves: bool) -> None:
    """Whether the face moves with it or rests."""
    steady, noise = SteadyDarkness(), np.random.default_rng(3).normal(0, 0.08, FORM.shape)
    steady.follow([drawn(FORM)])
    now = FORM if moves else np.roll(FORM, -1, axis=1)
    (shown,) = steady.follow([drawn(now + noise, right=1)])
    assert np.abs(shown.darkness - now)[:, :-1].mean() < 0.5 * np.abs(noise).mean()
