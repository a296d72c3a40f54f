"""Keeps the film of a session steady: on the GPU, or on the CPU where a page is too large for one texture."""

from __future__ import annotations

import logging
from dataclasses import replace

from vidstyle.core.bands import shared_pool
from vidstyle.core.picture import Encoding, Picture
from vidstyle.gpu.compile.nodes import PictureLayout
from vidstyle.gpu.device.runner import BlendWeights, GpuResources, Readback, Runner, StabilizerJob
from vidstyle.gpu.device.stabilize import StabilizerTextures
from vidstyle.stabilize.motion import Motion
from vidstyle.stabilize.stabilizer import Stabilized, Stabilizer, steady_encoding, with_planes

log = logging.getLogger("vidstyle")


class GpuStabilizer:
    """Keeps one film steady, on the GPU or, where a page is done in tiles, on the CPU.

    Whoever calls it owns the context.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style makes marks that lie still on the page.
        is_tiled: whether the page is done in tiles.
        source: how the planes are encoded that come in; for RGB, what `with_planes` makes of it.
        target: how those of the result are.
    """

    def __init__(
        self,
        resources: GpuResources,
        steady: float,
        is_fixed: bool,
        is_tiled: bool,
        source: Encoding,
        target: Encoding,
    ) -> None:
        self._motion = Motion(steady, is_fixed)
        self._stage = Stabilizer(steady, is_fixed, shared_pool()) if is_tiled else None
        self._textures = StabilizerTextures(
            resources.context, resources.programs, resources.textures, source, target
        )
        if is_tiled:
            log.info("pictures larger than one texture: the CPU keeps the film steady, which takes longer")

    def change_strength(self, steady: float, is_fixed: bool) -> None:
        """Use other values from the next picture on."""
        (self._stage or self._motion).change_strength(steady, is_fixed)

    def start(
        self, runner: Runner, picture: Picture, time: float, scene_cut: bool, weights: BlendWeights
    ) -> tuple[list[Readback], Stabilized | None]:
        """Start all that is to be done for a picture; what comes second is for `after`."""
        if self._stage is not None:
            stabilized = self._stage.before(picture, time, scene_cut)
            return runner.start(stabilized.picture, weights), stabilized
        job = StabilizerJob(self._textures, self._motion.follow(picture, time, scene_cut))
        return runner.start(with_planes(picture), weights, job), None

    def after(self, result: Picture, stabilized: Stabilized | None) -> Picture:
        """The picture to be shown."""
        return result if self._stage is None or stabilized is None else self._stage.after(result, stabilized)

    def release(self) -> None:
        """Release the textures; framebuffers must be out of use."""
        self._textures.release()


def planes_layout(picture: Picture) -> PictureLayout:
    """What `with_planes` makes of such a picture."""
    layout = PictureLayout.of(picture)
    if layout.planes != "color":
        return layout
    return PictureLayout(layout.encoding.as_float(), layout.shape, "chroma")


def stabilized_layout(picture: Picture) -> PictureLayout:
    """What a style sees of such a picture in a steady film."""
    layout = planes_layout(picture)
    return replace(layout, encoding=steady_encoding(layout.encoding))
