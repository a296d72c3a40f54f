"""Divides a film into segments that can be restyled separately, with the same pictures as in one run."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from fractions import Fraction
from typing import Any

from vidstyle.core.sampling import small_luma
from vidstyle.core.scene_cuts import KnownCuts, SceneCutDetector
from vidstyle.cues.cue_list import CueList, Moment
from vidstyle.cues.rotation import styles_of
from vidstyle.media.frame import Frame
from vidstyle.media.options import VideoInfo
from vidstyle.media.read.reader import Reader
from vidstyle.pipeline.segment_plan import FilmSegment, FrameDigest, SegmentPlan
from vidstyle.renderer import follow_faces, has_followed_faces, runs_on_cpu
from vidstyle.style import Style
from vidstyle.style.resolve import ResolvedStep, film_tables, has_moving_marks, masks_read, resolve

WARM_UP_FRAMES = 120
"""Frames after which a stabilizer usually remembers the same, wherever it began."""
WARM_UP_FACTOR = 20
"""Time constants after which smoothed measurements usually are the same. Both numbers were chosen on three
films of one scene: docs/batch.md."""
MIN_PART_SECONDS = 30
"""Least length of a segment that does not end at a scene cut."""
MIN_PART_RATIO = 4
"""Least length of such a segment, relative to its warm-up."""


def plan_segments(
    reader: Reader,
    style: Style | CueList,
    device: str,
    seconds: Fraction,
    parts: Mapping[str, str],
    undivided: str,
    follows_faces: bool,
    on_frame: Callable[[int], None],
) -> SegmentPlan | None:
    """Read a film once, and find where its segments begin.

    Args:
        reader: at the start of the film.
        style: the style, or the styles at the times of the reader's frames.
        device: see `open_renderer`.
        seconds: the least length of a segment, except the last one.
        parts, undivided: see `SegmentPlan`.
        follows_faces: whether to track faces in focus, which takes longer than all else.
        on_frame: called with the number of frames read so far.

    Returns:
        The plan; None if a scene is so long that it may be divided where no face is tracked.
    """
    info = reader.info
    if not reader.can_seek:
        undivided = "is not seekable"
    if info.alpha or info.still:
        undivided = "is a picture" if info.still else "has transparency"
    with ExitStack() as settings:
        borders = _Borders(info, style, device, seconds, settings, follows_faces)
        for frame in reader:
            if undivided:
                break
            if borders.lacks_faces:
                return None
            if isinstance(frame, Frame):
                borders.add(frame)
                on_frame(borders.number)
    if reader.damage.report():
        undivided = undivided or "is damaged"
    return SegmentPlan(parts, str(info.time_base), borders.cuts, borders.segments(), undivided)


class _Borders:
    """Finds scene cuts and segments, frame by frame.

    A style without memory of earlier frames may be divided anywhere. Otherwise segments begin at scene cuts,
    where a style forgets, and in long scenes at frames without faces in focus. On a GPU, and if a style reads
    masks, has colours of the film or marks that move with it, which follow a whole scene, scenes are not
    divided.

    Where the style changes without a transition, the new one remembers nothing, as at a scene cut. A scene
    with several styles is not divided within a transition, nor if faces are in focus.

    Attributes:
        number: how many frames were added.
        cuts: pts of the frames that begin scenes.
        lacks_faces: whether it is unknown if a segment may begin at a frame, as faces are not followed.
    """

    def __init__(
        self,
        info: VideoInfo,
        style: Style | CueList,
        device: str,
        seconds: Fraction,
        settings: ExitStack,
        follows_faces: bool,
    ) -> None:
        self._style = style
        styles = [(each, resolve(each, info.height, info.width)) for each in styles_of(style)]
        self._seconds, self._has_memory = seconds, any(has_memory(*each) for each in styles)
        follows_scene = any(_follows_scene(*each) for each in styles)
        warm_up = max(warm_up_frames(steps, float(info.rate or 25)) for _, steps in styles)
        self._recent: deque[int] = deque(maxlen=warm_up)
        self._part_seconds = max(seconds, MIN_PART_SECONDS, MIN_PART_RATIO * warm_up / (info.rate or 25))
        self._known, self._detector = KnownCuts(()), SceneCutDetector()
        has_faces = any(has_followed_faces(each) for each, _ in styles)
        self._divides_scenes = runs_on_cpu(style, device) and not follows_scene
        self._divides_scenes &= not (has_faces and isinstance(style, CueList))
        self._needs_faces, self.lacks_faces = has_faces, False
        self._faces = None
        if follows_faces and isinstance(style, Style) and (faces := follow_faces(style, self._known)):
            self._faces = settings.enter_context(faces)
        self._moment: Moment | None = None
        self._segments: list[FilmSegment] = []
        self._begin: dict[str, Any] = {"first": 0, "pts": 0}
        self._digest = FrameDigest()
        self.number = 0
        self.cuts: list[int] = []

    def add(self, frame: Frame) -> None:
        """Take the next frame."""
        if is_cut := self._detector.is_cut(small_luma(frame.picture)):
            self.cuts.append(frame.pts)
            self._known.add(float(frame.time))
        in_transition, begins_style = self._follow_cues(frame)
        forgets = is_cut or begins_style
        if forgets:
            self._recent.clear()
        begin = {"first": self.number, "pts": frame.pts}
        if self.number == 0:
            self._begin = begin
        elif self._lasts(frame, self._seconds) and (forgets or not self._has_memory):
            self._end_segment(begin)
        elif self._divides_scenes and self._lasts(frame, self._part_seconds) and not in_transition:
            self.lacks_faces = self._needs_faces and self._faces is None
            if self._has_no_faces:
                self._end_segment({**begin, **self._continuing()})
        if self._faces is not None:
            self._faces.follow(frame.picture, float(frame.time))
        self._recent.append(frame.pts)
        self._digest.add(frame)
        self.number += 1

    def _follow_cues(self, frame: Frame) -> tuple[bool, bool]:
        """Return whether this frame or the one before is in a transition, and whether a style begins here."""
        if not isinstance(self._style, CueList):
            return False, False
        before, now = self._moment, self._style.at(frame.time)
        self._moment = now
        in_transition = bool(now.ending or (before and before.ending))
        is_other = before is not None and before.active.run != now.active.run
        return in_transition, is_other and now.ending is None

    def segments(self) -> list[FilmSegment]:
        """Return all segments, after the last frame."""
        return [*self._segments, self._current]

    @property
    def _current(self) -> FilmSegment:
        return FilmSegment(**self._begin, end=self.number, digest=self._digest.text)

    @property
    def _has_no_faces(self) -> bool:
        return self._faces is None or self._faces.idle_since is not None

    def _lasts(self, frame: Frame, seconds: Fraction | float) -> bool:
        """Whether the segment lasts at least so long before this frame."""
        return (frame.pts - self._begin["pts"]) * frame.time_base >= seconds

    def _continuing(self) -> dict[str, Any]:
        """How a segment begins in the middle of a scene."""
        faces = self._faces
        return {
            "before_pts": self._recent[-1],
            "warm_up_pts": self._recent[0],
            "search_time": None if faces is None else faces.idle_since,
            "face_detail": 1.0 if faces is None else faces.detail,
        }

    def _end_segment(self, begin: dict[str, Any]) -> None:
        self._segments.append(self._current)
        self._begin, self._digest = begin, FrameDigest()


def has_memory(style: Style, steps: Mapping[str, tuple[ResolvedStep, ...]]) -> bool:
    """Whether the look of a frame depends on earlier ones."""
    follows_faces = style.focus and style.height is not None
    follows = style.steady or follows_faces or masks_read(style)
    return bool(follows or _settle_times(steps) or film_tables(steps))


def _follows_scene(style: Style, steps: Mapping[str, tuple[ResolvedStep, ...]]) -> bool:
    """Whether the look of a frame depends on the whole scene before it."""
    moves = style.steady > 0 and has_moving_marks(steps)
    return bool(moves or film_tables(steps) or masks_read(style))


def warm_up_frames(steps: Mapping[str, tuple[ResolvedStep, ...]], rate: float) -> int:
    """Return after how many frames a renderer usually remembers the same; `rate`: frames a second."""
    return WARM_UP_FRAMES + round(WARM_UP_FACTOR * rate * max(_settle_times(steps), default=0.0))


def _settle_times(steps: Mapping[str, tuple[ResolvedStep, ...]]) -> list[float]:
    """Return the time constants of all measured steps, in seconds."""
    return [step.settle for each in steps.values() for step in each if step.settle is not None]
