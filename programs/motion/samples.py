"""The planned motion along a line, at moments of it, and where it is between those."""

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geometry.arrays import Scalars
from geometry.compiled import compiled


@compiled
def interpolate(place: float, places: Scalars, values: Scalars) -> float:
    """Interpolate one value, as ``np.interp`` does to the last digit, in a fifth of its time."""
    last = len(places) - 1
    if place < places[0]:
        return values[0]
    if place >= places[last]:
        return values[last]
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if places[middle] <= place:
            low = middle
        else:
            high = middle
    if places[low] == place:
        return values[low]
    slope = (values[low + 1] - values[low]) / (places[low + 1] - places[low])
    return slope * (place - places[low]) + values[low]


@compiled
def interpolate_rows(targets: Scalars, places: Scalars, rows: Scalars) -> Scalars:
    """Interpolate rows (m, dof) at n places, (n, dof)."""
    found = np.empty((len(targets), rows.shape[1]))
    for at in range(len(targets)):
        for column in range(rows.shape[1]):
            found[at, column] = interpolate(targets[at], places, rows[:, column])
    return found


@dataclass(frozen=True, slots=True, eq=False)
class SampledLine:
    """The planned motion along one line, at m moments from its beginning to its end."""

    seconds: Scalars
    """(m,) since the line's beginning, increasing from 0."""
    shares: Scalars
    """(m,) of the line done, from 0 to 1, not decreasing."""
    joints: Scalars
    """(m, dof) radians or mm; dof is 0 where the joint motion is not known."""
    memo: dict[Hashable, Any] = field(init=False, default_factory=dict[Hashable, Any], repr=False)
    """What was computed from these samples, by what it depends on beside them: a text is written and read several times
    until its speeds are right, and most of its lines stay as they are."""

    def share_at(self, seconds: float) -> float:
        """Share of the line done by then."""
        return interpolate(seconds, self.seconds, self.shares)

    def second_at(self, share: float) -> float:
        """Time at which this share of the line is done."""
        return interpolate(share, self.shares, self.seconds)

    def joints_at(self, share: float) -> tuple[float, ...]:
        """Joints where this share of the line is done; empty if not known."""
        return tuple(interpolate_rows(np.array([share]), self.shares, self.joints)[0].tolist())

    def joints_at_each(self, shares: Scalars) -> Scalars:
        """Joints (n, dof) where n shares of the line are done."""
        return interpolate_rows(shares, self.shares, self.joints)

    def joints_when(self, seconds: Scalars) -> Scalars:
        """Joints (n, dof) at n times."""
        return interpolate_rows(seconds, self.seconds, self.joints)
