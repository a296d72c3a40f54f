"""What people ask of a running session, from keys or a page, and what they are told about it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from vidstyle.errors import UsageError
from vidstyle.style import Style, describe, load_style, override, set_values, style_names
from vidstyle.style.change import apply_variant
from vidstyle.style.values import suggest


@dataclass(frozen=True)
class Status:
    """How a session is at one moment.

    Attributes:
        style: the name of the style that runs, which may not be the one last asked for yet.
        bypass: whether frames go through untouched.
        source: what it is, for people; `source_state` is "running", "waiting" or "ended".
        size: width and height of the pictures that go out.
        frames: restyled so far.
        dropped: frames that came and were never restyled, a newer one being there.
        repeated: frames that targets showed again for want of a newer one.
        rate: restyled frames per second, over the last seconds.
        latency_ms: median and 99th percentile from capture to the targets, over the last seconds.
        given_up: what was given up to hold the rate, or "".
        targets: name and state of each.
        recording: whether a recording is being written.
        message: the last thing worth telling, or "".
    """

    style: str
    bypass: bool = False
    source: str = ""
    source_state: str = "waiting"
    size: tuple[int, int] = (0, 0)
    frames: int = 0
    dropped: int = 0
    repeated: int = 0
    rate: float = 0.0
    latency_ms: tuple[float, float] = (0.0, 0.0)
    given_up: str = ""
    targets: tuple[tuple[str, str], ...] = ()
    recording: bool = False
    message: str = ""


class Controls:
    """Wishes for a running session; every method may be called from any thread and returns at once.

    The session looks at the wishes between two frames.

    Attributes:
        names: the styles that can be chosen, each with its variants.
        quitting: set when the session is to end.

    >>> controls = Controls(load_style("plain"), ["plain", "ink"])
    >>> controls.next_style()
    >>> controls.style_name
    'ink'
    """

    def __init__(self, style: Style, names: Iterable[str] | None = None) -> None:
        """`style`: to begin with, with all that was set by hand; `names`: None for it and all shipped."""
        names = list(style_names() if names is None else names)
        self.names = names if style.name in names else [style.name, *names]
        self.quitting = threading.Event()
        self._first = self._style = style
        self._bypass = self._recording = self._snapshot = False
        self._lock = threading.RLock()
        self._report: Callable[[], Status] | None = None

    @property
    def style(self) -> Style:
        """The style last asked for."""
        return self._style

    @property
    def style_name(self) -> str:
        """Its name."""
        return self._style.name

    def choose(self, name: str) -> None:
        """Ask for another style; what was set by hand stays with the style that the session began with.

        Args:
            name: one of `names`, or a variant of one: "ink:green".

        Raises:
            UsageError: neither.
            StyleError: there is no such variant, or its file is not what it was.
        """
        listed = self._listed(name)
        if listed not in self.names:
            raise UsageError(name, "is not a style to choose", suggest(name, self.names))
        style = self._first if listed == self._first.name else load_style(listed)
        if listed != name:
            style = apply_variant(style, name.removeprefix(f"{listed}:"))
        with self._lock:
            self._style = style

    def next_style(self) -> None:
        """Ask for the style after this one; after the last comes the first."""
        with self._lock:
            place = self.names.index(self._listed(self.style_name))
            self.choose(self.names[(place + 1) % len(self.names)])

    def without_variant(self, name: str) -> Style:
        """The style of a name as it is chosen; of a variant's name the style that it is a variant of.

        Raises:
            StyleError: its file is not what it was.
        """
        listed = name.rpartition(":")[0]
        listed = listed if listed in self.names else name
        return self._first if listed == self._first.name else load_style(listed)

    def set(self, assignments: list[str]) -> None:
        """Change values of the style, as `--set` does: "posterize.levels=5".

        Raises:
            UsageError: with all that is wrong with them; nothing has changed then.
        """
        with self._lock:
            self._style = override(self._style, assignments)

    def steady(self, value: float) -> None:
        """Hold what flickers: 0 lets it boil, 1 keeps it still; values beyond are brought there."""
        with self._lock:
            self._style = set_values(self._style, {"steady": round(min(max(value, 0.0), 1.0), 2)})

    def bypass(self, on: bool | None = None) -> None:
        """Let frames through untouched; None turns over what is."""
        with self._lock:
            self._bypass = not self._bypass if on is None else on

    @property
    def bypassed(self) -> bool:
        """Whether frames are to go through untouched."""
        return self._bypass

    def snapshot(self) -> None:
        """Ask for the next picture as a file; the status tells its name."""
        self._snapshot = True

    def take_snapshot(self) -> bool:
        """Whether one was asked for since the last call; for the session."""
        with self._lock:
            asked, self._snapshot = self._snapshot, False
        return asked

    def record(self, on: bool | None = None) -> None:
        """Begin or end to write a film beside the other targets; None turns over what is."""
        with self._lock:
            self._recording = not self._recording if on is None else on

    @property
    def recording(self) -> bool:
        """Whether a film is to be written."""
        return self._recording

    def quit(self) -> None:
        """End the session."""
        self.quitting.set()

    def describe(self) -> dict[str, Any]:
        """The style last asked for, with every value and what it may be, as `vidstyle styles NAME --json`."""
        return describe(self._style)

    def status(self) -> Status:
        """How the session is."""
        return self._report() if self._report else Status(self.style_name, self._bypass)

    def _listed(self, name: str) -> str:
        """The name under which a style or a variant of it stands among `names`."""
        return name if name in self.names else name.rpartition(":")[0] or name

    def attach(self, report: Callable[[], Status]) -> None:
        """The session tells who knows its status."""
        self._report = report
