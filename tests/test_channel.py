"""The queue between two threads."""

from __future__ import annotations

import threading
import time

import pytest

from vidstyle.pipeline.bounded_queue import BoundedQueue, QueueClosedError


def test_items_arrive_in_order_and_the_giver_waits_for_room():
    channel = BoundedQueue[int](room=2)
    lying: list[int] = []
    given = 0

    def give():
        nonlocal given
        for number in range(50):
            channel.put(number)
            given = number + 1
        channel.close()

    giver = threading.Thread(target=give)
    giver.start()
    taken = []
    for number in channel:
        time.sleep(0.001)
        taken.append(number)
        lying.append(given - len(taken))
    giver.join()
    assert taken == list(range(50))
    assert max(lying) <= 2


def test_closing_wakes_a_giver_that_waits():
    channel = BoundedQueue[int](room=1)
    channel.put(1)
    raised = threading.Event()

    def give():
        with pytest.raises(QueueClosedError):
            channel.put(2)
        raised.set()

    threading.Thread(target=give).start()
    time.sleep(0.05)
    assert not raised.is_set()
    channel.close()
    assert raised.wait(1)
    assert list(channel) == [1]


def test_closing_wakes_a_taker_that_waits():
    channel = BoundedQueue[int](room=1)
    taken: list[int] = []
    taker = threading.Thread(target=lambda: taken.extend(channel))
    taker.start()
    channel.close()
    taker.join(1)
    assert not taker.is_alive()
    assert taken == []


def test_what_is_discarded_is_not_handed_out():
    channel = BoundedQueue[int](room=2)
    channel.put(1)
    channel.close(discard=True)
    assert list(channel) == []
