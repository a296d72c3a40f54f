"""Gives damaged files to the program: `python tools/fuzz.py --seconds 60 --seed 1 --kind film`.

The files of `tools/fuzzing` go through the Python API and the commands in worker processes. A crash, a hang,
an exception that is no `VidstyleError`, memory above the limit, an undocumented exit code and a film with
fewer frames than FFmpeg finds are finds: each becomes a file in tests/fixtures/found, all of which
tests/faults/test_found.py tries. A case depends only on the seed, its kind and its number, so that a seed
reproduces a find.
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
import sys
import tempfile
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT)]

from tools.fuzzing.attempts import attempt  # noqa: E402
from tools.fuzzing.cases import KINDS, Case, mutated  # noqa: E402
from tools.fuzzing.originals import whole_files  # noqa: E402
from tools.fuzzing.worker import Worker  # noqa: E402

FOUND = ROOT / "tests" / "fixtures" / "found"
EVERY = {"cache": 25}
"""Without --kind, only one case of so many of a kind is tried: each takes seconds."""


def main() -> None:
    """Try cases until the time or their count is up; fail if anything was found."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, help="default: 60, or as long as --count takes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=KINDS, action="append", help="may be repeated; default: all")
    parser.add_argument("--count", type=int, help="how many cases of each kind")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--found", type=Path, default=FOUND, help="folder for the finds")
    chosen = parser.parse_args()
    count = math.inf if chosen.count is None else chosen.count
    end = time.monotonic() + (chosen.seconds or (60 if chosen.count is None else math.inf))
    numbers = itertools.takewhile(
        lambda number: number < chosen.first + count and time.monotonic() < end, itertools.count(chosen.first)
    )
    kinds = chosen.kind or list(KINDS)
    cases = (
        Case(kind, chosen.seed, number)
        for number in numbers
        for kind in kinds
        if chosen.kind or number % EVERY.get(kind, 1) == 0
    )
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TMPDIR"] = folder  # so that workers that crash leave nothing behind
        whole = whole_files(Path(folder), kinds)
        counts = try_all(cases, whole, chosen.found, chosen.workers)
    for kind, outcomes in counts.items():
        said = ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
        print(f"{kind}: {outcomes.total()} cases of seed {chosen.seed}: {said}")
    sys.exit(any(outcomes.keys() - {"used", "refused"} for outcomes in counts.values()))


def try_all(
    cases: Iterator[Case],
    whole: dict[str, list[Path]],
    found: Path,
    workers: int,
) -> dict[str, Counter[str]]:
    """Try the cases in several workers and keep each find; how often each outcome was, by kind."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    lock = threading.Lock()

    def take_turns() -> None:
        with closing(Worker(whole, attempt)) as worker:
            while True:
                with lock:
                    case = next(cases, None)
                if case is None:
                    return
                outcome = worker.outcome(case)
                with lock:
                    counts[case.kind][outcome.partition(":")[0]] += 1
                if outcome not in ("used", "refused"):
                    keep(case, outcome, whole, found)

    threads = [threading.Thread(target=take_turns) for _ in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return counts


def keep(case: Case, outcome: str, whole: dict[str, list[Path]], found: Path) -> None:
    """Write what was found as a file."""
    suffix, content = mutated(*case, whole)
    path = found / f"{case.kind}-{case.seed}-{case.number}{suffix}"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    print(f"{path.name}: {outcome}", flush=True)


if __name__ == "__main__":
    main()
