"""Dilution of what the wash leaves, by exchanging the liquid over and over; rinse tanks in a row; and drying.

Every board carries the same volume D from one tank to the next: the film on its surfaces and what its gaps hold. In
tank i what it carries approaches the water there, ``b_i = c_i + (b_(i-1) - c_i) exp(-eta N_i)``, with N_i exchanges of
the film; ``b_0`` is the wash bath. With V_i the volume of the tank, F the fresh water for each board, and n boards

    V_i dc_i/dn = D (b_(i-1) - b_i) + F (c_(i+1) - c_i)

where ``c_(i+1)`` of the last tank, or of each one that has a feed of its own, is fresh water. Where exchange is
complete (``b_i = c_i``) and water is pure, the steady state is the closed form of plating shops: with r = F / D and k
tanks, ``c_i / b_0 = (r^(k+1-i) - 1) / (r^(k+1) - 1)`` in counter-current, ``c_i / b_0 = (1 + r)^-i`` with a feed for
each. Volumes do not change: as much leaves with a board as came with it, and nothing evaporates. All that is not
volatile counts as common salt.
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cleaning.errors import require_not_negative, require_positive, require_temperature
from cleaning.gap.edge_segments import EdgePressure
from cleaning.parameters.liquid import (
    density_kg_m3,
    latent_heat_j_kg,
    saturation_pa,
    surface_tension_n_m,
    vapour_diffusivity_m2_s,
    vapour_kg_m3,
    vapour_pressure_pa,
    wet_surface_c,
)
from cleaning.parameters.model import Drying, Liquid, Parameters, Rinse
from cleaning.process.stages import Stage
from cleaning.undersides.residue import GapStage
from geometry.arrays import Scalars

_PURE_WATER_US_CM = 0.055
"""Conductivity of pure water at 25 degrees C: its own ions."""
_SALT_US_CM_PER_G_M3 = 2.16
"""Conductivity that a gram of common salt in a cubic metre of water adds."""


def film_exchanges(rinse: Rinse, volume_mm: float) -> float:
    """How often the film on an exposed surface is renewed by a volume of liquid per area, mm."""
    require_not_negative(volume_mm=volume_mm)
    return 1000.0 * volume_mm / rinse.film_um


def bath_g_m3(liquid: Liquid) -> float:
    """What a bath carries and leaves behind when it dries, from its share of non-volatile residue by weight."""
    return 10.0 * liquid.bath_nvr_pct * liquid.density_kg_m3


def salt_g_m3(resistivity_mohm_cm: float | None) -> float:
    """Ions in water as common salt, from its resistivity; none where it is not stated or above that of pure water."""
    if resistivity_mohm_cm is None:
        return 0.0
    require_positive(resistivity_mohm_cm=resistivity_mohm_cm)
    return max(0.0, (1.0 / resistivity_mohm_cm - _PURE_WATER_US_CM) / _SALT_US_CM_PER_G_M3)


def resistivity_mohm_cm(content_g_m3: float) -> float:
    """Resistivity of water that carries so much common salt; the inverse of ``salt_g_m3``."""
    require_not_negative(content_g_m3=content_g_m3)
    return 1.0 / (_PURE_WATER_US_CM + _SALT_US_CM_PER_G_M3 * content_g_m3)


def water_g_m3(stage: Stage) -> float:
    """What the water of a rinse brings, as common salt: as its tank has it, else as its resistivity states."""
    return salt_g_m3(stage.liquid.resistivity_mohm_cm) if stage.water_g_m3 is None else stage.water_g_m3


def water_resistivity(stage: Stage) -> float | None:
    """Resistivity of the water of a rinse, MOhm cm; ``None`` where nothing states it."""
    return stage.liquid.resistivity_mohm_cm if stage.water_g_m3 is None else resistivity_mohm_cm(stage.water_g_m3)


def diluted_g_m3(rinse: Rinse, before_g_m3: float, exchanges: float, water_g_m3: float) -> float:
    """What is in the liquid after a rinse: what was there beyond what the water brings fades away, exp(-eta N).

    So two rinses one after the other are as good as one of as many exchanges, and none leaves more than was there. Of
    liquid that was purer than the water it is not assumed that it stays so.

    Args:
        rinse: Has the efficiency of an exchange, eta.
        before_g_m3: What was in the liquid.
        exchanges: N.
        water_g_m3: What the water brings.
    """
    require_not_negative(before_g_m3=before_g_m3, exchanges=exchanges, water_g_m3=water_g_m3)
    return water_g_m3 + max(before_g_m3 - water_g_m3, 0.0) * math.exp(-rinse.efficiency * exchanges)


def ionic_ug_cm2(content_g_m3: float, film_um: float) -> float:
    """What stays on a surface when a film on it dries: an index, not a measurement."""
    require_not_negative(content_g_m3=content_g_m3, film_um=film_um)
    return 1e-4 * content_g_m3 * film_um


def gap_content_g_m3(rinse: Rinse, stages: Sequence[Stage], gaps: Sequence[GapStage | None]) -> float:
    """Give what the liquid carries that stays in a gap at the end; nothing where no liquid got in.

    Each wash that enters brings its bath; each rinse that enters dilutes what is there, as often as it may
    be repeated.
    """
    content = 0.0
    for stage, gap in zip(stages, gaps, strict=True):
        if gap is None or not gap.entered:
            continue
        if stage.use == "wash":
            content = bath_g_m3(stage.liquid)
        else:
            content = diluted_g_m3(rinse, content, stage.repeats * gap.exchanges, water_g_m3(stage))
    return content


_LITRE_M3 = 1e-3
_DOUBLINGS = 30
"""Of a count of boards, beyond which it counts as never."""


def first_count(passed: Callable[[int], bool]) -> int | None:
    """Give the first count, from 0, at which something holds that stays so from then on; ``None`` if it never does."""
    if passed(0):
        return 0
    high = next((1 << power for power in range(_DOUBLINGS) if passed(1 << power)), None)
    return None if high is None else bisect_left(range(high), True, key=passed)


@dataclass(frozen=True)
class Cascade:
    """Tanks in the order in which boards pass them, and what one board does to them. SI."""

    solutions: tuple[str, ...]
    volumes_m3: tuple[float, ...]
    fresh_m3: float
    """For each board."""
    counter_current: bool
    """Whether fresh water enters the last tank and overflows to the first; else each tank has so much of its own."""
    fresh_g_m3: tuple[float, ...]
    """What fresh water of each tank brings, and what the tank holds before the first board."""
    carried_m3: float
    """By each board, D."""
    kept: tuple[float, ...]
    """Share of what a board carries beyond a tank's water that is still there when it leaves the tank."""

    def steady_g_m3(self, bath_g_m3: float) -> tuple[float, ...]:
        """Give what the water of each tank settles at while the wash bath stays as it is."""
        require_not_negative(bath_g_m3=bath_g_m3)
        rates, fresh, carried = self._balance
        return _plain(np.asarray(np.linalg.solve(rates, -(fresh + carried * bath_g_m3)), dtype=np.float64))

    def after_g_m3(
        self, boards: int, bath_g_m3: float, kept: float = 1.0, added_g_m3: float = 0.0
    ) -> tuple[float, ...]:
        """Give what the water of each tank carries after so many boards, from fresh water on.

        Args:
            boards: How many.
            bath_g_m3: Of the wash bath at the first board.
            kept: With each board the bath becomes so many times what it was, ...
            added_g_m3: ... and that more; as it is during a board, so it is carried over.
        """
        return _plain(self._at(boards, bath_g_m3, kept, added_g_m3))

    def boards_until(
        self, limit_mohm_cm: float, bath_g_m3: float, kept: float = 1.0, added_g_m3: float = 0.0
    ) -> int | None:
        """Count the boards after which the last tank is below a resistivity for the first time; ``None``: never.

        Holds for a bath that gets no cleaner, so that the tanks do not either.
        """

        def below(boards: int) -> bool:
            content = self._at(boards, bath_g_m3, kept, added_g_m3)[-1]
            return resistivity_mohm_cm(max(float(content), 0.0)) < limit_mohm_cm

        return first_count(below)

    def on_board_g_m3(self, contents_g_m3: Sequence[float], bath_g_m3: float) -> tuple[float, ...]:
        """Give what the liquid on a board carries when it leaves each tank."""
        found: list[float] = []
        for content, kept in zip(contents_g_m3, self.kept, strict=True):
            before = found[-1] if found else bath_g_m3
            found.append(content + (before - content) * kept)
        return tuple(found)

    @cached_property
    def _balance(self) -> tuple[Scalars, Scalars, Scalars]:
        """(k, k) and (k,) and (k,): dc/dn is the first times c, and the second, and the third times the wash bath."""
        count = len(self.solutions)
        boards, bath = np.zeros((count + 1, count)), np.zeros(count + 1)  # b_0 to b_k from c, and from the bath
        bath[0] = 1.0
        for row, kept in enumerate(self.kept):
            boards[row + 1] = kept * boards[row]
            boards[row + 1, row] += 1.0 - kept
            bath[row + 1] = kept * bath[row]
        rates, carried = -self.carried_m3 * np.diff(boards, axis=0), -self.carried_m3 * np.diff(bath)
        fresh = np.zeros(count)
        for row in range(count):
            rates[row, row] -= self.fresh_m3
            if self.counter_current and row + 1 < count:
                rates[row, row + 1] += self.fresh_m3
            else:
                fresh[row] = self.fresh_m3 * self.fresh_g_m3[row]
        volumes = np.array(self.volumes_m3)
        return rates / volumes[:, None], fresh / volumes, carried / volumes

    def _at(self, boards: int, bath_g_m3: float, kept: float, added_g_m3: float) -> Scalars:
        """(k,) contents: one step for a board with the bath as it is, taken as often as there are boards."""
        from scipy.linalg import expm  # takes a fifth of a second, and few processes have tanks

        rates, fresh, carried = self._balance
        count = len(rates)
        step = np.zeros((count + 2, count + 2))  # of the tanks, the bath, and 1
        decay = np.asarray(expm(rates), dtype=np.float64)
        step[:count, :count] = decay
        step[:count, count] = np.linalg.solve(rates, (decay - np.eye(count)) @ carried)
        step[:count, count + 1] = np.linalg.solve(rates, (decay - np.eye(count)) @ fresh)
        step[count, count:] = kept, added_g_m3
        step[count + 1, count + 1] = 1.0
        begin = np.array([*self.fresh_g_m3, bath_g_m3, 1.0])
        return (np.linalg.matrix_power(step, boards) @ begin)[:count]


@dataclass(frozen=True, slots=True)
class TankState:
    """One rinse tank at one moment."""

    solution: str
    volume_m3: float
    content_g_m3: float
    """What its water carries, as common salt."""
    resistivity_mohm_cm: float
    """Of its water."""
    kept: float
    """Share of what a board carries beyond that which is still there when it leaves the tank."""
    on_board_g_m3: float
    """What the liquid on the board carries when it leaves the tank."""


@dataclass(frozen=True, slots=True)
class RinseWater:
    """The tanks of a cascade at one moment, and what a board leaves them with."""

    cascade: Cascade
    bath_g_m3: float
    """What the wash bath carries."""
    contents_g_m3: tuple[float, ...]
    """What the water of each tank carries."""

    @property
    def tanks(self) -> tuple[TankState, ...]:
        """Each tank with what a board leaves it with, in the order in which boards pass them."""
        cascade = self.cascade
        left = cascade.on_board_g_m3(self.contents_g_m3, self.bath_g_m3)
        rows = zip(cascade.solutions, cascade.volumes_m3, cascade.kept, self.contents_g_m3, left, strict=True)
        return tuple(
            TankState(solution, volume, content, resistivity_mohm_cm(content), kept, on_board)
            for solution, volume, kept, content, on_board in rows
        )


def cascade_of(
    parameters: Parameters, stages: Sequence[Stage], landed_mm3: Sequence[float], area_mm2: float, gaps_mm3: float
) -> Cascade | None:
    """Find what one board does to the tanks of a parameter set; ``None`` where it has none or nothing is washed.

    Args:
        parameters: Has the tanks.
        stages: Of the process.
        landed_mm3: On the board in each stage; it exchanges the film as if it were spread evenly.
        area_mm2: Of all its surfaces.
        gaps_mm3: What its gaps hold.
    """
    stated, rinse = parameters.rinse.cascade, parameters.rinse
    if stated is None or not any(stage.use == "wash" for stage in stages):
        return None
    exchanges = dict.fromkeys((tank.solution for tank in stated.tanks), 0.0)
    for stage, landed in zip(stages, landed_mm3, strict=True):
        if stage.use == "rinse" and stage.solution in exchanges:
            exchanges[stage.solution] += stage.repeats * film_exchanges(rinse, landed / area_mm2)
    counter_current = stated.feed == "counter_current"
    liquids = [parameters.liquids[tank.solution] for tank in stated.tanks]
    fresh = [salt_g_m3((liquids[-1] if counter_current else each).resistivity_mohm_cm) for each in liquids]
    return Cascade(
        solutions=tuple(tank.solution for tank in stated.tanks),
        volumes_m3=tuple(_LITRE_M3 * tank.volume_l for tank in stated.tanks),
        fresh_m3=_LITRE_M3 * stated.fresh_l,
        counter_current=counter_current,
        fresh_g_m3=tuple(fresh),
        carried_m3=1e-9 * (area_mm2 * 1e-3 * rinse.final_film_um + gaps_mm3),
        kept=tuple(math.exp(-rinse.efficiency * each) for each in exchanges.values()),
    )


def _plain(values: Scalars) -> tuple[float, ...]:
    return tuple(max(float(each), 0.0) for each in values)  # rounding alone leads below 0


def dry_gap(
    drying: Drying, stages: Sequence[Stage], pressures: Sequence[EdgePressure | None], height_m: float, depth_m: float
) -> tuple[float, float] | None:
    """Blow out and evaporate what the last liquid leaves in a gap.

    Args:
        drying: How.
        stages: Of the process. Its warmest air, or the bake that follows, evaporates.
        pressures: On the edges, one per stage; ``None`` where the stage sprays another side, as good as no pressure.
        height_m: Of the gap.
        depth_m: From its edge to its farthest place.

    Returns:
        The least gap that is blown clear, m (infinite if none is), and how long what stays there takes to evaporate, s.
        ``None`` if the process does not dry, or wets nothing.
    """
    gases = [(stage, pressure) for stage, pressure in zip(stages, pressures, strict=True) if stage.use == "dry"]
    liquids = [stage for stage in stages if stage.use != "dry"]
    if not gases or not liquids:
        return None
    liquid, warmth = liquids[-1].liquid, liquids[-1].temperature_c
    pressed = [each.pressure_pa for _, each in gases if each is not None and len(each.sample)]
    # The highest pressure of one edge over another at one time; suction behind the part is in the coefficient.
    heads = ((values.max(axis=1) - values.min(axis=1).clip(min=0.0)).max() for values in pressed)
    head = float(max(heads, default=0.0))
    least = blow_off_m(drying, surface_tension_n_m(liquid, warmth), head)
    air_c = max(stage.temperature_c for stage, _ in gases) if drying.bake_c is None else drying.bake_c
    density = density_kg_m3(liquid, warmth)
    if height_m >= least:
        return least, film_dry_s(drying, air_c, 1e-6 * drying.residual_film_um, density)
    return least, gap_dry_s(drying, air_c, depth_m, density)


def blow_off_m(drying: Drying, tension_n_m: float, head_pa: float) -> float:
    """Give the least gap height from which a stream of gas drives the liquid; infinite if there is no stream.

    The two ends of a slug hold it back by what their contact angles differ: 2 gamma (cos receding - cos advancing) / h.

    Args:
        drying: Has the angles, and which share of the head is found between two edges of a part.
        tension_n_m: Surface tension of the liquid.
        head_pa: rho U^2 / 2 of the gas at the part; none where it blows from elsewhere.
    """
    require_not_negative(tension_n_m=tension_n_m, head_pa=max(head_pa, 0.0))
    if head_pa <= 0.0:
        return math.inf
    grip = math.cos(math.radians(drying.receding_deg)) - math.cos(math.radians(drying.advancing_deg))
    return max(2.0 * tension_n_m * grip, 0.0) / (drying.pressure_coefficient * head_pa)


def film_dry_s(drying: Drying, air_c: float, film_m: float, liquid_kg_m3: float) -> float:
    """How long a film takes to evaporate from a surface that heated room air is blown on; infinite if it never does.

    Args:
        drying: Has the room's air and the heat transfer.
        air_c: Of the heated air.
        film_m: Thickness.
        liquid_kg_m3: Density of the liquid, which evaporates as water does.
    """
    require_temperature(air_c=air_c)
    require_not_negative(film_m=film_m)
    require_positive(liquid_kg_m3=liquid_kg_m3)
    surface = wet_surface_c(air_c, vapour_pressure_pa(drying.room_c, drying.room_humidity_pct))
    heat = drying.transfer_w_m2_k * (air_c - surface)
    return liquid_kg_m3 * film_m * latent_heat_j_kg(surface) / heat if heat > 0.0 else math.inf


def gap_dry_s(drying: Drying, board_c: float, depth_m: float, liquid_kg_m3: float) -> float:
    """How long a gap full of liquid takes to evaporate through its edge; infinite if it never does.

    The meniscus recedes while vapour diffuses past the emptied part to the edge: t = rho L^2 / (2 D (rho_s - rho_a))
    (Stefan 1873, without the drift of the vapour itself, which only makes it faster).

    Args:
        drying: Has the room's air.
        board_c: Of the board.
        depth_m: From the edge to the farthest place.
        liquid_kg_m3: Density of the liquid, which evaporates as water does.
    """
    require_temperature(board_c=board_c)
    require_not_negative(depth_m=depth_m)
    require_positive(liquid_kg_m3=liquid_kg_m3)
    present = vapour_kg_m3(vapour_pressure_pa(drying.room_c, drying.room_humidity_pct), board_c)
    drive = vapour_kg_m3(saturation_pa(board_c), board_c) - present
    if drive <= 0.0:
        return math.inf
    return liquid_kg_m3 * depth_m**2 / (2.0 * vapour_diffusivity_m2_s(board_c) * drive)
