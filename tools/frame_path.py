"""Lists the functions that pass a film's frame on, on the CPU: `python -m tools.frame_path [--rows|--write]`.

A function counts when it takes the frame, in any form, and passes it on to another function or to its caller.
`--rows` counts what works on rows of its planes too; `--write` renews the list in docs/architecture.md.
"""

from __future__ import annotations

import inspect
import re
import sys
import tempfile
import threading
from collections import Counter
from pathlib import Path
from types import FrameType
from typing import Any

import av
import numpy as np

import vidstyle

PACKAGE = Path(vidstyle.__file__).parent
PAGE = PACKAGE.parent / "docs" / "architecture.md"
SECTION = re.compile(r"(?<=<!-- frame path -->\n).*?(?=<!-- end -->)", re.DOTALL)
WIDTH, HEIGHT, FRAMES = 98, 62, 8
STYLE = {"format": 1, "background": [{"block": "gaussian"}], "lines": [{"block": "sobel"}], "steady": 0}
FORMS = {"VideoFrame", "DecodedFrame", "Frame", "FrameRequest", "Picture"}
"""Names of the classes that hold a frame."""
STAGES = ("vidstyle read", "vidstyle style", "vidstyle write")

Function = tuple[str, str]
"""File, relative to the package, and qualified name."""


class FrameTracer:
    """A profile function: notes the functions that pass a frame on.

    Args:
        rows: whether arrays of its rows count as the frame.
    """

    def __init__(self, rows: bool) -> None:
        self._rows = rows
        self._seen: Counter[Function] = Counter()
        self._last: dict[Function, tuple[int, int]] = {}
        self._passing: set[Function] = set()
        self._given: set[FrameType] = set()

    def __call__(self, frame: FrameType, event: str, value: Any) -> None:
        """What `threading.setprofile` has called at every call and return of a thread."""
        if event not in ("call", "return") or not in_package(frame) or is_own_method(frame):
            return
        if event == "call":
            # A generator that goes on still has the frame before among its variables.
            resumed = frame.f_code.co_flags & inspect.CO_GENERATOR
            # One that is enclosed may be called while another thread works for it: it counts by its return.
            given = [value for name, value in frame.f_locals.items() if name not in frame.f_code.co_freevars]
            if not resumed and holds_frame(given, self._rows):
                self._given.add(frame)
                self._note(frame)
            return
        if holds_frame(value, self._rows):
            self._passing.add(function_of(frame))
            if frame not in self._given:
                self._note(frame)
        self._given.discard(frame)

    def _note(self, frame: FrameType) -> None:
        function = function_of(frame)
        thread = threading.current_thread().name
        # A band is worked on in a thread of a pool, during the stage in the middle.
        stage = STAGES.index(thread) if thread in STAGES else 1
        self._seen[function] += 1
        self._last[function] = stage, self._seen.total()
        caller = frame.f_back
        while caller is not None and not in_package(caller):
            caller = caller.f_back
        if caller is not None:
            self._passing.add(function_of(caller))

    def path(self) -> list[Function]:
        """The functions that passed every frame on, in the order in which the last frame met them."""
        found = [each for each in self._passing if self._seen[each] >= FRAMES - 1]
        return sorted(found, key=self._last.__getitem__)


def in_package(frame: FrameType) -> bool:
    """Whether the function is one of the package's."""
    return frame.f_code.co_filename.startswith(str(PACKAGE))


def function_of(frame: FrameType) -> Function:
    """What is called; lambdas and comprehensions count as the function that they stand in."""
    name = re.sub(r"\.<\w+>", "", frame.f_code.co_qualname)
    return Path(frame.f_code.co_filename).relative_to(PACKAGE).as_posix(), name


def holds_frame(value: Any, rows: bool) -> bool:
    """Whether it is a frame, or a list, tuple or dict with one; rows of its planes count if wanted."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        return any(holds_frame(each, rows) for each in value)
    if isinstance(value, np.ndarray):
        return rows and value.ndim > 1 and value.shape[1] in (WIDTH, WIDTH // 2)
    return type(value).__name__ in FORMS


def is_own_method(frame: FrameType) -> bool:
    """Whether it is a method or property of the frame itself, which does not pass it on."""
    return type(frame.f_locals.get("self")).__name__ in FORMS


def make_film(path: Path) -> None:
    """A film of noise."""
    random = np.random.default_rng(1)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25, pix_fmt="yuv420p", options={"bf": "0"})
        stream.width, stream.height = WIDTH, HEIGHT
        for _ in range(FRAMES):
            rgb = random.integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(rgb)))
        container.mux(stream.encode(None))


def measure(rows: bool = False) -> list[Function]:
    """The functions that every frame of a film passes, from the decoder to the encoder."""
    tracer = FrameTracer(rows)
    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder) / "film.mp4"
        make_film(film)
        threading.setprofile(tracer)  # of threads that begin from here on: not of this one, which only waits
        try:
            vidstyle.render(film, Path(folder) / "made.mp4", STYLE, device="cpu")
        finally:
            threading.setprofile(None)
    return tracer.path()


def as_markdown(path: list[Function]) -> str:
    """The list as it stands in docs/architecture.md."""
    files = len({file for file, _ in path})
    lines = [f"{number}. `{file}`: `{name}`" for number, (file, name) in enumerate(path, 1)]
    return "\n".join([f"{len(path)} functions in {files} files:", "", *lines, ""])


if __name__ == "__main__":
    text = as_markdown(measure("--rows" in sys.argv))
    if "--write" in sys.argv:
        PAGE.write_text(SECTION.sub(lambda _: text, PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    else:
        print(text)
