"""Shapes and places as a person writes them. Millimetres and degrees."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from specs.spec import PositiveFloat, Spec

Point: TypeAlias = tuple[float, float, float]
Sizes: TypeAlias = tuple[PositiveFloat, PositiveFloat, PositiveFloat]


class Place(Spec):
    """A pose: a place and a turn about fixed axes, as in URDF."""

    xyz_mm: Point = Field(default=(0, 0, 0), description="Where.")
    rpy_deg: Point = Field(
        default=(0, 0, 0), description="Turned about x, then y, then z of the frame it stands in: roll, pitch, yaw."
    )


class BoxSpec(Spec):
    """A box, centred on its place."""

    kind: Literal["box"] = Field(default="box", description="A box.")
    size_mm: Sizes = Field(description="Along x, y, z.")
    at: Place = Field(default=Place(), description="Its middle.")


class CapsuleSpec(Spec):
    """A rod with round ends."""

    kind: Literal["capsule"] = Field(default="capsule", description="A rod with round ends.")
    from_mm: Point = Field(description="Middle of one round end.")
    to_mm: Point = Field(description="Middle of the other.")
    radius_mm: PositiveFloat = Field(description="Of the rod and its ends.")


class CylinderSpec(Spec):
    """A rod with flat ends."""

    kind: Literal["cylinder"] = Field(default="cylinder", description="A rod with flat ends.")
    from_mm: Point = Field(description="Middle of one flat end.")
    to_mm: Point = Field(description="Middle of the other.")
    radius_mm: PositiveFloat = Field(description="Of the rod.")


class HoseSpec(Spec):
    """A hose, or the room that it needs, along a line of points."""

    kind: Literal["hose"] = Field(default="hose", description="A hose, or the room that it needs.")
    along_mm: list[Point] = Field(min_length=2, max_length=50, description="Points on its middle line.")
    radius_mm: PositiveFloat = Field(description="Of the hose with all that it sways.")


class MeshSpec(Spec):
    """Triangles of a file."""

    kind: Literal["mesh"] = Field(default="mesh", description="Triangles of a file.")
    file: str = Field(min_length=1, description="STL, OBJ or PLY; a relative path begins at the cell's file.")
    mm_per_unit: PositiveFloat = Field(default=1.0, description="1000 for a file in metres.")
    at: Place = Field(default=Place(), description="Where the file's own frame is.")


BodySpec: TypeAlias = Annotated[BoxSpec | CapsuleSpec | CylinderSpec | HoseSpec | MeshSpec, Field(discriminator="kind")]
