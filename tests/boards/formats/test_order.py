"""Nothing follows the order of the objects in a file: ties of equal objects are broken by where their corners are."""

import random
from itertools import permutations
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import trimesh
from command import washboard
from shapely import box

from boards.board import Board, Workpiece
from boards.formats.layout import LayoutNotes, LayoutPart, LayoutWords, build_bodies
from boards.formats.tri.tri import write_tri
from boards.load import load_board
from boards.packages.heights import HeightEvidence
from boards.part.load import load_part

Solid = tuple[str, trimesh.Trimesh]


def solid(size: tuple[float, float, float], at: tuple[float, float, float]) -> trimesh.Trimesh:
    """A box by its size and the middle of its underside."""
    mesh = trimesh.creation.box(size)
    mesh.apply_translation((at[0], at[1], at[2] + size[2] / 2))
    return mesh


def wedge(*, is_mirrored: bool) -> trimesh.Trimesh:
    """Half of a box, cut along a diagonal of its side; its mirror image has the same box and as many patches."""
    x = np.array([0.0, 4.0, 0.0, 0.0, 4.0, 0.0])
    x = 4.0 - x if is_mirrored else x
    corners = np.column_stack([x + 10.0, [0, 0, 0, 3, 3, 3], np.array([0.0, 0.0, 2.0, 0.0, 0.0, 2.0]) + 1.6])
    faces = np.array([[0, 1, 2], [3, 5, 4], [0, 3, 1], [3, 4, 1], [1, 4, 2], [4, 5, 2], [2, 5, 0], [5, 3, 0]])
    return trimesh.Trimesh(corners, faces[:, ::-1] if is_mirrored else faces, process=False)


def write_objects(file: Path, solids: list[Solid]) -> Path:
    """Objects of a scene in this order, or one heap for formats without names."""
    if file.suffix == ".stl":
        cast(trimesh.Trimesh, trimesh.util.concatenate([mesh for _, mesh in solids])).export(file)
    elif file.suffix == ".obj":
        lines: list[str] = []
        count = 1
        for name, mesh in solids:
            lines += [f"o {name}", *(f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in mesh.vertices.tolist())]
            lines += [f"f {a + count} {b + count} {c + count}" for a, b, c in mesh.faces.tolist()]
            count += len(mesh.vertices)
        file.write_text("\n".join(lines) + "\n", "utf-8")
    else:
        scene = trimesh.Scene()
        matrix = np.diag([1e-3, 1e-3, 1e-3, 1.0])
        for number, (name, mesh) in enumerate(solids):
            scene.add_geometry(mesh, node_name=name, geom_name=f"{number}", transform=matrix)
        scene.export(file)
    return file


def described(workpiece: Workpiece) -> tuple[object, ...]:
    """Everything that a plan looks at."""
    outlines = [each.outline.wkb for each in workpiece.components]
    measured = [(each.name, each.side, each.height_mm, each.pins, each.neighbours) for each in workpiece.components]
    faces = [(each.name, each.patches.tolist()) for each in workpiece.faces]
    return workpiece.sha256, [each.name for each in workpiece.bodies], outlines, measured, faces, workpiece.findings


def objects_of(board: Board) -> list[Solid]:
    names = {"board": "PCB"}
    meshes = (trimesh.Trimesh(**trimesh.triangles.to_kwargs(body.patches), process=False) for body in board.bodies)
    return [(names.get(body.role, body.name), mesh) for body, mesh in zip(board.bodies, meshes, strict=True)]


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".tri", ".glb", ".obj", ".stl"])
@pytest.mark.parametrize("sample", ["radio-stick", "sensor-hub", "smt-demo"])
def test_shuffled_objects_are_the_same_board(sample: str, suffix: str, tmp_path: Path) -> None:
    board, dice = load_board(Path(sample)), random.Random(3)
    bodies, objects, file = list(board.bodies), objects_of(board), tmp_path / f"b{suffix}"
    found: list[tuple[object, ...]] = []
    for _ in range(2):
        dice.shuffle(bodies)
        dice.shuffle(objects)
        if suffix == ".tri":
            file.write_text(write_tri(bodies), "utf-8")
        else:
            write_objects(file, objects)
        found.append(described(load_board(file)))
    assert found[0] == found[1]


@pytest.mark.slow
def test_shuffled_objects_of_cad_give_the_same_program(tmp_path: Path) -> None:
    objects, dice = objects_of(load_board(Path("tiny"))), random.Random(5)
    programs: list[bytes] = []
    for number in range(2):
        dice.shuffle(objects)
        (tmp_path / str(number)).mkdir()
        file = write_objects(tmp_path / str(number) / "b.glb", objects)
        planned = washboard("plan", file, "rinse-only", "--output", file.with_suffix(".wash"))
        assert planned.code == 0, planned.err
        programs.append(file.with_suffix(".wash").read_bytes())
    assert programs[0] == programs[1]


PLATE = ("PCB", solid((60.0, 40.0, 1.6), (0.0, 0.0, 0.0)))
TWINS = (wedge(is_mirrored=False), wedge(is_mirrored=True))


def in_both_orders() -> list[list[Solid]]:
    """Names that programs make up are counted in the order of the file."""
    return [[(f"Solid {n}", mesh) for n, mesh in enumerate(order, start=1)] for order in (TWINS, TWINS[::-1])]


@pytest.mark.parametrize("suffix", [".stl", ".glb", ".obj"])
def test_a_tie_of_equal_solids_is_broken_by_their_corners(suffix: str, tmp_path: Path) -> None:
    """Mirror images in one place: equal boxes, equally many patches, no names."""
    chip = ("R7", solid((2.0, 1.0, 0.5), (-20.0, 0.0, 1.6)))
    files = [
        write_objects(tmp_path / f"{n}{suffix}", [PLATE, chip, *order]) for n, order in enumerate(in_both_orders())
    ]
    one, other = (described(load_board(file)) for file in files)
    assert one == other


def test_of_equal_plates_the_first_in_the_file_is_not_taken(tmp_path: Path) -> None:
    plates = [("", solid((60.0, 40.0, 1.6), (at, 0.0, 0.0))) for at in (-40.0, 40.0, 120.0)]
    chip = ("", solid((4.0, 4.0, 1.0), (-40.0, 0.0, 1.6)))
    found = [described(load_board(write_objects(tmp_path / "b.stl", [*order, chip]))) for order in permutations(plates)]
    assert all(each == found[0] for each in found)


def test_a_tie_of_equal_pieces_of_a_part_is_broken_by_their_corners(tmp_path: Path) -> None:
    one, other = (described(load_part(write_objects(tmp_path / "p.obj", order))) for order in in_both_orders())
    assert one == other


def test_parts_of_one_name_and_one_place_are_numbered_by_what_they_are() -> None:
    words, outline = LayoutWords("Made up", "edge", "drawing", str), box(1, 1, 4, 4)
    parts = [
        LayoutPart("U1", outline, "top", HeightEvidence(package, "U1", (), "", False, 3.0), part=part)
        for package, part in (("SOIC-8", "a"), ("SOIC-8", "b"), ("QFN-16", "c"))
    ]
    found: list[list[tuple[str, str | None, str | None]]] = []
    for order in permutations(parts):
        bodies, _ = build_bodies(box(0, 0, 60, 40), 1.6, order, words, LayoutNotes())
        found.append(sorted((body.name, body.package, body.part) for body in bodies[1:]))
    assert all(each == found[0] for each in found)
