"""Keeps the film of a session steady: on the GPU, or on the CPU where a page is too large for one texture."""

from __future__ import annotations

import logging
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from vidstyle.core.bands import CORES
from vidstyle.core.picture import Encoding, Picture
from vidstyle.gpu.compile.nodes import PictureLayout
from vidstyle.gpu.device.runner import BlendWeights, GpuResources, Readback, Runner, StabilizerJob
from vidstyle.gpu.device.stabilize import StabilizerTextures
from vidstyle.stabilize.motion import Motion
from vidstyle.stabilize.stabilizer import Stabilized, Stabilizer, steady_encoding, with_planes

log = logging.getLogger("vidstyle")


class GpuStabilizer:
    """What one runner's films need to be steady. Whoever calls it owns the context.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style makes marks that lie still on the page.
        source: how the planes are encoded that come in; for RGB, what `with_planes` makes of it.
        target: how those of the result are.
    """

    def __init__(
        self,
        equipment: GpuResources,
        runner: Runner,
        steady: float,
        is_fixed: bool,
        source: Encoding,
        target: Encoding,
    ) -> None:
        self._runner = runner
        self._motion = Motion(steady, is_fixed)
        self._textures: StabilizerTextures | None = None
        self._pool: ThreadPoolExecutor | None = None
        if runner.is_tiled:
            log.info("pictures larger than one texture: the CPU keeps the film steady, which takes longer")
            self._pool = ThreadPoolExecutor(CORES, thread_name_prefix="vidstyle-steady")
            self._stage = Stabilizer(steady, is_fixed, self._pool)
        else:
            self._textures = StabilizerTextures(
                equipment.context, equipment.programs, equipment.textures, source, target
            )

    def draw(
        self, picture: Picture, time: float, begins: bool, blend_weights: BlendWeights
    ) -> tuple[list[Readback], Stabilized | None]:
        """Start all that is to be done for a picture; what comes second is for `after`."""
        if self._textures is None:
            steadied = self._stage.before(picture, time, begins)
            return self._runner.draw(steadied.picture, blend_weights), steadied
        steadying = StabilizerJob(self._textures, self._motion.follow(picture, time, begins))
        return self._runner.draw(with_planes(picture), blend_weights, steadying), None

    def after(self, result: Picture, steadied: Stabilized | None) -> Picture:
        """The picture to be shown."""
        return result if steadied is None else self._stage.after(result, steadied)

    def release(self) -> None:
        """Let everything go; framebuffers must be out of use."""
        if self._pool is not None:
            self._pool.shutdown()
        if self._textures is not None:
            self._textures.release()


def plain_layout(picture: Picture) -> PictureLayout:
    """What `with_planes` makes of such a picture."""
    layout = PictureLayout.of(picture)
    if layout.planes != "color":
        return layout
    return PictureLayout(layout.encoding.as_float(), layout.shape, "chroma")


def steady_layout(picture: Picture) -> PictureLayout:
    """What a style sees of such a picture in a steady film."""
    layout = plain_layout(picture)
    return replace(layout, encoding=steady_encoding(layout.encoding))
