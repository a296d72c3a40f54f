"""A short generated film with sound, for the demo, benchmarks and tests.

Morning over hills; two balls with faces bounce. It has smooth gradients, fine texture, shading, hard edges,
faces and letters; a drum beats when a ball touches the ground.
"""

from __future__ import annotations

import colorsys
import math
from typing import NamedTuple

import cv2
import numpy as np

FILM_WIDTH_PX, FILM_HEIGHT_PX = 640, 360
FILM_RATE, FILM_SECONDS = 25, 4
SAMPLE_RATE = 48000

_OVERSAMPLING_FACTOR = 2  # pictures are drawn larger and reduced, for smooth edges
_BEAT_SECONDS = 0.5  # time between two bounces
Point = tuple[float, float]
Rgb = tuple[float, float, float]
"""Red, green and blue, 0..1."""


class Ball(NamedTuple):
    """A bouncing ball: start as a share of the width, delay in seconds, radius in pixels, and hue."""

    start: float
    delay: float
    radius: float
    hue: float


_BALLS = (Ball(0.10, 0.0, 46, 0.02), Ball(0.62, 0.25, 34, 0.56))

_MELODY_SEMITONES = (0, 4, 7, 12, 9, 7, 4, 2, 0, 4, 9, 12, 14, 12, 7, 0)
"""Semitones above C, four notes per second."""


def film_picture(time: float) -> np.ndarray:
    """Draw the picture at a time in seconds: FILM_HEIGHT_PX x FILM_WIDTH_PX x 3 RGB, uint8."""
    canvas = _sky(time)
    _draw_sun(canvas, time)
    for depth in range(3):
        _draw_hills(canvas, time, depth)
    _draw_grass(canvas, time)
    for ball in _BALLS:
        _draw_ball(canvas, time, ball)
    _draw_title(canvas, time)
    return cv2.resize(canvas, (FILM_WIDTH_PX, FILM_HEIGHT_PX), interpolation=cv2.INTER_AREA)


def film_sound() -> np.ndarray:
    """Return the music of the whole film: mono float32, -1..1, at `SAMPLE_RATE`."""
    sound = np.zeros(FILM_SECONDS * SAMPLE_RATE)
    for number, semitones in enumerate(_MELODY_SEMITONES):
        _add(sound, number * _BEAT_SECONDS / 2, _plucked(261.63 * 2 ** (semitones / 12)) * 0.25)
        if number % 4 == 0:
            _add(sound, number * _BEAT_SECONDS / 2, _plucked(130.81 * 2 ** (semitones % 12 / 12)) * 0.3)
    for _, delay, radius, _ in _BALLS:
        for touch in np.arange(delay, FILM_SECONDS, _BEAT_SECONDS):
            _add(sound, touch, _thump(4000 / radius) * 0.3)
    sound *= 0.8 / np.abs(sound).max()
    return sound.astype(np.float32)


def _sky(time: float) -> np.ndarray:
    """Draw a sky that is blue at the top, warm at the horizon, and brightens at sunrise."""
    height, width = FILM_HEIGHT_PX * _OVERSAMPLING_FACTOR, FILM_WIDTH_PX * _OVERSAMPLING_FACTOR
    down = np.minimum(np.linspace(0, 1.7, height, dtype=np.float32), 1)[:, None, None]
    morning = time / FILM_SECONDS
    top = np.array([0.10 + 0.15 * morning, 0.22 + 0.25 * morning, 0.52 + 0.25 * morning], np.float32)
    horizon = np.array([0.98, 0.62 + 0.2 * morning, 0.38 + 0.3 * morning], np.float32)
    rows = (255 * (top + (horizon - top) * down**1.3)).astype(np.uint8)
    return np.ascontiguousarray(np.broadcast_to(rows, (height, width, 3)))


def _draw_sun(canvas: np.ndarray, time: float) -> None:
    center, reach = (
        (460 * _OVERSAMPLING_FACTOR, round((190 - 22 * time) * _OVERSAMPLING_FACTOR)),
        90 * _OVERSAMPLING_FACTOR,
    )
    for number in range(12):
        angle = (number / 12 + time / 40) * 2 * math.pi
        turns = angle - 0.07, angle + 0.07
        ray = [(center[0] + reach * math.cos(turn), center[1] + reach * math.sin(turn)) for turn in turns]
        _fill(canvas, [center, *ray], (1.0, 0.86, 0.5))
    for radius, color in ((52, (1.0, 0.8, 0.35)), (44, (1.0, 0.9, 0.55)), (34, (1.0, 0.97, 0.8))):
        _ellipse(canvas, center, (radius * _OVERSAMPLING_FACTOR, radius * _OVERSAMPLING_FACTOR), color)


def _hill_line(time: float, depth: int) -> np.ndarray:
    """Return the y coordinate of the hills at each column, in pixels; nearer hills move faster."""
    across = np.arange(FILM_WIDTH_PX * _OVERSAMPLING_FACTOR) / _OVERSAMPLING_FACTOR + time * 12 * (depth + 1)
    waves: np.ndarray = 22 * np.sin(across / (70 + 20 * depth) + depth * 2) + 9 * np.sin(across / 29 + depth)
    waves *= 1 - depth / 4
    return (waves + 190 + 50 * depth) * _OVERSAMPLING_FACTOR


def _draw_hills(canvas: np.ndarray, time: float, depth: int) -> None:
    line = _hill_line(time, depth)
    points = np.column_stack([np.arange(len(line)), line])
    corners = [(len(line), canvas.shape[0]), (0, canvas.shape[0])]
    color = ((0.45, 0.52, 0.62), (0.25, 0.50, 0.42), (0.20, 0.48, 0.20))[depth]
    _fill(canvas, [*points, *corners], color)


def _draw_grass(canvas: np.ndarray, time: float) -> None:
    """Draw blades of grass that move with the ground and bend in the wind."""
    line = _hill_line(time, 2)
    random = np.random.default_rng(7)
    width = canvas.shape[1]
    for start, depth, length, shade in random.random((900, 4)):
        x = (start * width * 1.5 - time * 36 * _OVERSAMPLING_FACTOR) % (width * 1.5)
        if x >= width:
            continue
        y = line[int(x)] + depth**1.5 * (canvas.shape[0] - line[int(x)])
        lean = 4 * math.sin(time * 2 + x / 90) * _OVERSAMPLING_FACTOR
        tip = round(x + lean), round(y - (6 + 14 * length * (0.4 + depth)) * _OVERSAMPLING_FACTOR)
        color = (0.12 + 0.35 * shade, 0.40 + 0.40 * shade, 0.10 + 0.1 * shade)
        cv2.line(canvas, (round(x), round(y)), tip, _levels(color), 2, cv2.LINE_AA)


def _draw_ball(canvas: np.ndarray, time: float, ball: Ball) -> None:
    start, delay, radius, hue = ball
    phase = (time - delay) / _BEAT_SECONDS % 1
    jump = 4 * phase * (1 - phase)  # a parabola: 0 on the ground, 1 at the top
    squash = 1 - 0.16 * max(0.0, 1 - jump * 6)
    x = (start + time / FILM_SECONDS * 0.30) * FILM_WIDTH_PX * _OVERSAMPLING_FACTOR
    ground = 318 * _OVERSAMPLING_FACTOR
    wide, tall = radius * _OVERSAMPLING_FACTOR / squash, radius * _OVERSAMPLING_FACTOR * squash
    y = ground - tall - jump * 120 * _OVERSAMPLING_FACTOR
    _ellipse(canvas, (x, ground), (wide * (1 - 0.5 * jump), wide * 0.18), (0.09, 0.25, 0.10))
    _shade_ball(canvas, (x, y), (wide, tall), hue)
    _draw_face(canvas, (x, y), (wide, tall), smile=0.4 + 0.6 * jump)


def _shade_ball(canvas: np.ndarray, center: Point, radii: Point, hue: float) -> None:
    """Draw a sphere lit from the upper right, with a highlight."""
    (x, y), (wide, tall) = center, radii
    for step in np.linspace(0, 1, 14):
        color = colorsys.hls_to_rgb((hue + 0.05 * step) % 1, 0.30 + 0.38 * step, 0.85)
        at = x + 0.28 * step * wide, y - 0.28 * step * tall
        _ellipse(canvas, at, (wide * (1 - 0.75 * step), tall * (1 - 0.75 * step)), color)
    _ellipse(canvas, (x + 0.38 * wide, y - 0.48 * tall), (wide / 7, tall / 9), (1, 1, 1), angle=-40)


def _draw_face(canvas: np.ndarray, center: Point, radii: Point, smile: float) -> None:
    (x, y), (wide, tall) = center, radii
    for side in (-1, 1):
        eye = x + side * 0.32 * wide, y - 0.12 * tall
        _ellipse(canvas, eye, (wide * 0.17, tall * 0.24), (1, 1, 1))
        pupil = eye[0] + 0.05 * wide, eye[1] + 0.03 * tall
        _ellipse(canvas, pupil, (wide * 0.08, tall * 0.13), (0.05, 0.05, 0.1))
    mouth = x, y + 0.25 * tall
    _ellipse(canvas, mouth, (wide * 0.38, tall * 0.35 * smile), (0.35, 0.05, 0.08), arc=180)


def _draw_title(canvas: np.ndarray, time: float) -> None:
    """Draw the title in letters that bob one after another."""
    font, size = cv2.FONT_HERSHEY_DUPLEX, 1.5 * _OVERSAMPLING_FACTOR
    x = 40 * _OVERSAMPLING_FACTOR
    for number, letter in enumerate("vidstyle"):
        y = round((64 + 6 * math.sin(time * math.pi * 2 - number * 0.7)) * _OVERSAMPLING_FACTOR)
        for shift, color in ((3, (0.08, 0.10, 0.25)), (0, (1.0, 0.96, 0.85))):
            at = x + shift * _OVERSAMPLING_FACTOR, y + shift * _OVERSAMPLING_FACTOR
            cv2.putText(canvas, letter, at, font, size, _levels(color), 4, cv2.LINE_AA)
        x += cv2.getTextSize(letter, font, size, 4)[0][0]


def _ellipse(
    canvas: np.ndarray, center: Point, radii: Point, color: Rgb, angle: float = 0, arc: float = 360
) -> None:
    at, size = (round(center[0]), round(center[1])), (round(radii[0]), round(radii[1]))
    cv2.ellipse(canvas, at, size, angle, 0, arc, _levels(color), -1, cv2.LINE_AA)


def _fill(canvas: np.ndarray, points: list[Point], color: Rgb) -> None:
    cv2.fillPoly(canvas, [np.round(np.array(points)).astype(np.int32)], _levels(color), cv2.LINE_AA)


def _levels(color: Rgb) -> list[float]:
    return [255 * value for value in color]


def _add(sound: np.ndarray, start: float, note: np.ndarray) -> None:
    first = round(start * SAMPLE_RATE)
    note = note[: len(sound) - first]
    sound[first : first + len(note)] += note


def _plucked(frequency: float) -> np.ndarray:
    """Return a plucked string: higher overtones decay faster."""
    time = np.arange(SAMPLE_RATE) / SAMPLE_RATE
    order = np.arange(1, 6)[:, None]
    tones = np.sin(2 * np.pi * frequency * order * time) * np.exp(-(3 + order) * time) / order
    return np.asarray(tones.sum(axis=0) * np.minimum(1, time * 400))


def _thump(frequency: float) -> np.ndarray:
    """Return a bounce: a low, falling tone with a fast decay."""
    time = np.arange(SAMPLE_RATE // 4) / SAMPLE_RATE
    return np.asarray(np.sin(2 * np.pi * frequency * (time - time**2)) * np.exp(-25 * time))
