"""The state behind the page: choices, candidates rendered ahead of clicks, and pictures of tiles."""

from __future__ import annotations

import itertools
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from vidstyle.core.closing import Closing
from vidstyle.errors import UsageError
from vidstyle.explore.choosing.chooser import Chooser
from vidstyle.explore.choosing.tile_screen import Tile
from vidstyle.explore.composed.shipped_parts import shipped_styles
from vidstyle.explore.crops.full_size import MAX_SIDE_PX, FullSize
from vidstyle.explore.look import MAX_LOOK_SIDE_PX, Look, look_of
from vidstyle.explore.matching.like import match_styles
from vidstyle.explore.naming.visible_marks import visible_marks
from vidstyle.explore.tuning_pad import TuningPad, tuning_pad_of
from vidstyle.explore.workers import Workers
from vidstyle.gallery.style_samples import restyle_picture, sheet_of
from vidstyle.media.resize import reduce_picture
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.preview.clip import Clip
from vidstyle.preview.encode import encode
from vidstyle.preview.plans import plan_message
from vidstyle.preview.representative import GLANCE_SIDE_PX, representative_frame
from vidstyle.regions.still_faces import NO_FACES, KnownFaces, StillFaces
from vidstyle.style import Style

NOW, SHOWN, TUNING, AHEAD, MOVING, LATER = range(6)
"""Priorities: candidates that a click waits for, and an opened look; the first picture of a tile; samples of
values to tune; candidates for the most likely next clicks; further pictures of tiles; candidates for other
clicks."""
LIKELY_CHOICE_COUNT = 4
"""Number of most likely clicks that are prepared first."""
MAX_CACHED_LOOKS = 1000
EXCERPT_SECONDS, MAX_EXCERPT_RATE = 3.0, 15.0
"""Length of the excerpt that plays in the tiles, and its maximum frame rate."""
DRAWN_SIDE_PX = 540
"""Shorter side at which tiles are drawn, then reduced: dots and strokes look as in the opened look."""
MATCH_SIDE_PX, MATCH_COUNT = 360, 30
"""Side at which looks are compared with a reference, and how many of the nearest styles may become tiles."""
MAX_TRIES = 9
"""Number of candidates for a screen that are shown until it is there."""
PAD_GRID_SIZE = 5
"""Rows and columns of the samples on a tuning pad."""


class Exploration(Closing):
    """The exploration of one clip. Thread-safe; choices are made one at a time.

    Attributes:
        chooser: screens and favourites; read it only between choices.
        on_progress: receives progress while a screen is made.
        tries: pictures of candidates for all screens, as JPEG, to be seen until each screen is there.
        references: the pictures whose looks the user wanted, as JPEG, the latest last.
        frames: the frame numbers of the excerpt.
        rate: the frame rate of the excerpt.
        stopped: whether choices are refused; see `stop`.
        marks: the visible marks of tiles, by tile number; see `visible_marks`.
        names: the names of looks so far, by the `repr` of their styles.
        glance: the first of these frames in approximate colours, as JPEG, before any kernel is compiled.
    """

    def __init__(self, clip: Clip, seed: int = 0) -> None:
        self.clip = clip
        self._workers = Workers()
        self._looks: OrderedDict[str, Future[Look | None]] = OrderedDict()
        self._pads: dict[int, TuningPad | None] = {}
        self._tiles: list[Tile] = []
        self._numbers: dict[int, int] = {}
        self._turn, self._lock = threading.Lock(), threading.RLock()
        self._faces, self._searching = StillFaces(), threading.Lock()
        self._change = itertools.count()
        self._latest, self._is_closed = -1, False
        self._try_count = 0
        self._awaited: list[Future[Look | None]] = []
        self._search = object()
        self.stopped = threading.Event()
        self.on_progress: ProgressCallback = ignore_progress
        self.references: list[bytes] = []
        self.tries: list[bytes] = []
        self.marks: dict[int, tuple[str, ...]] = {}
        self.names: dict[str, str] = {}
        self._ahead: list[tuple[str, Future[Look | None]]] = []
        self.move_to(self._first_part())
        self.glance = encode(clip.glance(self.frames[0], GLANCE_SIDE_PX), "jpeg")
        self.chooser = Chooser(self._candidate_looks, shipped_styles(), seed)

    def close(self) -> None:
        """End the processes."""
        self._latest = -2
        self._is_closed = True
        self._workers.close()

    def _first_part(self) -> float:
        """Return the position at which the excerpt begins with a frame that represents the film."""
        length = min(self.clip.count, max(1, round(EXCERPT_SECONDS * self.clip.fps)))
        number = representative_frame(self.clip)
        return min(1.0, number / (self.clip.count - length)) if number and self.clip.count > length else 0.4

    def move_to(self, part: float) -> None:
        """Move the excerpt to a position in the clip, 0..1."""
        fps, count = self.clip.fps, self.clip.count
        step = max(1, round(fps / MAX_EXCERPT_RATE))
        length = min(count, max(1, round(EXCERPT_SECONDS * fps)))
        first = round(part * (count - length))
        self.frames = range(first, first + length, step)
        self.rate = fps / step

    # Tiles, which the page identifies by number

    def tile(self, number: int) -> Tile:
        """Return a tile by number.

        Raises:
            UsageError: the tile does not exist.
        """
        if not 0 <= number < len(self._tiles):
            raise UsageError("tile", f"there is no tile {number}")
        return self._tiles[number]

    def number(self, tile: Tile) -> int:
        """Return the permanent number of a tile."""
        with self._lock:
            if id(tile) not in self._numbers:
                self._numbers[id(tile)] = len(self._tiles)
                self._tiles.append(tile)
            return self._numbers[id(tile)]

    # Choosing

    def begin(self) -> None:
        """Make the first screen, unless it exists."""
        with self._turn:
            if not self.chooser.screens:
                self.chooser.new_screen()
            self._see_marks()
        self._look_ahead()

    def new_screen(self) -> None:
        """Show nine new styles."""
        self._choose(self.chooser.new_screen)

    def match(self, wanted: np.ndarray) -> None:
        """Show the styles that are most like a reference picture, H x W x 3 uint8.

        Raises:
            UsageError: the exploration was closed.
        """
        photograph = np.ascontiguousarray(self.clip.frame(self.frames[0], MATCH_SIDE_PX))

        def show() -> None:
            found = match_styles(wanted, photograph, self._report_match)
            self.references.append(encode(reduce_picture(wanted, MATCH_SIDE_PX), "jpeg"))
            self.chooser.show_matches([(each.style, each.words) for each in found[:MATCH_COUNT]])

        self._choose(show)

    def _report_match(self, step: str, done: float, total: float) -> None:
        if self._is_closed:
            raise UsageError("the explorer", "is closed")
        if self.stopped.is_set():
            raise CancelledError
        self.on_progress(step, done, total)

    def more_like(self, number: int) -> None:
        """Show styles similar to a tile."""
        tile = self.tile(number)
        tiles = self.chooser.screen.tiles
        if tile in tiles:
            self._choose(lambda: self.chooser.more_like(tiles.index(tile)))
        else:
            self._choose(lambda: self.chooser.again(tile))

    def set_near(self, part: float) -> None:
        """Set the distance of new tiles from the chosen one, from the next screen on."""
        self.chooser.near = part
        self._look_ahead()

    def lock(self, name: str, on: bool) -> None:
        """Lock or unlock a part of the chosen tile, from the next screen on."""
        self.chooser.locks = self.chooser.locks | {name} if on else self.chooser.locks - {name}
        self._look_ahead()

    def again(self) -> None:
        """Show more styles like the tile in the middle."""
        self._choose(self.chooser.again)

    def star(self, number: int, on: bool) -> None:
        """Keep a tile, or stop keeping it."""
        self.chooser.star(self.tile(number), on)

    def back(self) -> None:
        """Show the previous screen."""
        self._choose(self.chooser.back)

    def forward(self) -> None:
        """Show the next screen again after `back`."""
        self._choose(self.chooser.forward)

    def jump(self, screen: int) -> None:
        """Show a screen by number.

        Raises:
            UsageError: the screen does not exist.
        """
        if screen >= len(self.chooser.screens):
            raise UsageError("screen", f"there is no screen {screen}")
        self._choose(lambda: setattr(self.chooser, "at", screen))

    def stop(self) -> None:
        """Stop making a screen: its choice raises UsageError, and the present screen stays."""
        self.stopped.set()
        for future in self._awaited:
            future.cancel()

    def _choose(self, action: Any) -> None:
        with self._turn:
            self._stop_looking_ahead()
            self._try_count = 0
            try:
                action()
            except CancelledError:
                raise UsageError("the search", "was cancelled") from None
            finally:
                self._awaited = []
            self._see_marks()
        self._look_ahead()

    def _see_marks(self) -> None:
        """Find the visible marks of the tiles of the screen; their names are made of them."""
        tiles = {self.number(tile): tile for tile in self.chooser.screen.tiles}
        new = {number: tile.style for number, tile in tiles.items() if number not in self.marks}
        seen = {
            number: self._workers.submit(NOW, visible_marks, style, self._picture)
            for number, style in new.items()
        }
        self.marks |= {number: future.result() for number, future in seen.items()}

    # Looks

    def _samples(self, styles: Sequence[Style]) -> list[Look | None]:
        """Return looks for fine tuning: no picture that the user has asked for waits for them."""
        futures = [self._request_look(style, TUNING)[1] for style in styles]
        return [future.result() for future in futures]

    def _candidate_looks(self, styles: Sequence[Style]) -> list[Look | None]:
        """Return the looks of candidates for a screen; report how many are there, let `stop` cancel."""
        search = self._search = object()
        finished_count = itertools.count(1)

        def report(finished: Future[Look | None]) -> None:
            if search is not self._search:  # another one has begun since
                return
            if not finished.cancelled() and not finished.exception():
                self._keep_try(finished.result())
            self.on_progress("trying styles", next(finished_count), len(styles))

        self.on_progress("trying styles", 0, len(styles))
        self._awaited = self._request_looks(styles, report)
        if self.stopped.is_set():
            self.stop()
        return [future.result() for future in self._awaited]

    def _request_looks(
        self, styles: Sequence[Style], on_done: Callable[[Future[Look | None]], None] = lambda _: None
    ) -> list[Future[Look | None]]:
        """Request looks; `on_done` is called with each that is there or was cancelled."""
        # Styles with few steps first: if no kernel is compiled yet, something is seen early.
        order = sorted(range(len(styles)), key=lambda place: len(styles[place].steps))
        futures = {place: self._request_look(styles[place], NOW)[1] for place in order}
        for future in futures.values():
            future.add_done_callback(on_done)
        return [futures[place] for place in range(len(styles))]

    def _keep_try(self, look: Look | None) -> None:
        """Keep the picture of a candidate, to be seen until the screen is there."""
        if look is not None and self._try_count < MAX_TRIES and not look.fault:
            self._try_count += 1
            self.tries.append(encode(look.picture, "jpeg"))

    @cached_property
    def _picture(self) -> np.ndarray:
        """The picture on which styles are tried; its kernels may have to be compiled first."""
        return np.ascontiguousarray(self.clip.frame(self.frames[0], MAX_LOOK_SIDE_PX))

    @cached_property
    def _crops(self) -> FullSize:
        """The crops on which styles are measured at full size."""
        return FullSize(np.ascontiguousarray(self.clip.frame(self.frames[0], MAX_SIDE_PX)))

    def _request_look(self, style: Style, urgency: int) -> tuple[str, Future[Look | None]]:
        """Request the look of a style; return its key and future."""
        key = repr(style)
        with self._lock:
            future = self._looks.get(key)
            if future is None or future.cancelled():
                future = self._workers.submit(urgency, look_of, self._picture, style, self._crops)
                self._looks[key] = future
                if len(self._looks) > MAX_CACHED_LOOKS:
                    self._looks.popitem(last=False)
            elif urgency <= TUNING and not future.done():
                self._workers.hurry(future, urgency)
            self._looks.move_to_end(key)
        return key, future

    def _look_ahead(self) -> None:
        """Request candidates for the next click in a separate thread, most likely first."""
        self._latest = change = next(self._change)
        threading.Thread(target=self._order_ahead, args=(change,), name="vidstyle ahead", daemon=True).start()

    def _order_ahead(self, change: int) -> None:
        with self._turn:
            if self._latest != change or not self.chooser.screens:
                return
            places = self.chooser.by_liking()
        for rank, place in enumerate(places):
            with self._turn:
                if self._latest != change:
                    return
                styles = self.chooser.likely_styles(place)
                urgency = AHEAD if rank < LIKELY_CHOICE_COUNT else LATER
                self._ahead += [self._request_look(style, urgency) for style in styles]

    def _stop_looking_ahead(self) -> None:
        self._latest = -1
        for key, future in self._ahead:
            if future.cancel():
                with self._lock:
                    self._looks.pop(key, None)
        self._ahead.clear()

    # Pictures and plans

    def source(self, frame: int, side: int) -> bytes:
        """Return an unchanged frame as JPEG."""
        return encode(self.clip.frame(frame, side), "jpeg")

    def look(self, number: int) -> bytes:
        """The small picture of a tile, as JPEG."""
        return encode(self.tile(number).look.picture, "jpeg")

    def styled(self, style: Style, frame: int, side: int, opened: bool = False) -> Future[bytes]:
        """Render a frame in a style, as JPEG.

        Args:
            opened: whether the look is opened: its first picture comes before those of tiles.

        Raises:
            UsageError: the exploration was closed.
        """
        picture = np.ascontiguousarray(self.clip.frame(frame, max(side, DRAWN_SIDE_PX)))
        first, faces = NOW if opened else SHOWN, self._faces_of(frame)
        if self._is_closed:
            raise UsageError("the explorer", "is closed")
        urgency = first if frame == self.frames[0] else MOVING
        return self._workers.submit(urgency, styled_jpeg, picture, style, faces, side, min(self.clip.size))

    def _faces_of(self, frame: int) -> KnownFaces:
        """Return the faces of a frame; of a camera, whose frames have no numbers, none."""
        if self.clip.live:
            return NO_FACES
        with self._searching:
            return self._faces.find(frame, lambda: np.ascontiguousarray(self.clip.frame(frame)))

    def plan(self, style: Style, side: int) -> Future[dict[str, Any]]:
        """Make the plan of a style for pictures with this shorter side."""
        height, width = self.clip.frame(self.frames[0], side).shape[:2]
        return self._workers.submit(NOW, plan_message, replace(style, steady=0.0), width, height)

    # Fine tuning

    def pad(self, number: int) -> TuningPad:
        """Return the tuning pad of a tile.

        Raises:
            UsageError: fewer than two values change the picture.
        """
        if number not in self._pads:
            self._pads[number] = tuning_pad_of(self.tile(number).style, self._samples)
        pad = self._pads[number]
        if pad is None:
            raise UsageError(self.tile(number).style.name, "has no two values that change this picture")
        return pad

    def pad_picture(self, number: int) -> bytes:
        """Render samples across the tuning pad of a tile, as one JPEG."""
        pad, places = self.pad(number), np.linspace(0, 1, PAD_GRID_SIZE)
        looks = self._samples([pad.style_at(x, 1 - y) for y in places for x in places])
        pictures = [look.picture if look else np.zeros_like(self.tile(number).look.picture) for look in looks]
        framed = [np.pad(each, ((1, 1), (1, 1), (0, 0))) for each in pictures]
        return encode(sheet_of(framed, PAD_GRID_SIZE), "jpeg")

    def tuned(self, number: int, x: float, y: float) -> int:
        """Make a new tile from a point on the tuning pad of a tile."""
        style = self.pad(number).style_at(x, y)
        style = replace(style, name=f"{style.name.partition('~')[0]}~tuned{len(self._tiles)}")
        look = self._request_look(style, NOW)[1].result()
        assert look is not None
        return self.number(Tile(style, "tuned", look, (self.tile(number).style.name,)))


def styled_jpeg(picture: np.ndarray, style: Style, faces: KnownFaces, side: int, seen_side: float) -> bytes:
    """Render a picture, H x W x 3 uint8, in a style, with focus on these faces, as JPEG.

    Args:
        side: maximum shorter side of the result.
        seen_side: see `FrameRequest`.
    """
    longest = round(side * max(picture.shape[:2]) / min(picture.shape[:2]))
    return encode(reduce_picture(restyle_picture(picture, style, faces, seen_side), longest), "jpeg")
