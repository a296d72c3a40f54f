"""The queue between two threads."""

from __future__ import annotations

import threading
import time

import pytest

from vidstyle.pipeline.bounded_queue import BoundedQueue, QueueClosedError


def test_items_arrive_in_order_and_the_producer_waits_for_capacity():
    queue = BoundedQueue[int](capacity=2)
    lying: list[int] = []
    given = 0

    def give():
        nonlocal given
        for number in range(50):
            queue.put(number)
            given = number + 1
        queue.close()

    giver = threading.Thread(target=give)
    giver.start()
    taken = []
    for number in queue:
        time.sleep(0.001)
        taken.append(number)
        lying.append(given - len(taken))
    giver.join()
    assert taken == list(range(50))
    assert max(lying) <= 2


def test_closing_wakes_a_giver_that_waits():
    queue = BoundedQueue[int](capacity=1)
    queue.put(1)
    raised = threading.Event()

    def give():
        with pytest.raises(QueueClosedError):
            queue.put(2)
        raised.set()

    threading.Thread(target=give).start()
    time.sleep(0.05)
    assert not raised.is_set()
    queue.close()
    assert raised.wait(1)
    assert list(queue) == [1]


def test_closing_wakes_a_taker_that_waits():
    queue = BoundedQueue[int](capacity=1)
    taken: list[int] = []
    taker = threading.Thread(target=lambda: taken.extend(queue))
    taker.start()
    queue.close()
    taker.join(1)
    assert not taker.is_alive()
    assert taken == []


def test_what_is_discarded_is_not_handed_out():
    queue = BoundedQueue[int](capacity=2)
    queue.put(1)
    queue.close(discard=True)
    assert list(queue) == []
