"""Requests in a row: few are done, the last one always is."""

import threading
import time
from itertools import pairwise

import pytest
from waiting import WAIT_S

from webui.threads.threads import Throttle


@pytest.mark.slow
def test_the_last_of_many_is_done_and_few_of_the_others():
    done, last = [], threading.Event()

    def do(what):
        done.append(what)
        if what == 200:
            last.set()

    pace, begun = Throttle(do, 0.1), time.monotonic()
    for number in range(201):
        pace.request(number)
        time.sleep(0.001)
    assert last.wait(WAIT_S)
    assert done == sorted(done)
    assert len(done) <= 2 + (time.monotonic() - begun) / 0.1
    pace.close()


@pytest.mark.slow
def test_calls_never_overlap_and_are_apart():
    times, busy = [], threading.Lock()

    def do(_):
        assert busy.acquire(blocking=False)
        times.append(time.monotonic())
        time.sleep(0.02)
        busy.release()

    pace = Throttle(do, 0.05)
    end = time.monotonic() + WAIT_S
    while len(times) < 4 and time.monotonic() < end:
        pace.request(0)
        time.sleep(0.003)
    pace.close()
    assert len(times) >= 4
    assert all(later - earlier >= 0.05 for earlier, later in pairwise(times))


@pytest.mark.slow
def test_what_is_forgotten_or_asked_after_the_end_is_not_done():
    done = []
    pace = Throttle(done.append, 2.0)
    pace.request(1)
    end = time.monotonic() + WAIT_S
    while not done and time.monotonic() < end:
        time.sleep(0.005)
    pace.request(2)
    pace.clear()
    time.sleep(2.3)
    assert done == [1]
    pace.close()
    pace.request(3)
    time.sleep(0.05)
    assert done == [1]
