"""Wait for what happens beside a test."""

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")
WAIT_S = 90.0
"""Long enough for a machine with three busy processes to each core; only a test that fails waits for so long."""


def wait_for(condition: Callable[[], T], what: str = "it") -> T:
    """Wait until a function returns something that is true, and return it."""
    end = time.monotonic() + WAIT_S
    while not (found := condition()):
        assert time.monotonic() < end, f"waited for {what}"
        time.sleep(0.01)
    return found
