"""Moves with the jet off, past part and fixtures: straight, retreated along the jet, or around the grown hull."""

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import ConvexHull

from geometry.arrays import Directions, Points
from recipes.errors import RecipeError
from rulesengine.strokes.laid import Aim
from rulesengine.surface.site import PartSite
from rulesengine.surface.sweep import is_free

_RETREATS_MM = (0.0, 10.0, 25.0, 50.0, 100.0, 200.0)
_ROOM_MM = 15.0
"""Between the hull, grown by the lance, and the places around it."""
_NEAR_RAD = 0.9
_TURN_MM = 60.0
"""Millimetres that a radian of turning counts as: it takes time too."""
_MOST_TRIES = 400
_ALIKE_MM = 0.07
"""Ways whose lengths differ by less are equally long; no round length lies half-way between two multiples of it."""


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
        open_ = np.ones(len(one), dtype=np.bool_)
        row = {(int(a), int(b)): number for number, (a, b) in enumerate(zip(one, two, strict=True))}
        for number, key in enumerate(zip(one.tolist(), two.tolist(), strict=True)):
            open_[number] = self.known.get(key, True) if key[1] < count else True
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
            if key[1] < count:
                if key not in self.known:
                    self.known[key] = _free(self.site, [one, two])
                free = self.known[key]
            else:
                free = _free(self.site, [one, two])
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
