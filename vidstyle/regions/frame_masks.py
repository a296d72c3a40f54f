"""The masks that a style reads, for one frame after another."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import cv2
import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.block.gray_png import read_gray_png
from vidstyle.core.closing import Closing
from vidstyle.core.picture import Picture
from vidstyle.core.planes import luma_rows
from vidstyle.core.scene_cuts import SceneCutDetector, SceneCuts
from vidstyle.errors import StyleError, UsageError
from vidstyle.regions.backdrop import Backdrop
from vidstyle.regions.boxes import Box
from vidstyle.regions.chosen_files import backdrop_file
from vidstyle.regions.face_tracks import FaceFollower, searched_copy
from vidstyle.regions.faces import FaceFinder, skin_map
from vidstyle.regions.mask_edges import refine
from vidstyle.regions.masks import color_mask, head_mask
from vidstyle.regions.people import open_people_network
from vidstyle.regions.steady_mask import SteadyMask
from vidstyle.style import Style
from vidstyle.style.mask_declarations import BACKGROUND, MASK_VALUES, MAX_MASK_BYTES, MAX_MASK_SIDE_PX, PEOPLE
from vidstyle.style.resolve import masks_read
from vidstyle.style.values import asset_path

MaskMaker = Callable[[Picture, float | None, bool], np.ndarray]
"""Returns the mask of the next frame, H x W uint8: of a picture, its time, and whether it begins a scene; or
the backdrop, H x W x 3 uint8."""


class FrameMasks(Closing):
    """Computes the masks that a style reads, for one frame after another.

    Args:
        style: the style.
        cuts: scene cuts of the film; None: they are detected.

    Raises:
        UsageError: what finds a region is not installed.
        InputError: the model of people cannot be used.
        StyleError: the file of a mask cannot be used.
    """

    def __init__(self, style: Style, cuts: SceneCuts | None = None) -> None:
        self._names = masks_read(style)
        self._cuts = cuts or SceneCutDetector()
        self._follower: FaceFollower | None = None
        self._files: Backdrop | None = None
        found = [PEOPLE if name == BACKGROUND else name for name in self._names]
        self._makers = {name: self._maker(style, name) for name in found}

    def close(self) -> None:
        """End the search for faces, and close the backdrop."""
        for each in (self._follower, self._files):
            if each is not None:
                each.close()

    def of(self, picture: Picture, time: float | None) -> dict[str, np.ndarray]:
        """Return the masks of the next frame by name, H x W uint8; `time`: in seconds, None for a still."""
        is_cut = bool(self._names) and self._cuts.begins_scene(picture, time)
        masks = {name: make(picture, time, is_cut) for name, make in self._makers.items()}
        if BACKGROUND in self._names:
            masks[BACKGROUND] = 255 - masks[PEOPLE]
        return masks

    def _maker(self, style: Style, name: str) -> MaskMaker:
        match name:
            case "people":
                return _people()
            case "faces":
                return self._faces()
            case "backdrop":
                return self._backdrop()
            case "skin":
                return lambda picture, *_: _refined(skin_map(searched_copy(picture)), picture)
        return _declared(style, name)

    def _backdrop(self) -> MaskMaker:
        path = backdrop_file()
        if path is None:
            raise UsageError("backdrop", "is not chosen", "give a picture or a film as --background")
        self._files = backdrop = Backdrop(path)
        return lambda picture, time, _: backdrop.at(time, picture.shape)

    def _faces(self) -> MaskMaker:
        finder = FaceFinder()
        if not finder.has_model:
            raise UsageError("the mask faces", "needs a finder of faces", "run pip install 'vidstyle[comic]'")
        self._follower = follower = FaceFollower(finder, self._cuts)

        def make(picture: Picture, time: float | None, _: bool) -> np.ndarray:
            whole = np.zeros(picture.shape, np.float32)
            window = Box(0, 0, picture.shape[1], picture.shape[0])
            for face in follower.follow(picture, time):
                np.maximum(whole, face.opacity * head_mask(face.box, window), out=whole)
            return _as_bytes(whole)

        return make


def _people() -> MaskMaker:
    network = open_people_network()

    def find(picture: Picture, is_first: bool) -> np.ndarray:
        color = searched_copy(picture, 2 * min(network.size))
        return network.find(cv2.resize(color, network.size, interpolation=cv2.INTER_AREA), is_first)

    mask = SteadyMask(find)
    return lambda picture, time, is_cut: _refined(mask.follow(picture, time, is_cut), picture)


def _declared(style: Style, name: str) -> MaskMaker:
    """Return what makes a mask that the style declares."""
    values: dict[str, Any] = {key: each.default for key, each in MASK_VALUES.items()}
    values |= style.masks[name]
    make = _from_file(style, name, values["file"]) if values["file"] else _from_color(values)
    return (lambda *frame: 255 - make(*frame)) if values["invert"] else make


def _from_color(values: dict[str, Any]) -> MaskMaker:
    find = partial(
        color_mask,
        color=rgb_from_text(values["color"]),
        tolerance=values["tolerance"],
        softness=values["softness"],
    )
    return lambda picture, *_: _as_bytes(find(picture))


def _from_file(style: Style, name: str, file: str) -> MaskMaker:
    try:
        mask = read_gray_png(asset_path(style.folder, file), MAX_MASK_SIDE_PX, MAX_MASK_BYTES)
    except (ValueError, OSError) as error:
        raise StyleError(style.name, [f"masks.{name}: file: {file!r}: {error}"]) from None

    def make(picture: Picture, *_: object) -> np.ndarray:
        height, width = picture.shape
        is_smaller = height * width < mask.size
        method = cv2.INTER_AREA if is_smaller else cv2.INTER_LINEAR
        return cv2.resize(mask, (width, height), interpolation=method)

    return make


def _refined(mask: np.ndarray, picture: Picture) -> np.ndarray:
    return refine(mask, luma_rows(picture, 0, picture.shape[0]))


def _as_bytes(mask: np.ndarray) -> np.ndarray:
    return np.rint(mask * np.float32(255)).astype(np.uint8)
