"""Part files: a small YAML beside the meshes of a part and its fixtures."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from specs.spec import Bounds, Coordinate, Size, Spec, Turn

Name: TypeAlias = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]
"""A word that can stand in a program file and in a robot's program."""
Unit: TypeAlias = Annotated[float, Bounds(1e-6, 1e6, "mm", "units of files")]
FaceAngle: TypeAlias = Annotated[float, Bounds(1, 90, "degrees", "bends at which a face ends")]
Component: TypeAlias = Annotated[float, Bounds(-1e6, 1e6)]


class PartPlace(Spec):
    """A pose in the part's frame: a position and a rotation about fixed axes."""

    xyz_mm: tuple[Coordinate, Coordinate, Coordinate] = Field(default=(0, 0, 0), description="Position.")
    rpy_deg: tuple[Turn, Turn, Turn] = Field(
        default=(0, 0, 0), description="Turned about x, then y, then z of the part's frame: roll, pitch, yaw."
    )


class MeshBody(Spec):
    """Triangles or solids of a file."""

    kind: Literal["mesh"] = Field(default="mesh", description="Triangles or solids of a file.")
    file: str = Field(
        min_length=1,
        description="STL, OBJ, PLY, STEP, GLB, or points (PLY, xyz, txt); in the part file's folder or below.",
    )
    mm_per_unit: Unit | None = Field(
        default=None, description="25.4 for a file in inches; left out, STEP and GLB state metres, others are in mm."
    )
    cell_mm: Size | None = Field(
        default=None, description="Smallest shape that is kept of a cloud of points; left out, as its points allow."
    )
    at: PartPlace = Field(default=PartPlace(), description="Pose of the file's own frame.")


class BoxBody(Spec):
    """A box, centred on its pose."""

    kind: Literal["box"] = Field(default="box", description="A box.")
    size_mm: tuple[Size, Size, Size] = Field(description="Along x, y, z.")
    at: PartPlace = Field(default=PartPlace(), description="Pose of its centre.")


FixtureBody: TypeAlias = Annotated[MeshBody | BoxBody, Field(discriminator="kind")]


class FacingWay(Spec):
    """Faces whose mean normal is near a direction."""

    normal: tuple[Component, Component, Component] = Field(description="Direction in the part's frame, any length.")
    within_deg: Annotated[float, Bounds(0, 180, "degrees", "angles between directions")] = Field(
        default=10, description="Largest angle from it."
    )


class FacesSpec(Spec):
    """How a part's surface is divided into faces, and which of them are left alone."""

    split_deg: FaceAngle = Field(default=20, description="An edge that bends by at least this much ends a face.")
    ignore: list[str | FacingWay] = Field(
        default=[], description="Faces that are not sprayed: names such as face-3 or bore*, or directions."
    )


class PartFile(Spec):
    """A part: one YAML file beside its meshes."""

    part: Name = Field(description="Name of the part.")
    description: str = Field(default="", description="What it is.")
    extends: str | None = Field(default=None, description="Part file whose keys are inherited.")
    body: MeshBody = Field(description="The part itself.")
    fixtures: dict[Name, FixtureBody] = Field(default={}, description="What holds it, by name.")
    faces: FacesSpec = Field(default=FacesSpec(), description="Its faces.")
