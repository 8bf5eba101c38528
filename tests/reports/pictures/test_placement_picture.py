"""Scenes of a placement are valid, small, in metres with y up."""

import dataclasses
import json
import struct
import sys
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from placed_parts import lance_cell

from boards.part.load import load_part
from reports.pictures.placement_picture import placement_glb, placement_usdz
from robotcell.cell.load import read_cell
from robotcell.placement.configurations import PlacementDetails, describe_placement
from robotcell.placement.evaluate import PlacementGoal
from robotcell.placement.placement_map import PlacementMap
from robotcell.placement.reachability import surface_targets
from specs.errors import JobError

SIZES = {5121: 1, 5123: 2, 5125: 4, 5126: 4}
PARTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
FORMATS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


@pytest.fixture(scope="module")
def part() -> object:
    return load_part("f-bracket")


@pytest.fixture(scope="module")
def details(part) -> PlacementDetails:
    """The F part before a UR5e whose bodies are drawn; some of the points are out of reach."""
    cell = read_cell("ur5e-bench").cell
    cell = dataclasses.replace(cell, T_cell_board=lance_cell(0.1).T_cell_board)
    return describe_placement(cell, surface_targets(part, 50.0, 12), PlacementGoal())


@pytest.fixture(scope="module")
def mapped(details: PlacementDetails) -> PlacementMap:
    values = np.linspace(-1.0, 0.1, 6 * 5 * 2).reshape(6, 5, 2)
    x, y, yaw = np.linspace(0.2, 0.8, 6), np.linspace(-0.3, 0.3, 5), np.array([0.0, np.pi])
    return PlacementMap(x, y, yaw, values, (5, 4, 1), details.score, details.cell.T_cell_board)


def accessors_of(glb: bytes) -> tuple[dict, list[np.ndarray]]:
    """Read a GLB by the rules of glTF 2.0 (sections 3.6 and 4.4), and check them."""
    magic, version, length = struct.unpack_from("<4sII", glb)
    assert (magic, version, length) == (b"glTF", 2, len(glb))
    size, kind = struct.unpack_from("<I4s", glb, 12)
    assert (kind, size % 4) == (b"JSON", 0)
    tree = json.loads(glb[20 : 20 + size])
    held, kind = struct.unpack_from("<I4s", glb, 20 + size)
    assert (kind, held % 4, 28 + size + held) == (b"BIN\0", 0, len(glb))
    data = glb[28 + size :]
    assert tree["asset"]["version"] == "2.0"
    assert len(tree["buffers"]) == 1
    assert 0 <= len(data) - tree["buffers"][0]["byteLength"] <= 3
    found: list[np.ndarray] = []
    for each in tree["accessors"]:
        view = tree["bufferViews"][each["bufferView"]]
        width = SIZES[each["componentType"]]
        begin = view.get("byteOffset", 0) + each.get("byteOffset", 0)
        count = each["count"] * PARTS[each["type"]]
        assert begin % width == 0
        assert each.get("byteOffset", 0) + count * width <= view["byteLength"]
        assert view.get("byteOffset", 0) + view["byteLength"] <= len(data)
        values = np.frombuffer(data, FORMATS[each["componentType"]], count, begin).reshape(each["count"], -1)
        assert np.isfinite(values).all()
        for name, most in (("min", values.min(axis=0)), ("max", values.max(axis=0))):
            if name in each:
                np.testing.assert_allclose(each[name], most, rtol=1e-6, atol=1e-9)
        found.append(values)
    return tree, found


def test_a_glb_keeps_the_rules_of_gltf(details: PlacementDetails, part, mapped: PlacementMap) -> None:
    glb = placement_glb(details, part, mapped)
    assert len(glb) <= 5_000_000
    assert placement_glb(details, part, mapped) == glb
    tree, accessors = accessors_of(glb)
    for mesh in tree["meshes"]:
        for primitive in mesh["primitives"]:
            position = tree["accessors"][primitive["attributes"]["POSITION"]]
            assert {"min", "max"} <= set(position)
            indices = accessors[primitive["indices"]]
            assert indices.max() < position["count"]
            assert indices.size % 3 == 0
            for attribute in primitive["attributes"].values():
                assert tree["accessors"][attribute]["count"] == position["count"]
            if "material" in primitive:
                assert primitive["material"] < len(tree["materials"])
    names = {node.get("name") for node in tree["nodes"]}
    assert {"robot", "tool", "workpiece", "points not reached", "worst point", "map"} <= names
    children = [child for node in tree["nodes"] for child in node.get("children", [])]
    assert len(children) == len(set(children))  # a tree
    assert max(children, default=0) < len(tree["nodes"])


def test_a_glb_is_in_metres_with_y_up(details: PlacementDetails, part) -> None:
    import trimesh

    scene = trimesh.load_scene(trimesh.util.wrap_as_stream(placement_glb(details, part, None)), file_type="glb")
    at = details.cell.T_cell_board @ details.targets.T_board_tcp[details.worst]
    matrix, name = scene.graph["worst point"]
    middle = scene.geometry[name].copy().apply_transform(matrix).bounds.mean(axis=0)
    np.testing.assert_allclose(middle, (at[0, 3], at[2, 3], -at[1, 3]), atol=1e-6)


@pytest.mark.slow
def test_usdz_passes_the_validators_of_openusd_and_is_the_same_scene(
    details: PlacementDetails, part, mapped: PlacementMap, tmp_path: Path
) -> None:
    from pxr import Usd, UsdGeom, UsdValidation

    content = placement_usdz(details, part, mapped)
    assert len(content) <= 5_000_000
    assert placement_usdz(details, part, mapped) == content
    with ZipFile(BytesIO(content)) as archive:
        assert {each.date_time for each in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert archive.testzip() is None
    file = tmp_path / "place.usdz"
    file.write_bytes(content)
    stage = Usd.Stage.Open(str(file))
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    assert [each.GetErrorAsString() for each in context.Validate(stage)] == []
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    meshes = {prim.GetDisplayName(): UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)}
    at = details.cell.T_cell_board @ details.targets.T_board_tcp[details.worst]
    middle = np.array(meshes["worst point"].GetExtentAttr().Get()).mean(axis=0)
    np.testing.assert_allclose(middle, (at[0, 3], at[2, 3], -at[1, 3]), atol=1e-6)
    assert {"robot", "workpiece", "map"} <= set(meshes)


def test_usdz_without_its_extra_is_one_sentence(details: PlacementDetails, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(JobError, match=r"^a scene as USDZ needs `pip install washboard\[ar\]`\.$"):
        placement_usdz(details, None, None)
