"""Parts from files: faces, fixtures, and what bad files are told to be."""

from pathlib import Path

import numpy as np
import pytest
from small_parts import block, body, cylinder, part_of

from boards.errors import BoardError
from boards.formats.tri.tri import write_tri
from boards.part.load import load_part
from boards.part.sources import part_library
from boards.part.understand import FaceChoice, understand_part

CUBE = block((0, 0, 0), (40, 30, 20))
PLACE = "at: {xyz_mm: [%s]}"


def rules(part) -> list[str]:
    return [finding.rule.id for finding in part.findings]


def write_stl(file: Path, patches: np.ndarray) -> Path:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in patch)
        + "endloop\nendfacet\n" for patch in patches
    )  # fmt: skip
    file.write_text(f"solid thing\n{facets}endsolid thing\n")
    return file


def part_file(folder: Path, patches: np.ndarray, text: str = "", body: str = "file: thing.stl") -> Path:
    write_stl(folder / "thing.stl", patches)
    file = folder / "thing.yaml"
    file.write_text(f"part: thing\nbody: {{{body}}}\n{text}")
    return file


@pytest.mark.parametrize("name", part_library())
def test_every_library_part_is_sound(name: str) -> None:
    part = load_part(name)
    of_cloud = {"cloud-open", "cloud-surface", "part-open"} if name == "hood" else set()
    assert {finding.rule.id for finding in part.findings} == of_cloud
    assert part.served


def test_the_f_part_has_twelve_faces_and_stands_on_one(tmp_path: Path) -> None:
    part = load_part("f-bracket")
    assert len(part.faces) == 12
    assert [face.normal for face in part.faces if not face.serve] == [(0.0, 0.0, -1.0)]
    assert {body.name: body.role for body in part.bodies} == {
        "part": "part", "table": "fixture", "front_jaw": "fixture", "back_jaw": "fixture",
    }  # fmt: skip
    outline = 2 * (200 + 140) + 2 * 55
    assert sum(face.area_mm2 for face in part.faces) == pytest.approx(2 * 15475 + 50 * outline)


def test_a_part_is_the_same_from_its_canonical_text(tmp_path: Path) -> None:
    part = load_part("f-bracket")
    file = tmp_path / "f-bracket.tri"
    file.write_text(write_tri(part.bodies))
    again = load_part(str(file))
    assert again.sha256 == part.sha256
    assert [(face.name, face.serve, face.area_mm2) for face in again.faces] == [
        (face.name, face.serve, face.area_mm2) for face in part.faces
    ]


def test_a_mesh_alone_is_a_part_without_fixtures(tmp_path: Path) -> None:
    part = load_part(str(write_stl(tmp_path / "cube.stl", CUBE)))
    assert [face.serve for face in part.faces] == [True] * 6
    assert part.bodies[0].role == "part"


@pytest.mark.parametrize("length", ["2", "1e-308"])
def test_faces_are_ignored_by_name_pattern_and_direction(length: str, tmp_path: Path) -> None:
    text = f"faces: {{ignore: [face-1, {{normal: [0, 0, -{length}]}}]}}\n"
    part = load_part(str(part_file(tmp_path, CUBE, text)))
    left = [face for face in part.faces if not face.serve]
    assert {face.name for face in left} >= {"face-1"}
    assert any(face.normal == (0.0, 0.0, -1.0) for face in left)
    with pytest.raises(BoardError, match="every face of the part is left out"):
        load_part(str(part_file(tmp_path, CUBE, 'faces: {ignore: ["face-*"]}\n')))


def test_inches_are_stated_in_the_part_file_and_doubted_otherwise(tmp_path: Path) -> None:
    found = load_part(str(part_file(tmp_path, CUBE / 25.4)))
    assert rules(found) == ["part-size"]
    assert "were its file in inches, 40 x 30 x 20 mm" in found.findings[0].message
    part = load_part(str(part_file(tmp_path, CUBE / 25.4, body="file: thing.stl, mm_per_unit: 25.4")))
    assert rules(part) == []
    assert np.ptp(part.patches.reshape(-1, 3), axis=0) == pytest.approx([40, 30, 20], abs=1e-3)


@pytest.mark.parametrize(
    ("mm", "unit", "stated"),
    [(1000.0, "metres", "1000"), (25.4, "inches", "25.4")],
)
def test_the_unit_of_a_file_is_recognised_by_the_size_of_the_part(
    tmp_path: Path, mm: float, unit: str, stated: str
) -> None:
    found = load_part(str(part_file(tmp_path, CUBE * (2.0 / mm))))
    assert (
        f"were its file in {unit}, 80 x 60 x 40 mm: state mm_per_unit: {stated} in a part" in found.findings[0].message
    )


def test_a_body_that_is_in_a_file_twice_is_taken_once(tmp_path: Path) -> None:
    turned = np.roll(CUBE[::-1], 1, axis=1)
    found = load_part(str(part_file(tmp_path, np.concatenate([CUBE, turned]))))
    assert [each.message for each in found.findings] == [
        "12 patches of part are there twice, at the same place, and were left out once."
    ]
    once = load_part(str(part_file(tmp_path, CUBE)))
    assert [face.area_mm2 for face in found.faces] == [face.area_mm2 for face in once.faces]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("scale", [1.0, 5.0])
def test_corners_that_jitter_are_joined(tmp_path: Path, seed: int, scale: float) -> None:
    fine = np.concatenate([block((0, 0, 0), (40, 30, 20)) * scale, block((60, 0, 0), (90, 20, 10)) * scale])
    noise = np.random.default_rng(seed).uniform(-1e-4, 1e-4, fine.shape)
    found = load_part(str(part_file(tmp_path, fine + noise)))
    assert rules(found) == []
    assert len(found.faces) == 12


def test_what_is_ignored_is_the_name_or_direction_of_a_face(tmp_path: Path) -> None:
    text = "faces: {ignore: [bore*, {normal: [1, 1, 0]}, face-2]}\n"
    found = load_part(str(part_file(tmp_path, CUBE, text)))
    assert rules(found) == ["part-ignores-nothing"] * 2
    assert found.findings[0].message == (
        "faces: ignore: 'bore*' is of no face; the part has face-1 to face-6. Correct it, or leave it out."
    )
    assert "the normal (1, 1, 0) is of no face" in found.findings[1].message
    assert sum(face.serve for face in found.faces) == 5


def test_holes_are_filled_up_to_the_width_that_a_part_file_states(tmp_path: Path) -> None:
    part = load_part(str(part_file(tmp_path, CUBE[1:], body="file: thing.stl, fill_holes_mm: 60")))
    (found,) = part.findings
    assert found.rule.id == "part-holes-filled"
    width, middle = np.ptp(CUBE[0], axis=0), CUBE[0].mean(axis=0)
    at = ", ".join(f"{each:.1f}" for each in middle)
    assert found.message == (f"1 hole was filled; the widest, {np.linalg.norm(width):.1f} mm, is at {at} mm.")
    whole = load_part(str(write_stl(tmp_path / "cube.stl", CUBE)))
    assert [face.area_mm2 for face in part.faces] == pytest.approx([face.area_mm2 for face in whole.faces])
    none = load_part(str(part_file(tmp_path, CUBE, body="file: thing.stl, fill_holes_mm: 60")))
    assert rules(none) == ["part-holes-none"]
    assert "fill_holes_mm: 60: there is no hole as narrow as this" in none.findings[0].message


def test_normals_that_point_inwards_are_mended_with_a_finding(tmp_path: Path) -> None:
    flipped = CUBE.copy()
    flipped[[2, 5]] = flipped[[2, 5]][:, ::-1]
    part = load_part(str(part_file(tmp_path, flipped)))
    assert rules(part) == ["part-normals"]
    assert "2 of 12 patches" in part.findings[0].message
    middle = part.patches.reshape(-1, 3).mean(axis=0)
    assert (np.einsum("ij,ij->i", part.normals, part.patches.mean(axis=1) - middle) > 0).all()


def test_an_open_mesh_and_one_that_crosses_itself_are_found(tmp_path: Path) -> None:
    assert rules(load_part(str(part_file(tmp_path, CUBE[1:])))) == ["part-open"]
    crossing = np.concatenate([CUBE, block((20.5, 10.3, 5.7), (60, 22, 50))])
    found = load_part(str(part_file(tmp_path, crossing)))
    assert [(each.rule.id, each.severity) for each in found.findings] == [("part-crosses-itself", "error")]


def test_patches_without_an_area_are_left_out_and_a_part_of_them_is_refused(tmp_path: Path) -> None:
    flat = np.concatenate([CUBE, [[[0, 0, 0], [10, 0, 0], [20, 0, 0]]]])
    assert "part-patches" in rules(load_part(str(part_file(tmp_path, flat))))
    with pytest.raises(BoardError, match="no face with an area"):
        load_part(str(part_file(tmp_path, flat[-1:])))


@pytest.mark.parametrize("far", ["1e300", "1e308", "1e155", "20000", "nan"])
@pytest.mark.parametrize("suffix", ["stl", "obj", "xyz"])
def test_a_corner_beyond_all_bounds_is_one_quiet_error(
    suffix: str, far: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    corners = ["0 0 0", f"{far} 0 1", f"1 {far} 0"]
    facet = "\n".join(f"vertex {each}" for each in corners)
    content = {
        "stl": f"solid x\nfacet normal 0 0 1\nouter loop\n{facet}\nendloop\nendfacet\nendsolid x\n",
        "obj": "".join(f"v {each}\n" for each in corners) + "f 1 2 3\n",
        "xyz": "\n".join(corners),
    }[suffix]
    (tmp_path / f"thing.{suffix}").write_text(content)
    turned = f"part: x\nbody: {{file: thing.{suffix}, mm_per_unit: 100, at: {{rpy_deg: [10, 20, 30]}}}}\n"
    (tmp_path / "part.yaml").write_text(turned)
    for name in (f"thing.{suffix}", "part.yaml"):
        with pytest.raises(BoardError, match=r"more than 1?0 m away|beyond 10 m|1 different points"):
            load_part(tmp_path / name)
    assert capfd.readouterr() == ("", "")


def test_a_part_inside_its_fixture_is_refused_with_the_fixture_named(tmp_path: Path) -> None:
    text = "fixtures: {tub: {kind: box, size_mm: [200, 200, 200]}}\n"
    with pytest.raises(BoardError, match=r"thing\.yaml: the part lies inside its fixture tub"):
        load_part(str(part_file(tmp_path, CUBE, text)))
    text = "fixtures: {clamp: {kind: box, size_mm: [20, 60, 50], at: {xyz_mm: [0, 15, 10]}}}\n"
    assert rules(load_part(str(part_file(tmp_path, CUBE, text)))) == ["part-in-fixture"]
    text = "fixtures: {table: {kind: box, size_mm: [200, 200, 20], at: {xyz_mm: [0, 0, -10]}}}\n"
    assert rules(load_part(str(part_file(tmp_path, CUBE, text)))) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("body: {file: gone.stl}", r"thing\.yaml:2: body\.file: gone\.stl: "),
        ("body: {file: ../thing.stl}", r"thing\.yaml:2: body\.file: \.\./thing\.stl: is outside the folder"),
        ("body: {file: thing.stl}\nfixtures: {jaw: {kind: ball}}", r"thing\.yaml:3: fixtures\.jaw"),
        ("body: {file: thing.stl}\nfaces: {split: 3}", r"thing\.yaml:3: faces\.split"),
        ("body: {file: thing.stl}\nfaces: {ignore: [{normal: [0, 0, 0]}]}", r"has no direction"),
    ],
)
def test_a_mistake_in_a_part_file_is_named_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    write_stl(tmp_path / "thing.stl", CUBE)
    (tmp_path / "thing.yaml").write_text(f"part: thing\n{text}\n")
    with pytest.raises(BoardError, match=message):
        load_part(str(tmp_path / "thing.yaml"))


def test_a_round_wall_is_one_face_and_small_faces_get_no_stripes() -> None:
    part = part_of(cylinder(20, 50))
    assert sorted(face.flat for face in part.faces) == [False, True, True]
    sliver = np.concatenate([CUBE, block((50, 0, 0), (50.5, 0.5, 20))])
    assert "part-face-tiny" in rules(understand_part([body("p", "part", sliver)], "p", FaceChoice()))
