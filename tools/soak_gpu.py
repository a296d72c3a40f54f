"""Restyle many frames on the GPU with changing styles and sizes, and fail if memory or objects grow.

`python -m tools.soak_gpu` runs 20,000 frames and checks the second half; a software renderer suffices.
"""

from __future__ import annotations

import argparse
import gc
import sys
from itertools import cycle

import numpy as np

from tools.soak import MAX_GROWTH_RATE, fit_growth, make_pictures, resident_bytes
from vidstyle.backend import FrameRequest
from vidstyle.gpu.device.devices import choose
from vidstyle.gpu.session import GpuSession, InFlightFrame
from vidstyle.style import Style, load_style, style_names

STYLE_CHANGE_FRAMES = 100
"""Number of frames before the style changes."""
PICTURE_SIZES = ((96, 64), (90, 52), (128, 72), (55, 91))
"""Width and height in pixels; each for a tenth of the frames."""


def main() -> None:
    """Restyle frames, and exit with 1 if memory or the number of OpenGL objects grows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=20_000)
    parser.add_argument("--device", default="gpu")
    parser.add_argument("--form", choices=("compute", "fragment"))
    arguments = parser.parse_args()
    samples = soak(arguments.frames, arguments.device, arguments.form)
    half = samples[len(samples) // 2 :]
    slope = fit_growth(half)
    print(
        f"{arguments.frames} frames: {slope:+.2f} MB per 10,000 frames "
        f"({half[:, 1].min() / 2**20:.1f} to {half[:, 1].max() / 2**20:.1f} MB), "
        f"{half[:, 2].min()} to {half[:, 2].max()} OpenGL objects"
    )
    first, last = np.array_split(half, 2)
    sys.exit(int(slope > MAX_GROWTH_RATE or last[:, 2].max() > first[:, 2].max()))


def soak(frames: int, device: str, form: str | None) -> np.ndarray:
    """Return rows of finished frames, bytes of memory and OpenGL objects, before each change of style."""
    styles = cycle([load_style(name) for name in style_names() if name != "plain"])
    chosen = choose(device).device
    if chosen is None:
        sys.exit(f"{device}: is no GPU; use --device gpu")
    session = GpuSession(chosen, form)  # type: ignore[arg-type]
    style, samples = next(styles), list[tuple[int, int, int]]()
    done = 0
    for size in cycle(PICTURE_SIZES):
        waiting: InFlightFrame | None = None
        for picture in make_pictures(max(frames // 10, 1), *size):
            waiting = advance_frame(session, style, FrameRequest(picture, done / 25), waiting)
            done += 1
            if done % STYLE_CHANGE_FRAMES == 0:
                samples.append((done, resident_bytes(), count_objects(session)))
                style = next(styles)
        if done >= frames:
            session.close()
            return np.array(samples)
    raise AssertionError("cycles do not end")


def advance_frame(
    session: GpuSession, style: Style, request: FrameRequest, waiting: InFlightFrame | None
) -> InFlightFrame:
    """Start a frame and fetch the previous one, as for films."""
    drawn = session.start(style, request)
    if waiting is not None:
        session.fetch(waiting).result()
    return drawn.result()


def count_objects(session: GpuSession) -> int:
    """Return the number of OpenGL objects that have not been released."""
    import moderngl

    kinds = (
        moderngl.Texture,
        moderngl.TextureArray,
        moderngl.Buffer,
        moderngl.Framebuffer,
        moderngl.Program,
        moderngl.VertexArray,
    )
    gc.collect()
    things = [thing for thing in gc.get_objects() if type(thing) in kinds]
    return sum(not isinstance(thing.mglo, moderngl.InvalidObject) for thing in things)


if __name__ == "__main__":
    main()
