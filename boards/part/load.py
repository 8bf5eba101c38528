"""A part from whatever file it comes in, with its fixtures."""

import itertools
from dataclasses import replace
from operator import itemgetter
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field

from boards.board import Body, Part, Role, Surface
from boards.bounds import beyond
from boards.errors import MAX_BYTES, BoardError
from boards.formats.table import find_format
from boards.formats.tree import read_tree, without_file_order
from boards.formats.tri.tri import read_tri
from boards.load import name_of
from boards.part.cloud import PartMesh
from boards.part.sources import PART_SUFFIXES, part_library
from boards.part.understand import FaceChoice, Facing, ignored_in_vain, understand_part
from geometry.arrays import Triangles
from geometry.mesh import areas_and_normals
from geometry.solids.holes import fill_holes
from specs.confinement import find_beside
from specs.finding import Finding, worst_first
from specs.finding_rules import PART_HOLES_FILLED, PART_HOLES_NONE
from specs.input_file import InputFile
from specs.progress import Progress, no_progress, subprogress
from specs.spec import Bounds, Coordinate, Name, Size, Spec, Turn
from specs.yaml.file_kind import FileKind
from specs.yaml.load import find_file, parse_spec, read_text, resolve_text
from specs.yaml.located import Located

_BOX = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip
"""Triangles of a box, by its corners: number 4 x + 2 y + z has the coordinates -1 or 1 for a 0 or 1 of x, y and z."""

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
    fill_holes_mm: Size | None = Field(
        default=None, description="Widest hole that is closed: of a scan, or a bore that is not to be sprayed."
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


PART = FileKind(
    "part", "part: NAME", "washboard part", BoardError, PartFile, part_library, named=frozenset({"fixtures"})
)


def load_part(source: str | Path, progress: Progress = no_progress) -> Part:
    """Read a part file, or the mesh of a part without fixtures, and understand it.

    Args:
        source: A name of the library, a YAML file, a ``.tri`` file with role=part, or a mesh.
        progress: Receives the stage and the share done.

    Raises:
        BoardError: it cannot be found, read or used.
    """
    path = find_file(str(source), PART)
    progress(f"reading {path.name}", 0.0)
    try:
        bodies, choice, name, findings = _read(path, subprogress(progress, 0.0, 0.6))
        progress("finding faces", 0.6)
        part = understand_part(bodies, name, choice, findings)
        return replace(part, findings=worst_first((*part.findings, *ignored_in_vain(part.faces, choice))))
    except BoardError as error:
        raise error if error.file is not None else BoardError(str(error), file=path) from None


def _read(path: Path, progress: Progress) -> tuple[list[Body], FaceChoice | None, str, list[Finding]]:
    name = path.name.lower()
    if name.endswith((".yaml", ".yml")):
        return _read_part_file(path, progress)
    InputFile(path, BoardError, "part file", MAX_BYTES).check()
    if name.endswith((".tri", ".tri.gz")):
        bodies, noticed = read_tri(path)
        return list(bodies), None, name_of(path), list(noticed)
    if not name.endswith(PART_SUFFIXES):
        raise BoardError(f"no reader for this kind of file. Parts are {', '.join(PART_SUFFIXES)}.", file=path)
    mesh = _read_mesh(path, None, None, progress)
    choice = FaceChoice(least_mm2=mesh.least_face_mm2)
    return [_body("part", "part", mesh.patches)], choice, name_of(path), list(mesh.findings)


def _read_part_file(path: Path, progress: Progress) -> tuple[list[Body], FaceChoice, str, list[Finding]]:
    root = resolve_text(read_text(path, PART), path, PART)
    spec = parse_spec(root, PART)
    mesh = _read_named(spec.body, root, ("body",), progress)
    noticed = list(mesh.findings)
    bodies = [_body("part", "part", _placed(mesh.patches, spec.body.at))]
    for name, fixture in spec.fixtures.items():
        match fixture:
            case BoxBody():
                signs = np.array([*itertools.product((-1.0, 1.0), repeat=3)])
                solid = (signs * np.array(fixture.size_mm) / 2)[_BOX]
            case MeshBody():
                held = _read_named(fixture, root, ("fixtures", name), progress)
                solid, noticed = held.patches, [*noticed, *held.findings]
        bodies.append(_body(name, "fixture", _placed(solid, fixture.at)))
    ignore = tuple(
        each if isinstance(each, str) else Facing(each.normal, each.within_deg) for each in spec.faces.ignore
    )
    for place, each in enumerate(ignore):
        if isinstance(each, Facing) and not any(each.normal):
            at = root.at(("faces", "ignore", place)).mark
            message = "has no direction: one of the three numbers is not 0"
            raise BoardError(message, path=f"faces.ignore[{place}].normal", file=at.file, line=at.line)
    return bodies, FaceChoice(spec.faces.split_deg, ignore, mesh.least_face_mm2), spec.part, noticed


def _read_named(spec: MeshBody, root: Located, path: tuple[str, ...], progress: Progress) -> PartMesh:
    """Read the mesh that a part file names; an error states the line that names it."""
    mark = root.at((*path, "file")).mark
    try:
        mesh = _read_mesh(find_beside(spec.file, Path(mark.file)), spec.mm_per_unit, spec.cell_mm, progress)
        return mesh if spec.fill_holes_mm is None else _without_holes(mesh, spec.fill_holes_mm)
    except (BoardError, ValueError) as error:
        where = ".".join((*path, "file"))
        raise BoardError(f"{spec.file}: {error}", path=where, file=mark.file, line=mark.line) from None


def _read_mesh(path: Path, mm_per_unit: float | None, cell_mm: float | None, progress: Progress) -> PartMesh:
    """Read all triangles of a file, or those of the surface of its points, mm; its own frame is kept."""
    form = find_format(path, "points", "tree")
    if form.points:
        return form.function("points")(path, mm_per_unit or 1.0, cell_mm)
    tree, _, findings = read_tree(path, progress)
    scale = mm_per_unit or form.unit_mm
    pieces = without_file_order(
        (patches for patches in tree.geometry() if len(patches)),
        lambda patches: (*patches.min(axis=(0, 1)).tolist(), *patches.max(axis=(0, 1)).tolist(), len(patches)),
        lambda patches: patches[np.lexsort(patches.reshape(-1, 9).T[::-1])].ravel().tolist(),
    )
    if not pieces:
        raise BoardError("holds no triangles or surfaces. Export the part as a solid.", file=path)
    with np.errstate(over="ignore"):
        return PartMesh(np.concatenate(pieces) * scale, 0.0, findings)


def _without_holes(mesh: PartMesh, widest_mm: float) -> PartMesh:
    patches, holes = fill_holes(mesh.patches, widest_mm)
    if not holes:
        text = (
            f"fill_holes_mm: {widest_mm:g}: there is no hole as narrow as this. Leave it out, or state a greater width."
        )
        return replace(mesh, findings=(*mesh.findings, Finding(PART_HOLES_NONE, text)))
    width, middle = max(holes, key=itemgetter(0))
    many = "1 hole was" if len(holes) == 1 else f"{len(holes)} holes were"
    at = ", ".join(f"{each:z.1f}" for each in middle)
    text = f"{many} filled; the widest, {width:.1f} mm, is at {at} mm."
    return replace(mesh, patches=patches, findings=(*mesh.findings, Finding(PART_HOLES_FILLED, text)))


def _body(name: str, role: Role, patches: Triangles) -> Body:
    is_sound = not beyond(patches)  # what is not is refused once it is understood
    steps = np.round(patches, 4) + 0.0 if is_sound else patches
    normals = areas_and_normals(steps.copy())[1] if is_sound else np.zeros((len(patches), 3))
    return Body(name, role, steps, normals, (Surface("surface-1", len(steps)),))


def _placed(patches: Triangles, at: PartPlace) -> Triangles:
    """Turn about x, then y, then z of the fixed frame, then move; quarter turns are exact."""
    angles, exact = np.radians(at.rpy_deg), np.mod(at.rpy_deg, 90.0) == 0.0
    (a, b, c), (u, v, w) = (np.where(exact, np.rint(each(angles)), each(angles)) for each in (np.cos, np.sin))
    about_x = np.array([[1, 0, 0], [0, a, -u], [0, u, a]])
    about_y = np.array([[b, 0, v], [0, 1, 0], [-v, 0, b]])
    about_z = np.array([[c, -w, 0], [w, c, 0], [0, 0, 1]])
    with np.errstate(all="ignore"):  # of what is beyond all numbers
        return patches @ (about_z @ about_y @ about_x).T + np.array(at.xyz_mm)
