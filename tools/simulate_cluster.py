"""Simulate clusters that restyle films in segments, and print the table of docs/scale.md.

    python tools/simulate_cluster.py --restyle 1.4 --analyse 0.15

Each option is a measured time or a property of the cluster, see `--help`. A worker is one core. All films are
queued at the start. Each film is analysed, restyled in segments, and joined.
"""

from __future__ import annotations

import argparse
import heapq
import random
import statistics
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace

WORKER_COUNTS = (10, 1_000, 100_000)
RUN_SECONDS = 3600.0
"""Duration of a run without losses."""
MIN_FILMS = 20


@dataclass(frozen=True)
class Cluster:
    """A cluster and its work; times in seconds, data in bytes.

    Attributes:
        film, segment: lengths of a film and of its segments.
        restyle, analyse, join: time of one core for a second of film.
        start: time of a task before its first frame.
        read, write: data of a second of film.
        workers: number of cores.
        node: cores of a machine, which are lost together.
        loss: mean time until a machine is lost.
        repair: time until a lost machine is back.
        stragglers, slowness: share of tasks that take longer, and how many times as long.
        dispatch: tasks that the scheduler begins in a second.
        storage: data that the storage transfers in a second, for all workers.
    """

    film: float = 5400.0
    segment: float = 30.0
    restyle: float = 1.5
    analyse: float = 0.15
    join: float = 0.002
    start: float = 2.0
    read: float = 625e3
    write: float = 625e3
    workers: int = 10
    node: int = 10
    loss: float = 50 * 3600.0
    repair: float = 600.0
    stragglers: float = 0.01
    slowness: float = 4.0
    dispatch: float = 500.0
    storage: float = 10e9

    @property
    def segments(self) -> int:
        """Number of segments of a film."""
        return max(1, round(self.film / self.segment))

    @property
    def film_work(self) -> float:
        """Time of one core for a film, without losses and stragglers."""
        return self.film * (self.analyse + self.restyle + self.join) + self.start * (self.segments + 2)


@dataclass(frozen=True)
class Task:
    """A task of a film; `kind` is "analyse", "restyle" or "join"."""

    film: int
    kind: str
    work: float
    data: float


@dataclass
class Outcome:
    """The result of a run; times in seconds.

    Attributes:
        makespan: until the last film is joined.
        finished: number of tasks that have ended, by film and kind.
        latencies: of each film, from the beginning of its analysis.
        lost_work: time of cores on tasks whose machine was lost.
        lost_machines: number of losses.
        dispatching, transferring: how long the scheduler and the storage were busy.
    """

    makespan: float = 0.0
    finished: Counter[tuple[int, str]] = field(default_factory=Counter)
    latencies: list[float] = field(default_factory=list)
    lost_work: float = 0.0
    lost_machines: int = 0
    dispatching: float = 0.0
    transferring: float = 0.0


class Server:
    """A resource that serves one request after another; `busy`: for how many seconds."""

    def __init__(self, rate: float) -> None:
        self._rate, self._free, self.busy = rate, 0.0, 0.0

    def serve(self, now: float, amount: float) -> float:
        """Return when a request of this amount, made now, has been served."""
        self.busy += amount / self._rate
        self._free = max(now, self._free) + amount / self._rate
        return self._free


class Simulation:
    """A run of a cluster; `run` may be called once."""

    def __init__(self, cluster: Cluster, films: int, seed: int = 0) -> None:
        self._cluster, self._random = cluster, random.Random(seed)
        self._now, self._count, self._left = 0.0, 0, films
        self._events: list[tuple[float, int, Callable[[int], None], int]] = []
        self._waiting = deque(range(films))
        self._ready: deque[Task] = deque()
        self._free, self._running = [*range(cluster.workers)], dict[int, tuple[Task, float, float]]()
        self._missing, self._begun = [cluster.segments] * films, [-1.0] * films
        self._scheduler, self._storage = Server(cluster.dispatch), Server(cluster.storage)
        self._outcome = Outcome()

    def run(self) -> Outcome:
        """Run until all films are joined."""
        for node in range(-(-self._cluster.workers // self._cluster.node)):
            self._plan_loss(node)
        while self._left:
            while self._free and (task := self._next_task()):
                self._begin(self._free.pop(), task)
            self._now, _, act, subject = heapq.heappop(self._events)
            act(subject)
        self._outcome.makespan = self._now
        self._outcome.dispatching, self._outcome.transferring = self._scheduler.busy, self._storage.busy
        return self._outcome

    def _next_task(self) -> Task | None:
        """Return the next task; films in progress come first."""
        if self._ready:
            return self._ready.popleft()
        if not self._waiting:
            return None
        film, cluster = self._waiting.popleft(), self._cluster
        self._begun[film] = self._now
        return Task(film, "analyse", cluster.analyse * cluster.film, cluster.read * cluster.film)

    def _begin(self, worker: int, task: Task) -> None:
        cluster = self._cluster
        begin = self._scheduler.serve(self._now, 1)
        slowness = cluster.slowness if self._random.random() < cluster.stragglers else 1.0
        # Cores and storage work at the same time; the slower one decides.
        end = max(begin + (cluster.start + task.work) * slowness, self._storage.serve(begin, task.data))
        self._running[worker] = task, self._now, end
        self._plan(end, self._end, worker)

    def _end(self, worker: int) -> None:
        if worker not in self._running or self._running[worker][2] != self._now:
            return  # the machine was lost in the meantime
        task, _, _ = self._running.pop(worker)
        self._free.append(worker)
        self._outcome.finished[task.film, task.kind] += 1
        self._follow(task)

    def _follow(self, task: Task) -> None:
        """Queue the tasks that depend on a finished one."""
        film, cluster = task.film, self._cluster
        if task.kind == "analyse":
            length = cluster.film / cluster.segments
            data = (cluster.read + cluster.write) * length
            self._ready.extend([Task(film, "restyle", cluster.restyle * length, data)] * cluster.segments)
        elif task.kind == "restyle":
            self._missing[film] -= 1
            if not self._missing[film]:
                data = 2 * cluster.write * cluster.film
                self._ready.appendleft(Task(film, "join", cluster.join * cluster.film, data))
        else:
            self._left -= 1
            self._outcome.latencies.append(self._now - self._begun[film])

    def _lose(self, node: int) -> None:
        """Lose a machine; its tasks restart on other machines."""
        workers = self._workers(node)
        for worker in workers & self._running.keys():
            task, since, _ = self._running.pop(worker)
            self._outcome.lost_work += self._now - since
            self._ready.appendleft(task)
        self._free = [worker for worker in self._free if worker not in workers]
        self._outcome.lost_machines += 1
        self._plan(self._now + self._cluster.repair, self._return, node)

    def _return(self, node: int) -> None:
        self._free += self._workers(node)
        self._plan_loss(node)

    def _workers(self, node: int) -> set[int]:
        first = node * self._cluster.node
        return set(range(first, min(first + self._cluster.node, self._cluster.workers)))

    def _plan_loss(self, node: int) -> None:
        if self._cluster.loss:
            self._plan(self._now + self._random.expovariate(1 / self._cluster.loss), self._lose, node)

    def _plan(self, time: float, act: Callable[[int], None], subject: int) -> None:
        self._count += 1
        heapq.heappush(self._events, (time, self._count, act, subject))


def films_for_run(cluster: Cluster) -> int:
    """Return the number of films that the cluster renders in `RUN_SECONDS`."""
    return max(MIN_FILMS, round(cluster.workers * RUN_SECONDS / cluster.film_work))


def simulate_row(cluster: Cluster, films: int, price: float) -> str:
    """Run a cluster and return a row of the table; `price` is the price of a core-hour."""
    outcome = Simulation(cluster, films).run()
    hours, core_seconds = films * cluster.film / 3600, cluster.workers * outcome.makespan
    shares = (
        films * cluster.film_work / core_seconds,
        outcome.lost_work / core_seconds,
        outcome.dispatching / outcome.makespan,
        outcome.transferring / outcome.makespan,
    )
    cells = [
        f"{cluster.workers:,}",
        f"{hours / outcome.makespan * 86400:,.0f}",
        *(f"{share:.1%}" for share in shares),
        f"{outcome.lost_machines:,}",
        f"{statistics.median(outcome.latencies) / 60:.0f}",
        f"{core_seconds / 3600 * price / hours:.3f}",
    ]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Simulate, and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for each in fields(Cluster):
        if each.name != "workers":
            parser.add_argument(f"--{each.name}", type=type(each.default), default=each.default)
    parser.add_argument("--workers", type=int, nargs="+", default=WORKER_COUNTS)
    parser.add_argument("--price", type=float, default=0.04, help="price of a core-hour")
    arguments = vars(parser.parse_args())
    workers, price = arguments.pop("workers"), arguments.pop("price")
    titles = ("workers", "hours of film a day", "useful", "lost", "scheduler", "storage", "machines lost",
              "film, min", "price of an hour")  # fmt: skip
    print(f"| {' | '.join(titles)} |", f"|{'---:|' * len(titles)}", sep="\n")
    for number in workers:
        cluster = replace(Cluster(**arguments), workers=number)
        print(simulate_row(cluster, films_for_run(cluster), price), flush=True)


if __name__ == "__main__":
    main()
