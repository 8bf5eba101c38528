"""What stops an analysis, and the argument checks of the model's formulas.

Each check takes its values by the names of the caller's arguments, so that the message names the one that is wrong.
"""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from specs.errors import LocatedError

_ABSOLUTE_ZERO_C = -273.15


class CleaningError(LocatedError):
    """Parameters or measurements cannot be used: the message names the file, the line and the path."""


def require_positive(**values: ArrayLike) -> None:
    """Check for finite numbers above 0, alone or in arrays of any shape.

    Raises:
        CleaningError: one is not.
    """
    for name, value in values.items():
        for wrong in _outside(value, 0.0):
            raise CleaningError(f"{name} must be a positive number, not {wrong:g}")


def require_not_negative(**values: ArrayLike) -> None:
    """Check for finite numbers that are not below 0, alone or in arrays of any shape.

    Raises:
        CleaningError: one is not.
    """
    for name, value in values.items():
        for wrong in _outside(value, -math.ulp(0.0)):
            raise CleaningError(f"{name} must be a number that is not negative, not {wrong:g}")


def require_temperature(**values: float) -> None:
    """Check for temperatures in degrees Celsius above absolute zero.

    Raises:
        CleaningError: one is not.
    """
    for name, value in values.items():
        for wrong in _outside(value, _ABSOLUTE_ZERO_C):
            raise CleaningError(f"{name} must be a temperature above {_ABSOLUTE_ZERO_C:g} degrees C, not {wrong:g}")


def _outside(value: ArrayLike, above: float) -> Iterable[float]:
    """The first number that is not finite or not above a bound, if there is one."""
    if isinstance(value, float | int):  # arrays would cost twenty times as much, and most values are numbers
        return () if above < value < math.inf else (float(value),)
    numbers = np.asarray(value, dtype=np.float64).ravel()
    return numbers[~((numbers > above) & (numbers < math.inf))][:1].tolist()
