"""The queue between two threads."""

from __future__ import annotations

import threading

import pytest
from waiting import LONG, eventually, is_waiting

from vidstyle.pipeline.bounded_queue import BoundedQueue, QueueClosedError


def test_items_arrive_in_order_and_the_producer_waits_for_capacity():
    queue = BoundedQueue[int](capacity=2)
    given: list[int] = []

    def give():
        for number in range(50):
            queue.put(number)
            given.append(number)
        queue.close()

    giver = threading.Thread(target=give)
    giver.start()
    taken: list[int] = []
    lying = []
    for number in queue:
        taken.append(number)
        eventually(lambda: len(given) == 50 or len(given) >= len(taken) + 2 and is_waiting(giver))
        lying.append(len(given) - len(taken))
    giver.join()
    assert taken == list(range(50))
    assert max(lying) == 2


def test_closing_wakes_a_giver_that_waits():
    queue = BoundedQueue[int](capacity=1)
    queue.put(1)

    def give():
        with pytest.raises(QueueClosedError):
            queue.put(2)

    giver = threading.Thread(target=give)
    giver.start()
    eventually(lambda: is_waiting(giver))
    queue.close()
    giver.join(LONG)
    assert not giver.is_alive()
    assert list(queue) == [1]


def test_closing_wakes_a_taker_that_waits():
    queue = BoundedQueue[int](capacity=1)
    taken: list[int] = []
    taker = threading.Thread(target=lambda: taken.extend(queue))
    taker.start()
    eventually(lambda: is_waiting(taker))
    queue.close()
    taker.join(LONG)
    assert not taker.is_alive()
    assert taken == []


def test_what_is_discarded_is_not_handed_out():
    queue = BoundedQueue[int](capacity=2)
    queue.put(1)
    queue.close(discard=True)
    assert list(queue) == []
