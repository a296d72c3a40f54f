"""Fuzz the program with damaged files: `python tools/fuzz.py --seconds 60 --seed 1 --kind film`.

Worker processes open the files of `tools/fuzzing` with the Python API and the commands. Findings are crashes,
hangs, exceptions other than `VidstyleError`, memory above the limit, undocumented exit codes, and films with
fewer frames than FFmpeg decodes. Each is saved in tests/fixtures/found, and tests/faults/test_found.py tries
all of these files. A case depends only on the seed, its kind and its number, so a seed reproduces a finding.
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
from tools.fuzzing.cases import KINDS, Case, make_file  # noqa: E402
from tools.fuzzing.originals import write_originals  # noqa: E402
from tools.fuzzing.worker import Worker  # noqa: E402

FOUND = ROOT / "tests" / "fixtures" / "found"
SLOW_KIND_STEPS = {"cache": 25}
"""Without --kind, only every Nth case of these kinds is tried, as each takes seconds."""


def main() -> None:
    """Try cases for a time or up to a count; exit with 1 if there are findings."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, help="default: 60, or as long as --count takes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=KINDS, action="append", help="may be repeated; default: all")
    parser.add_argument("--count", type=int, help="number of cases of each kind")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--found", type=Path, default=FOUND, help="folder for the findings")
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
        if chosen.kind or number % SLOW_KIND_STEPS.get(kind, 1) == 0
    )
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TMPDIR"] = folder  # files of crashed workers are removed with it
        whole = write_originals(Path(folder), kinds)
        counts = try_all(cases, whole, chosen.found, chosen.workers)
    for kind, outcomes in counts.items():
        summary = ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
        print(f"{kind}: {outcomes.total()} cases of seed {chosen.seed}: {summary}")
    sys.exit(any(outcomes.keys() - {"used", "refused"} for outcomes in counts.values()))


def try_all(
    cases: Iterator[Case],
    whole: dict[str, list[Path]],
    found: Path,
    workers: int,
) -> dict[str, Counter[str]]:
    """Try cases in several workers, save each finding, and return the count of each outcome by kind."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    lock = threading.Lock()

    def try_cases() -> None:
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
                    save_finding(case, outcome, whole, found)

    threads = [threading.Thread(target=try_cases) for _ in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return counts


def save_finding(case: Case, outcome: str, whole: dict[str, list[Path]], found: Path) -> None:
    """Write the file of a finding, and print its outcome."""
    suffix, content = make_file(*case, whole)
    path = found / f"{case.kind}-{case.seed}-{case.number}{suffix}"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    print(f"{path.name}: {outcome}", flush=True)


if __name__ == "__main__":
    main()
