"""What is compared with what others published: each quantity with the columns of its table and its prediction.

Predictions are made by the functions that an analysis uses, with the default parameter set.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from cleaning.calibration.coupon import Coupons, CouponSetup, upright_stage
from cleaning.calibration.fitted_files import choose_nozzle
from cleaning.calibration.measurements import Column, Measurements
from cleaning.errors import CleaningError
from cleaning.film.film import REACH, farthest, rim_of
from cleaning.gap.joint_lattice import post_factor
from cleaning.jet.jet import jet_of, liquid_speed_m_s
from cleaning.parameters.liquid import (
    air_density_kg_m3,
    saturation_pa,
    vapour_kg_m3,
    vapour_pressure_pa,
    water_surface_tension_n_m,
)
from cleaning.parameters.model import Liquid, Parameters, Soil
from cleaning.undersides.residue import removal_rate, softening_rate, step
from cleaning.undersides.rinse import blow_off_m, gap_dry_s
from geometry.arrays import Scalars
from recipes.footprint import plate_profile
from recipes.nozzles import FullCone, Radial

LABEL = "label"
"""Column with the name of each row."""
_STANDOFF_MM = 50.0
"""From which a coherent jet falls: it stays as wide as it is."""
_WATER_KG_M3 = 1000.0
_BAR_PA = 1e5
_FINE = 4001
_STAGES = 2000
QuantityName: TypeAlias = Literal[
    "film_end", "half_flow_radius", "jet_speed", "post_permeability", "removed", "rate_ratio", "residue_ratio",
    "gap_drying", "blow_off_gap", "vapour", "removal_stages", "cleaned_width",
]  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """n rows of a table."""

    labels: tuple[str, ...]
    columns: Mapping[str, Scalars]
    """(n,) each; those that the reference states for all rows too."""
    published: Scalars
    """(n,) NaN where a cell is blank."""
    error: Callable[[str], CleaningError]
    """Makes the error of the whole table."""


class Compared(NamedTuple):
    """Rows with what is predicted for them; (n,) each, NaN where the model predicts nothing."""

    rows: Rows
    predicted: Scalars
    low: Scalars
    high: Scalars


Prediction: TypeAlias = Callable[[Rows, Parameters], Compared]


@dataclass(frozen=True, slots=True)
class Quantity:
    """One quantity that the model predicts."""

    words: str
    """What it is, with its unit."""
    published: str
    """Column of what was published."""
    columns: Mapping[str, Column]
    """Of the conditions."""
    compare: Prediction


def _plain(rows: Rows, predicted: Scalars, ends: tuple[Scalars, Scalars] | None = None) -> Compared:
    low, high = (predicted, predicted) if ends is None else ends
    return Compared(rows, predicted, low, high)


def _each(rows: Rows, predict: Callable[..., float], *names: str) -> Compared:
    """Predict row by row from the named columns."""
    table = zip(*(rows.columns[name].tolist() for name in names), strict=True)
    return _plain(rows, np.array([predict(*row) for row in table], dtype=np.float64))


def _film_end(rows: Rows, parameters: Parameters) -> Compared:
    """Radius to which the film of a coherent jet presses; the jet is a full cone as narrow as the jet is at a plate."""

    def predict(nozzle_mm: float, flow_g_s: float, viscosity_mpa_s: float, tension_mn_m: float, theta: float) -> float:
        area_m2 = math.pi / 4.0 * (1e-3 * nozzle_mm) ** 2
        speed_m_s = 1e-3 * flow_g_s / _WATER_KG_M3 / area_m2
        bar = 0.5 * _WATER_KG_M3 * (speed_m_s / parameters.spray.discharge) ** 2 / _BAR_PA
        angle = math.degrees(math.atan2(0.5 * nozzle_mm, _STANDOFF_MM))
        nozzle = FullCone(half_angle_deg=angle, flow_lpm=60.0 * flow_g_s / _WATER_KG_M3, at_bar=bar)
        liquid = Liquid(
            use="wash",
            concentration_pct=100.0,
            viscosity_mpa_s=viscosity_mpa_s,
            surface_tension_mn_m=tension_mn_m,
            contact_board_deg=theta,
        )
        jet = jet_of(upright_stage(nozzle, liquid, bar, _STANDOFF_MM), parameters.spray)
        return REACH * farthest(rim_of(jet, parameters.film), _STANDOFF_MM, 1.0)

    names = "nozzle_mm", "flow_g_s", "viscosity_mpa_s", "surface_tension_mn_m", "contact_deg"
    return _each(rows, predict, *names)


def _half_flow_radius(rows: Rows, _: Parameters) -> Compared:
    """Radius within which half of the flow lands: the pattern of the least height, as a recipe has it, at others."""
    heights = rows.columns["height_mm"]
    sheets = {height: _profile(rows, height) for height in np.unique(heights).tolist()}
    first = min(sheets)
    radius, flux = sheets[first]
    nozzle = Radial(
        flow_lpm=1.0,
        radius_mm=float(radius[-1]),
        at_mm=first,
        profile=list(zip(radius.tolist(), flux.tolist(), strict=True)),
    )
    slope, shape = plate_profile(nozzle, _FINE)
    others = [height for height in sheets if height > first]
    measured = np.array([_half_radius(*sheets[height]) for height in others], dtype=np.float64)
    predicted = np.array([_half_radius(height * slope, shape) for height in others], dtype=np.float64)
    columns = {"height_mm": np.array(others, dtype=np.float64)}
    labels = tuple(f"{height:g} mm, from {first:g} mm" for height in others)
    return _plain(Rows(labels, columns, measured, rows.error), predicted)


def _profile(rows: Rows, height_mm: float) -> tuple[Scalars, Scalars]:
    """Radii and flux of one sheet, from the axis outwards.

    Raises:
        CleaningError: it does not begin at the axis.
    """
    here = np.flatnonzero(rows.columns["height_mm"] == height_mm)
    radius = rows.columns["radius_mm"][here]
    order = np.argsort(radius, kind="stable")
    if len(here) < 2 or radius[order[0]] != 0.0 or (np.diff(radius[order]) <= 0.0).any():
        raise rows.error(f"the sheet at {height_mm:g} mm needs radii from 0 outwards, each once")
    return radius[order], rows.published[here][order]


def _half_radius(radius_mm: Scalars, flux: Scalars) -> float:
    fine = np.linspace(0.0, float(radius_mm[-1]), _FINE)
    ring = fine * np.interp(fine, radius_mm, flux)
    landed = np.concatenate([[0.0], np.cumsum(ring[1:] + ring[:-1])])
    return float(np.interp(0.5 * landed[-1], landed, fine))


def _jet_speed(rows: Rows, parameters: Parameters) -> Compared:
    """Speed with which an analysis lets the liquid arrive."""

    def speed(bar: float) -> float:
        return liquid_speed_m_s(bar * _BAR_PA, _WATER_KG_M3, parameters.spray.discharge)

    return _each(rows, speed, "pressure_bar")


def _post_permeability(rows: Rows, _: Parameters) -> Compared:
    columns = rows.columns
    return _plain(rows, post_factor(columns["diameter_um"], columns["pitch_um"], columns["depth_um"]))


def _removed(rows: Rows, parameters: Parameters) -> Compared:
    """Per cent that leaves an exposed coupon, over the range of softening and of shear that are stated."""
    soil, columns = parameters.soil, rows.columns
    factor = parameters.known("soil.k1_per_s").within_factor or 1.0

    def removed(k1: float, shear_pa: Scalars) -> Scalars:
        rates = np.array(
            [k1 * softening_rate(soil, celsius, soil.reference_pct) for celsius in columns["temperature_c"]]
        )
        hard, soft = step(1.0, 0.0, rates, removal_rate(soil, shear_pa), columns["time_s"])
        return 100.0 * (1.0 - hard - soft)

    least, most = columns["least_shear_pa"], columns["most_shear_pa"]
    ends = removed(1.0 / factor, least), removed(factor, most)
    return _plain(rows, removed(1.0, np.sqrt(least * most)), ends)


def _rate_ratio(rows: Rows, parameters: Parameters) -> Compared:
    """Rate of softening at the warmer over that at the cooler temperature; range by that of the activation."""
    factor = parameters.known("soil.activation_kj_mol").within_factor or 1.0
    columns = rows.columns

    def ratio(scale: float) -> Scalars:
        energy = scale * parameters.soil.activation_kj_mol
        soil = parameters.soil.model_copy(update={"activation_kj_mol": energy})
        pairs = zip(columns["warm_c"].tolist(), columns["cool_c"].tolist(), strict=True)
        found = [softening_rate(soil, warm, 1.0) / softening_rate(soil, cool, 1.0) for warm, cool in pairs]
        return np.array(found, dtype=np.float64)

    return _plain(rows, ratio(1.0), (ratio(1.0 / factor), ratio(factor)))


_LEVERS = ("standoff_um", "time_s", "temperature_c", "pressure_bar", "concentration_pct")
_PUMP = "pump_power"
"""Lever that trades flow for pressure; its values are pressures."""
_COUPON = {
    "standoff_um": Column(1.0, 1000.0),
    "time_s": Column(0.1, 1e5),
    "temperature_c": Column(1.0, 99.0),
    "pressure_bar": Column(0.01, 100.0),
    "concentration_pct": Column(0.01, 100.0),
    "height_mm": Column(5.0, 500.0),
    "distance_mm": Column(1.0, 500.0),
    "size_mm": Column(1.0, 200.0),
}


def _residue_ratio(rows: Rows, parameters: Parameters) -> Compared:
    """How many times less residue a glass coupon keeps when one lever, the label, goes from one value to another."""
    unknown = [label for label in rows.labels if label not in (*_LEVERS, _PUMP)]
    if unknown:
        raise rows.error(f"no lever {unknown[0]!r}; it has {', '.join((*_LEVERS, _PUMP))}")
    found: list[float] = []
    for at, lever in enumerate(rows.labels):
        base = {name: float(column[at]) for name, column in rows.columns.items()}
        before, after = (_coupon_residue(base, lever, base[end], parameters) for end in ("from", "to"))
        found.append(before / max(after, 1e-300))
    return _plain(rows, np.array(found, dtype=np.float64))


def _coupon_residue(base: Mapping[str, float], lever: str, value: float, parameters: Parameters) -> float:
    """Share that a coupon keeps, the nozzle and solution those of the library's default recipe and set."""
    nozzle = choose_nozzle("smt-aqueous", None)[1]
    if lever == _PUMP:  # flow times pressure stays
        flow = nozzle.flow_lpm * base["pressure_bar"] / nozzle.at_bar
        nozzle = nozzle.model_copy(update={"at_bar": value, "flow_lpm": flow * base["pressure_bar"] / value})
    stated = {**base, ("pressure_bar" if lever == _PUMP else lever): value}
    names = {**{name: name for name in _COUPON if name != "size_mm"}, "width_mm": "size_mm", "length_mm": "size_mm"}
    columns: dict[str, Scalars] = {name: np.array([stated[key]], dtype=np.float64) for name, key in names.items()}
    columns["cleaned_fraction"] = np.zeros(1)
    setup = CouponSetup(nozzle, parameters.liquids["saponifier-15"], parameters)
    coupons = Coupons(Measurements(Path(), "", False, columns, np.zeros(1, dtype=np.int64), 0), setup)
    shear = coupons.shear_pa(coupons.drop_pa(parameters.film.puddle_mm))
    return 1.0 - float(coupons.predict(parameters.soil, shear)[0])


def _gap_drying(rows: Rows, parameters: Parameters) -> Compared:
    def minutes(board_c: float, depth_mm: float) -> float:
        return gap_dry_s(parameters.drying, board_c, 1e-3 * depth_mm, _WATER_KG_M3) / 60.0

    return _each(rows, minutes, "board_c", "depth_mm")


def _blow_off_gap(rows: Rows, parameters: Parameters) -> Compared:
    def least_um(speed_m_s: float, air_c: float) -> float:
        head = 0.5 * air_density_kg_m3(air_c) * speed_m_s**2
        return 1e6 * blow_off_m(parameters.drying, water_surface_tension_n_m(air_c), head)

    return _each(rows, least_um, "speed_m_s", "air_c")


def _vapour(rows: Rows, _: Parameters) -> Compared:
    """Vapour that air can still take, over a density."""

    def deficit(air_c: float, humidity_pct: float, density_kg_m3: float) -> float:
        present = vapour_pressure_pa(air_c, humidity_pct)
        return vapour_kg_m3(saturation_pa(air_c) - present, air_c) / density_kg_m3

    return _each(rows, deficit, "air_c", "humidity_pct", "density_kg_m3")


_FEATURES = ("first over fastest", "last over fastest", "fastest at half the shear over fastest")


def _removal_stages(rows: Rows, parameters: Parameters) -> Compared:
    """Relative rates at which residue leaves a sheared surface: at first, at last, and what shear does to them."""
    unknown = [label for label in rows.labels if label not in _FEATURES]
    if unknown:
        raise rows.error(f"no feature {unknown[0]!r}; it has {', '.join(_FEATURES)}")

    def predict(at: int) -> float:
        celsius, shear = float(rows.columns["temperature_c"][at]), float(rows.columns["shear_pa"][at])
        rates, slower = (_removal_rates(parameters.soil, celsius, each) for each in (shear, 0.5 * shear))
        fastest = float(rates.max())
        values = float(rates[0]), float(rates[-1]), float(slower.max())
        return values[_FEATURES.index(rows.labels[at])] / fastest

    return _plain(rows, np.array([predict(at) for at in range(len(rows.labels))], dtype=np.float64))


def _removal_rates(soil: Soil, celsius: float, shear_pa: float) -> Scalars:
    """(n,) -d ln(residue) / dt, 1/s, from the beginning until a millionth is left."""
    k1 = softening_rate(soil, celsius, soil.reference_pct)
    k2 = float(removal_rate(soil, np.array([shear_pa]))[0])
    times: Scalars = np.linspace(0.0, 14.0 * (1.0 / k1 + 1.0 / max(k2, 1e-9)), _STAGES, dtype=np.float64)
    hard, soft = step(1.0, 0.0, k1, k2, times)
    logs = np.log(np.maximum(hard + soft, 1e-12))
    kept = hard + soft > 1e-6
    return -np.diff(logs[kept]) / np.diff(times[kept])


def _nothing(rows: Rows, _: Parameters) -> Compared:
    """The model has no law for it."""
    return _plain(rows, np.full(len(rows.labels), np.nan))


_CELSIUS = Column(-50.0, 300.0)
_UM = Column(1e-3, 1e6)
_ANY = Column(0.0, 1e6)
QUANTITIES: dict[QuantityName, Quantity] = {
    "film_end": Quantity(
        "radius at which the film after a jet ends, mm",
        "end_mm",
        {
            "nozzle_mm": Column(0.1, 50.0),
            "flow_g_s": Column(0.01, 10_000.0),
            "viscosity_mpa_s": Column(0.01, 1000.0),
            "surface_tension_mn_m": Column(1.0, 200.0),
            "contact_deg": Column(1.0, 179.0),
        },
        _film_end,
    ),
    "half_flow_radius": Quantity(
        "radius within which half of the flow lands, mm",
        "flux_kg_m2_s",
        {"height_mm": Column(1.0, 1000.0), "radius_mm": Column(0.0, 2000.0)},
        _half_flow_radius,
    ),
    "jet_speed": Quantity(
        "speed at which the spray arrives, m/s",
        "speed_m_s",
        {
            "height_mm": Column(1.0, 10_000.0),
            "radius_mm": Column(0.0, 2000.0),
            "diameter_um": Column(0.1, 10_000.0),
            "pressure_bar": Column(0.01, 1000.0),
        },
        _jet_speed,
    ),
    "post_permeability": Quantity(
        "flow through a gap with posts over that without",
        "flow_share",
        {"diameter_um": _UM, "pitch_um": _UM, "depth_um": _UM},
        _post_permeability,
    ),
    "removed": Quantity(
        "residue removed from an exposed coupon, %",
        "removed_pct",
        {
            "time_s": Column(0.1, 1e5),
            "temperature_c": Column(1.0, 99.0),
            "least_shear_pa": Column(0.0, 1e6),
            "most_shear_pa": Column(0.0, 1e6),
        },
        _removed,
    ),
    "rate_ratio": Quantity(
        "rate when warm over rate when cool", "rate_ratio", {"warm_c": _CELSIUS, "cool_c": _CELSIUS}, _rate_ratio
    ),
    "residue_ratio": Quantity(
        "residue before a change over residue after it",
        "times_less",
        {**_COUPON, "from": Column(0.0, 1e6), "to": Column(0.0, 1e6)},
        _residue_ratio,
    ),
    "gap_drying": Quantity(
        "time until a gap is dry, min", "minutes", {"board_c": _CELSIUS, "depth_mm": Column(0.01, 1000.0)}, _gap_drying
    ),
    "blow_off_gap": Quantity(
        "least gap that air blows clear, µm",
        "gap_um",
        {"speed_m_s": Column(0.1, 340.0), "air_c": _CELSIUS},
        _blow_off_gap,
    ),
    "vapour": Quantity(
        "vapour that air can take, kg/m³, over a density",
        "deficit",
        {"air_c": _CELSIUS, "humidity_pct": Column(0.0, 100.0), "density_kg_m3": Column(1e-3, 1e5)},
        _vapour,
    ),
    "removal_stages": Quantity(
        "rates of removal over one another",
        "at_most",
        {"temperature_c": Column(1.0, 99.0), "shear_pa": Column(1e-3, 1e6)},
        _removal_stages,
    ),
    "cleaned_width": Quantity(
        "width that a jet cleans, over that of the first row",
        "width",
        {"time_s": _ANY, "speed_mm_s": _ANY},
        _nothing,
    ),
}
"""By name."""
if set(QUANTITIES) != set(get_args(QuantityName)):
    raise AssertionError("every quantity needs its prediction")
