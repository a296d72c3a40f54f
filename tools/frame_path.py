"""List the functions that a frame passes through on the CPU: `python -m tools.frame_path [--rows|--write]`.

A function counts if it receives the frame in any form, and passes it to another function or its caller.
`--rows` includes functions that process rows of its planes; `--write` updates docs/architecture.md.
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
FILM_WIDTH_PX, FILM_HEIGHT_PX, FILM_LENGTH_FRAMES = 98, 62, 8
STYLE = {"format": 1, "background": [{"block": "gaussian"}], "lines": [{"block": "sobel"}], "steady": 0}
FRAME_CLASSES = {"VideoFrame", "DecodedFrame", "Frame", "FrameRequest", "Picture"}
"""Names of the classes that contain a frame."""
STAGES = ("vidstyle read", "vidstyle style", "vidstyle write")

Function = tuple[str, str]
"""File, relative to the package, and qualified name."""


class FrameTracer:
    """A profile function that records the functions that a frame passes through.

    Args:
        rows: whether arrays of rows of its planes count as the frame.
    """

    def __init__(self, rows: bool) -> None:
        self._rows = rows
        self._seen: Counter[Function] = Counter()
        self._last: dict[Function, tuple[int, int]] = {}
        self._passing: set[Function] = set()
        self._given: set[FrameType] = set()
        self._lock = threading.Lock()

    def __call__(self, frame: FrameType, event: str, value: Any) -> None:
        """Record a call or a return; `threading.setprofile` calls this for each."""
        if event not in ("call", "return") or not is_in_package(frame) or is_own_method(frame):
            return
        if event == "call":
            # A resumed generator still has the previous frame among its variables.
            resumed = frame.f_code.co_flags & inspect.CO_GENERATOR
            # A free variable may belong to another thread; such functions count by their return value.
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
        # Threads of pools process bands, in the middle stage.
        stage = STAGES.index(thread) if thread in STAGES else 1
        with self._lock:  # several threads of the middle stage count at once
            self._seen[function] += 1
            self._last[function] = stage, self._seen.total()
        caller = frame.f_back
        while caller is not None and not is_in_package(caller):
            caller = caller.f_back
        if caller is not None:
            self._passing.add(function_of(caller))

    def path(self) -> list[Function]:
        """Return the functions that every frame passed through, in the order of the last frame."""
        found = [each for each in self._passing if self._seen[each] >= FILM_LENGTH_FRAMES - 1]
        return sorted(found, key=self._last.__getitem__)


def is_in_package(frame: FrameType) -> bool:
    """Return whether the function is defined in the package."""
    return frame.f_code.co_filename.startswith(str(PACKAGE))


def function_of(frame: FrameType) -> Function:
    """Return the called function; lambdas and comprehensions count as their enclosing function."""
    name = re.sub(r"\.<\w+>", "", frame.f_code.co_qualname)
    return Path(frame.f_code.co_filename).relative_to(PACKAGE).as_posix(), name


def holds_frame(value: Any, rows: bool) -> bool:
    """Return whether a value is a frame, or a list, tuple or dict with one."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        return any(holds_frame(each, rows) for each in value)
    if isinstance(value, np.ndarray):
        return rows and value.ndim > 1 and value.shape[1] in (FILM_WIDTH_PX, FILM_WIDTH_PX // 2)
    return type(value).__name__ in FRAME_CLASSES


def is_own_method(frame: FrameType) -> bool:
    """Return whether the function is a method of the frame itself, which does not count."""
    return type(frame.f_locals.get("self")).__name__ in FRAME_CLASSES


def make_film(path: Path) -> None:
    """Write a film of noise."""
    random = np.random.default_rng(1)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25, pix_fmt="yuv420p", options={"bf": "0"})
        stream.width, stream.height = FILM_WIDTH_PX, FILM_HEIGHT_PX
        for _ in range(FILM_LENGTH_FRAMES):
            rgb = random.integers(0, 255, (FILM_HEIGHT_PX, FILM_WIDTH_PX, 3), np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(rgb)))
        container.mux(stream.encode(None))


def trace_film(rows: bool = False) -> list[Function]:
    """Return the functions that every frame passes through, from the decoder to the encoder."""
    tracer = FrameTracer(rows)
    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder) / "film.mp4"
        make_film(film)
        threading.setprofile(tracer)  # for new threads only: this one just waits
        try:
            vidstyle.render(film, Path(folder) / "made.mp4", STYLE, device="cpu")
        finally:
            threading.setprofile(None)
    return tracer.path()


def format_path(path: list[Function]) -> str:
    """Return the list for docs/architecture.md as Markdown."""
    files = len({file for file, _ in path})
    lines = [f"{number}. `{file}`: `{name}`" for number, (file, name) in enumerate(path, 1)]
    return "\n".join([f"{len(path)} functions in {files} files:", "", *lines, ""])


if __name__ == "__main__":
    text = format_path(trace_film("--rows" in sys.argv))
    if "--write" in sys.argv:
        PAGE.write_text(SECTION.sub(lambda _: text, PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    else:
        print(text)
