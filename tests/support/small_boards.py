"""Boards made of boxes, for tests of everything that comes after the reading of a board."""

import numpy as np
from shapely import Polygon, affinity, box

from boards.board import Board, Body, Component, Obstacle
from boards.formats.prism import prism

THICKNESS_MM = 1.6


def part(name, x, y, width, depth, height=1.0, **known):
    """A box on the top side, lower left corner at x, y; ``known`` may give side, pins, package, turn_deg."""
    outline = affinity.rotate(box(x, y, x + width, y + depth, ccw=True), known.pop("turn_deg", 0.0))
    stated = {"package": "C_0805_2012Metric", "pins": 2, "side": "top"} | known
    return Component(
        name=name,
        part="",
        value="",
        pins_source="stated",
        footprint=outline,
        outline=outline,
        height_mm=height,
        area_mm2=outline.area,
        gap_height_mm=0.1,
        gap_height_source="stated",
        neighbours=(),
        **stated,
    )


def board_of(*parts, outline=None, fixtures=(), surface_z=0.0):
    """A board with these parts; 100 x 60 mm if no outline is given; fixtures are (polygon, height) pairs."""
    outline = box(0, 0, 100, 60, ccw=True) if outline is None else outline
    patches, normals, surfaces = prism(outline, surface_z - THICKNESS_MM, surface_z)
    body = Body("board", "board", patches, normals, surfaces)
    known = tuple(_with_neighbours(each, parts) for each in parts)
    clamps = tuple(Obstacle(f"F{i}", polygon, height) for i, (polygon, height) in enumerate(fixtures))
    obstacles = {side: _obstacles(parts, side) + clamps for side in ("top", "bottom")}
    ring = np.array(outline.exterior.coords)
    edges = np.diff(ring, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    longest = int(np.argmax(np.round(lengths, 3)))
    return Board(
        name="boxes",
        sha256="0" * 64,
        bodies=(body,),
        outline=outline,
        axis=tuple(edges[longest] / lengths[longest]),
        top_z_mm=surface_z,
        bottom_z_mm=surface_z - THICKNESS_MM,
        components=known,
        top_obstacles=obstacles["top"],
        bottom_obstacles=obstacles["bottom"],
        findings=(),
    )


def _obstacles(parts, side):
    return tuple(Obstacle(each.name, each.outline, each.height_mm) for each in parts if each.side == side)


def _with_neighbours(component, parts):
    from dataclasses import replace

    others = [other for other in parts if other is not component and other.side == component.side]
    near = sorted((round(component.outline.distance(other.outline), 4), other.name) for other in others)
    return replace(component, neighbours=tuple((name, gap) for gap, name in near[:6]))


def l_shape(size=60.0):
    """An outline with one inner corner."""
    half = size / 2
    return Polygon([(0, 0), (size, 0), (size, half), (half, half), (half, size), (0, size)])
