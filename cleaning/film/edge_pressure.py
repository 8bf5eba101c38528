"""Pressure on the edge segments of components while a jet passes: its own stress, and the film that it drives."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cleaning.film.film import REACH, Rim, farthest, film_around, film_momentum, rim_of
from cleaning.gap.edge_segments import SEGMENTS, EdgePressure, Edges
from cleaning.jet.compiled_jet import KNIFE, RING, ROUND, TAIL_SIGMAS, JetForm, misses, profile, ray_to, stress_factor
from cleaning.jet.jet import Jet
from cleaning.parameters.model import Film
from cleaning.process.stages import Stage
from geometry.arrays import Directions, Indices, Points, Scalars
from geometry.compiled import inlined, quick
from geometry.disc_grid import DiscGrid, build_disc_grid


class _Air(NamedTuple):
    """How a jet of gas slows down: with (core / x) to a power, in terms of the speed squared."""

    stagnation_pa: float
    """At the orifice; 0 for liquids."""
    core_mm: float
    power: float


class _Law(NamedTuple):
    """Everything about the jet and its film."""

    jet: JetForm
    rim: Rim
    air: _Air
    lit: tuple[float, float]
    """Least and greatest squared cosine of the angle from the axis at which a cone presses at all."""
    lee: float
    puddle_mm: float
    most_pa: float


class _Part(NamedTuple):
    """The edges of one component. Board frame, mm."""

    middles: Points
    """(8, 3)"""
    outward: Directions
    """(8, 3)"""
    spared: NDArray[np.float64]
    """(8,) share of the film's pressure that neighbours leave, where the film comes from that side."""
    height_mm: float
    facing: float


def edge_pressures(
    stage: Stage, jet: Jet, edges: Edges, film: Film, near: DiscGrid | None = None
) -> list[EdgePressure]:
    """Find the pressure on every edge segment from every sample of a stage that is near enough to matter.

    A liquid presses with the normal stress of its jet on the board before the edge, and with the film's momentum that
    is stopped in a puddle of depth d: cos² psi M'/(2 d) where the film comes towards the edge, -c_lee times as much
    where it runs off behind the part; psi lies between the film and the edge's normal. A neighbour within the film's
    ``shelter_mm`` of an edge that the film comes to leaves only the share ``shelter`` of it there. What the part itself
    keeps off the puddle before its edge does not press. No pressure is above the stagnation pressure of the jet.

    A gas presses with cos² psi rho U²/2, likewise, of which the jet's own stress, where it strikes the board, is a
    part (Bernoulli).

    Only jets above the component's own side and towards it count, and only within three distances from the pole to the
    rim of the spray.

    Args:
        stage: Its samples.
        jet: ``jet_of`` the stage.
        edges: Of the components.
        film: The film's numbers.
        near: ``pressing_samples`` of the stage, for edges of which these are some: only samples that may reach an edge
            are looked at. Without it all are.

    Returns:
        One for each row of the edges; without samples where the spray never comes near.
    """
    return prepare_edges(stage, jet, edges, film, near).pressures(film.puddle_mm)


@dataclass(frozen=True, slots=True, eq=False)
class PreparedEdges:
    """A stage and the edges that it presses on, for any depth of the puddle: fits try hundreds."""

    law: _Law
    parts: tuple[_Part, ...]
    candidates: tuple[NDArray[np.int32], ...]
    """Samples that may reach each part."""
    poses: tuple[Points, NDArray[np.float64]]

    def pressures(self, puddle_mm: float) -> list[EdgePressure]:
        """Find the pressures with a puddle of that depth; see ``edge_pressures``."""
        law = self.law._replace(puddle_mm=puddle_mm)
        found: list[EdgePressure] = []
        room = (np.empty(SEGMENTS), np.empty(SEGMENTS), np.empty(SEGMENTS), np.empty(SEGMENTS))
        for part, candidates in zip(self.parts, self.candidates, strict=True):
            sample, pressure = np.empty(len(candidates), dtype=np.int64), np.empty((len(candidates), SEGMENTS))
            count = _press(law, part, self.poses, candidates, (sample, pressure), room)
            found.append(EdgePressure(sample[:count].copy(), pressure[:count].copy()))
        return found


def prepare_edges(stage: Stage, jet: Jet, edges: Edges, film: Film, near: DiscGrid | None = None) -> PreparedEdges:
    """Prepare the arguments of ``edge_pressures`` for any depth of the puddle."""
    spared = np.where(edges.sheltered <= film.shelter_mm, film.shelter, 1.0)
    parts: list[_Part] = []
    candidates: list[NDArray[np.int32]] = []
    for row in range(len(edges.component)):
        height, facing = float(edges.heights_mm[row]), float(edges.facing[row])
        parts.append(_Part(edges.middles[row], edges.outward[row], spared[row], height, facing))
        x, y = edges.middles[row, :, :2].mean(axis=0).tolist()
        every = np.arange(len(stage.samples.times), dtype=np.int32) if near is None else near.near(x, y)
        candidates.append(every)
    return PreparedEdges(_law_of(jet, film), tuple(parts), tuple(candidates), _poses_of(stage))


def pressing_samples(stage: Stage, jet: Jet, edges: Edges, film: Film) -> DiscGrid:
    """Sort the samples of a stage by where on the board they may press on any of the edges; at least one row."""
    law, poses = _law_of(jet, film), _poses_of(stage)
    discs = np.zeros((len(poses[0]), 3))
    middles = edges.middles.mean(axis=1)
    away = np.linalg.norm(edges.middles[:, :, :2] - middles[:, None, :2], axis=2).max()
    # Poles on both surfaces where the edges lie on both; a sample presses on the one that it points at.
    surfaces = (float(middles[:, 2].max()), float(middles[:, 2].min()))
    _reach(law, poses, surfaces, discs)
    radii = np.where(discs[:, 2] < 0.0, -1.0, discs[:, 2] + float(away))
    return build_disc_grid(discs[:, :2], radii, middles[:, :2])


def _law_of(jet: Jet, film: Film) -> _Law:
    """Decay of a gas: a curtain as a plane free jet, U = U0 2.4 sqrt(b / x); a round one keeps U² = q v, q = I / r²."""
    stagnation, air, lit = 0.5 * jet.density_kg_m3 * jet.speed_m_s**2, _Air(0.0, 0.0, 0.0), (-1.0, math.inf)
    if jet.gas and jet.form.gas_curtain:
        air = _Air(stagnation, jet.form.core_mm, 1.0)
    elif jet.gas:
        air = _Air(stagnation, 1e3 * math.sqrt(jet.flow_m3_s * jet.form.scale / jet.speed_m_s), 2.0)
    if jet.form.kind in ROUND:
        inner, outer = jet.half_angles - TAIL_SIGMAS * jet.sigmas, jet.half_angles + TAIL_SIGMAS * jet.sigmas
        inmost = max(0.0, float(inner.min())) if jet.form.kind == RING else 0.0
        outmost = min(math.pi / 2, float(outer.max()))
        lit = math.cos(outmost) ** 2 * (1.0 - 1e-9), math.cos(inmost) ** 2 * (1.0 + 1e-9)
    return _Law(jet.form, rim_of(jet, film), air, lit, film.lee, film.puddle_mm, stagnation)


def _poses_of(stage: Stage) -> tuple[Points, NDArray[np.float64]]:
    return np.ascontiguousarray(stage.samples.tcp), np.ascontiguousarray(stage.samples.axes)


@quick
def _reach(law: _Law, poses: tuple[Points, NDArray[np.float64]], surfaces: tuple[float, float], discs: Points) -> None:
    """Fill the pole of each sample on the surface that it points at, and how far from it the spray presses (n, 3)."""
    tcp, axes = poses
    for at in range(len(tcp)):
        side = 1.0 if axes[at, 2, 2] < 0.0 else -1.0
        facing = -axes[at, 2, 2] * side
        height = (tcp[at, 2] - (surfaces[0] if side > 0.0 else surfaces[1])) * side
        discs[at, 2] = -1.0
        if facing > 0.0 and height > 0.0:
            standoff = height / facing
            discs[at, 0] = tcp[at, 0] + standoff * axes[at, 0, 2]
            discs[at, 1] = tcp[at, 1] + standoff * axes[at, 1, 2]
            discs[at, 2] = REACH * farthest(law.rim, standoff, facing)


@quick
def _press(
    law: _Law,
    part: _Part,
    poses: tuple[Points, NDArray[np.float64]],
    candidates: NDArray[np.int32],
    out: tuple[Indices, Points],
    room: tuple[Scalars, Scalars, Scalars, Scalars],
) -> int:
    """Fill those of the candidates that are near and their pressures (k, 8); return how many they are.

    There is room for four numbers of each segment.
    """
    tcp, axes = poses
    sample, pressure = out
    centre, radius = _around(part)
    count = 0
    for number in range(len(candidates)):
        at = candidates[number]
        facing = -axes[at, 2, 2] * part.facing
        height = (tcp[at, 2] - centre[2]) * part.facing
        if facing <= 0.0 or height <= 0.0:
            continue
        standoff = height / facing
        x, y = tcp[at, 0] + standoff * axes[at, 0, 2], tcp[at, 1] + standoff * axes[at, 1, 2]
        near = REACH * farthest(law.rim, standoff, facing) + radius
        if (x - centre[0]) ** 2 + (y - centre[1]) ** 2 > near * near:
            continue
        if _press_once(law, part, (tcp[at], axes[at], x, y, standoff), room, pressure[count]):
            sample[count] = at
            count += 1
    return count


@inlined
def _around(part: _Part) -> tuple[tuple[float, float, float], float]:
    """Middle of the segments, and the distance of the farthest from it."""
    x, y, z = part.middles[:, 0].mean(), part.middles[:, 1].mean(), part.middles[:, 2].mean()
    radius = 0.0
    for at in range(SEGMENTS):
        radius = max(radius, math.hypot(part.middles[at, 0] - x, part.middles[at, 1] - y))
    return (x, y, z), radius


@inlined
def _press_once(
    law: _Law,
    part: _Part,
    pose: tuple[Scalars, NDArray[np.float64], float, float, float],
    room: tuple[Scalars, Scalars, Scalars, Scalars],
    pressure: Scalars,
) -> bool:
    """Fill the pressures (8,) of one sample; whether any segment is within its reach."""
    tcp, turn, pole_x, pole_y, standoff = pose
    ways_x, ways_y, fars, shares = room
    for at in range(SEGMENTS):
        place = part.middles[at, 0] - pole_x, part.middles[at, 1] - pole_y
        ways_x[at], ways_y[at] = _from_pole(law, turn, place, standoff)
    film_around(law.rim, turn, (standoff, -turn[2, 2] * part.facing), (ways_x, ways_y), (fars, shares))
    reached = False
    for at in range(SEGMENTS):
        pressure[at] = 0.0
        away = math.sqrt(ways_x[at] * ways_x[at] + ways_y[at] * ways_y[at])
        if away > REACH * fars[at]:
            continue
        reached = True
        flow_x, flow_y = ways_x[at] / max(away, 1e-9), ways_y[at] / max(away, 1e-9)
        leaning = flow_x * turn[0, 2] + flow_y * turn[1, 2]
        struck = _struck(law, part, at, (tcp, turn)) if _lit(law, standoff, leaning, away) else 0.0
        towards = -(flow_x * part.outward[at, 0] + flow_y * part.outward[at, 1])
        if law.air.stagnation_pa > 0.0:
            x_mm = max(standoff + away, 1e-9)
            head = law.air.stagnation_pa * min(1.0, (law.air.core_mm / x_mm) ** law.air.power)
            driven = max(0.0, head - struck)
        else:
            momentum = film_momentum(law.rim, fars[at], shares[at], away)
            driven = abs(momentum) / (2e-3 * law.puddle_mm)
            towards = math.copysign(1.0, momentum) * towards
        share = part.spared[at] if towards > 0.0 else -law.lee
        total = struck + share * towards * towards * driven
        pressure[at] = max(-law.most_pa, min(law.most_pa, total))
    return reached


@inlined
def _from_pole(
    law: _Law, turn: NDArray[np.float64], place: tuple[float, float], standoff: float
) -> tuple[float, float]:
    """Way in the board's plane along which the flow comes to a place, mm.

    Flow comes from the pole; that of a curtain of gas from the nearest point of the line that the curtain strikes.
    """
    x, y = place
    if law.jet.kind == KNIFE and law.air.stagnation_pa > 0.0:
        line_x, line_y = turn[0, 0], turn[1, 0]
        squared = line_x * line_x + line_y * line_y
        half = law.rim.half_slot_mm + standoff * law.rim.wide
        along = max(-half, min(half, (x * line_x + y * line_y) / max(squared, 1e-12)))
        x, y = x - along * line_x, y - along * line_y
    return x, y


@inlined
def _lit(law: _Law, standoff: float, leaning: float, away: float) -> bool:
    """Whether the jet may press there at all: a cheap bound for the many places where it does not."""
    along = standoff + away * leaning
    squared = along * along + away * away * (1.0 - leaning * leaning)
    least, most = law.lit
    return least * squared <= along * along <= most * squared


@inlined
def _struck(law: _Law, part: _Part, at: int, pose: tuple[Scalars, NDArray[np.float64]]) -> float:
    """Normal stress of the jet on the puddle before a segment, of which the part shades what is behind it, Pa."""
    tcp, turn = pose
    x, y, z = part.middles[at, 0] - tcp[0], part.middles[at, 1] - tcp[1], part.middles[at, 2] - tcp[2]
    place = (
        turn[0, 0] * x + turn[1, 0] * y + turn[2, 0] * z,
        turn[0, 1] * x + turn[1, 1] * y + turn[2, 1] * z,
        turn[0, 2] * x + turn[1, 2] * y + turn[2, 2] * z,
    )
    if misses(law.jet, place[0], place[1], place[2]):
        return 0.0
    up = (turn[2, 0] * part.facing, turn[2, 1] * part.facing, turn[2, 2] * part.facing)
    ray_x, ray_y, ray_z, length, spread = ray_to(law.jet, place[0], place[1], place[2])
    over = 0.0
    for axis in range(2):
        over += part.outward[at, axis] * (turn[axis, 0] * ray_x + turn[axis, 1] * ray_y + turn[axis, 2] * ray_z)
    fall = -(up[0] * ray_x + up[1] * ray_y + up[2] * ray_z)
    shaded = part.height_mm * over / law.puddle_mm
    if fall <= 0.0 or shaded >= fall:
        return 0.0
    strength, _ = profile(law.jet, ray_x, ray_y, ray_z)
    if strength <= 0.0:
        return 0.0
    return stress_factor(law.jet, strength, length, spread) * fall * (fall - max(0.0, shaded))
