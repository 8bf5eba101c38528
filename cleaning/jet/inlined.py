"""Small pieces of compiled loops, written into the loops that use them."""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

from numba import njit

P = ParamSpec("P")
R = TypeVar("R")


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function into each of its callers: a call would copy the description of the jet every time."""
    return cast(Any, njit)(inline="always")(function)
