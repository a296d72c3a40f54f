"""Measures of styles at the size that people see, on crops of the picture.

A blurred picture looks sharp when it is reduced. Crops show what a style does to edges, texture and faces, in
a fraction of the time that the whole picture takes. They are rendered like parts of the picture in a film or
a still: lengths and percentiles are those of the whole picture, and small faces are in focus.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.scene_cuts import SceneCuts
from vidstyle.core.shared_tones import SharedTones
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.explore.composed.kept_parts import parts_favor
from vidstyle.explore.crops.crop_measures import ComparedCrop, FullSizeMetrics, edge_hardness
from vidstyle.explore.measure import MAX_DRAWN_SIDE_PX, gradient_of, luma_of_codes
from vidstyle.media.resize import reduce_picture
from vidstyle.regions.boxes import Box
from vidstyle.regions.features.landmarks import MarkedFaces
from vidstyle.regions.focus import FocusRenderer
from vidstyle.regions.mask_renderer import MaskRenderer
from vidstyle.regions.still_faces import KnownFaces, StillFaces
from vidstyle.style import Style

MAX_SIDE_PX = 1920
"""Longer side of the picture of which crops are measured."""
CROP_WIDTH_PX, CROP_HEIGHT_PX = 480, 360
MARGIN_PX = 24
"""Rendered around a crop, but not measured: wide filters differ near borders."""
CROP_COUNT = 2
"""Crops: the largest face, then the parts with the most edges."""
MIN_FACE_SIDE_PX = 24.0
"""Smaller faces have no features to keep."""
MIN_FACE_HARDNESS = 0.46
"""Hardness of edges below which a face is out of focus, and each of its styles would count as blurred. Of 45
faces that are in focus, on 26 photographs, the softest has 0.47."""
RGB_ENCODING = Encoding(full_range=True, subsampling=(1, 1))


class FullSize:
    """Crops of a picture, H x W x 3 uint8, on which styles are measured.

    Attributes:
        is_large: whether the picture is larger than a crop: gates at full size suit only such pictures.
    """

    def __init__(self, picture: np.ndarray) -> None:
        seen_side = min(picture.shape[:2])
        picture = reduce_picture(picture, MAX_SIDE_PX)
        self.is_large = picture.shape[0] > CROP_HEIGHT_PX and picture.shape[1] > CROP_WIDTH_PX
        self._small = reduce_picture(picture, MAX_DRAWN_SIDE_PX)
        known = StillFaces().find("", lambda: picture)
        faces = comparable_faces(known, picture.shape[0])
        boxes = _crop_boxes(picture, sharp_faces(faces, picture))
        crops = [Crop(picture, box, faces, known.detail, seen_side) for box in boxes]
        self._crops = crops[:1] if crops and crops[0].compared.has_faces else crops

    def measure(self, style: Style) -> FullSizeMetrics:
        """Return the metrics of a style; renders the crops, one after the other.

        The crop with the largest face counts, else the mean of all crops.
        """
        tones = tones_of(style, self._small)
        rows = [crop.compared.measure(crop.render(style, tones)) for crop in self._crops]
        mean = FullSizeMetrics(*np.mean(rows, axis=0).tolist())
        return mean._replace(has_face=rows[0].has_face, parts=parts_favor(style))


class Crop:
    """Part of a picture, rendered with a margin.

    Args:
        picture: the whole picture, H x W x 3 uint8.
        box: the part.
        faces: of the whole picture; those that are out of focus are not compared.
        detail: the level of detail that they need.
        seen_side: see `FrameRequest`.

    Attributes:
        compared: compares its renderings with the source.
    """

    def __init__(
        self,
        picture: np.ndarray,
        box: Box[int],
        faces: MarkedFaces,
        detail: float = 1.0,
        seen_side: float = math.inf,
    ) -> None:
        self._seen_side = seen_side
        height, width = picture.shape[:2]
        left, top = max(box.left - MARGIN_PX, 0), max(box.top - MARGIN_PX, 0)
        right, bottom = min(box.right + MARGIN_PX, width), min(box.bottom + MARGIN_PX, height)
        self._source = np.ascontiguousarray(picture[top:bottom, left:right])
        self._inner = np.s_[box.top - top : box.bottom - top, box.left - left : box.right - left]
        self._side_ratio = min(height, width) / min(self._source.shape[:2])
        seen = {face: marks for face, marks in faces.items() if face.intersection(box).area}
        self._known = KnownFaces(
            {face.moved(-left, -top).scaled(1 / (bottom - top)): marks for face, marks in seen.items()},
            detail,
        )
        inner = [face.moved(-box.left, -box.top) for face in sharp_faces(seen, picture)]
        self.compared = ComparedCrop(self._source[self._inner], inner)

    def render(self, style: Style, tones: SharedTones) -> np.ndarray:
        """Return the crop in a style, without the margin.

        Args:
            tones: the percentiles of the whole picture in this style.
        """
        if style.height:
            style = replace(style, height=style.height / self._side_ratio)
        request = FrameRequest(
            Picture.from_array(self._source),
            target=RGB_ENCODING,
            rgb=True,
            tones=tones,
            seen_side=self._seen_side,
        )
        with MaskRenderer(style, lambda: self._focus(style)) as renderer:
            color = renderer.restyle(request).color
        assert color is not None
        return np.ascontiguousarray(color[self._inner])

    def _focus(self, style: Style) -> FocusRenderer:
        return FocusRenderer(style, _open_renderer, self._known, side_ratio=self._side_ratio)


def tones_of(style: Style, small: np.ndarray) -> SharedTones:
    """Return the percentiles that a style measures on a small copy of the whole picture."""
    tones, style = SharedTones(), replace(style, steady=0.0)
    request = FrameRequest(Picture.from_array(small), target=RGB_ENCODING, rgb=True, measured=tones)
    with tones.measuring(), MaskRenderer(style, lambda: _open_renderer(style, None)) as renderer:
        renderer.restyle(request)
    return tones


def comparable_faces(known: KnownFaces, height: int) -> MarkedFaces:
    """Return the faces that have features to compare in a picture of this height, the largest first."""
    faces = {box.scaled(height): marks for box, marks in known.boxes.items()}
    return {box: marks for box, marks in faces.items() if min(box.width, box.height) >= MIN_FACE_SIDE_PX}


def sharp_faces(faces: MarkedFaces, picture: np.ndarray) -> MarkedFaces:
    """Return the faces that are in focus in a picture, H x W x 3 uint8."""
    luma = luma_of_codes(picture)

    def is_sharp(face: Box[float]) -> bool:
        left, top, right, bottom = map(round, face.intersection(Box(0, 0, luma.shape[1], luma.shape[0])))
        return edge_hardness(luma[top:bottom, left:right]) >= MIN_FACE_HARDNESS

    return {face: marks for face, marks in faces.items() if is_sharp(face)}


def _open_renderer(style: Style, cuts: SceneCuts | None) -> CpuRenderer:
    return CpuRenderer(style, threads=1)


def _crop_boxes(picture: np.ndarray, faces: MarkedFaces) -> list[Box[int]]:
    """Return the crop around the largest face, then those with the most edges, which do not overlap."""
    height, width = picture.shape[:2]
    rows, columns = min(CROP_HEIGHT_PX, height), min(CROP_WIDTH_PX, width)
    edges = gradient_of(cv2.GaussianBlur(luma_of_codes(picture), (0, 0), 3))
    # Away from the borders, where the subject is; the root, so that one strong edge does not decide.
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    weights = np.sqrt(edges) * np.exp(-(x * x + y * y))
    sums = cv2.integral(weights)
    scores = (sums[rows:, columns:] - sums[:-rows, columns:]) - (
        sums[rows:, :-columns] - sums[:-rows, :-columns]
    )
    boxes: list[Box[int]] = []

    def take(top: int, left: int) -> None:
        boxes.append(Box(left, top, left + columns, top + rows))
        scores[max(top - rows, 0) : top + rows, max(left - columns, 0) : left + columns] = -1

    for face in list(faces)[:1]:
        middle_x, middle_y = map(round, face.center)
        top, left = middle_y - rows // 2, middle_x - columns // 2
        take(min(max(top, 0), height - rows), min(max(left, 0), width - columns))
    while len(boxes) < CROP_COUNT and scores.max() >= 0:
        top, left = np.unravel_index(int(scores.argmax()), scores.shape)
        take(int(top), int(left))
    return boxes
