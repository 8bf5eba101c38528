"""Small parts: boxes, an L, cylinders and balls, with or without fixtures, as the reader would give them."""

import numpy as np
import shapely

from boards.board import Body, Part, Surface
from boards.part.understand import FaceChoice, understand_part
from geometry.mesh import areas_and_normals
from recipes.load import parse_recipe
from recipes.recipe import Recipe

RECIPE = """
recipe: small
functions: {clean: {solution: water, pressure_bar: 3, max_speed_mm_s: 120}}
nozzles: {jet: {pattern: full_cone, half_angle_deg: 15, flow_lpm: 1, body: {radius_mm: 8, length_mm: 100}}}
classes: {}
templates: {all: {path: surface, standoff_mm: 60, %s}}
limits: {clearance_mm: 2}
sequence: [{function: clean, nozzle: jet, paths: [all]}]
"""


def surface_recipe(keys: str = "required_s: 1") -> Recipe:
    return parse_recipe(RECIPE % keys)


def body(name: str, role: str, patches: np.ndarray) -> Body:
    patches = np.asarray(patches, dtype=np.float64)
    return Body(name, role, patches, areas_and_normals(patches.copy())[1], (Surface("s", len(patches)),))


def block(low, high) -> np.ndarray:
    """Twelve patches of a box, wound outwards."""
    return prism([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])], low[2], high[2])


def prism(ring, low: float, high: float) -> np.ndarray:
    """Patches of an upright prism over a counter-clockwise ring, wound outwards."""
    polygon = shapely.Polygon(ring)
    found = []
    for piece in shapely.get_parts(shapely.constrained_delaunay_triangles(polygon)):
        corners = np.asarray(shapely.orient_polygons(piece).exterior.coords)[:3, :2]
        found.append(np.column_stack([corners, np.full(3, high)]))
        found.append(np.column_stack([corners[::-1], np.full(3, low)]))
    for (x0, y0), (x1, y1) in zip(ring, [*ring[1:], ring[0]], strict=True):
        found.append([(x0, y0, low), (x1, y1, low), (x1, y1, high)])
        found.append([(x0, y0, low), (x1, y1, high), (x0, y0, high)])
    return np.array(found, dtype=np.float64)


def cylinder(radius: float, height: float, facets: int = 48) -> np.ndarray:
    angles = 2 * np.pi * np.arange(facets) / facets
    return prism(list(zip(radius * np.cos(angles), radius * np.sin(angles), strict=True)), 0.0, height)


def moved(patches: np.ndarray, turn: np.ndarray, shift) -> np.ndarray:
    return patches @ turn.T + np.array(shift)


def part_of(patches: np.ndarray, *ignore: str, split_deg: float = 20, **fixtures: np.ndarray) -> Part:
    bodies = [body("part", "part", patches), *(body(name, "fixture", each) for name, each in fixtures.items())]
    return understand_part(bodies, "thing", FaceChoice(split_deg, ignore))
