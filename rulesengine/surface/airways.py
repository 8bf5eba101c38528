"""Moves with the jet off, past part and fixtures: straight, retreated along the jet, or around the grown hull.

They lead to the strokes that the pieces of stripes become.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import ConvexHull

from geometry.arrays import Directions, Points, Scalars
from programs.plan import PlanItem, Transfer
from recipes.errors import RecipeError
from recipes.nozzles import AirKnife, FlatFan
from rulesengine.strokes.laid import Aim, LaidStroke, Pose, Reached
from rulesengine.surface.site import PartSite, Piece, is_free
from specs.source import Source

_RETREATS_MM = (0.0, 10.0, 25.0, 50.0, 100.0, 200.0)
_ROOM_MM = 15.0
"""Between the hull, grown by the lance, and the places around it."""
_NEAR_RAD = 0.9
_TURN_MM = 60.0
"""Millimetres that a radian of turning counts as: it takes time too."""
_MOST_TRIES = 400
_ALIKE_MM = 0.07
"""Ways whose lengths differ by less are equally long; no round length lies half-way between two multiples of it."""
_SAME = 1e-6
_RAMP_ROUNDS = 20


@dataclass(slots=True, eq=False)
class Airways:
    """Free ways around a part: places outside its hull, and which ways between them are known to be free or not."""

    site: PartSite
    places: Points
    """(k, 3) orifices."""
    inward: Directions
    """(k, 3) directions of the jet there, towards the middle."""
    known: dict[tuple[int, int], bool] = field(default_factory=dict[tuple[int, int], bool])

    def connect(self, start: Aim, end: Aim) -> list[Aim]:
        """Aims of a free way from one to another, both included, proved by a swept capsule.

        Raises:
            RecipeError: none was found.
        """
        if np.abs(start.tcp - end.tcp).max() < 1e-6 and np.abs(start.approach - end.approach).max() < 1e-9:
            return [start]
        for way in _retreats(start, end):
            if _free(self.site, way):
                return way
        return self._shortened(self._around(start, end))

    def _around(self, start: Aim, end: Aim) -> list[Aim]:
        """Shortest way over the places around the hull; ways are checked when the search is about to use them.

        Lazy probabilistic roadmap (Bohlin and Kavraki 2000), with places that are not random.
        """
        count = len(self.places)
        begins, ends = (self._left(pose) for pose in (start, end))
        tcp = np.vstack([self.places, begins.tcp, ends.tcp])
        inward = np.vstack([self.inward, begins.approach, ends.approach])
        one, two = (each.ravel() for each in np.triu_indices(count + 2, 1))
        turn = np.arccos(np.clip(np.einsum("ij,ij->i", inward[one], inward[two]), -1.0, 1.0))
        cost = np.linalg.norm(tcp[one] - tcp[two], axis=1) + _TURN_MM * turn
        usable = (turn < _NEAR_RAD) | (two >= count)
        one, two, cost = one[usable], two[usable], cost[usable]
        row = {key: number for number, key in enumerate(zip(one.tolist(), two.tolist(), strict=True))}
        open_ = np.array([self.known.get(key, True) for key in row], dtype=np.bool_)
        for _ in range(_MOST_TRIES):
            graph = coo_array((cost[open_], (one[open_], two[open_])), shape=(count + 2, count + 2))
            distances, before = dijkstra(graph, directed=False, indices=count, return_predecessors=True)
            if not np.isfinite(distances[count + 1]):
                break
            nodes = [count + 1]
            while nodes[-1] != count:
                nodes.append(int(before[nodes[-1]]))
            nodes.reverse()
            poses = [Aim(tcp[node], inward[node]) for node in nodes]
            bad = self._first_blocked(nodes, poses, count)
            if bad is None:
                return [start, *poses, end]
            open_[row[bad]] = False
        x, y, z = (round(float(value), 1) for value in start.tcp)
        raise RecipeError(
            f"no free way for the lance away from ({x}, {y}, {z}) to the next stripe. Shorten nozzles.*.body, lower "
            "limits.clearance_mm or tilt_max_deg, or ignore the face.",
            path=f"templates.{self.site.made_by.template}",
        )

    def _first_blocked(self, nodes: list[int], poses: list[Aim], count: int) -> tuple[int, int] | None:
        for a, b, one, two in zip(nodes[:-1], nodes[1:], poses[:-1], poses[1:], strict=True):
            key = (min(a, b), max(a, b))
            free = self.known[key] if key in self.known else _free(self.site, [one, two])
            if key[1] < count:  # the ends are those of this way alone
                self.known[key] = free
            if not free:
                return key
        return None

    def _left(self, pose: Aim) -> Aim:
        """Retreat along the jet as far as it is free, at most out of the hull."""
        left = pose
        for distance in _RETREATS_MM[1:]:
            farther = Aim(pose.tcp - pose.approach * distance, pose.approach)
            if not _free(self.site, [left, farther, farther]):
                break
            left = farther
        return left

    def _shortened(self, way: list[Aim]) -> list[Aim]:
        """Leave out poses of a way between which the straight way is free."""
        number = 0
        while number + 2 < len(way):
            for later in range(len(way) - 1, number + 1, -1):
                if _free(self.site, [way[number], way[later]]):
                    del way[number + 1 : later]
                    break
            number += 1
        return way


def _free(site: PartSite, way: list[Aim]) -> bool:
    return is_free(site, np.array([pose.tcp for pose in way]), np.array([pose.approach for pose in way]))


def _retreats(start: Aim, end: Aim) -> list[list[Aim]]:
    """Ways that leave the one pose and reach the other along their jets, the shortest first."""
    ways: list[tuple[float, list[Aim]]] = []
    for leave in _RETREATS_MM:
        for reach in _RETREATS_MM:
            left = Aim(start.tcp - start.approach * leave, start.approach)
            reached = Aim(end.tcp - end.approach * reach, end.approach)
            length = leave + reach + float(np.linalg.norm(reached.tcp - left.tcp))
            middle = [each for each, distance in ((left, leave), (reached, reach)) if distance > 0]
            ways.append((round(length / _ALIKE_MM), [start, *middle, end]))
    ways.sort(key=lambda each: (each[0], len(each[1])))  # of equal ones the first, wherever the part lies
    return [way for _, way in ways]


def build_airways(site: PartSite, up: Directions) -> Airways:
    """Place poses around the hull of all bodies, grown by the lance: in the 42 directions of a divided icosahedron.

    The icosahedron stands on the part's own up (3,), so that it turns with the part.
    """
    corners = np.unique(np.concatenate([body.patches.reshape(-1, 3) for body in site.part.bodies]), axis=0)
    hull = ConvexHull(corners)
    middle = (corners.max(axis=0) + corners.min(axis=0)) / 2
    own = site.part.own_bodies[0].patches
    middle = own.reshape(-1, 3).mean(axis=0) if len(own) else middle
    edge = own[0, 1] - own[0, 0]
    side = edge - up * (edge @ up)
    if np.linalg.norm(side) < 1e-6 * np.linalg.norm(edge) + 1e-9:
        edge = own[0, 2] - own[0, 0]
        side = edge - up * (edge @ up)
    side /= np.linalg.norm(side)
    axes = np.stack([side, np.cross(up, side), up])
    ways: Directions = np.asarray(_sphere() @ axes, dtype=np.float64)
    facing = ways @ hull.equations[:, :3].T
    depth = -(hull.equations[:, :3] @ middle + hull.equations[:, 3])
    exits = np.where(facing > 1e-9, depth / np.maximum(facing, 1e-9), np.inf).min(axis=1)
    reach = exits + site.lance.radius_mm + _ROOM_MM
    places = middle + ways * reach[:, None]
    free = site.blockers(places, -ways) < 0
    return Airways(site, places[free], -ways[free])


def _sphere() -> Directions:
    """(42, 3) corners and middles of the edges of an icosahedron, on the unit ball."""
    golden = (1 + np.sqrt(5)) / 2
    corners = [[0.0, a, b * golden] for a in (-1, 1) for b in (-1, 1)]
    corners = np.array([np.roll(each, turn) for turn in range(3) for each in corners])
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    one, two = np.nonzero(np.triu(np.abs(apart - 2.0) < 1e-6))
    both = np.vstack([corners, (corners[one] + corners[two]) / 2])
    return both / np.linalg.norm(both, axis=1, keepdims=True)


@dataclass(frozen=True, slots=True, eq=False)
class PartWays:
    """Free ways around a part. The part's frame, mm."""

    parked: Pose
    airways: Airways

    def place(self, tcp: Points, approach: Directions, reference: Directions) -> tuple[Points, Directions, Directions]:
        """Poses are in the part's frame already."""
        return tcp, approach, reference

    def park(self, pose: Pose, speed_mm_s: float, made_by: Source) -> tuple[list[PlanItem], Pose]:
        """Go to the parked pose, turned about the jet as little as possible on the way."""
        items = list(self._go(pose, self.parked, speed_mm_s, made_by))
        reference = items[-1].reference[-1] if items else pose.reference
        return [*items], Pose(self.parked.tcp, self.parked.approach, reference)

    def reach(self, pose: Pose, stroke: LaidStroke, speed_mm_s: float) -> Reached:
        """Go to the beginning of a stroke, and turn about the jet there if its pattern lies across the travel."""
        made_by = replace(stroke.made_by, motion="transfer")
        items = list(self._go(pose, Aim(stroke.tcp[0], stroke.approach[0]), speed_mm_s, made_by))
        carried = items[-1].reference[-1] if items else pose.reference
        if stroke.reference is None:
            return Reached([*items], replace(stroke, reference=carry(carried, stroke.approach)))
        # A flat pattern is the same turned by half a turn.
        reference = stroke.reference if stroke.reference[0] @ carried >= 0 else -stroke.reference
        if not np.allclose(reference[0], carried, rtol=0, atol=_SAME):
            tcp, approach = (np.tile(each[0], (2, 1)) for each in (stroke.tcp, stroke.approach))
            items.append(Transfer(tcp, approach, np.stack([carried, reference[0]]), speed_mm_s, made_by))
        return Reached([*items], replace(stroke, reference=reference))

    def _go(self, pose: Pose, end: Aim, speed_mm_s: float, made_by: Source) -> Iterator[Transfer]:
        way = self.airways.connect(pose, end)
        if len(way) > 1:
            tcp, approach = np.array([each.tcp for each in way]), np.array([each.approach for each in way])
            yield Transfer(tcp, approach, carry(pose.reference, approach), speed_mm_s, made_by)


def lay(site: PartSite, piece: Piece) -> LaidStroke:
    """Give a piece its speeds; a flat pattern lies across its travel, a round one is turned as little as possible."""
    reference: Directions | None = None
    if isinstance(site.nozzle, FlatFan | AirKnife) and len(piece.tcp) >= 2:
        across = np.cross(piece.approach, np.gradient(piece.tcp, axis=0))
        lengths = np.linalg.norm(across, axis=1, keepdims=True)
        reference = None if (lengths < 1e-9).any() else across / lengths  # it has no travel
    return LaidStroke(
        tcp=piece.tcp,
        approach=piece.approach,
        reference=reference,
        speeds_mm_s=_speeds(site, piece),
        delays=piece.pauses_s,
        made_by=replace(site.made_by, components=(piece.face,)),
    )


def carry(reference: Directions, approach: Directions) -> Directions:
    """Tool +X (n, 3) along (n, 3) directions of the jet, each turned from the last about the axis that both share.

    Args:
        reference: (3,) at right angles to the first direction.
        approach: (n, 3) unit vectors; neighbours are not opposite.
    """
    rows = [reference]
    for before, after in pairwise(approach):
        axis, cosine = np.cross(before, after), float(before @ after)
        last = rows[-1]
        # Rodrigues, for the smallest rotation that takes the one direction to the other.
        turned = last * cosine + np.cross(axis, last) + axis * float(axis @ last) / max(1.0 + cosine, 1e-9)
        turned -= after * float(after @ turned)
        rows.append(turned / np.linalg.norm(turned))
    return np.array(rows)


def _speeds(site: PartSite, piece: Piece) -> Scalars:
    """(n - 1,) speeds of the orifice that give each segment its time; where it only turns, the largest.

    A segment is entered and left no faster than its neighbours are gone through. While the orifice speeds up from u to
    v, it falls (v - u)² / (2 a) behind, which the speed makes up for.
    """
    ways, fastest = piece.ways_mm, site.max_speed_mm_s
    if not len(ways):
        return ways
    moving = ways > _SAME
    speeds = np.where(moving, ways / piece.seconds, fastest)
    acceleration = site.acceleration_mm_s2
    if site.spec.repair:
        for _ in range(_RAMP_ROUNDS):
            beside = np.concatenate([[0.0], speeds, [0.0]])
            before, after = beside[:-2], beside[2:]
            lost = (np.maximum(speeds - before, 0.0) ** 2 + np.maximum(speeds - after, 0.0) ** 2) / (2.0 * acceleration)
            reached = np.sqrt(acceleration * ways + (before**2 + after**2) / 2.0)
            speeds = np.where(moving, np.minimum(np.minimum((ways + lost) / piece.seconds, reached), fastest), fastest)
    return np.clip(speeds, 0.01, fastest)
