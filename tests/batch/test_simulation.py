"""The simulated cluster: no task is lost, and no time is gained."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import pytest

from tools.simulate_cluster import Cluster, Outcome, Simulation, simulate_row

QUIET = Cluster(film=600.0, segment=30.0, loss=0.0, stragglers=0.0, dispatch=1e12, storage=1e18)
"""A cluster without losses, whose scheduler and storage take no time."""
FILMS = 12


def run(cluster: Cluster, seed: int = 0) -> Outcome:
    """Run a cluster and check the invariants."""
    outcome = Simulation(cluster, FILMS, seed).run()
    expected = Counter({(film, kind): 1 for film in range(FILMS) for kind in ("analyse", "join")})
    expected |= Counter({(film, "restyle"): cluster.segments for film in range(FILMS)})
    assert outcome.finished == expected, "each task ends once"
    total = FILMS * cluster.film_work + outcome.lost_work
    assert outcome.makespan * cluster.workers >= total * (1 - 1e-9)
    length = cluster.film / cluster.segments
    chain = cluster.film * (cluster.analyse + cluster.join) + length * cluster.restyle + 3 * cluster.start
    assert min(outcome.latencies) >= chain * (1 - 1e-9) and len(outcome.latencies) == FILMS
    assert outcome.makespan >= max(outcome.latencies)
    assert outcome.makespan >= max(outcome.dispatching, outcome.transferring) * (1 - 1e-9)
    return outcome


def test_one_worker_takes_the_sum_of_the_work() -> None:
    assert run(replace(QUIET, workers=1)).makespan == pytest.approx(FILMS * QUIET.film_work)


def test_many_workers_take_as_long_as_the_longest_chain() -> None:
    outcome = run(replace(QUIET, workers=FILMS * QUIET.segments))
    chain = QUIET.film * (QUIET.analyse + QUIET.join) + 30 * QUIET.restyle + 3 * QUIET.start
    assert outcome.makespan == pytest.approx(chain)


def test_every_cluster_ends_all_tasks() -> None:
    numbers = random.Random(0)
    for seed in range(20):
        cluster = replace(
            QUIET,
            workers=numbers.randint(1, 60),
            node=numbers.randint(1, 8),
            loss=numbers.choice((0.0, 900.0, 3600.0)),
            repair=numbers.uniform(1, 600),
            stragglers=numbers.choice((0.0, 0.1)),
            dispatch=numbers.choice((5.0, 1e12)),
            storage=numbers.choice((5e7, 1e18)),
        )
        run(cluster, seed)


def test_what_is_lost_is_made_again() -> None:
    cluster = replace(QUIET, workers=20, node=4, loss=900.0)
    outcome, quiet = run(cluster), run(replace(QUIET, workers=20))
    assert outcome.lost_machines > 0 and outcome.lost_work > 0
    assert outcome.makespan > quiet.makespan
    assert run(cluster).makespan == outcome.makespan != run(cluster, seed=1).makespan


def test_one_worker_is_always_busy_or_lost() -> None:
    cluster = replace(QUIET, workers=1, node=1, loss=300.0, repair=1.0)
    outcome = run(cluster)
    busy = FILMS * QUIET.film_work + outcome.lost_work
    assert outcome.lost_machines > 10
    assert outcome.makespan == pytest.approx(busy + outcome.lost_machines * cluster.repair)


def test_a_slow_scheduler_and_a_slow_storage_decide() -> None:
    busy = run(replace(QUIET, workers=1000, dispatch=0.2))
    assert busy.makespan == pytest.approx(busy.dispatching, rel=0.2)
    busy = run(replace(QUIET, workers=1000, storage=1e7))
    assert busy.makespan == pytest.approx(busy.transferring, rel=0.2)


def test_a_row_has_the_hours_of_a_day() -> None:
    cells = simulate_row(replace(QUIET, workers=1), 2, price=0.04).strip("| ").split(" | ")
    hours = 24 * QUIET.film / QUIET.film_work
    assert cells[:3] == ["1", f"{hours:,.0f}", "100.0%"]
    assert float(cells[-1]) == pytest.approx(0.04 * QUIET.film_work / QUIET.film, abs=0.001)
