"""How a live session went."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Delivery:
    """What one target got: frames delivered, shown again, and left out for newer ones."""

    name: str
    state: str
    delivered: int
    repeated: int
    dropped: int

    def __str__(self) -> str:
        counts = f"{self.delivered} delivered, {self.repeated} shown again, {self.dropped} left out"
        return f"{self.name}: {self.state}, {counts}"


@dataclass(frozen=True)
class LiveSummary:
    """How a session went.

    Attributes:
        frames: restyled.
        dropped: came and were never restyled, a newer one being there.
        elapsed: seconds from the first picture to the end.
        restyled_ms: median and 99th percentile from capture until a picture is restyled, and
        latency_ms: until a target has written it; 0 where none tells.
        size: width and height of what went out.
        rate: frames per second that the targets were promised.
        given_up: what was given up at the end to hold the rate, or "".
        deliveries: for each target.
    """

    source: str
    frames: int
    dropped: int
    elapsed: float
    restyled_ms: tuple[float, float]
    latency_ms: tuple[float, float]
    size: tuple[int, int]
    rate: float
    given_up: str
    deliveries: tuple[Delivery, ...]

    @property
    def repeated(self) -> int:
        """Frames that targets showed again."""
        return sum(delivery.repeated for delivery in self.deliveries)

    def as_dict(self) -> dict[str, Any]:
        """Everything in plain values, for JSON."""
        return {
            "source": self.source,
            "frames": self.frames,
            "dropped": self.dropped,
            "repeated": self.repeated,
            "elapsed": round(self.elapsed, 3),
            "fps": round(self.frames / self.elapsed, 2) if self.elapsed > 0 else 0.0,
            "rate": round(self.rate, 3),
            "restyled_ms": _as_dict(self.restyled_ms),
            "latency_ms": _as_dict(self.latency_ms),
            "size": list(self.size),
            "given_up": self.given_up,
            "targets": [vars(delivery) for delivery in self.deliveries],
        }

    def lines(self) -> list[str]:
        """The same for people."""
        lost = f"{self.dropped} dropped, {self.repeated} shown again"
        first = f"{self.frames} frames in {self.elapsed:.1f} s, {lost}"
        restyled = "capture to restyled: " + _text(self.restyled_ms)
        delivered = "capture to delivered: " + _text(self.latency_ms)
        return [first, restyled, *([delivered] if any(self.latency_ms) else []), *map(str, self.deliveries)]


def _as_dict(latency: tuple[float, float]) -> dict[str, float]:
    return {"median": round(latency[0], 2), "p99": round(latency[1], 2)}


def _text(latency: tuple[float, float]) -> str:
    return f"median {latency[0]:.1f} ms, 99 % within {latency[1]:.1f} ms"
