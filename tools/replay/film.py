"""The threads of `vidstyle render` as operations on virtual cores."""

from __future__ import annotations

from collections.abc import Iterator

from tools.replay.record import Event, Recording
from tools.replay.virtual_cores import Give, Semaphore, Take, Thread, Work, run
from vidstyle.cpu.renderer import WAITING_FRAMES
from vidstyle.pipeline.stages import MAX_QUEUED_BATCHES


def predicted_seconds(recording: Recording, cores: int) -> float:
    """Return the time of the recorded film on a number of cores, with a frame per thread."""
    return run(_Film(recording, cores).threads(), cores)


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
    def __init__(self, recording: Recording, cores: int) -> None:
        self._recording, self._cores = recording, cores
        self._count = min(map(len, (recording.reading, recording.writing, recording.finished)))
        self._lock = Semaphore(1)  # Python's
        self._read, self._result = _Queue(MAX_QUEUED_BATCHES), _Queue(MAX_QUEUED_BATCHES)
        self._encoder = _Queue(cores * 3 // 2 or 1)  # as many frames as x264 has threads
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
            yield Work(seconds)
            yield from self._read.put()

    def _style(self) -> Thread:
        in_flight = self._cores + WAITING_FRAMES
        for number in range(self._count):
            yield from self._read.get()
            yield from self._events(number, self._recording.begun[number])
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
            yield Work(self._recording.writing[number])
            yield Give(self._encoder.places)

    def _events(self, number: int, events: list[Event]) -> Thread:
        for kind, value in events:
            if kind == "enter":
                yield Take(self._turn(value, number))
            elif kind == "leave":
                yield Give(self._turn(value, number + 1))
            elif kind == "python":
                yield Take(self._lock)
                yield Work(value)
                yield Give(self._lock)
            else:
                yield Work(value)

    def _turn(self, memory: float | int, number: int) -> Semaphore:
        """Return the right of a frame to use what earlier frames have left."""
        return self._turns.setdefault((memory, number), Semaphore(0 if number else 1))
