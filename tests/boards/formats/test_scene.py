import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from boards.board import Body
from boards.errors import BoardError
from boards.formats.scene import read_scene
from boards.formats.tri.tri import read_tri, write_tri

Vector = tuple[float, float, float]
Box = tuple[str, Vector, Vector]  # name, size, middle of the underside

BOARD: Box = ("PCB", (60.0, 40.0, 1.6), (0.0, 0.0, 0.0))
CHIPS: list[Box] = [
    ("R1", (1.6, 0.8, 0.5), (-10.0, 5.0, 1.6)),
    ("U1", (7.0, 7.0, 1.4), (10.0, 5.0, 1.65)),
    ("C1", (3.2, 1.6, 1.2), (-10.0, -8.0, -1.2)),
]


def box(size: Vector, at: Vector) -> trimesh.Trimesh:
    mesh = trimesh.creation.box(size)
    mesh.apply_translation((at[0], at[1], at[2] + size[2] / 2))
    return mesh


def heap(boxes: Sequence[Box]) -> trimesh.Trimesh:
    return cast(trimesh.Trimesh, trimesh.util.concatenate([box(size, at) for _, size, at in boxes]))


def turn(angle: float, axis: Vector) -> NDArray[np.float64]:
    return trimesh.transformations.rotation_matrix(angle, axis)


def write_scene(path: Path, boxes: Sequence[Box], matrix: NDArray[np.float64]) -> Path:
    """One node and one mesh a box, all under a node that places them with ``matrix``."""
    scene = trimesh.Scene()
    scene.graph.update(frame_from="world", frame_to="assembly", matrix=matrix)
    for name, size, at in boxes:
        scene.add_geometry(box(size, at), node_name=name, geom_name=f"mesh of {name}", parent_node_name="assembly")
    scene.export(path)
    return path


def spans(bodies: Sequence[Body]) -> dict[str, NDArray[np.float64]]:
    return {body.name: np.array([body.patches.min(axis=(0, 1)), body.patches.max(axis=(0, 1))]) for body in bodies}


def span_of(size: Vector, at: Vector) -> NDArray[np.float64]:
    low = np.array([at[0] - size[0] / 2, at[1] - size[1] / 2, at[2]])
    return np.array([low, low + size])


METRES_Y_UP = turn(-math.pi / 2, (1.0, 0.0, 0.0)) @ np.diag([0.001, 0.001, 0.001, 1.0])


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_gltf_is_turned_z_up_and_brought_to_mm(suffix: str, tmp_path: Path) -> None:
    path = write_scene(tmp_path / f"card{suffix}", [*CHIPS[:1], BOARD, *CHIPS[1:]], METRES_Y_UP)
    bodies, findings = read_scene(path)
    assert [body.name for body in bodies] == ["board", "C1", "R1", "U1"]
    for name, size, at in [*CHIPS, ("board", *BOARD[1:])]:
        np.testing.assert_allclose(spans(bodies)[name], span_of(size, at), atol=2e-4)
    assert [finding.rule.id for finding in findings] == ["board-turned"]


def test_gltf_that_is_z_up_already_stays(tmp_path: Path) -> None:
    path = write_scene(tmp_path / "card.glb", [BOARD, *CHIPS], np.eye(4))
    bodies, findings = read_scene(path)
    np.testing.assert_allclose(spans(bodies)["U1"], span_of(*CHIPS[1][1:]), atol=2e-4)
    assert [finding.rule.id for finding in findings] == ["unit-guessed", "board-not-turned"]


def test_poses_scales_and_mirrors_of_gltf_nodes_add_up(tmp_path: Path) -> None:
    path = write_scene(tmp_path / "card.gltf", [BOARD, *CHIPS], METRES_Y_UP)
    header = json.loads(path.read_text())
    chip = next(node for node in header["nodes"] if node.get("name") == "U1")
    mirrored = {"name": "U2", "mesh": chip["mesh"], "scale": [-1, 1, 1], "translation": [-20, 0, 0]}
    half = math.sqrt(0.5)
    turned = {"name": "U3", "mesh": chip["mesh"], "rotation": [0, 0, half, half], "translation": [0, -20, 0]}
    parent = next(node for node in header["nodes"] if node.get("name") == "assembly")
    parent["children"] += [len(header["nodes"]), len(header["nodes"]) + 1]
    header["nodes"] += [mirrored, turned]
    path.write_text(json.dumps(header))
    bodies, _ = read_scene(path)
    found = spans(bodies)
    np.testing.assert_allclose(found["U2"], span_of((7, 7, 1.4), (-30, 5, 1.65)), atol=2e-4)
    np.testing.assert_allclose(found["U3"], span_of((7, 7, 1.4), (-5, -10, 1.65)), atol=2e-4)
    for body in bodies:
        outward = body.patches.mean(axis=1) - body.patches.reshape(-1, 3).mean(axis=0)
        assert (np.einsum("ij,ij->i", outward, body.normals) > 0.0).all()


def test_a_components_pieces_are_one_body_with_a_surface_each(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    scene.graph.update(frame_from="world", frame_to="J1")
    scene.add_geometry(box((8, 3, 4), (0, 0, 0.002)), node_name="case", geom_name="plastic", parent_node_name="J1")
    for x in (-2, 2):
        pin = box((0.6, 0.6, 3), (x, 0, -3))
        scene.add_geometry(pin, node_name=f"PIN{x + 3}", geom_name="gold", parent_node_name="J1")
    scene.add_geometry(box((50, 40, 1.6), (0, 0, -1.6)), node_name="board", geom_name="SOLID")
    scene.export(tmp_path / "card.glb")
    bodies, _ = read_scene(tmp_path / "card.glb")
    assert [(body.name, len(body.surfaces)) for body in bodies] == [("board", 1), ("J1", 3)]
    assert bodies[1].package is None  # which of the pieces would name it?


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj"])
def test_loose_bodies_are_ranked_by_size(suffix: str, tmp_path: Path) -> None:
    heap([*CHIPS, BOARD]).export(tmp_path / f"card{suffix}")
    bodies, findings = read_scene(tmp_path / f"card{suffix}")
    assert findings == ()
    assert [(body.name, body.role) for body in bodies] == [
        ("board", "board"),
        ("part-1", "component"),
        ("part-2", "component"),
        ("part-3", "component"),
    ]
    for name, (_, size, at) in zip(("part-1", "part-2", "part-3"), (CHIPS[1], CHIPS[2], CHIPS[0]), strict=True):
        np.testing.assert_allclose(spans(bodies)[name], span_of(size, at), atol=2e-4)


@pytest.mark.slow
@settings(max_examples=15)
@given(angle=st.floats(-math.pi, math.pi), dx=st.floats(-300.0, 300.0), dy=st.floats(-300.0, 300.0))
def test_moving_the_board_moves_the_bodies_and_nothing_else(angle: float, dx: float, dy: float, tmp_path: Path) -> None:
    pins = [(f"pin {x}", (0.4, 1.5, 0.6), (x, 9.0, 1.6)) for x in (7.5, 8.5, 9.5, 10.5, 11.5)]
    twins = [(f"twin {y}", (2.0, 2.0, 1.0), (-20.0, y, 1.6)) for y in (-12.0, -4.0, 4.0, 12.0)]
    mesh = heap([*twins, BOARD, *CHIPS, *pins])
    mesh.export(tmp_path / "here.ply")
    move = turn(angle, (0.0, 0.0, 1.0))
    move[:2, 3] = dx, dy
    mesh.apply_transform(move)
    mesh.export(tmp_path / "there.ply")
    here, _ = read_scene(tmp_path / "here.ply")
    there, _ = read_scene(tmp_path / "there.ply")
    assert len(here) == 1 + 3 + 4  # the pins belong to U1
    assert [body.name for body in here] == [body.name for body in there]
    for before, after in zip(here, there, strict=True):
        moved = before.patches @ move[:3, :3].T + move[:3, 3]
        np.testing.assert_allclose(after.patches, moved, atol=3e-4)


@pytest.mark.parametrize(("unit", "scale"), [("inches", 1 / 25.4), ("metres", 0.001), ("micrometres", 1000.0)])
def test_a_wrong_unit_is_recognised_and_said(unit: str, scale: float, tmp_path: Path) -> None:
    mesh = heap([BOARD, *CHIPS])
    mesh.apply_scale(scale)
    mesh.export(tmp_path / "card.ply")
    bodies, findings = read_scene(tmp_path / "card.ply")
    assert [(finding.rule.id, finding.severity) for finding in findings] == [("unit-guessed", "warning")]
    assert f"looks like {unit}" in findings[0].message
    np.testing.assert_allclose(spans(bodies)["board"], span_of(*BOARD[1:]), atol=1e-3)


@pytest.mark.parametrize(("angle", "axis"), [(-90, (1, 0, 0)), (90, (0, 1, 0)), (25, (0.6, -0.8, 0.0))])
def test_a_board_on_edge_or_tilted_is_laid_flat(angle: float, axis: Vector, tmp_path: Path) -> None:
    mesh = heap([BOARD, *CHIPS])
    mesh.apply_transform(turn(math.radians(angle), axis))
    mesh.export(tmp_path / "card.stl")
    bodies, findings = read_scene(tmp_path / "card.stl")
    assert [finding.rule.id for finding in findings] == ["board-turned"]
    for name, chip in (("board", BOARD), ("part-1", CHIPS[1])):
        np.testing.assert_allclose(spans(bodies)[name], span_of(*chip[1:]), atol=2e-3)


def test_a_part_in_the_recess_of_another_stays_apart(tmp_path: Path) -> None:
    rails = [("", (2.0, 12.0, 3.0), (x, 0.0, 1.6)) for x in (-6.0, 6.0)] + [("", (14.0, 2.0, 3.0), (0.0, 7.0, 1.6))]
    heap([BOARD, *rails, ("", (4.0, 4.0, 1.0), (0.0, 0.0, 1.6))]).export(tmp_path / "card.stl")
    bodies, _ = read_scene(tmp_path / "card.stl")
    assert [len(body.patches) for body in bodies] == [12, 36, 12]


def test_layers_of_the_board_are_left_out(tmp_path: Path) -> None:
    layers: list[Box] = [("mask", (59.0, 39.0, 0.02), (0.0, 0.0, 1.6)), ("R9", (1.0, 1.0, 0.4), (0.0, 0.0, 0.8))]
    path = write_scene(tmp_path / "card.glb", [BOARD, *layers, *CHIPS], METRES_Y_UP)
    bodies, findings = read_scene(path)
    assert [body.name for body in bodies] == ["board", "C1", "R1", "U1"]
    said = {finding.rule.id: finding for finding in findings}
    assert "mask" in said["board-layers"].message
    assert said["component-without-height"].severity == "warning"
    assert "R9" in said["component-without-height"].message


def test_a_second_board_beside_the_first_is_kept_as_an_obstacle(tmp_path: Path) -> None:
    second: Box = ("PCB second", BOARD[1], (0.0, 45.0, 0.0))
    bodies, findings = read_scene(write_scene(tmp_path / "card.glb", [BOARD, second, *CHIPS], METRES_Y_UP))
    roles = {body.name: body.role for body in bodies}
    assert (roles["board"], roles["PCB_second"]) == ("board", "fixture")
    np.testing.assert_allclose(spans(bodies)["board"], span_of(*BOARD[1:]), atol=2e-4)
    assert "PCB second" in next(found.message for found in findings if found.rule.id == "not-on-the-board")


def test_the_board_is_told_from_a_larger_plate_by_its_name(tmp_path: Path) -> None:
    carrier: Box = ("carrier", (120.0, 90.0, 4.0), (0.0, 0.0, -30.0))
    path = write_scene(tmp_path / "card.glb", [carrier, BOARD, *CHIPS], METRES_Y_UP)
    bodies, findings = read_scene(path)
    assert [body.name for body in bodies if body.role == "fixture"] == ["carrier"]
    np.testing.assert_allclose(spans(bodies)["board"], span_of(*BOARD[1:]), atol=2e-4)
    assert "not-on-the-board" in [finding.rule.id for finding in findings]


def test_repeated_names_are_joined_where_they_touch_and_renamed_elsewhere(tmp_path: Path) -> None:
    path = write_scene(tmp_path / "card.gltf", [BOARD, *CHIPS, ("sink", (6, 6, 3), (10, 5, 3.05))], METRES_Y_UP)
    header = json.loads(path.read_text())
    for node in header["nodes"]:
        node["name"] = {"sink": "U1", "C1": "R1"}.get(node.get("name"), node.get("name"))
    path.write_text(json.dumps(header))
    bodies, findings = read_scene(path)
    assert [(body.name, len(body.patches)) for body in bodies] == [
        ("board", 12),
        ("R1", 12),
        ("R1-2", 12),
        ("U1", 24),
    ]
    said = {finding.rule.id: finding.message for finding in findings}
    assert "R1 -> R1-2" in said["repeated-name"]
    assert "U1" in said["models-joined"]


@pytest.mark.parametrize("letter", ["o", "g"])
def test_objects_and_groups_of_obj_are_names(letter: str, tmp_path: Path) -> None:
    lines, count = ["mtllib gone.mtl"], 0
    for name, size, at in [CHIPS[0], BOARD, CHIPS[1]]:
        mesh = box(size, at)
        lines += [f"{letter} {name}:1", *(f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in mesh.vertices), "usemtl black"]
        lines += [f"f {a + count} {b + count} {c + count}" for a, b, c in mesh.faces + 1]
        count += len(mesh.vertices)
    path = tmp_path / "card.obj"
    path.write_text("\n".join(lines) + "\n")
    bodies, _ = read_scene(path)
    assert [body.name for body in bodies] == ["board", "R1", "U1"]
    np.testing.assert_allclose(spans(bodies)["U1"], span_of(*CHIPS[1][1:]), atol=2e-4)


def test_a_missing_texture_does_no_harm(tmp_path: Path) -> None:
    path = write_scene(tmp_path / "card.gltf", [BOARD, *CHIPS], METRES_Y_UP)
    header = json.loads(path.read_text())
    header |= {"images": [{"uri": "gone.png"}], "textures": [{"source": 0}]}
    path.write_text(json.dumps(header))
    assert len(read_scene(path)[0]) == 4


def test_a_lone_board_is_said_to_have_no_components(tmp_path: Path) -> None:
    heap([BOARD]).export(tmp_path / "card.stl")
    bodies, findings = read_scene(tmp_path / "card.stl")
    assert [body.role for body in bodies] == ["board"]
    assert [finding.rule.id for finding in findings] == ["no-components"]


def test_bodies_survive_the_board_file(tmp_path: Path) -> None:
    path = write_scene(tmp_path / "card.glb", [BOARD, *CHIPS, ("M3 screw #1", (5, 5, 3), (20, -10, 1.6))], METRES_Y_UP)
    bodies, _ = read_scene(path)
    text = write_tri(bodies)
    (tmp_path / "card.tri").write_text(text)
    again, findings = read_tri(tmp_path / "card.tri")
    assert findings == ()
    assert write_tri(again) == text
    assert [(body.name, body.role) for body in again] == [(body.name, body.role) for body in bodies]
    for before, after in zip(bodies, again, strict=True):
        np.testing.assert_array_equal(before.patches, after.patches)


def no_board(path: Path) -> None:
    trimesh.creation.icosphere(radius=5.0).export(path)


def not_a_number(path: Path) -> None:
    mesh = heap([BOARD])
    vertices = mesh.vertices.copy()
    vertices[3, 1] = np.nan
    trimesh.Trimesh(vertices, mesh.faces, process=False).export(path)


def signalling_not_a_number(path: Path) -> None:
    """Processors report such a number where they convert it."""
    not_a_number(path)
    content = path.read_bytes()
    quiet = np.float32(np.nan).tobytes()
    assert quiet in content
    path.write_bytes(content.replace(quiet, np.uint32(0x7FA00000).tobytes()))


def without_faces(path: Path) -> None:
    trimesh.PointCloud(np.eye(3)).export(path)


def without_its_bin(path: Path) -> None:
    write_scene(path, [BOARD, *CHIPS], METRES_Y_UP)
    for file in path.parent.glob("*.bin"):
        file.unlink()


def compressed(path: Path) -> None:
    path.write_text(json.dumps({"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_draco_mesh_compression"]}))


def endless(path: Path) -> None:
    nodes = [{"children": [1]}, {"children": [0]}]
    path.write_text(json.dumps({"asset": {"version": "2.0"}, "nodes": nodes, "scenes": [{"nodes": [0]}]}))


def backwards(path: Path) -> None:
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n")


def nothing(path: Path) -> None:
    path.write_bytes(b"")


def prose(path: Path) -> None:
    path.write_bytes(b"Dear customer,\nthe board is in the post.\n")


@pytest.mark.parametrize(
    ("spoil", "suffix", "said"),
    [
        (no_board, ".stl", "holds no board"),
        (no_board, ".glb", "holds no board"),
        (not_a_number, ".ply", "not numbers"),
        (not_a_number, ".stl", "not numbers"),
        (not_a_number, ".glb", "not numbers"),
        *((signalling_not_a_number, suffix, "not numbers") for suffix in (".stl", ".glb")),
        (without_faces, ".ply", "no triangles"),
        (without_faces, ".glb", "no triangles"),
        (without_its_bin, ".gltf", r"its data file '.*\.bin' cannot be read"),
        (compressed, ".gltf", "without compression"),
        (endless, ".gltf", "never ends"),
        (backwards, ".obj", "absolute numbers"),
        *((nothing, suffix, "card") for suffix in (".glb", ".gltf", ".stl", ".obj", ".ply")),
        *((prose, suffix, "card") for suffix in (".glb", ".gltf", ".stl", ".obj", ".ply")),
    ],
)
def test_a_bad_file_is_one_clear_error(
    spoil: "object", suffix: str, said: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"card{suffix}"
    assert callable(spoil)
    spoil(path)
    with pytest.raises(BoardError, match=said) as caught:
        read_scene(path)
    assert str(caught.value).startswith(str(path))
    assert str(caught.value).endswith(".")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "uri",
    ["../outside.bin", "{around}/outside.bin", "%2e%2e/outside.bin", "link.bin", "way/outside.bin", "file:///a.bin"],
)
def test_a_gltf_names_nothing_outside_its_folder(uri: str, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    (tmp_path / "outside.bin").write_bytes(bytes(36))
    (folder / "link.bin").symlink_to(tmp_path / "outside.bin")
    (folder / "way").symlink_to(tmp_path)
    buffer = {"uri": uri.format(around=tmp_path), "byteLength": 36}
    path = folder / "card.gltf"
    path.write_text(json.dumps({"asset": {"version": "2.0"}, "buffers": [buffer]}, indent=1))
    reason = "cannot be read" if "file:" in uri else "is outside the folder of the file that names it"
    with pytest.raises(BoardError, match=f"^{path}:7: its data file '.*' {reason}. Put it beside"):
        read_scene(path)


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(BoardError, match="no such file"):
        read_scene(tmp_path / "gone.stl")


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("samples")
    for suffix in ("stl", "ply", "obj"):
        heap([BOARD, *CHIPS]).export(folder / f"card.{suffix}")
    write_scene(folder / "card.glb", [BOARD, *CHIPS], METRES_Y_UP)
    return {suffix: (folder / f"card.{suffix}").read_bytes() for suffix in ("stl", "ply", "obj", "glb")}


@settings(max_examples=60)
@given(data=st.data(), suffix=st.sampled_from(["stl", "ply", "obj", "glb"]))
def test_damage_gives_an_error_or_whole_bodies(
    data: st.DataObject, suffix: str, samples: dict[str, bytes], tmp_path: Path
) -> None:
    content = bytearray(samples[suffix])
    for _ in range(data.draw(st.integers(0, 3))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path / f"card.{suffix}"
    path.write_bytes(content[: data.draw(st.one_of(st.just(len(content)), st.integers(0, len(content))))])
    try:
        bodies, _ = read_scene(path)
    except BoardError:
        return
    assert bodies[0].role == "board"
    assert all(len(body.patches) > 0 and np.isfinite(body.patches).all() for body in bodies)


def test_what_a_library_stumbled_over_is_said_briefly(tmp_path: Path) -> None:
    """The exception of a text that is none carries the whole text."""
    path = tmp_path / "board.gltf"
    path.write_bytes(b'{"asset": "' + b"x" * 5000 + b'\xff"}')
    with pytest.raises(BoardError, match="codec can't decode") as caught:
        read_scene(path)
    assert len(str(caught.value)) < 300 + len(str(path))
