"""A box between two jaws with a recipe for parts, planned once for all tests."""

from functools import cache
from pathlib import Path

import numpy as np
from small_parts import block, part_of

from rulesengine.planning.pipeline import run
from webui.page.document import Document
from webui.page.session import Session

RECIPE = """recipe: boxes
functions: {clean: {solution: water, pressure_bar: 3, max_speed_mm_s: 120}}
nozzles: {jet: {pattern: full_cone, half_angle_deg: 15, flow_lpm: 1, body: {radius_mm: 8, length_mm: 100}}}
classes: {}
templates: {all: {path: surface, standoff_mm: 60, required_s: 1, repair: false}}
limits: {clearance_mm: 2}
sequence: [{function: clean, nozzle: jet, paths: [all]}]
"""


@cache
def part_session() -> Session:
    document = Document(Path("boxes.yaml"), RECIPE, RECIPE)
    part = part_of(block((0, 0, 0), (40, 30, 20)), jaw=block((-20, 5, -20), (-1, 25, 8)))
    loaded = document.read()
    return Session("box", part, document, loaded, run(loaded.recipe, part))


def ascii_stl(patches: np.ndarray) -> bytes:
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in patch.tolist())
        + "endloop\nendfacet\n"
        for patch in patches
    ]
    return f"solid box\n{''.join(facets)}endsolid box\n".encode()
