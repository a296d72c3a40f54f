"""What a run is made of, kept beside its unfinished file, so that a later run can continue it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from vidstyle.errors import UsageError, output_error
from vidstyle.media.write.atomic import partial_path

AGAIN = "-y starts anew"


@dataclass(frozen=True)
class Fingerprint:
    """What decides every picture and every packet of a film.

    Attributes:
        parts: a text for each part, by names that people know ("source", "style", "crf").
        resume: whether to continue what an earlier run of the same parts has left.
    """

    parts: Mapping[str, str]
    resume: bool = False

    def store(self, record: Path) -> None:
        """Write the parts to a file; raises OutputError."""
        try:
            record.write_text(json.dumps(dict(self.parts), indent=1), encoding="utf-8")
        except OSError as error:
            raise output_error(record, error) from error

    def check(self, record: Path, left: Path) -> None:
        """Compare the parts with those of an earlier run.

        Args:
            record: where they were stored.
            left: what it left, for messages.

        Raises:
            UsageError: they differ, or are not known.
        """
        earlier = read_record(record)
        if earlier is None:
            raise UsageError(left, f"cannot be continued, since {record.name} is missing or damaged", AGAIN)
        names = [name for name in {**self.parts, **earlier} if self.parts.get(name) != earlier.get(name)]
        if names:
            reason = f"was begun with another {', '.join(names)}"
            raise UsageError(left, reason, f"use the same to continue it; {AGAIN}")


def read_record(record: Path) -> Mapping[str, str] | None:
    """The parts that `Fingerprint.store` has written, or None."""
    try:
        found = json.loads(record.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def record_path(target: Path) -> Path:
    """Where the record of an unfinished target is.

    >>> record_path(Path("a.mp4")).name
    'a.mp4.partial.json'
    """
    return partial_path(target.with_name(target.name + ".json"))


def earlier_run(left: Path, held: str, record: Path) -> UsageError:
    """The error for what an earlier run has left, that is not to be lost.

    Args:
        left: the file.
        held: what is in it.
        record: where the earlier run's parts were stored, if they were.
    """
    remedy = f"--resume continues it, {AGAIN}" if read_record(record) else f"rename it to keep it; {AGAIN}"
    return UsageError(left, f"holds {held} of an earlier run", remedy)
