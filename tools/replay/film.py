"""Simulate the threads of `vidstyle render` on virtual cores."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tools.replay.record import Event, Recording
from tools.replay.virtual_cores import Give, Semaphore, Take, Thread, Work, run
from vidstyle.cpu.renderer import WAITING_FRAMES
from vidstyle.cpu.style_processes import MIN_PROCESS_THREADS, useful_processes
from vidstyle.pipeline.stages import MAX_QUEUED_BATCHES

REQUEST_SECONDS = 0.00014
"""Time with the GIL for sending a picture to a process and receiving the result. For pictures of 512 pixels,
a change takes 0.09 ms and `ink` 0.19 ms of processor time, partly in the system."""


@dataclass(frozen=True)
class Machine:
    """Properties of a machine that limit a film, in addition to the times of its tasks on one core.

    Attributes:
        slowdown: processor time on several cores, divided by the processor time on one core; caches, memory
            and clock rate are shared.
        wake_up_seconds: time until a thread that waits for the GIL continues.
        has_processes: whether pictures are restyled in processes, see `useful_processes`.
    """

    slowdown: float = 1.0
    wake_up_seconds: float = 0.0
    has_processes: bool = True


def predict_seconds(
    recording: Recording, cores: int, machine: Machine = Machine(), frames: int | None = None
) -> float:
    """Return the time of the recorded film, or of its first frames, on `cores` with one frame per thread."""
    return run(_Film(recording, cores, machine, frames).threads(), cores)


class _Queue:
    def __init__(self, capacity: int) -> None:
        self.places, self.items = Semaphore(capacity), Semaphore()

    def put(self) -> Iterator[Take | Give]:
        yield Take(self.places)
        yield Give(self.items)

    def get(self) -> Iterator[Take | Give]:
        yield Take(self.items)
        yield Give(self.places)


class _Film:
    def __init__(self, recording: Recording, cores: int, machine: Machine, frames: int | None) -> None:
        self._recording, self._cores = recording, cores
        self._slowdown = machine.slowdown if cores > 1 else 1.0
        made = min(len(recording.reading), len(recording.writing), len(recording.finished))
        self._count = min(made, frames or made)
        self._between = {name: each / made for name, each in recording.between.items()}
        self._encoding = [each + sum(recording.ending) / made for each in recording.writing]
        self._lock = Semaphore(1, machine.wake_up_seconds)  # the GIL
        self._processes = Semaphore(useful_processes(cores) if machine.has_processes else 0)
        self._moved = ("edit", "style") if cores >= MIN_PROCESS_THREADS else ("edit",)
        self._read, self._result = _Queue(MAX_QUEUED_BATCHES), _Queue(MAX_QUEUED_BATCHES)
        self._encoder = _Queue(cores * 3 // 2 or 1)  # the number of threads of x264
        self._begun = Semaphore()
        self._done = [Semaphore() for _ in range(self._count)]
        self._turns: dict[tuple[float | int, int], Semaphore] = {}
        self._numbers, self._encoded = iter(range(self._count)), iter(range(self._count))

    def threads(self) -> list[Thread]:
        workers = [self._work() for _ in range(self._cores)]
        encoders = [self._encode() for _ in range(self._encoder.places.permits)]
        return [self._reader(), self._style(), self._writer(), *workers, *encoders]

    def _reader(self) -> Thread:
        for seconds in self._recording.reading[: self._count]:
            yield self._work_of(seconds)
            yield from self._hold_lock("read")
            yield from self._read.put()

    def _style(self) -> Thread:
        in_flight = self._cores + WAITING_FRAMES
        for number in range(self._count):
            yield from self._read.get()
            yield from self._events(number, self._recording.begun[number])
            yield from self._hold_lock("style")
            yield Give(self._begun)
            if number >= in_flight:
                yield from self._pass_on(number - in_flight)
        for number in range(max(0, self._count - in_flight), self._count):
            yield from self._pass_on(number)
        for _ in range(self._cores):
            yield Give(self._begun)

    def _pass_on(self, number: int) -> Thread:
        yield Take(self._done[number])
        yield from self._result.put()

    def _work(self) -> Thread:
        while True:
            yield Take(self._begun)
            number = next(self._numbers, None)
            if number is None:
                return
            yield from self._events(number, self._recording.finished[number])
            yield Give(self._done[number])

    def _writer(self) -> Thread:
        for _ in range(self._count):
            yield from self._result.get()
            yield from self._hold_lock("write")
            yield Take(self._encoder.places)
            yield Give(self._encoder.items)
        for _ in range(self._cores * 2):
            yield Give(self._encoder.items)

    def _encode(self) -> Thread:
        while True:
            yield Take(self._encoder.items)
            number = next(self._encoded, None)
            if number is None:
                return
            yield self._work_of(self._encoding[number])
            yield Give(self._encoder.places)

    def _work_of(self, seconds: float) -> Work:
        return Work(seconds * self._slowdown)

    def _events(self, number: int, events: list[Event]) -> Thread:
        is_here = True  # not in a process
        for kind, value in events:
            if kind == "enter":
                yield Take(self._turn(value, number))
            elif kind == "leave":
                yield Give(self._turn(value, number + 1))
            elif kind in ("edit", "style"):
                is_here = kind not in self._moved or not self._processes.permits
                if not is_here:
                    yield Take(self._processes)
                    yield from self._locked(REQUEST_SECONDS)
                    yield self._work_of(value)
            elif kind == "moved":
                if not is_here:
                    yield Give(self._processes)
                is_here = True
            elif kind == "python" and is_here:
                yield from self._locked(value)
            else:
                yield self._work_of(value)

    def _hold_lock(self, stage: str) -> Thread:
        """Simulate the work of a stage between its tasks."""
        yield from self._locked(self._between.get(stage, 0.0))

    def _locked(self, seconds: float) -> Thread:
        yield Take(self._lock)
        yield self._work_of(seconds)
        yield Give(self._lock)

    def _turn(self, memory: float | int, number: int) -> Semaphore:
        """Return the permit of a frame to use the state of earlier frames."""
        return self._turns.setdefault((memory, number), Semaphore(0 if number else 1))
