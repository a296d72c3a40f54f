"""Tracking of faces in a film: detected about once per second, tracked in between, faded in and out."""

from __future__ import annotations

import math
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import count

import cv2
import numpy as np

from vidstyle.core.closing import Closing
from vidstyle.core.picture import SITINGS, Picture
from vidstyle.core.planes import color_rows
from vidstyle.core.scene_cuts import SceneCutDetector, SceneCuts
from vidstyle.regions.automatic_detail import MIN_CROWD_DETAIL, face_detail
from vidstyle.regions.boxes import Box, Point, Rectangle
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS, Landmarks, MarkedFaces
from vidstyle.stabilize.motion import reduced_luma

MIN_PICTURE_SIDE_PX = 144
"""Minimum shorter side for the detection of faces: in smaller pictures, faces have too few pixels."""
MIN_FACE_RATIO = 0.05
"""Minimum height of a face, relative to the picture's shorter side: 54 of 1080 lines."""
MIN_CROWD_FACE_RATIO, MAX_CROWD_PROPOSALS = 0.0185, 400
"""The same in a crowd: 20 of 1080 lines; and how many parts of the picture are examined there."""
MAX_SEARCHED_SIDE_PX = 720
"""Maximum shorter side of the copy in which faces are detected."""
SEARCH_SECONDS = 1.2
"""Interval of searches in a scene."""
DELAY_SECONDS = 0.2
"""Delay after which the result of a search is used, so that no frame waits for it."""
MAX_GAP_SECONDS = 1.0
"""Longest gap between frames; after a longer one, a film is searched again, as after a scene cut."""
MAX_MISSES = 2
"""Maximum number of consecutive searches that miss a face before it fades out."""
FADE_SECONDS = 0.4
"""Time in which a face fades in or out within a scene."""

_FOLLOW_RANGE_RATIO = 0.4
"""Maximum motion of a face between two frames, relative to its height."""
_MIN_TEMPLATE_HEIGHT_PX = 32
"""Height of the copies in which larger faces are followed, at least."""
_MIN_FOLLOW_CORRELATION = 0.5
"""Minimum correlation of a face with its picture at the last search, 0..1; below it, the face is lost."""
_FAST_RATIO = 0.06
"""Motion from which a face is tracked without smoothing, relative to its height."""
_MIN_FOLLOW_WEIGHT = 0.25
"""Weight of the smallest motion."""
_SIZE_WEIGHT = 0.5
"""Weight of the size from a new search."""


@dataclass(frozen=True)
class Face:
    """A face in a frame.

    Attributes:
        track: number of the face, the same in all frames until it is lost.
        box: in pixels of the frame.
        opacity: 0..1, below 1 while the face fades in or out.
        landmarks: its eyes, nose and mouth.
    """

    track: int
    box: Box[float]
    opacity: float = 1.0
    landmarks: Landmarks = USUAL_LANDMARKS


class _Template:
    """The picture of a face at the last search, cropped from a small copy; of a large face, reduced.

    Args:
        small: the copy, H x W uint8.
        box: the face in it.
    """

    def __init__(self, small: np.ndarray, box: Box[float]) -> None:
        place, self._factor = _inside(small, box), max(1, int(box.height / _MIN_TEMPLATE_HEIGHT_PX))
        self._pixels = self._cropped(small, place)
        self._offset = box.left - place.left, box.top - place.top

    def shift(self, small: np.ndarray, box: Box[float]) -> Point | None:
        """Return the motion of the face from `box` to the right and down; None if it is lost."""
        reach = _FOLLOW_RANGE_RATIO * box.height
        around = _inside(small, box.padded(reach, reach, reach))
        seen = self._cropped(small, around)
        if not self._pixels.size or any(np.less(seen.shape, self._pixels.shape)):
            return None
        likeness = cv2.matchTemplate(seen, self._pixels, cv2.TM_CCOEFF_NORMED)
        _, best, _, (column, row) = cv2.minMaxLoc(likeness)
        if best < _MIN_FOLLOW_CORRELATION:
            return None
        right, down = _peak(likeness[row], column), _peak(likeness[:, column], row)
        return (
            around.left + self._factor * right + self._offset[0] - box.left,
            around.top + self._factor * down + self._offset[1] - box.top,
        )

    def _cropped(self, small: np.ndarray, place: Rectangle) -> np.ndarray:
        pixels = small[place.top : place.bottom, place.left : place.right]
        height, width = (side // self._factor for side in pixels.shape)
        if self._factor == 1 or not height * width:
            return pixels
        whole = pixels[: height * self._factor, : width * self._factor]
        return cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)


_Seen = tuple[Box[float], Landmarks, _Template]
"""A face that has been found."""


@dataclass
class _Track:
    """A tracked face."""

    number: int
    box: Box[float]
    landmarks: Landmarks
    opacity: float
    template: _Template
    misses: int = 0
    is_lost: bool = False


@dataclass(frozen=True)
class _Search:
    """A search for faces in another thread.

    Attributes:
        time: presentation time of the frame.
        small: a small copy of the frame.
        found: faces in pixels of the frame.
    """

    time: float
    small: np.ndarray
    found: Future[MarkedFaces]


@dataclass(frozen=True)
class FacelessStart:
    """Frames before a time, in which no face is tracked.

    Attributes:
        end: the time, in seconds.
        search_time: time of the last search before it.
        detail: see `FaceFollower`.
    """

    end: float
    search_time: float
    detail: float = 1.0


class FaceFollower(Closing):
    """Returns the faces of one frame after another. Close it to end its thread.

    A scene cut, a gap and a size change reset the tracking; then faces have full opacity at once. The results
    do not depend on the speed of the searches.

    Attributes:
        detail: level of detail that the faces of a picture, or of the scene's first frame, need; see
            `automatic_detail`.
    """

    def __init__(
        self, finder: FaceFinder, cuts: SceneCuts | None = None, faceless: FacelessStart | None = None
    ) -> None:
        """Start without faces.

        Args:
            cuts: scene cuts of the film; None: they are detected.
            faceless: frames that are not searched, because an earlier run has tracked no face in them.
        """
        self._finder, self._faceless = finder, faceless
        self._cuts = cuts or SceneCutDetector()
        self._numbers = count()
        self._tracks: list[_Track] = []
        self._shape: tuple[int, int] | None = None
        self._time = self._search_time = math.nan
        self._thread = ThreadPoolExecutor(1, "vidstyle-faces")
        self._search: _Search | None = None
        self._still: tuple[object, float, tuple[Face, ...]] = (None, 1.0, ())
        self.detail = 1.0

    @property
    def idle_since(self) -> float | None:
        """Time of the last search, if no face is tracked and no search is running; otherwise None."""
        return None if self._tracks or self._search is not None else self._search_time

    def close(self) -> None:
        """Wait for the last search, and end the thread."""
        self._thread.shutdown()

    def follow(self, picture: Picture, time: float | None) -> tuple[Face, ...]:
        """Return the faces of the next frame, the largest first.

        Args:
            picture: the frame.
            time: presentation time in seconds; None for a single picture.
        """
        if min(picture.shape) < MIN_PICTURE_SIDE_PX:
            self._shape, self._tracks, self.detail = picture.shape, [], 1.0
            return ()
        if time is None:
            return self._faces_of_still(picture)
        if self._faceless is not None and time < self._faceless.end:
            self._shape, self._search_time = picture.shape, self._faceless.search_time
            self.detail = self._faceless.detail
        elif self._starts(picture, time):
            self._start(picture, time)
        else:
            self._continue(picture, time)
            self._fade(time - self._time)
        self._time = time
        tracks = sorted(self._tracks, key=lambda track: -track.box.area)
        faces = (Face(each.number, each.box, each.opacity, each.landmarks) for each in tracks)
        return tuple(face for face in faces if face.opacity > 0)

    def _faces_of_still(self, picture: Picture) -> tuple[Face, ...]:
        """Return the faces of a single picture; the same picture is not searched again."""
        plane = picture.color if picture.luma is None else picture.luma
        if self._still[0] is not plane:
            found = find_boxes(self._finder, picture, searches_crowds=True)
            faces = (Face(next(self._numbers), box, 1.0, marks) for box, marks in found.items())
            self._still = plane, face_detail(found, min(picture.shape)), tuple(faces)
        self._shape = None  # the next frame of a film begins a scene
        _, self.detail, found_before = self._still
        return found_before

    def _starts(self, picture: Picture, time: float) -> bool:
        """Whether there is no state of earlier frames."""
        is_cut, elapsed = self._cuts.begins_scene(picture, time), time - self._time
        before, self._shape = self._shape, picture.shape
        return is_cut or before != picture.shape or not 0 <= elapsed <= MAX_GAP_SECONDS

    def _start(self, picture: Picture, time: float) -> None:
        """Detect the faces in the first frame of a scene."""
        self._tracks, self._search, self._search_time = [], None, time
        found = find_boxes(self._finder, picture)
        self.detail = face_detail(found, min(picture.shape))
        if found:
            small = reduced_luma(picture)
            factor = picture.shape[1] / small.shape[1]
            seen = ((box, marks, _Template(small, box.scaled(1 / factor))) for box, marks in found.items())
            self._match(seen, opacity=1.0)

    def _continue(self, picture: Picture, time: float) -> None:
        """Move tracks to their positions in the next frame, and start searches at intervals."""
        search, is_due = self._search, time - self._search_time >= SEARCH_SECONDS
        is_found = search is not None and time - search.time >= DELAY_SECONDS
        if not (self._tracks or is_found or is_due):
            return
        small = reduced_luma(picture)
        factor = picture.shape[1] / small.shape[1]
        for track in self._tracks:
            _move(track, small, factor)
        if search is not None and is_found:
            self._search = None
            self._match(_moved(search, small, factor), opacity=0.0)
        if is_due:
            self._search_time = time
            self._search = _Search(time, small, self._thread.submit(find_boxes, self._finder, picture))

    def _match(self, found: Iterable[_Seen], opacity: float) -> None:
        """Continue the tracks of detected faces; start tracks with this opacity for new faces."""
        left = {box: (marks, template) for box, marks, template in found}
        for track in self._tracks:
            near = min(left, key=lambda box: _distance(track.box, box), default=None)
            if near is None or _distance(track.box, near) > 1:
                track.misses += 1
                continue
            (marks, track.template), track.misses, track.is_lost = left.pop(near), 0, False
            track.box, track.landmarks = _approach(track.box, near), _between(track.landmarks, marks)
        self._tracks += [
            _Track(next(self._numbers), box, marks, opacity, template)
            for box, (marks, template) in left.items()
        ]

    def _fade(self, elapsed: float) -> None:
        """Update the opacity of all tracks; remove tracks that have faded out."""
        for track in self._tracks:
            leaves = track.is_lost or track.misses >= MAX_MISSES
            change = elapsed / FADE_SECONDS
            track.opacity = min(1.0, max(0.0, track.opacity + (-change if leaves else change)))
        self._tracks = [each for each in self._tracks if each.opacity > 0]


def find_boxes(finder: FaceFinder, picture: Picture, searches_crowds: bool = False) -> MarkedFaces:
    """Return the faces of at least `MIN_FACE_RATIO` in a picture, in its pixels, the largest first.

    Args:
        finder: detects faces.
        picture: any picture.
        searches_crowds: whether to search for smaller faces too where many are small, which takes seconds.
    """
    color = searched_copy(picture)
    side = min(color.shape[:2])
    found = finder.find(color, MIN_FACE_RATIO * side / color.shape[0])
    if searches_crowds and face_detail(found, side) >= MIN_CROWD_DETAIL:
        found = finder.find(color, MIN_CROWD_FACE_RATIO * side / color.shape[0], MAX_CROWD_PROPOSALS)
    factor = picture.shape[1] / color.shape[1]
    return {box.scaled(factor): marks for box, marks in found.items()}


def _move(track: _Track, small: np.ndarray, factor: float) -> None:
    """Move a track to the position of its face in a small copy; `factor`: pixels of the frame per pixel."""
    shift = track.template.shift(small, track.box.scaled(1 / factor))
    track.is_lost = shift is None
    if shift is not None:
        distance = math.hypot(*shift) * factor / (_FAST_RATIO * track.box.height)
        weight = factor * min(1.0, max(_MIN_FOLLOW_WEIGHT, distance))
        track.box = track.box.moved(weight * shift[0], weight * shift[1])


def _moved(search: _Search, small: np.ndarray, factor: float) -> Iterable[_Seen]:
    """Yield the faces that a search has found, at their positions in a later frame."""
    for box, marks in search.found.result().items():
        before = box.scaled(1 / factor)
        template = _Template(search.small, before)
        shift = template.shift(small, before)
        if shift is not None:
            yield before.moved(*shift).scaled(factor), marks, template


def searched_copy(picture: Picture, max_side: int = MAX_SEARCHED_SIDE_PX) -> np.ndarray:
    """Return a picture as H x W x 3 uint8, of at most `max_side` pixels on its shorter side."""
    scale = min(1.0, max_side / min(picture.shape))
    height, width = (max(1, round(side * scale)) for side in picture.shape)

    def reduced(plane: np.ndarray, kind: str) -> np.ndarray:
        return cv2.resize(plane, (width, height), interpolation=cv2.INTER_AREA)

    small = Picture(picture.encoding, picture.luma, picture.chroma, picture.color)
    small = small.map_planes(reduced, replace(picture.encoding, subsampling=(1, 1), siting=SITINGS["center"]))
    return cv2.convertScaleAbs(np.clip(color_rows(small, 0, height), 0, 1), alpha=255)


def _distance(one: Box[float], other: Box[float]) -> float:
    """Return the distance of two faces relative to their size; above 1, they are different faces."""
    (x, y), (other_x, other_y) = one.center, other.center
    reach = (one.height + other.height) / 4
    size = abs(math.log(max(one.height, 1) / max(other.height, 1))) / math.log(2)
    return max(math.hypot(x - other_x, y - other_y) / reach, size)


def _approach(box: Box[float], found: Box[float]) -> Box[float]:
    """Interpolate between the box of a tracked face and its box in a new search."""
    return Box(*(now + _SIZE_WEIGHT * (then - now) for now, then in zip(box, found, strict=True)))


def _between(marks: Landmarks, found: Landmarks) -> Landmarks:
    """Interpolate between landmarks of a tracked face and of a new search, as `_approach`."""
    return Landmarks(
        *(
            (x + _SIZE_WEIGHT * (then_x - x), y + _SIZE_WEIGHT * (then_y - y))
            for (x, y), (then_x, then_y) in zip(marks, found, strict=True)
        )
    )


def _peak(line: np.ndarray, place: int) -> float:
    """Return the position of a maximum between samples, by a parabola through its neighbours."""
    if not 0 < place < len(line) - 1:
        return float(place)
    left, middle, right = (float(each) for each in line[place - 1 : place + 2])
    bend = left - 2 * middle + right
    return place + ((left - right) / (2 * bend) if bend < 0 else 0.0)


def _inside(small: np.ndarray, box: Box[float]) -> Box[int]:
    height, width = small.shape
    return Box(*map(round, box)).intersection(Box(0, 0, width, height))
