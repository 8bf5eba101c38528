"""A glass coupon on two shims above a plate with dyed residue: how much of it a spray leaves, by the model's own laws.

The shims close two sides. The nozzle stands upright beside one of the open sides, its reference azimuth towards the
coupon, and the flow goes straight through to the other: one pressure drop, one shear, one residue everywhere. The
coupon is wet from the beginning, and its residue is too thin to narrow the gap.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cleaning.calibration.measurements import Column, Measurements, read_measurements
from cleaning.film.edge_pressure import PreparedEdges, prepare_edges
from cleaning.gap.edge_segments import Edges
from cleaning.gap.flushing import inertial, lubrication_velocity
from cleaning.jet.jet import Jet, jet_of
from cleaning.parameters.liquid import density_kg_m3, viscosity_pa_s
from cleaning.parameters.model import Liquid, Parameters, Soil
from cleaning.process.stages import Samples, Stage
from cleaning.undersides.residue import removal_rate, softening_rate, step
from geometry.arrays import Indices, Scalars
from recipes.nozzles import Nozzle
from specs.source import Source

_BAR_PA = 1e5
_COUPON_THICK_MM = 1.0
_LEAST_ROWS = 8
_HEIGHT_MM = 50.0
_DISTANCE_MM = 40.0
_SIZE_MM = 25.0


@dataclass(frozen=True, slots=True)
class CouponSetup:
    """With what the coupons were sprayed, and what is known beforehand."""

    nozzle: Nozzle
    liquid: Liquid
    parameters: Parameters


@dataclass(frozen=True)
class Coupons:
    """n measurements on coupons."""

    measurements: Measurements
    setup: CouponSetup

    @cached_property
    def blows(self) -> tuple[list[tuple[float, ...]], Indices]:
        """Distinct pressure, size, height and distance in the order of the file; and which is each row's (n,)."""
        return self.measurements.distinct("pressure_bar", "width_mm", "length_mm", "height_mm", "distance_mm")

    @cached_property
    def baths(self) -> tuple[list[tuple[float, ...]], Indices]:
        """Distinct temperature and concentration, likewise."""
        return self.measurements.distinct("temperature_c", "concentration_pct")

    @property
    def cleaned(self) -> Scalars:
        """(n,) share that was cleaned."""
        return self.measurements.columns["cleaned_fraction"]

    @property
    def between(self) -> NDArray[np.bool_]:
        """(n,) whether a coupon is neither untouched nor clean.

        Nothing is seen below 0 or above 1, so that those at the ends show no scatter: a fit must not count them when
        it judges how large that is.
        """
        return (self.cleaned > 0.0) & (self.cleaned < 1.0)

    @cached_property
    def jets(self) -> list[tuple[Stage, Jet]]:
        """The jet of each blow, the same for those of one pressure and height; it takes some time to find."""
        keys = [(bar, height) for bar, _, _, height, _ in self.blows[0]]
        stages = {key: upright_stage(self.setup.nozzle, self.setup.liquid, *key) for key in dict.fromkeys(keys)}
        found = {key: (stage, jet_of(stage, self.setup.parameters.spray)) for key, stage in stages.items()}
        return [found[key] for key in keys]

    @cached_property
    def _prepared(self) -> list[PreparedEdges]:
        """What presses in each blow, whatever the depth of the puddle: a fit tries hundreds."""
        places = [(width, length, away) for _, width, length, _, away in self.blows[0]]
        edges = {place: _edges(*place) for place in dict.fromkeys(places)}
        film = self.setup.parameters.film
        return [prepare_edges(*jet, edges[place], film) for jet, place in zip(self.jets, places, strict=True)]

    def drop_pa(self, puddle_mm: float) -> Scalars:
        """(n,) pressure of the side before the nozzle less that of the far side, for a depth of the puddle."""
        drops = np.zeros(len(self.blows[0]))
        for index, prepared in enumerate(self._prepared):
            (found,) = prepared.pressures(puddle_mm)
            if len(found.sample):
                drops[index] = float(found.pressure_pa[0, :2].mean() - found.pressure_pa[0, 4:6].mean())
        return drops[self.blows[1]]

    def shear_pa(self, drop_pa: Scalars) -> Scalars:
        """(n,) wall shear in the gap: 6 mu u / h of the flow that viscosity and inertia allow."""
        columns = self.measurements.columns
        height, path = 1e-6 * columns["standoff_um"], 1e-3 * columns["length_mm"]
        loss = self.setup.parameters.gap.entrance_loss
        shear = np.zeros(len(height))
        for index, (celsius, _) in enumerate(self.baths[0]):
            mine = self.baths[1] == index
            viscosity = viscosity_pa_s(self.setup.liquid, celsius)
            density = density_kg_m3(self.setup.liquid, celsius)
            thin = lubrication_velocity(drop_pa[mine], height[mine], path[mine], viscosity)
            speed = inertial(thin, height[mine], path[mine], density, viscosity, loss)
            shear[mine] = 6.0 * viscosity * np.maximum(speed, 0.0) / height[mine]
        return shear

    def predict(self, soil: Soil, shear_pa: Scalars) -> Scalars:
        """(n,) predicted share that is cleaned."""
        each = [softening_rate(soil, celsius, percent) for celsius, percent in self.baths[0]]
        softening = np.array(each, dtype=np.float64)[self.baths[1]]
        hard, soft = step(1.0, 0.0, softening, removal_rate(soil, shear_pa), self.measurements.columns["time_s"])
        return 1.0 - hard - soft


def read_coupons(path: Path, setup: CouponSetup) -> Coupons:
    """Read measurements on coupons.

    Raises:
        CleaningError: they cannot be used; the message names the line.
    """
    measurements = read_measurements(path, _columns(setup.liquid), _LEAST_ROWS)
    measurements.require_variation("time_s", "measure at two times at least, or no rate can be fitted")
    apart = "measure at two temperatures at least, some 10 °C apart, for the activation"
    measurements.require_variation("temperature_c", apart)
    measurements.require_variation("cleaned_fraction", "nothing changed, so that nothing can be fitted")
    coupons = Coupons(measurements, setup)
    between = int(coupons.between.sum())
    if between < _LEAST_ROWS:
        message = f"{between} rows lie between 0 and 1; {_LEAST_ROWS} are needed. Try times between"
        raise measurements.error(message, "cleaned_fraction")
    return coupons


def _columns(liquid: Liquid) -> Mapping[str, Column]:
    return {
        "standoff_um": Column(1.0, 1000.0),
        "time_s": Column(0.1, 1e5),
        "temperature_c": Column(1.0, 99.0),
        "pressure_bar": Column(0.01, 100.0),
        "cleaned_fraction": Column(0.0, 1.0),
        "width_mm": Column(1.0, 200.0, default=_SIZE_MM),
        "length_mm": Column(1.0, 200.0, default=_SIZE_MM),
        "concentration_pct": Column(0.01, 100.0, default=liquid.concentration_pct),
        "height_mm": Column(5.0, 500.0, default=_HEIGHT_MM),
        "distance_mm": Column(1.0, 500.0, default=_DISTANCE_MM),
    }


def _edges(width_mm: float, length_mm: float, distance_mm: float) -> Edges:
    """The eight edge segments of a coupon whose front side faces the nozzle at the origin, from -y."""
    quarter, near, far = 0.25 * width_mm, distance_mm, distance_mm + length_mm
    places = [(-quarter, near), (quarter, near)]
    places += [(2 * quarter, near + 0.25 * length_mm), (2 * quarter, near + 0.75 * length_mm)]
    places += [(quarter, far), (-quarter, far)]
    places += [(-2 * quarter, near + 0.75 * length_mm), (-2 * quarter, near + 0.25 * length_mm)]
    outward = np.repeat([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]], 2, axis=0)
    return Edges(
        component=np.zeros(1, dtype=np.int64),
        middles=np.array([[[x, y, 0.0] for x, y in places]]),
        outward=outward[None],
        heights_mm=np.array([_COUPON_THICK_MM]),
        sheltered=np.full((1, 8), np.inf),
        facing=np.ones(1),
    )


def upright_stage(nozzle: Nozzle, liquid: Liquid, pressure_bar: float, height_mm: float) -> Stage:
    """Stage of a nozzle that sprays for a second over the origin, upright, its reference azimuth towards +y."""
    axes = np.array([[[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]])
    source, tcp = Source(entry="coupon"), np.array([[0.0, 0.0, height_mm]])
    samples = Samples(np.zeros(1), np.ones(1), tcp, axes, np.zeros(1, dtype=np.int64), (source,))
    return Stage(
        made_by=source,
        function="clean",
        use="wash",
        nozzle_name="coupon",
        nozzle=nozzle,
        solution="coupon",
        liquid=liquid,
        pressure_pa=_BAR_PA * pressure_bar,
        temperature_c=60.0,
        begin_s=0.0,
        end_s=1.0,
        samples=samples,
    )
