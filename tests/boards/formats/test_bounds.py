"""Numbers that no board has, announcements that no file keeps, and nesting without end: one clear error each."""

import gzip
import json
import struct
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import trimesh
from step_writer import StepWriter

import boards.formats.step
from boards.board import Body, Surface
from boards.bounds import FARTHEST_MM, MOST_BODIES, MOST_CORNERS, check_bodies, number_within
from boards.errors import BoardError
from boards.formats import gltf
from boards.load import board_library, load_board
from boards.understand import understand

EDGE = " ".join(
    f"(gr_line (start {a}) (end {b}) (layer Edge.Cuts))"
    for a, b in (("0 0", "30 0"), ("30 0", "30 20"), ("30 20", "0 20"), ("0 20", "0 0"))
)
DATA = Path(__file__).parents[1] / "data"
PAD = "(pad 1 smd rect (at 0 0) (size 1 1) (layers F.Cu))"
IDF = """.HEADER
BOARD_FILE 3.0 "x" 2024/05/01.10:00:00 1
b MM
.END_HEADER
.BOARD_OUTLINE ECAD
1.6
0 0 0 0
0 40 0 0
0 40 {x} {angle}
0 0 30 0
0 0 0 0
.END_BOARD_OUTLINE
"""
TRI = "board-tri 1\nunits mm\nobjects 1\nobject b surfaces 1 role=board\nsurface 1 patches 1\n0 0 0 1 0 0 {} 1 0\n"


def refused(path: Path, content: str | bytes) -> str:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(BoardError) as caught:
        load_board(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:")
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    ("word", "found"),
    [("1.5", 1.5), ("-1e4", -1e4), ("10000.1", None), ("1e308", None), ("nan", None), ("1_0", None), ("x", None)],
)
def test_a_number_is_finite_and_within_its_bound(word: str, found: float | None) -> None:
    value = number_within(word, FARTHEST_MM)
    assert (None if np.isnan(value) else value) == found


@pytest.mark.parametrize(
    "item",
    [
        "(gr_arc (start 5 5) (end 1e15 5) (angle 90) (layer Edge.Cuts))",
        "(gr_arc (start 5 5) (end 6 5) (angle 1e15) (layer Edge.Cuts))",
        "(gr_circle (center 5 5) (end 1e8 5) (layer Edge.Cuts))",
        "(gr_line (start 1e308 5) (end 4 0) (layer Edge.Cuts))",
        f"(module R (layer F.Cu) (at -1e308 54) {PAD})",
        "(module R (layer F.Cu) (at 9 9) (pad 1 smd rect (at 99999999999 0) (size 1 1) (layers F.Cu)))",
        "(module R (layer F.Cu) (at 9 9) (pad 1 thru_hole circle (at 0 0) (size 1 1) (drill 1e9) (layers *.Cu)))",
        f"(module R (layer F.Cu) (at 9 9 1e30) {PAD})",
    ],
)
def test_numbers_of_kicad_are_bounded_with_their_line(item: str, tmp_path: Path) -> None:
    message = refused(tmp_path / "b.kicad_pcb", f"(kicad_pcb (version 20171130)\n{item}\n{EDGE})")
    assert message.startswith(f"{tmp_path / 'b.kicad_pcb'}:2: number ")


@pytest.mark.parametrize("bracket", ["(", "[", "{", "'"])
def test_no_nesting_of_kicad_is_too_deep(bracket: str, tmp_path: Path) -> None:
    refused(tmp_path / "b.kicad_pcb", f"(kicad_pcb (module {bracket * 100_000}\n{EDGE}")


def test_arcs_of_a_drawing_are_bounded_together(tmp_path: Path) -> None:
    circle = "(gr_circle (center 0 0) (end 9999 0) (layer Edge.Cuts))"
    count = MOST_CORNERS // 2000
    message = refused(tmp_path / "b.kicad_pcb", f"(kicad_pcb (version 20171130)\n{circle * count})")
    assert "more than 200,000 corners" in message


@pytest.mark.parametrize(("x", "angle"), [("1e308", "0"), ("1e308", "90"), ("1e9", "90"), ("30", "1e15"), ("nan", "0")])
def test_numbers_of_idf_are_bounded_with_their_line(x: str, angle: str, tmp_path: Path) -> None:
    assert ":9: " in refused(tmp_path / "b.emn", IDF.format(x=x, angle=angle))


@pytest.mark.parametrize("x", ["1e308", "-1e8", "1e999"])
def test_numbers_of_a_board_file_are_bounded_with_their_line(x: str, tmp_path: Path) -> None:
    assert ":6: " in refused(tmp_path / "b.tri", TRI.format(x))


@pytest.mark.parametrize("x", ["1e308", "1e8", "-10001"])
def test_numbers_of_a_parts_table_are_bounded_with_their_line(x: str, tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text(f"Ref,PosX,PosY\nR1,1,1\nU1,{x},0\n")
    with pytest.raises(
        BoardError, match=r"t\.csv:3: (column PosX: .* not a length within ±10000|U1 is farther than 10 m)"
    ):
        load_board(Path("tiny"), table)


def test_a_board_that_unpacks_without_end_is_not_unpacked(tmp_path: Path) -> None:
    message = refused(tmp_path / "b.tri.gz", gzip.compress(bytes(30_000_000)))
    assert "to more than 10,000,000 bytes: that is no board" in message


@pytest.mark.parametrize(
    ("suffix", "content"),
    [
        ("obj", "v 8\nv 8\nv 8\nv 1\nf 3 8 7\no R1\nv 1\nf 0 2 9\n"),
        ("obj", "v 1\nv \nv 8\nf 2 4 1\nv 2 1\n"),
        ("obj", "v 8\nv 5\nv 8\nv 8\nf 2 4 1\nf5 2 1\nf 1 4 3\nv 2\n"),
        ("obj", "v 0 0 0\nv 1e308 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("stl", "solid x\nfacet normal 0 0 q\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendsolid"),
        ("ply", "ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\nend_header\n0\n"),
        ("ply", "ply\nformat ascii 1.0\nelement vertex 9e9\nproperty float x\nend_header\n0\n"),
        ("gltf", '{"a":' * 100_000),
        ("gltf", '{"scene": 0, "scenes": [{"nodes": [{}]}]}'),
    ],
)
def test_damaged_meshes_are_one_quiet_error(
    suffix: str, content: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    message = refused(tmp_path / f"b.{suffix}", content)
    assert "Error" not in message
    assert capfd.readouterr() == ("", "")


def glb(header: dict[str, object], chunk: bytes = b"") -> bytes:
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(chunk), 0x004E4942) + chunk
    return struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts


def card(**changed: object) -> dict[str, object]:
    """One triangle in each of two nodes; every key may be replaced."""
    return {
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "name": "R1"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"componentType": 5126, "type": "VEC3", "bufferView": 0, "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}],
        **changed,
    }


TRIANGLE = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
VEC3 = {"componentType": 5126, "type": "VEC3"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"accessors": [{**VEC3, "bufferView": 0, "count": 10**12}]}, "damaged or cut short"),
        ({"accessors": [{**VEC3, "count": 10**12}]}, "sparse or has no data"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 36, "byteStride": 10**9}]}, "damaged or cut short"),
        ({"bufferViews": [{"buffer": 7, "byteLength": 36}]}, "an index leads beyond the end"),
        ({"meshes": [{"primitives": [{"attributes": {}}]}]}, "'POSITION' is missing"),
        ({"nodes": [{"children": [n + 1, n + 1]} for n in range(60)] + [{"mesh": 0}]}, "tree of its nodes never ends"),
        ({"nodes": [{"children": [1]}, {"children": [0]}]}, "tree of its nodes never ends"),
        ({"nodes": [{"mesh": 0, "scale": [1e-9, 1e-9, 1e-9]}, {}]}, "holds no board"),
        ({"nodes": [{"mesh": 0, "translation": [1e30, 0, 0]}, {}]}, "absurdly large"),
    ],
)
def test_what_a_gltf_announces_is_not_believed(changed: dict[str, object], words: str, tmp_path: Path) -> None:
    assert words in refused(tmp_path / "b.glb", glb(card(**changed), TRIANGLE))


def test_a_mesh_of_a_gltf_is_decoded_no_further_than_the_bound(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Its primitives may all be the same data: a small file would fill the memory."""
    monkeypatch.setattr(gltf, "MOST_TRIANGLES", 5)
    decode, decoded = gltf._decode_primitive, list[object]()
    monkeypatch.setattr(gltf, "_decode_primitive", lambda *words: decoded.append(words) or decode(*words))
    same = [{"attributes": {"POSITION": 0}}] * 1000
    assert "triangles" in refused(tmp_path / "b.glb", glb(card(meshes=[{"primitives": same}]), TRIANGLE))
    assert len(decoded) == 6


def test_a_file_that_a_gltf_names_again_is_read_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "b.bin").write_bytes(TRIANGLE)
    (tmp_path / "c.bin").write_bytes(TRIANGLE)
    names = [{"byteLength": 36, "uri": "b.bin"}] * 1000
    (tmp_path / "b.gltf").write_text(json.dumps(card(buffers=names)))
    read = gltf.read_bytes
    monkeypatch.setattr(gltf, "MAX_BYTES", 50)
    monkeypatch.setattr(gltf, "read_bytes", opened := Mock(wraps=read))
    assert gltf.parse_gltf((tmp_path / "b.gltf").read_bytes(), tmp_path / "b.gltf").children
    assert opened.call_count == 1
    content = json.dumps(card(buffers=[*names, {"byteLength": 36, "uri": "c.bin"}]))
    assert "brings its data files to more than 50 bytes" in refused(tmp_path / "b.gltf", content)


def test_a_gltf_whose_board_is_in_a_wrong_unit_is_refused(tmp_path: Path) -> None:
    scene = trimesh.Scene([trimesh.creation.box((30e-9, 20e-9, 0.8e-9)), trimesh.creation.box((1e-9, 1e-9, 1e-9))])
    assert "no area in steps" in refused(tmp_path / "b.glb", bytes(scene.export(file_type="glb")))


@pytest.mark.parametrize("mode", [4, 5, 6])
def test_triangles_strips_and_fans_are_decoded(mode: int) -> None:
    from boards.formats.gltf import parse_gltf

    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0], [1, 2, 0]], dtype="<f4")
    primitive = {"attributes": {"POSITION": 0}, "mode": mode}
    header = card(
        meshes=[{"primitives": [primitive]}],
        accessors=[{**VEC3, "bufferView": 0, "count": 6}],
        bufferViews=[{"buffer": 0, "byteLength": 72}],
        nodes=[{"mesh": 0}],
        scenes=[{"nodes": [0]}],
    )
    faces = {
        4: [(0, 1, 2), (3, 4, 5)],
        5: [(0, 1, 2), (2, 1, 3), (2, 3, 4), (4, 3, 5)],
        6: [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)],
    }[mode]
    found = parse_gltf(glb(header, points.tobytes()), Path("b.glb")).geometry()[0]
    np.testing.assert_array_equal(found, points[np.array(faces)])


@pytest.mark.parametrize(
    ("entity", "word"),
    [
        ("CARTESIAN_POINT('',(0.,0.,{}))", "1E300"),
        ("CIRCLE('',#8,{})", "-123456789.5"),
        ("CIRCLE('E9',#8,{})", "1.E+08"),
    ],
)
def test_sizes_of_step_are_bounded_with_their_line(entity: str, word: str, tmp_path: Path) -> None:
    text = StepWriter().write([("R1", "R", (1, 1, 1), (0, 0, 0))])
    message = refused(tmp_path / "b.step", text.replace("DATA;\n", f"DATA;\n#9999={entity.format(word)};\n"))
    assert f":8: #9999 ({entity.partition('(')[0]}) has {word}, beyond" in message


def test_a_small_step_file_is_refused_within_five_seconds() -> None:
    assert boards.formats.step.limits_for(20_000).cpu_s == 3


def body(role: str, scale: float) -> Body:
    mesh = trimesh.creation.box((60.0, 40.0, 1.6))
    patches = np.asarray(mesh.triangles).copy()
    patches[:, :, 2] += 0.0 if role == "board" else 1.6
    return Body(
        role, role, patches if role == "board" else patches * scale, np.asarray(mesh.face_normals), (Surface("1", 12),)
    )  # type: ignore[arg-type]


@pytest.mark.parametrize("scale", [1e3, 1e30, float("inf")])
def test_whatever_a_reader_lets_through_is_not_understood_beyond_the_bounds(scale: float) -> None:
    with pytest.raises(BoardError, match=r"component has a corner that is no number or lies more than"):
        understand([body("board", 1.0), body("component", scale)], "b")


def test_more_bodies_than_any_board_has_are_refused_before_they_are_looked_at() -> None:
    with pytest.raises(BoardError, match=r"holds 50,001 bodies; at most 50,000 are read"):
        check_bodies([body("component", 1.0)] * (MOST_BODIES + 1))


def test_names_of_files_and_parts_do_not_break_a_line(tmp_path: Path) -> None:
    file = tmp_path / "a\nerror: forged\udcff.tri"
    text = board_library()["tiny"].read_text().replace("object U1 ", "object U\x1b[2J1 ")
    file.write_bytes(text.encode())
    board = load_board(file)
    assert board.name == "a\\nerror: forged\\xff"
    assert all(component.name.isprintable() for component in board.components)
    assert any(component.name == "U\\x1b[2J1" for component in board.components)


@pytest.mark.slow
def test_a_thousand_copies_of_a_part_are_refused(tmp_path: Path) -> None:
    mesh = trimesh.creation.box((60.0, 40.0, 1.6))
    chip = trimesh.creation.box((2.0, 2.0, 1.0), transform=trimesh.transformations.translation_matrix((5, 5, 1.3)))
    # Each a little higher than the last, so that no two are one body.
    copies = [chip.copy().apply_translation((0.0, 0.0, 1e-3 * n)) for n in range(720)]
    whole = trimesh.util.concatenate([mesh, *copies])
    assert "lie upon each other" in refused(tmp_path / "b.stl", bytes(whole.export(file_type="stl")))


@pytest.mark.parametrize("suffix", ["kicad_pcb", "brd", "emn", "tri"])
def test_a_thousand_placements_at_one_place_are_refused_at_once(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("boards.understand.shape_of", lambda *_: pytest.fail("each of them was measured"))
    (tmp_path / "b.emp").write_bytes((DATA / "notched.emp").read_bytes())
    message = refused(tmp_path / f"b.{suffix}", crowded(suffix))
    assert "thousands of its parts lie upon each other" in message


def crowded(suffix: str) -> str:
    """A board whose part U1 is placed 720 times, at the same place."""
    if suffix == "tri":
        head, board, part = board_library()["tiny"].read_text().split("\nobject ")[:3]
        copies = [f"C{n} {part.partition(' ')[2]}" for n in range(720)]
        return "\nobject ".join([head.replace("objects 6", "objects 721"), board, *copies]) + "\n"
    file, first, last = {
        "kicad_pcb": ("small_v9.kicad_pcb", '  (footprint "Package_SO', "\n  )\n"),
        "brd": ("small.brd", '<element name="U2"', "\n"),
        "emn": ("notched.emn", '"wedge 4x2" PN-1 U1', "PLACED\n"),
    }[suffix]
    text = (DATA / file).read_text()
    begin = text.index(first)
    end = text.index(last, begin) + len(last)
    return text[:begin] + 720 * text[begin:end] + text[end:]


def test_brackets_without_end_in_a_parts_table_are_refused_at_once(tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text(f"a\tb{'(' * 100_000}\nR1\t1\n")
    with pytest.raises(BoardError, match="no line names the columns"):
        load_board(Path("tiny"), table)


@pytest.mark.parametrize("word", ["5e-324", "-1e-310"])
def test_a_number_with_fewer_digits_than_others_is_zero(word: str) -> None:
    """GEOS does not come back from simplifying an outline that has one."""
    assert str(number_within(word, FARTHEST_MM)) == "0.0"
