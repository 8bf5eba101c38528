"""From bodies to a part: its mesh checked and mended, its faces found."""

import hashlib
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from boards.board import Body, Face, Part, Surface
from boards.bounds import check_bodies
from boards.errors import BoardError
from boards.formats.names import canonical_order
from boards.formats.tri.tri import SMALLEST_AREA_MM2, write_tri
from geometry.arrays import Indices, Triangles
from geometry.mesh import areas_and_normals
from geometry.solids.regions import find_regions
from geometry.solids.soundness import count_crossings, find_edges, join_corners, join_near, outward
from geometry.solids.tree import winding_numbers
from specs.finding import Finding, worst_first
from specs.finding_rules import (
    PART_CROSSES_ITSELF,
    PART_EDGES_SHARED,
    PART_FACE_TINY,
    PART_IGNORES_NOTHING,
    PART_IN_FIXTURE,
    PART_NORMALS,
    PART_OPEN,
    PART_PATCHES,
    PART_SIZE,
)

IGNORED = "x-ignored"
"""Key of the extra attribute of a body: the names of its surfaces that are not sprayed, with commas between."""

_TINY_MM2 = 1.0
_TINY_SHARE = 1e-4
_SMALL_MM, _LARGE_MM = 15.0, 5000.0
_PROBED = 300
_INSIDE = 0.5
_UNITS = {"inches": 25.4, "metres": 1000.0}
_SAME_MM = 0.001
"""Corners that are nearer are one corner: models are exported with rounding, and with noise below it."""


@dataclass(frozen=True, slots=True)
class Facing:
    """Faces whose normal is within an angle of a direction."""

    normal: tuple[float, float, float]
    within_deg: float


@dataclass(frozen=True, slots=True)
class FaceChoice:
    """How the surface of a part is divided, and which faces are not sprayed: by name or by direction."""

    split_deg: float = 20.0
    ignore: tuple[str | Facing, ...] = ()
    least_mm2: float = 0.0
    """A smaller face joins the one that it has the longest border with."""


def understand_part(
    bodies: Iterable[Body], name: str, choice: FaceChoice | None, findings: Iterable[Finding] = ()
) -> Part:
    """Understand a part: mend what can be mended, find its faces.

    Args:
        bodies: One part or several with role ``part``, and fixtures, in any order; mm.
        name: What to call it.
        choice: How faces are found; ``None`` takes the surfaces of the bodies as they are, as a ``.tri`` file has them.
        findings: What was noticed while reading; the part's own are added.

    Raises:
        BoardError: there is no part, it lies inside a fixture, or it has no area.
    """
    noticed = list(findings)
    bodies = canonical_order(bodies)
    check_bodies(bodies)
    own = [body for body in bodies if body.role == "part"]
    if not own:
        raise BoardError("there is no part among the objects. Give the part role=part.")
    mended = {body.name: _mend(body, noticed if body.role == "part" else []) for body in bodies}
    bodies = tuple(mended.get(body.name, body) for body in bodies)
    own = [body for body in bodies if body.role == "part"]
    noticed += _check_size(np.concatenate([body.patches for body in own]))
    noticed += _check_fixtures(own, [body for body in bodies if body.role == "fixture"])
    faces: list[Face] = []
    named: list[Body] = []
    begin = 0
    for body in own:
        found, kept = _with_faces(body, begin, choice, faces)
        faces += kept
        named.append(found)
        begin += len(found.patches)
    least = _least_area(sum(face.area_mm2 for face in faces))
    if tiny := [face.name for face in faces if face.area_mm2 < least]:
        listed = ", ".join(tiny[:5]) + (f" and {len(tiny) - 5} more" if len(tiny) > 5 else "")
        text = f"{len(tiny)} faces have less than {least:.2g} mm2 and get no stripes: {listed}."
        noticed.append(Finding(PART_FACE_TINY, text))
    by_name = {body.name: body for body in named}
    bodies = tuple(by_name.get(body.name, body) for body in bodies)
    if not any(face.serve for face in faces):
        raise BoardError("every face of the part is left out. Ignore fewer faces, under faces: ignore.")
    sha256 = hashlib.sha256(write_tri(bodies).encode()).hexdigest()
    return Part(name=name, sha256=sha256, bodies=bodies, findings=worst_first(noticed), faces=tuple(faces))


def ignored_in_vain(faces: Sequence[Face], choice: FaceChoice | None) -> Iterator[Finding]:
    """Name what a choice ignores and no face of a part is."""
    for each in choice.ignore if choice is not None else ():
        if not any(_is_ignored(face, each) for face in faces):
            what = repr(each) if isinstance(each, str) else f"the normal ({', '.join(f'{n:g}' for n in each.normal)})"
            names = faces[0].name if len(faces) == 1 else f"{faces[0].name} to {faces[-1].name}"
            text = f"faces: ignore: {what} is of no face; the part has {names}. Correct it, or leave it out."
            yield Finding(PART_IGNORES_NOTHING, text)


def _mend(body: Body, noticed: list[Finding]) -> Body:
    """Drop patches without an area, turn the others outwards, and note what is not sound."""
    patches = join_near(np.round(body.patches, 4) + 0.0, _SAME_MM)
    areas, _ = areas_and_normals(patches)
    keep = areas > SMALLEST_AREA_MM2
    if not keep.any():
        raise BoardError(f"{body.name} has no face with an area. Correct its model, and check the units.")
    if not keep.all():
        message = f"{np.count_nonzero(~keep)} patches of {body.name} have no area and were left out."
        noticed.append(Finding(PART_PATCHES, message))
    # A body may be in a file twice: of patches with the same corners in the same sense the first is kept.
    corners = join_corners(patches)
    begin = np.argmin(corners, axis=1)[:, None]
    alike = np.take_along_axis(corners, (begin + np.arange(3)) % 3, axis=1)
    first = np.zeros(len(patches), dtype=np.bool_)
    first[np.unique(alike, axis=0, return_index=True)[1]] = True
    if twice := np.count_nonzero(keep & ~first):
        message = f"{twice} patches of {body.name} are there twice, at the same place, and were left out once."
        noticed.append(Finding(PART_PATCHES, message))
    keep &= first
    patches = patches[keep]
    edges = find_edges(patches)
    turn, twisted = outward(patches, edges)
    if twisted:
        noticed.append(Finding(PART_NORMALS, f"{body.name} has a surface with one side only. Correct its model."))
    elif turn.any():
        message = (
            f"{np.count_nonzero(turn)} of {len(turn)} patches of {body.name} faced inwards and were turned around."
        )
        noticed.append(Finding(PART_NORMALS, message))
    patches = np.where(turn[:, None, None], patches[:, ::-1], patches)
    noticed += _check_soundness(body.name, patches)
    owner = np.repeat(np.arange(len(body.surfaces)), [surface.patches for surface in body.surfaces])[keep]
    counts = np.bincount(owner, minlength=len(body.surfaces)).tolist()
    surfaces = tuple(replace(one, patches=count) for one, count in zip(body.surfaces, counts, strict=True) if count)
    return replace(body, patches=patches, normals=areas_and_normals(patches.copy())[1], surfaces=surfaces)


def _check_soundness(name: str, patches: Triangles) -> Iterator[Finding]:
    edges = find_edges(patches)
    if edges.open:
        message = (
            f"{name} is open: {edges.open} edges belong to one patch alone. Only the side of its normals is sprayed."
        )
        yield Finding(PART_OPEN, message)
    if edges.crowded:
        message = f"{edges.crowded} edges of {name} belong to more than two patches: faces end there."
        yield Finding(PART_EDGES_SHARED, message)
    crossed = count_crossings(patches, edges)
    if crossed:
        message = (
            f"{name} crosses itself: {crossed} patches go through each other. Repair it in CAD, or allow it by name."
        )
        yield Finding(PART_CROSSES_ITSELF, message)


def _check_size(patches: Triangles) -> Iterator[Finding]:
    size = np.ptp(patches.reshape(-1, 3), axis=0)
    if _SMALL_MM <= size.max() <= _LARGE_MM:
        return
    x, y, z = size.tolist()
    text = f"the part is {x:.3g} x {y:.3g} x {z:.3g} mm"
    for unit, mm in _UNITS.items():
        if _SMALL_MM <= float(size.max()) * mm <= _LARGE_MM:
            x, y, z = (size * mm).tolist()
            text += (
                f"; were its file in {unit}, {x:.4g} x {y:.4g} x {z:.4g} mm: state mm_per_unit: {mm:g} in a part file"
            )
    yield Finding(PART_SIZE, f"{text}. Check the unit of its file.")


def _check_fixtures(own: Sequence[Body], fixtures: Sequence[Body]) -> Iterator[Finding]:
    corners = np.unique(np.concatenate([body.patches.reshape(-1, 3) for body in own]), axis=0)
    step = max(1, len(corners) // _PROBED)
    middles = np.concatenate([body.patches.mean(axis=1) for body in own])[::step]
    probes = np.concatenate([corners[::step], middles])
    for fixture in fixtures:
        low, high = fixture.patches.min(axis=(0, 1)), fixture.patches.max(axis=(0, 1))
        near = ((probes > low + 1e-3) & (probes < high - 1e-3)).all(axis=1)
        if not near.any():
            continue
        share = float((np.abs(winding_numbers(fixture.patches, probes[near])) > _INSIDE).sum()) / len(probes)
        if share > 0.99:
            raise BoardError(f"the part lies inside its fixture {fixture.name}. Correct the place of one of them.")
        if share > 0:
            message = f"{share:.0%} of the part lies inside {fixture.name}; what is inside cannot be sprayed."
            yield Finding(PART_IN_FIXTURE, message)


def _with_faces(body: Body, begin: int, choice: FaceChoice | None, before: Sequence[Face]) -> tuple[Body, list[Face]]:
    """Give a body with a surface for each face, patches ordered face after face, and its faces."""
    areas, normals = areas_and_normals(body.patches.copy())
    if choice is None:
        face = np.repeat(np.arange(len(body.surfaces)), [surface.patches for surface in body.surfaces])
        names = [surface.name for surface in body.surfaces]
        ignored = set(dict(body.extra).get(IGNORED, "").split(","))
    else:
        face = find_regions(normals, areas, find_edges(body.patches), choice.split_deg, choice.least_mm2).face
        names = [f"face-{len(before) + number + 1}" for number in range(int(face.max()) + 1)]
        ignored = set[str]()
    order = np.argsort(face, kind="stable")
    patches, normals, areas, face = body.patches[order], normals[order], areas[order], face[order]
    faces = [_face(name, np.flatnonzero(face == number), normals, areas) for number, name in enumerate(names)]
    least = _least_area(float(areas.sum()))
    listed = choice.ignore if choice is not None else ()
    served = [
        face.area_mm2 >= least and face.name not in ignored and not any(_is_ignored(face, each) for each in listed)
        for face in faces
    ]
    faces = [
        replace(each, patches=each.patches + begin, serve=serve) for each, serve in zip(faces, served, strict=True)
    ]
    surfaces = tuple(Surface(each.name, len(each.patches)) for each in faces)
    left = ",".join(each.name for each in faces if not each.serve)
    extra = tuple((key, value) for key, value in body.extra if key != IGNORED) + (((IGNORED, left),) if left else ())
    return replace(body, patches=patches, normals=normals, surfaces=surfaces, extra=extra), faces


def _face(name: str, patches: Indices, normals: Triangles, areas: NDArray[np.float64]) -> Face:
    own, weights = normals[patches], areas[patches]
    total = float(weights.sum())
    mean = (own * weights[:, None]).sum(axis=0) / max(total, 1e-12)
    length = float(np.linalg.norm(mean))
    x, y, z = (mean / length if length > 0.1 else own[0]).tolist()
    flat = bool((own @ np.array([x, y, z]) > math.cos(math.radians(1.0))).all())
    return Face(name, patches, (x, y, z), total, flat, serve=True)


def _least_area(total_mm2: float) -> float:
    """Area from which on a face gets stripes, mm2: of a small part it is less."""
    return min(_TINY_MM2, _TINY_SHARE * total_mm2)


def _is_ignored(face: Face, each: str | Facing) -> bool:
    if isinstance(each, str):
        return fnmatchcase(face.name, each)
    way = np.array(each.normal) / np.abs(each.normal).max()  # of any length: squares of small ones are 0
    way /= np.linalg.norm(way)
    return face.flat and float(way @ np.array(face.normal)) >= math.cos(math.radians(each.within_deg)) - 1e-9
