import tempfile
from pathlib import Path

import numpy as np
import pytest
from step_writer import HEAD, Placed, StepWriter

from boards.board import Body
from boards.errors import BoardError
from boards.formats.scene import read_scene
from boards.formats.step import Structure, detach, name_products, read_structure
from boards.formats.tree import Node
from specs.finding import Finding

PARTS: list[Placed] = [
    ("R2", "R_0603", (1.6, 0.8, 0.5), (-8, 5, 1.6)),
    ("U1", "SOIC-8", (5, 4, 1.5), (5, 5, 1.6)),
    ("R1", "R_0603", (1.6, 0.8, 0.5), (-5, 5, 1.6)),
    ("bare", "card PCB", (40, 30, 1.6), (2, 1, 0)),
    ("M3 screw", "DIN912", (5, 5, 3), (18, -10, 1.6)),
    ("fixture plate", "plate", (80, 60, 5), (0, 0, -20)),
]


@pytest.fixture(scope="module")
def text() -> str:
    return StepWriter().write(PARTS)


Scene = tuple[tuple[Body, ...], tuple[Finding, ...], list[float]]


@pytest.fixture(scope="module")
def scene(text: str, tmp_path_factory: pytest.TempPathFactory) -> Scene:
    path = tmp_path_factory.mktemp("step") / "card.step"
    path.write_text(text)
    seen: list[float] = []
    bodies, findings = read_scene(path, lambda _, fraction: seen.append(fraction))
    return bodies, findings, seen


def test_bodies_stand_where_the_assembly_puts_them(scene: Scene) -> None:
    bodies = {body.name: body for body in scene[0]}
    assert list(bodies) == ["board", "M3_screw", "R1", "R2", "U1", "fixture_plate"]
    assert [bodies[name].role for name in ("board", "U1", "M3_screw")] == ["board", "component", "component"]
    for name, (_, _, size, at) in zip(("R2", "U1", "R1", "board"), PARTS, strict=False):
        low = np.array([at[0] - size[0] / 2, at[1] - size[1] / 2, at[2]])
        np.testing.assert_allclose(bodies[name].patches.min(axis=(0, 1)), low, atol=1e-4)
        np.testing.assert_allclose(bodies[name].patches.max(axis=(0, 1)), low + size, atol=1e-4)


def test_a_box_keeps_its_outward_normals(scene: Scene) -> None:
    part = next(body for body in scene[0] if body.name == "U1")
    middle = part.patches.reshape(-1, 3).mean(axis=0)
    outward = part.patches.mean(axis=1) - middle
    assert (np.einsum("ij,ij->i", outward, part.normals) > 0.0).all()
    assert sum(surface.patches for surface in part.surfaces) == len(part.patches) == 12


def test_products_are_the_packages(scene: Scene) -> None:
    packages = {body.name: body.package for body in scene[0] if body.role == "component"}
    assert packages == {"R2": "R_0603", "U1": "SOIC-8", "R1": "R_0603", "M3_screw": "DIN912"}


def test_what_does_not_stand_on_the_board_is_an_obstacle(scene: Scene) -> None:
    bodies, findings, _ = scene
    assert [body.role for body in bodies if body.name == "fixture_plate"] == ["fixture"]
    assert [finding.rule.id for finding in findings] == ["not-on-the-board"]


def test_progress_goes_forward_and_ends(scene: Scene) -> None:
    seen = scene[2]
    assert seen == sorted(seen)
    assert seen[0] == 0.0
    assert seen[-1] == 1.0
    assert any(0.0 < fraction <= 0.95 for fraction in seen)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is not a STEP file"),
        (b"hello, this is text\n", "is not a STEP file"),
        (HEAD.encode(), "is cut short"),
    ],
    ids=["empty", "text", "truncated"],
)
def test_what_is_no_step_file_is_refused(content: bytes, said: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.stp"
    path.write_bytes(content)
    with pytest.raises(BoardError, match=said):
        read_scene(path)


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["hole", "wireframe"])
def test_a_damaged_or_empty_assembly_is_one_quiet_error(
    damage: str, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    lines = text.splitlines()
    curves = "GEOMETRIC_CURVE_SET('',())"
    shown = {
        "hole": lines[:60] + lines[90:],
        "wireframe": [line.split("=")[0] + f"={curves};" if "FACETED_BREP(" in line else line for line in lines],
    }[damage]
    path = tmp_path / "bad.step"
    path.write_text("\n".join(shown) + "\n")
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    with pytest.raises(BoardError, match=r"bad\.step: .* Export "):
        read_scene(path)
    assert list(scratch.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_products_are_found_through_line_breaks_quotes_and_wide_letters() -> None:
    data = (
        b"#7 = PRODUCT('id','O''Brien; \\X2\\00B5\\X0\\C','',(#\n  8));\n#6 = PRODUCT_DEFINITION_FORMATION('','',#7);\n"
        b"#5 = PRODUCT_DEFINITION('design','',#6,#9);\n#15 = PRODUCT('by id','','',(#8));\n"
        b"#14 = PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE('','',#15,.MADE.);\n"
        b"#13 = PRODUCT_DEFINITION('design','',#14,#9);\n"
        b"#20 = NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','U1','',#1,#5\n  ,$);\n"
        b"#21 = NEXT_ASSEMBLY_USAGE_OCCURRENCE('2','R1','',#1,#13,$);\n"
        b"#22 = NEXT_ASSEMBLY_USAGE_OCCURRENCE('3','SOLID','',#1,#13,$);\n"
        b"#23 = NEXT_ASSEMBLY_USAGE_OCCURRENCE('4','SOLID','',#1,#5,$);\n"
    )
    assert read_structure(data) == Structure(
        products={"#5": "O'Brien; µC", "#13": "by id"},
        uses={"#1": (("U1", "#5"), ("R1", "#13"), ("SOLID", "#13"), ("SOLID", "#5"))},
        nameless=frozenset(),
    )


def test_a_place_without_a_description_still_has_its_product() -> None:
    data = (
        b"#7=PRODUCT('SOIC-8','SOIC-8',$,(#8));\n#6=PRODUCT_DEFINITION_FORMATION('',$,#7);\n"
        b"#5=PRODUCT_DEFINITION('design',$,#6,#9);\n#20=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','U1',$,#1,#5,$);\n"
    )
    structure = read_structure(data)
    assert structure.products == {"#5": "SOIC-8"}
    assert structure.uses == {"#1": (("U1", "#5"),)}


def test_a_name_that_stands_for_two_products_is_told_by_the_part_it_is_in() -> None:
    leaf = Node("body", "mesh", ())
    tree = Node("", "", (), (Node("card", "", (), (Node("U1", "", (), (leaf,)), Node("U2", "", (), (leaf,)))),))
    structure = Structure(
        products={"#1": "card", "#2": "first", "#3": "second", "#4": "case", "#5": "lid"},
        uses={"#1": (("U1", "#2"), ("U2", "#3")), "#2": (("body", "#4"),), "#3": (("body", "#5"),)},
        nameless=frozenset(),
    )
    card = name_products(tree, structure).children[0]
    assert [part.product for part in card.children] == ["first", "second"]
    assert [part.children[0].product for part in card.children] == ["case", "lid"]


@pytest.mark.slow
def test_places_without_names_are_called_by_their_products(tmp_path: Path) -> None:
    """As Altium Designer writes: the place has a number only, and the product is the reference designator."""
    parts: list[Placed] = [
        ("", "Board", (40, 30, 1.6), (2, 1, 0)),
        ("", "U7", (5, 4, 1.5), (5, 5, 1.6)),
        ("", "C1206", (3.2, 1.6, 1.2), (-8, 5, 1.6)),
        ("", "Extruded", (2, 2, 1), (-8, -5, 1.6)),
    ]
    (tmp_path / "card.step").write_text(StepWriter().write(parts))
    bodies, _ = read_scene(tmp_path / "card.step")
    assert [body.name for body in bodies] == ["board", "part-1", "C1206", "U7"]


EXTERNAL = """#901=DOCUMENT_TYPE('');
#902=DOCUMENT_FILE('{name}','',$,#901,'',$);
#903=IDENTIFICATION_ROLE('external document id and location',$);
#904=EXTERNAL_SOURCE(IDENTIFIER(''));
#905=APPLIED_EXTERNAL_IDENTIFICATION_ASSIGNMENT('{name}',#903,#904,(#902));
#906=DOCUMENT_REPRESENTATION_TYPE('digital',#902);
#907=PRODUCT('X9','X9','',(#2));
#908=PRODUCT_DEFINITION_FORMATION('','',#907);
#909=PRODUCT_DEFINITION('design','',#908,#3);
#910=APPLIED_DOCUMENT_REFERENCE(#902,'',(#909));
#911=OBJECT_ROLE('mandatory',$);
#912=ROLE_ASSOCIATION(#911,#910);
#913=PRODUCT_DEFINITION_SHAPE('','',#909);
#914=SHAPE_REPRESENTATION('',(#11),#7);
#915=SHAPE_DEFINITION_REPRESENTATION(#913,#914);
#916=NEXT_ASSEMBLY_USAGE_OCCURRENCE('9','X9','',#14,#909,$);
#917=PRODUCT_DEFINITION_SHAPE('','',#916);
#918=ITEM_DEFINED_TRANSFORMATION('','',#11,#11);
#919=(REPRESENTATION_RELATIONSHIP('','',#914,#16) REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#918)
SHAPE_REPRESENTATION_RELATIONSHIP());
#920=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#919,#917);
"""
"""A part whose model is in another file, as OpenCASCADE reads and writes it."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "before"),
    [
        ("{folder}/secret.step", ""),
        ("{folder}/secret.step", "/* ' */"),
        ("../outside/secret.step", ""),
        ("secret.step", ""),
    ],
)
def test_a_step_file_names_no_other_file(
    name: str, before: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "outside"
    folder.mkdir()
    secret = StepWriter().write([("secret", "SECRET", (7, 7, 7), (0, 0, 0))])
    (folder / "secret.step").write_text(secret)
    monkeypatch.chdir(folder)
    parts: list[Placed] = [("board", "card PCB", (40, 30, 1.6), (0, 0, 0)), ("U1", "SOIC/8", (5, 4, 1.5), (5, 5, 1.6))]
    card = StepWriter().write(parts)
    more = before + EXTERNAL.format(name=name.format(folder=folder))
    path = tmp_path / "card.step"
    path.write_text(card.replace("ENDSEC;\nEND-ISO", f"{more}ENDSEC;\nEND-ISO"))
    bodies, findings = read_scene(path)
    assert [(body.name, body.package) for body in bodies] == [("board", None), ("U1", "SOIC_8")]
    reported = " ".join(finding.message for finding in findings)
    assert "X9" in reported
    assert "secret" not in reported.lower()


def test_names_keep_their_slashes_where_no_file_is_named() -> None:
    assert detach(b"PRODUCT('SOT-23/5')/* a */") == b"PRODUCT('SOT-23/5')/* a */"
    assert detach(b"/* a */document_file('/b/c')") == b"/* a */document_file('_b_c')"
