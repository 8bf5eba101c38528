"""Compiling hot loops, and keeping what was compiled where that is possible."""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

from numba import njit

P = ParamSpec("P")
R = TypeVar("R")

# Nothing calls them from C: without that second way in compiling takes a seventh less time.
_NO_C = {"no_cfunc_wrapper": True}
_QUICK = {"_nrt": False, "nogil": True, "error_model": "numpy", **_NO_C}


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function at its first call, and keep the result beside the module or in the user's cache.

    Other threads go on while it runs.
    """
    return _compile(function, {"nogil": True, **_NO_C})


def vectorised(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function as ``compiled`` does, with sums vectorised (SIMD).

    Sums are reassociated and multiplications fused with additions (FMA): in the last digits results differ from one
    kind of processor to another.
    """
    return _compile(function, {"nogil": True, "fastmath": {"reassoc", "contract", "nsz"}, **_NO_C})


def quick(function: Callable[P, R]) -> Callable[P, R]:
    """Compile what makes no arrays.

    Without the counting of references to those it is handed it takes half the time. A division by zero gives infinity
    or NaN as with arrays: a check at each would keep loops from being vectorised. Other threads go on here too.
    """
    return _compile(function, _QUICK)


def inner(function: Callable[P, R]) -> Callable[P, R]:
    """Compile as ``quick`` does what compiled code alone calls: without a way in from Python it takes a fifth less."""
    return _compile(function, {**_QUICK, "no_cpython_wrapper": True})


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function into each of its callers: a call would copy tuples of many arrays every time."""
    return cast(Any, njit)(inline="always")(function)


def _compile(function: Callable[P, R], options: dict[str, Any]) -> Callable[P, R]:
    compile_ = cast(Any, njit)
    try:
        return compile_(cache=True, **options)(function)
    except RuntimeError:  # neither the installation nor a home can be written: each run compiles anew
        return compile_(**options)(function)
