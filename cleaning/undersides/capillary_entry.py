"""Whether a liquid gets into a gap: the pressure that is held at its edges, and what the gap itself does."""

import numpy as np
from numpy.typing import NDArray

from cleaning.gap.edge_segments import SEGMENTS, EdgePressure
from cleaning.process.stages import Stage
from geometry.arrays import Indices, Scalars
from geometry.compiled import compiled

_TOGETHER_S = 1e-6


def entry_margin(pressure: EdgePressure, stage: Stage, capillary_pa: float, hold_s: float) -> tuple[float, int]:
    """Find what is left of the held edge pressure after the gap has taken or given its share, and when it first is.

    A pressure is held if one segment feels no less of it in samples that follow each other without a pause and last
    ``hold_s`` together; a sample that lasts so long by itself will do. Where the film has come at all, it lies at the
    edge with no pressure at least, and a gap that draws liquid in needs no more than that. A component that no film
    reaches (it has no samples) stays dry however its gap draws.

    Args:
        pressure: Of one component in the stage.
        stage: Times the samples.
        capillary_pa: Capillary pressure at the open height h (1 - f).
        hold_s: How long a pressure must be held.

    Returns:
        The margin in Pa, and the first row of ``pressure`` at which the gap is open; -1 where it stays dry. Without
        samples the margin is at most 0.
    """
    if not len(pressure.sample):
        return min(capillary_pa, 0.0), -1
    times, seconds = stage.samples.times[pressure.sample], stage.samples.seconds[pressure.sample]
    broken = np.append(True, ~_follows(pressure.sample, times, seconds))
    held = np.asarray(_held(np.ascontiguousarray(pressure.pressure_pa), seconds, broken, hold_s), dtype=np.float64)
    margins = np.maximum(held, 0.0) + capillary_pa
    opened = np.flatnonzero(margins >= 0.0)
    return float(margins.max()), int(opened[0]) if len(opened) else -1


def _follows(sample: Indices, times: Scalars, seconds: Scalars) -> NDArray[np.bool_]:
    """(k - 1,) whether each sample after the first begins where the one before it ends."""
    apart = np.diff(times) - 0.5 * (seconds[1:] + seconds[:-1])
    return (np.diff(sample) == 1) & (apart <= _TOGETHER_S)


@compiled
def _held(pressure: NDArray[np.float64], seconds: Scalars, broken: NDArray[np.bool_], hold_s: float) -> Scalars:
    """(k,) highest pressure of any segment that has been held when each sample ends; minus infinity before any is."""
    held = np.full(len(seconds), -np.inf)
    for last in range(len(seconds)):
        least = np.full(SEGMENTS, np.inf)
        lasted = 0.0
        for at in range(last, -1, -1):
            for segment in range(SEGMENTS):
                least[segment] = min(least[segment], pressure[at, segment])
            lasted += seconds[at]
            if lasted >= hold_s - _TOGETHER_S:
                held[last] = least.max()
                break
            if broken[at]:
                break
    return held
