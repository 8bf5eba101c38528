"""Fitting the kinetics of the residue, and the depth of the puddle at an edge, to coupons.

Least squares in the logarithms of the parameters on the model that the analysis uses, with profile-likelihood
intervals. What the coupons do not determine is left at what was known before.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cleaning.calibration.confidence import Estimate, Fit, correlations, highest_squares, profile_end
from cleaning.calibration.coupon import Coupons, CouponSetup, read_coupons
from cleaning.parameters.model import Film, Soil
from geometry.arrays import Scalars
from specs.progress import Progress, no_progress

FITTED: tuple[str, ...] = ("soil.k1_per_s", "soil.activation_kj_mol", "soil.k_m_per_s", "film.puddle_mm")
"""What is fitted, by path; what the data do not determine is given up from the end."""
_FARTHEST = math.log(1000.0)
"""How far from what was known before is searched, either way."""
_WIDEST = math.log(10.0)
"""An interval over more than a factor of ten means that the data do not determine the parameter."""
_STARTS = {"soil.k1_per_s": (0.0, -1.2, 1.2), "soil.k_m_per_s": (0.0, -2.3, 2.3)}
_ROUNDS = 5
_USUAL_FITS = 110
"""With the intervals of four parameters; for the share done."""
_PRECISION = 1e-3
"""No fraction is measured better: fits that leave less are taken to leave this."""
_ALIKE = 0.98
"""Parameters that are more strongly correlated than this cannot be fitted apart."""


@dataclass(frozen=True, slots=True)
class Undetermined:
    """A parameter that the coupons do not determine."""

    low: float
    """Least value that they allow; 0 where there is none."""
    high: float
    """Greatest; infinite where there is none."""
    kept: float
    """What was known before, and is kept."""


@dataclass(frozen=True, slots=True, eq=False)
class GapFit:
    """Fitted kinetics."""

    coupons: Coupons
    estimates: Mapping[str, Estimate]
    """By path."""
    undetermined: Mapping[str, Undetermined]
    """By path."""
    soil: Soil
    film: Film
    predicted: Scalars
    """(n,) cleaned fractions."""

    @property
    def rms(self) -> float:
        """Root mean square of what the fit leaves of the cleaned fractions."""
        return float(np.sqrt(np.mean((self.predicted - self.coupons.cleaned) ** 2)))


def calibrate_gap(path: Path, setup: CouponSetup, progress: Progress = no_progress) -> GapFit:
    """Fit the softening and its activation energy, the removal and the puddle depth to a table of coupons.

    Args:
        path: CSV of standoff, time, temperature, pressure and cleaned fraction.
        setup: With what they were sprayed; its parameters are where the fit begins.
        progress: Receives the stage and the share done, which is estimated.

    Raises:
        CleaningError: the table cannot be used.
    """
    coupons = read_coupons(path, setup)
    model = _Model(coupons, progress)
    if not model.drives():
        raise coupons.measurements.error("the film does not reach the coupon; check nozzle, height_mm and distance_mm")
    found = _fit_determined(model)
    for _ in range(_ROUNDS):  # again where the fitted puddle lifts other coupons above the threshold of the shear
        if not model.moves_threshold(found.logs):
            break
        found = _fit_determined(model)
    if not found.logs:
        message = "these coupons determine nothing: any rate fits them. Vary time, standoff and pressure more"
        raise coupons.measurements.error(message)
    estimates = {name: model.estimate(name, log, found.intervals[name]) for name, log in found.logs.items()}
    soil, film = model.changed({name: estimate.value for name, estimate in estimates.items()})
    predicted = coupons.predict(soil, coupons.shear_pa(coupons.drop_pa(film.puddle_mm)))
    return GapFit(coupons, estimates, found.undetermined, soil, film, predicted)


@dataclass(frozen=True, slots=True)
class _Determined:
    """What the data determine: logarithms over what was known before."""

    logs: Mapping[str, float]
    intervals: Mapping[str, tuple[float, float]]
    undetermined: Mapping[str, Undetermined]


def _fit_determined(model: "_Model") -> _Determined:
    """Give up parameters, the last first, until the data determine all that are left; then find their intervals."""
    free, undetermined = list(FITTED), dict[str, Undetermined]()
    starts = model.starts(free)
    while free:
        fit = model.fit(free, starts)
        intervals: dict[str, tuple[float, float]] = {}
        # The last parameter that makes no difference, or none that another one would not make as well.
        related = np.flatnonzero(np.triu(correlations(fit), 1).max(axis=0) > _ALIKE)
        vague = int(related[-1]) if related.size else None
        if vague is None:
            intervals = {name: model.profile(free, index, fit) for index, name in enumerate(free)}
            wide = [index for index, (low, high) in enumerate(intervals.values()) if high - low > _WIDEST]
            vague = wide[-1] if wide else None
        if vague is None:
            return _Determined(dict(zip(free, fit.parameters.tolist(), strict=True)), intervals, undetermined)
        name = free.pop(vague)
        starts = [np.delete(fit.parameters, vague), np.zeros(len(free))]
        bounds = model.estimate(name, 0.0, intervals.get(name, (-math.inf, math.inf)))
        undetermined[name] = Undetermined(bounds.low, bounds.high, model.known(name))
    return _Determined({}, {}, undetermined)


class _Model:
    """The sum of squares as a function of the logarithms of parameters over what was known of them before.

    Which coupons are above the threshold of the shear is held while a fit goes on: at the jump nothing is smooth, and
    where exactly it lies is not known so well that a puddle depth could be fitted to it.
    """

    def __init__(self, coupons: Coupons, progress: Progress) -> None:
        self._coupons = coupons
        self._progress, self._solved = progress, 0
        parameters = coupons.setup.parameters
        self._soil, self._film = parameters.soil, parameters.film
        self.prior = {
            "soil.k1_per_s": self._soil.k1_per_s,
            "soil.activation_kj_mol": max(self._soil.activation_kj_mol, 1.0),
            "soil.k_m_per_s": max(self._soil.k_m_per_s, 1e-3),
            "film.puddle_mm": self._film.puddle_mm,
        }
        self._shear = lru_cache(maxsize=4096)(self._shear_at)
        self._flushed = self._above(self._film.puddle_mm)

    def drives(self) -> bool:
        """Whether any coupon is flown through."""
        return bool((self._shear_at(self._film.puddle_mm) > 0.0).any())

    def moves_threshold(self, ratios: Mapping[str, float]) -> bool:
        """Take the coupons above the threshold at a fit for those of the next; whether they are others."""
        before = self._flushed
        self._flushed = self._above(self._film.puddle_mm * math.exp(ratios.get("film.puddle_mm", 0.0)))
        return bool((before != self._flushed).any())

    def estimate(self, name: str, log: float, interval: tuple[float, float]) -> Estimate:
        """Turn logarithms over what was known before into values."""
        value, low, high = (math.exp(each) * self.prior[name] for each in (log, *interval))
        return Estimate(value, low, high)

    def changed(self, values: Mapping[str, float]) -> tuple[Soil, Film]:
        """Put values in, by path."""
        parts = {"soil": dict[str, float](), "film": dict[str, float]()}
        for name, value in values.items():
            block, _, key = name.partition(".")
            parts[block][key] = value
        return self._soil.model_copy(update=parts["soil"]), self._film.model_copy(update=parts["film"])

    def known(self, name: str) -> float:
        """Give what was known of a parameter before."""
        block, _, key = name.partition(".")
        return float(getattr(self._soil if block == "soil" else self._film, key))

    def fit(self, free: list[str], starts: list[Scalars]) -> Fit:
        """Fit some parameters, the others as known before."""
        fits = [self._solve(free, start, {}) for start in starts]
        return fits[int(np.argmin([round(fit.squares, 12) for fit in fits]))]

    def profile(self, free: list[str], index: int, best: Fit) -> tuple[float, float]:
        """Give the interval of one parameter: logarithms over what was known before."""
        others = [each for each in free if each != free[index]]
        start = np.delete(best.parameters, index)

        def squares_at(value: float) -> float:
            return self._solve(others, start, {free[index]: value}).squares

        floor = best.freedom * _PRECISION**2
        most = highest_squares(max(best.squares, floor), best.freedom)
        middle = float(best.parameters[index])
        low, high = (profile_end(squares_at, middle, side * _FARTHEST, most) for side in (-1.0, 1.0))
        return low, high

    def starts(self, free: list[str]) -> list[Scalars]:
        """Give places from which to search: rates that are slower, as known before, or faster."""
        grids = np.meshgrid(*(_STARTS.get(name, (0.0,)) for name in free), indexing="ij")
        return list(np.column_stack([grid.ravel() for grid in grids]).astype(np.float64))

    def _solve(self, free: list[str], start: Scalars, fixed: Mapping[str, float]) -> Fit:
        from scipy.optimize import least_squares

        def residuals(logs: Scalars) -> Scalars:
            ratios = {**fixed, **dict(zip(free, logs.tolist(), strict=True))}
            values = {name: self.prior[name] * math.exp(ratio) for name, ratio in ratios.items()}
            soil, film = self.changed({**values, "soil.shear_threshold_pa": 0.0})
            shear = np.where(self._flushed, self._shear(film.puddle_mm), 0.0)
            return self._coupons.predict(soil, shear) - self._coupons.cleaned

        freedom = int(self._coupons.between.sum()) - len(free) - len(fixed)
        if not free:
            left = residuals(start)
            return Fit(start, float(left @ left), freedom, np.zeros((len(left), 0)))
        first = np.clip(start, -_FARTHEST, _FARTHEST)
        self._solved += 1
        self._progress("fitting the kinetics", min(self._solved / _USUAL_FITS, 0.99))
        found = least_squares(residuals, first, bounds=(-_FARTHEST - 0.1, _FARTHEST + 0.1))
        return Fit(np.asarray(found.x, dtype=np.float64), 2.0 * float(found.cost), freedom, np.asarray(found.jac))

    def _above(self, puddle_mm: float) -> NDArray[np.bool_]:
        return self._shear_at(puddle_mm) > self._soil.shear_threshold_pa

    def _shear_at(self, puddle_mm: float) -> Scalars:
        film = self._film.model_copy(update={"puddle_mm": puddle_mm})
        return self._coupons.shear_pa(self._coupons.drop_pa(film.puddle_mm))
