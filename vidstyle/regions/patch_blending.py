"""Lays restyled patches over the restyled picture."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.masks import face_mask, mask_box
from vidstyle.regions.patches import Patch, PatchSet, plane_area

EDGE_SHARPNESS_FACTOR = 10
"""Factor by which the edge of a mask is narrower where picture and patch are black and white."""


def lay_over(
    page: Picture,
    styled: Picture,
    faces: Picture,
    patches: PatchSet,
    region: np.ndarray | None,
    cell: tuple[int, int] | None,
) -> Picture:
    """Return a picture with the restyled patches laid over it, by the masks of their faces.

    Args:
        page: the picture; planes of `styled` are copied, others are changed in place.
        styled: the restyled picture without patches.
        faces: the restyled picture of all patches.
        patches: the patches.
        region: where the style applies, H x W float32, 0..1; None: everywhere.
        cell: see `patch_mask`.
    """
    parts = [_within_mask(patch, page.encoding.subsampling, cell) for patch in patches.visible]
    masks = [patch_weight(patch, styled, faces, region, cell) for patch in parts]
    fine = [each for each in (faces.luma, *(faces.chroma or ()), faces.color) if each is not None]

    def blend_plane(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind == "alpha":
            return plane
        step = page.encoding.subsampling if kind == "chroma" else (1, 1)
        whole, restyled = plane.copy() if page is styled else plane, fine.pop(0)
        for patch, mask in zip(parts, masks, strict=True):
            area = plane_area(patch.window, step)
            whole[area] = _blend(whole[area], restyled[plane_area(patch.place, step)], mask)
        return whole

    return page.map_planes(blend_plane)


def patch_weight(
    patch: Patch,
    styled: Picture,
    faces: Picture,
    region: np.ndarray | None,
    cell: tuple[int, int] | None,
) -> np.ndarray:
    """Return the weight of a patch at each pixel of its window, H x W float32, 0..1; see `lay_over`."""
    mask = patch_mask(patch, cell, None if cell else _difference(patch, styled, faces))
    return mask if region is None else mask * region[plane_area(patch.window, (1, 1))]


def patch_mask(
    patch: Patch, cell: tuple[int, int] | None = None, difference: np.ndarray | None = None
) -> np.ndarray:
    """Return the weight of a patch with a face at each pixel of its window: H x W float32, 0..1.

    Args:
        patch: the patch.
        cell: height and width of squares on the page, of which each gets one weight, and no edge is soft.
        difference: between picture and patch at each pixel, H x W float32, 0..1. The more they differ, the
            sharper is the edge: half black and half white would be gray, which line drawings do not have.
    """
    assert patch.face is not None
    mask = face_mask(patch.face.box, patch.window)
    if cell is not None:
        mask = (mask[_in_cells(patch.window, cell)] >= 0.5).astype(np.float32)
    elif difference is not None:
        half = np.float32(0.5)
        mask = np.clip(half + (1 + np.float32(EDGE_SHARPNESS_FACTOR) * difference) * (mask - half), 0, 1)
    mask *= np.float32(patch.face.opacity)
    # Together with the newer patch, it covers as much as one of them alone.
    under = 1 - (1 - mask) / np.maximum(1 - patch.cover * mask, np.float32(1e-6)) if patch.cover else mask
    return np.asarray(patch.weight * under, np.float32)


def _within_mask(patch: Patch, step: tuple[int, int], cell: tuple[int, int] | None) -> Patch:
    """Return the part of a patch outside of which its mask is 0, at multiples of `step`."""
    assert patch.face is not None
    down, across = cell or (1, 1)
    left, top, right, bottom = mask_box(patch.face.box).padded(across, down, down)
    box = Box(
        int(left // step[0]) * step[0],
        int(top // step[1]) * step[1],
        -int(-right // step[0]) * step[0],
        -int(-bottom // step[1]) * step[1],
    ).intersection(patch.window)
    right_by, down_by = patch.place.left - patch.window.left, patch.place.top - patch.window.top
    return patch._replace(window=box, place=box.moved(right_by, down_by))


def _in_cells(window: Rectangle, cell: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return, for each row and column of a window, those in the middle of the page's cells."""
    rows, columns = (
        np.clip(np.arange(first, last) // side * side + side // 2, first, last - 1) - first
        for first, last, side in (
            (window.top, window.bottom, cell[0]), (window.left, window.right, cell[1])
        )
    )  # fmt: skip
    return rows[:, None], columns


def _difference(patch: Patch, styled: Picture, faces: Picture) -> np.ndarray:
    """Return the difference between picture and patch at each pixel of the window, H x W float32, 0..1."""
    under, over = (each.color if each.luma is None else each.luma for each in (styled, faces))
    assert under is not None and over is not None
    gap = cv2.absdiff(under[plane_area(patch.window, (1, 1))], over[plane_area(patch.place, (1, 1))])
    gap = gap if gap.ndim == 2 else cv2.transform(gap, styled.encoding.weights[None])
    black, white = styled.encoding.luma_levels
    return gap * np.float32(1 / (white - black))


def _blend(under: np.ndarray, over: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Blend two planes by a mask for each pixel."""
    if mask.shape != under.shape[:2]:
        mask = cv2.resize(mask, under.shape[1::-1], interpolation=cv2.INTER_AREA)
    weight = mask if under.ndim == 2 else mask[..., None]
    mixed = under + weight * (over.astype(np.float32) - under)
    return mixed if under.dtype.kind == "f" else np.rint(mixed).astype(under.dtype)
