"""What stops an analysis, and the argument checks of the model's formulas.

Each check takes its values by the names of the caller's arguments, so that the message names the one that is wrong.
"""

import math
from collections.abc import Mapping

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
    _require(values, 0.0, "a positive number")


def require_not_negative(**values: ArrayLike) -> None:
    """Check for finite numbers that are not below 0, alone or in arrays of any shape.

    Raises:
        CleaningError: one is not.
    """
    _require(values, -math.ulp(0.0), "a number that is not negative")


def require_temperature(**values: float) -> None:
    """Check for temperatures in degrees Celsius above absolute zero.

    Raises:
        CleaningError: one is not.
    """
    _require(values, _ABSOLUTE_ZERO_C, f"a temperature above {_ABSOLUTE_ZERO_C:g} degrees C")


def _require(values: Mapping[str, ArrayLike], above: float, what: str) -> None:
    """Refuse the first number that is not finite or not above a bound."""
    for name, value in values.items():
        if isinstance(value, float | int):  # arrays would cost twenty times as much, and most values are numbers
            wrong = () if above < value < math.inf else (float(value),)
        else:
            numbers = np.asarray(value, dtype=np.float64).ravel()
            wrong = numbers[~((numbers > above) & (numbers < math.inf))][:1]
        for each in wrong:
            raise CleaningError(f"{name} must be {what}, not {each:g}")
