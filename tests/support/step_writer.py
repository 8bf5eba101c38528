"""STEP files of boxes, for tests of whatever reads them."""

import itertools
import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

Vector = tuple[float, float, float]
Placed = tuple[str, str, Vector, Vector]  # instance, product, size, place of the middle of its underside

HEAD = (
    "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
    "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
)
TAIL = "ENDSEC;\nEND-ISO-10303-21;\n"


class StepWriter:
    """Writes an assembly of boxes as AP214 faceted solids."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        application = self.add("APPLICATION_CONTEXT('mechanical design')")
        self.product_context = self.add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
        self.design = self.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
        length = self.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
        angle = self.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
        solid = self.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
        self.context = self.add(
            f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))"
            "REPRESENTATION_CONTEXT('',''))"
        )
        self.origin = self.axes((0, 0, 0), (0, 0, 1), (1, 0, 0))

    def add(self, text: str) -> str:
        self.lines.append(f"#{len(self.lines) + 1}={text};")
        return f"#{len(self.lines)}"

    def vector(self, kind: str, values: Vector) -> str:
        return self.add(f"{kind}('',({','.join(f'{value:.6f}' for value in values)}))")

    def axes(self, at: Vector, z: Vector, x: Vector) -> str:
        place = self.vector("CARTESIAN_POINT", at)
        return self.add(f"AXIS2_PLACEMENT_3D('',{place},{self.vector('DIRECTION', z)},{self.vector('DIRECTION', x)})")

    def box(self, size: Vector) -> str:
        half = np.array([size[0] / 2, size[1] / 2, 0.0])
        corners: dict[tuple[int, ...], str] = {
            corner: self.vector("CARTESIAN_POINT", tuple(np.array(corner) * size - half))
            for corner in itertools.product((0, 1), repeat=3)
        }
        faces: list[str] = []
        for axis, end in itertools.product(range(3), (0, 1)):
            ring: list[str] = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))[:: 1 if end else -1]:
                corner = [0, 0, 0]
                corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = end, a, b
                ring.append(corners[corner[0], corner[1], corner[2]])
            unit = np.eye(3)
            foot = unit[axis] * (end * size[axis] - half[axis])
            faces.append(self._face(ring, foot, unit[axis], unit[(axis + 1) % 3]))
        return self._solid(faces)

    def _face(self, ring: list[str], foot: np.ndarray, normal: np.ndarray, along: np.ndarray) -> str:
        loop = self.add(f"POLY_LOOP('',({','.join(ring)}))")
        bound = self.add(f"FACE_OUTER_BOUND('',{loop},.T.)")
        plane = self.add(f"PLANE('',{self.axes(tuple(foot), tuple(normal), tuple(along))})")
        return self.add(f"FACE_SURFACE('',({bound}),{plane},.T.)")

    def _solid(self, faces: list[str]) -> str:
        shell = self.add(f"CLOSED_SHELL('',({','.join(faces)}))")
        return self.add(f"FACETED_BREP('',{shell})")

    def prism(self, ring: list[tuple[float, float]], low: float, high: float) -> str:
        """Add an upright prism over a counter-clockwise ring, with a face for each of its sides."""
        levels = [np.array([(*each, z) for each in ring]) for z in (low, high)]
        under, over = ([self.vector("CARTESIAN_POINT", tuple(each)) for each in level] for level in levels)
        x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
        faces = [self._face(under[::-1], levels[0][0], -z, x), self._face(over, levels[1][0], z, x)]
        for here in range(len(ring)):
            there = (here + 1) % len(ring)
            along = levels[0][there] - levels[0][here]
            along /= np.linalg.norm(along)
            corners = [under[here], under[there], over[there], over[here]]
            faces.append(self._face(corners, levels[0][here], np.cross(along, z), along))
        return self._solid(faces)

    def write_solid(self, name: str, solid: str) -> str:
        """Write one solid as a part."""
        self.product(name, "FACETED_BREP_SHAPE_REPRESENTATION", f"{self.origin},{solid}")
        return HEAD + "\n".join(self.lines) + "\n" + TAIL

    def product(self, name: str, kind: str, items: str) -> tuple[str, str]:
        product = self.add(f"PRODUCT('{name}','{name}','',({self.product_context}))")
        formation = self.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        definition = self.add(f"PRODUCT_DEFINITION('design','',{formation},{self.design})")
        shape = self.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        representation = self.add(f"{kind}('',({items}),{self.context})")
        self.add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{representation})")
        return definition, representation

    def write(self, parts: list[Placed], turns_deg: Mapping[str, float] = MappingProxyType({})) -> str:
        """Write the assembly; instances may be turned about z, by name."""
        top, top_shape = self.product("card", "SHAPE_REPRESENTATION", self.origin)
        made: dict[str, tuple[str, str]] = {}
        for number, (instance, name, size, at) in enumerate(parts):
            if name not in made:
                made[name] = self.product(name, "FACETED_BREP_SHAPE_REPRESENTATION", f"{self.origin},{self.box(size)}")
            definition, shape = made[name]
            use = self.add(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}','{instance}','',{top},{definition},$)")
            use_shape = self.add(f"PRODUCT_DEFINITION_SHAPE('','',{use})")
            turn = math.radians(turns_deg.get(instance, 0.0))
            target = self.axes(at, (0, 0, 1), (math.cos(turn), math.sin(turn), 0))
            move = self.add(f"ITEM_DEFINED_TRANSFORMATION('','',{self.origin},{target})")
            relation = self.add(
                f"(REPRESENTATION_RELATIONSHIP('','',{shape},{top_shape})"
                f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({move})SHAPE_REPRESENTATION_RELATIONSHIP())"
            )
            self.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{use_shape})")
        return HEAD + "\n".join(self.lines) + "\n" + TAIL
