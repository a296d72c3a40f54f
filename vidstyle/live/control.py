"""Options, control and status of a live session."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from vidstyle.cues.cue_list import CueList
from vidstyle.errors import UsageError, suggest
from vidstyle.media.capture.microphone import Microphone
from vidstyle.style import Style, load_style, popular_first, set_values
from vidstyle.style.change import apply_variant
from vidstyle.style.mask_declarations import REGIONS
from vidstyle.style.panel import switch_variant


@dataclass(frozen=True)
class LiveOptions:
    """Options of a session.

    Attributes:
        size: of the output; one side may be -1 to keep the aspect ratio, or -2 to be even too.
        rate: frames per second of the targets; None: the source's own.
        device: as for `open_renderer`.
        budget: whether to work at a smaller size when the rate cannot be held otherwise.
        sound: whether to pass sound to the targets that take any.
        microphone: captured in place of the source's own sound, or None.
        frames, seconds: after which to end; None: at the end of the source.
    """

    size: tuple[int, int] | None = None
    rate: Fraction | None = None
    device: str = "auto"
    budget: bool = True
    sound: bool = True
    microphone: Microphone | None = None
    frames: int | None = None
    seconds: Fraction | float | None = None


@dataclass(frozen=True)
class Status:
    """The status of a session at one moment.

    Attributes:
        style: the name of the style that runs, which may not be the one last requested yet.
        preparing: the name of the style that will run once it is prepared, or "".
        bypass: whether frames are passed through unchanged.
        split: the share of the width, from the left, in which frames are passed through unchanged.
        source: the name of the source; `source_state` is "running", "waiting" or "ended".
        size: width and height of the output.
        frames: number of frames restyled so far.
        dropped: number of frames that were captured and dropped for newer ones.
        repeated: number of frames that targets repeated for want of a newer one.
        rate: restyled frames per second, over the last seconds.
        latency_ms: median and 99th percentile from capture to the targets, over the last seconds.
        degraded: a description of the reduced working size, or "".
        full_size: whether the size is kept although it may be too slow.
        targets: name and state of each.
        recording: whether a recording is being written.
        recorded: the names of the finished recordings.
        message: the last message to the user, or "".
    """

    style: str
    preparing: str = ""
    bypass: bool = False
    split: float = 0.0
    source: str = ""
    source_state: str = "waiting"
    size: tuple[int, int] = (0, 0)
    frames: int = 0
    dropped: int = 0
    repeated: int = 0
    rate: float = 0.0
    latency_ms: tuple[float, float] = (0.0, 0.0)
    degraded: str = ""
    full_size: bool = False
    targets: tuple[tuple[str, str], ...] = ()
    recording: bool = False
    recorded: tuple[str, ...] = ()
    message: str = ""


@dataclass(frozen=True)
class StyleShow:
    """Styles that change during a session.

    Attributes:
        rotation: the styles that follow the initial one, which then comes again; empty: all styles.
        seconds: interval at which the next one follows; None: only on request.
        cues: a cue list that can be started.
    """

    rotation: Sequence[Style] = ()
    seconds: float | None = None
    cues: CueList | None = None


class Controls:
    """Requests to a running session; thread-safe, and no method blocks.

    The session reads the requests between two frames.

    Attributes:
        names: the available styles, each with its variants.
        style: the style last requested.
        bypassed: whether frames are to be passed through unchanged.
        full_size: whether to work at full size even if the rate cannot be held.
        split: the share of the width, from the left, in which frames are passed through unchanged.
        recording: whether a recording is to be written in addition to the other targets.
        recorded: the files of the finished recordings; the session appends to them.
        quitting: set when the session should end.
        status: returns the current status; replaced by the session.

    >>> controls = Controls(load_style("plain"), ["plain", "ink"])
    >>> controls.next_style()
    >>> controls.style.name
    'ink'
    """

    def __init__(
        self, style: Style, names: Iterable[str] | None = None, show: StyleShow | None = None
    ) -> None:
        """`style`: the initial one, with its overrides; `names`: None for all, the initial ones first."""
        self._show = show or StyleShow()
        self._own = {each.name: each for each in (style, *self._show.rotation)}
        names = dict.fromkeys((*self._own, *popular_first())) if names is None else list(names)
        self.names = [*(name for name in self._own if name not in names), *names]
        self._cues: CueList | None = None
        self._changes_at: float | None = None
        self.bypassed = self.recording = self._snapshot = self.full_size = False
        self.recorded: list[Path] = []
        self.split = 0.0
        self.quitting = threading.Event()
        self.style = self._initial = style
        self.status: Callable[[], Status] = lambda: Status(
            self.style.name, bypass=self.bypassed, split=self.split
        )
        self._lock = threading.RLock()

    def choose(self, name: str) -> None:
        """Request another style; the overrides of the initial style apply to that style only.

        Its regions, and what it has behind people, apply to all: a call must not show the room.

        Args:
            name: one of `names`, or a variant of one: "ink:green".

        Raises:
            UsageError: the style is not in `names`.
            StyleError: the variant does not exist, or the style file has changed and is invalid.
        """
        listed = self._listed(name)
        if listed not in self.names:
            raise UsageError(name, "is not a style to choose", suggest(name, self.names))
        style = self.named(listed)
        style = style if listed == name else apply_variant(style, name.removeprefix(f"{listed}:"))
        with self._lock:
            self.style, self._cues, self._changes_at = style, None, None

    def vary(self, variant: str) -> None:
        """Request a variant of the style last requested; changed values that it does not set stay.

        Args:
            variant: its name; "" for the style itself.

        Raises:
            StyleError: the variant does not exist, or the style file has changed and is invalid.
        """
        with self._lock:
            start = self.without_variant(self.style.name)
            self.style = switch_variant(self.style, start, variant)
            self._cues = self._changes_at = None

    def named(self, name: str) -> Style:
        """Return the style of this name, as in `choose`.

        Raises:
            StyleError: the style file has changed and is invalid.
        """
        if name in self._own:
            return self._own[name]
        initial = self._initial
        regions = {key: mask for key in ("only", "keep") if (mask := getattr(initial, key)) in REGIONS}
        style = load_style(name)
        return replace(style, behind=initial.behind or style.behind, **regions)

    def next_style(self) -> None:
        """Request the next style; the first follows the last."""
        with self._lock:
            names = [*self._own] if self._show.rotation else self.names
            name = self.style.name if self.style.name in names else self._listed(self.style.name)
            place = names.index(name) if name in names else -1
            self.choose(names[(place + 1) % len(names)])

    @property
    def look(self) -> Style | CueList:
        """The style last requested, or the cue list that was started since."""
        return self._cues or self.style

    def start_cues(self) -> None:
        """Start the cue list, if there is one, from its beginning; a request for a style ends it."""
        if self._show.cues is not None:
            self._cues = replace(self._show.cues)

    def follow(self, time: float) -> None:
        """Request the next style when it is due; for the session, before each frame.

        Args:
            time: of the frame, in seconds.

        Raises:
            StyleError: as `choose`.
        """
        if self._show.seconds is None or self.bypassed or self._cues is not None:
            return
        is_due = self._changes_at is not None and time >= self._changes_at
        if is_due:
            self.next_style()
        if is_due or self._changes_at is None:
            self._changes_at = time + self._show.seconds

    def without_variant(self, name: str) -> Style:
        """Return the style of this name; for a variant, its base style.

        Raises:
            StyleError: the style file has changed and is invalid.
        """
        base = name.rpartition(":")[0]
        return self.named(base if base in self.names else name)

    def set_values(self, values: Mapping[str, object]) -> None:
        """Change values of the style: {"posterize.levels": 5}.

        Raises:
            UsageError: a value is invalid; lists all mistakes and changes nothing.
        """
        with self._lock:
            self.style, self._cues = set_values(self.style, values), None

    def steady(self, value: float) -> None:
        """Set temporal smoothing, from 0 (off) to 1 (strongest); values outside are clamped."""
        self.set_values({"steady": round(min(max(value, 0.0), 1.0), 2)})

    def bypass(self, on: bool | None = None) -> None:
        """Pass frames through unchanged; None toggles."""
        self.bypassed = not self.bypassed if on is None else on

    def compare(self, at: float) -> None:
        """Pass the left part of frames through unchanged, up to this share of the width; 0 ends it."""
        self.split = at

    def keep_size(self, on: bool) -> None:
        """Work at full size even if the rate cannot be held, or adapt the size again."""
        self.full_size = on

    def record(self, on: bool | None = None) -> None:
        """Start or stop a recording in addition to the other targets; None toggles."""
        self.recording = not self.recording if on is None else on

    def snapshot(self) -> None:
        """Request the next frame as a file; the status shows its name."""
        self._snapshot = True

    def pop_snapshot(self) -> bool:
        """Whether a snapshot was requested since the last call; for the session."""
        requested, self._snapshot = self._snapshot, False
        return requested

    def quit(self) -> None:
        """End the session."""
        self.quitting.set()

    def _listed(self, name: str) -> str:
        """Return the entry of `names` for a style or a variant."""
        return name if name in self.names else name.rpartition(":")[0] or name
