"""Parts from the shell: shown, planned, checked, written, analysed."""

import json
from pathlib import Path

import numpy as np
import pytest
from command import washboard
from PIL import Image
from small_parts import block

from boards.part.load import load_part

RECIPE = """
recipe: plate
functions: {clean: {solution: water, pressure_bar: 3, max_speed_mm_s: 120}}
nozzles: {jet: {pattern: full_cone, half_angle_deg: 15, flow_lpm: 1, body: {radius_mm: 8, length_mm: 100}}}
classes: {}
templates: {all: {path: surface, standoff_mm: 60, required_s: 1}}
sequence: [{function: clean, nozzle: jet, paths: [all]}]
"""


def write_obj(file: Path, patches) -> None:
    corners = patches.reshape(-1, 3)
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in corners]
    lines += [f"f {3 * n + 1} {3 * n + 2} {3 * n + 3}" for n in range(len(patches))]
    file.write_text("\n".join(lines) + "\n")


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    write_obj(tmp_path / "plate.obj", block((0, 0, 0), (60, 40, 10)))
    text = "part: plate\nbody: {file: plate.obj}\nfaces: {ignore: [face-2, face-3, face-4, face-5, face-6]}\n"
    (tmp_path / "plate.yaml").write_text(text)
    (tmp_path / "recipe.yaml").write_text(RECIPE)
    return tmp_path


@pytest.mark.slow
def test_a_part_is_planned_written_and_judged_face_by_face(plate: Path) -> None:
    out, recipe = plate / "out.wash", plate / "recipe.yaml"
    done = washboard("plan", plate / "plate.yaml", recipe, "-o", out, "--report", plate / "r.json")
    assert done.code == 0, done.err
    assert "5 stripes on 1 faces" in done.out
    report = json.loads((plate / "r.json").read_text())
    assert report["part"]["name"] == "plate"
    assert report["coverings"][0]["faces"][0]["held_share"] >= 0.99
    found = washboard("analyse", out, plate / "plate.yaml", "--recipe", recipe, "--json", plate / "a.json")
    assert found.code == 0, found.err + found.out
    assert json.loads((plate / "a.json").read_text())["faces"][0]["verdict"] == "clean"


@pytest.mark.slow
def test_a_mesh_alone_is_a_part_for_a_recipe_over_surfaces(plate: Path) -> None:
    done = washboard("plan", plate / "plate.obj", plate / "recipe.yaml", "-o", plate / "out.wash")
    assert done.code == 0, done.err
    assert (plate / "out.wash").exists()


@pytest.mark.slow
def test_the_canonical_text_is_planned_like_its_sources(plate: Path) -> None:
    text, recipe = plate / "plate.tri", plate / "recipe.yaml"
    assert washboard("part", "import", plate / "plate.yaml", "-o", text).code == 0
    for source, out in ((plate / "plate.yaml", "one.wash"), (text, "two.wash")):
        assert washboard("plan", source, recipe, "-o", plate / out).code == 0
    assert (plate / "one.wash").read_bytes() == (plate / "two.wash").read_bytes()


@pytest.mark.slow
def test_what_forbids_a_plan_leaves_nothing_half_written(plate: Path) -> None:
    write_obj(plate / "plate.obj", block((0, 0, 0), (60, 40, 10)).repeat(1, axis=0)[:, :, :])
    crossing = (plate / "plate.obj").read_text() + "v 20 20 -20\nv 25 22 30\nv 30 25 30\nf 37 38 39\n"
    (plate / "plate.obj").write_text(crossing)
    out = plate / "out.wash"
    done = washboard("plan", plate / "plate.obj", plate / "recipe.yaml", "-o", out)
    assert done.code == 2
    assert "--allow part-crosses-itself" in done.err
    assert not out.exists()


def test_mixtures_of_boards_and_parts_are_refused(plate: Path) -> None:
    done = washboard("plan", plate / "plate.yaml", "smt-aqueous")
    assert (
        done.code,
        "is a path over boards, and plate is a part. Open a recipe for parts, such as part-degrease" in done.err,
    ) == (2, True)
    done = washboard("plan", "tiny", plate / "recipe.yaml")
    assert (done.code, "tiny is a board. Open a recipe for boards" in done.err) == (2, True)
    done = washboard("plan", plate / "plate.yaml", plate / "recipe.yaml", "--parts", plate / "none.csv")
    assert (done.code, "--parts is for boards; " in done.err) == (2, True)


@pytest.mark.slow
def test_the_card_of_a_part_has_its_faces_and_a_picture(plate: Path) -> None:
    picture = plate / "p.png"
    done = washboard("part", "show", plate / "plate.yaml", "--recipe", plate / "recipe.yaml", "--picture", picture)
    assert done.code == 0, done.err
    assert "face-1" in done.out
    assert "100.0%" in done.out
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "f-bracket" in washboard("part", "list").out


@pytest.fixture
def picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A disc of 100 pixels."""
    monkeypatch.chdir(tmp_path)
    y, x = np.mgrid[0:140, 0:140] - 69.5
    Image.fromarray(np.where(x**2 + y**2 < 50**2, 20, 235).astype(np.uint8)).save("disc.png")
    return tmp_path


@pytest.mark.slow
def test_a_scan_is_a_part_for_the_other_commands(picture: Path) -> None:
    words = ("part", "scan", "disc.png", "disc.png", "--mm-per-pixel", "0.5", "--symmetry", "revolution")
    outcome = washboard(*words, "-o", "ball.tri", "--picture", "ball.png")
    assert (outcome.code, outcome.err) == (0, "")
    assert "a body of revolution" in outcome.out
    assert outcome.out.endswith("Part     ball.tri\nPicture  ball.png\n")
    assert load_part(picture / "ball.tri").name == "ball"
    assert washboard(*words, "-o", "ball.tri.gz").code == 0
    assert load_part(picture / "ball.tri.gz").sha256 == load_part(picture / "ball.tri").sha256


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--mm-per-pixel", "0.5", "-o", "ball.stl"), "part texts end in .tri"),
        (("--mm-per-pixel", "0", "-o", "ball.tri"), "0 mm per pixel is no scale"),
        (("--mm-per-pixel", "0.5", "--side-mm-per-pixel", "0", "-o", "ball.tri"), "0 mm per pixel is no scale"),
        (("--mm-per-pixel", "0.5", "--side-mm-per-pixel", "0.6", "-o", "ball.tri"), "mm high"),
        (("--mm-per-pixel", "0.5", "--symmetry", "extrusion", "-o", "ball.tri"), "neither view is a rectangle"),
        (("--mm-per-pixel", "0.5", "-o", "disc.png"), "it is read by this command"),
    ],
)
def test_what_cannot_be_scanned_is_refused_and_nothing_is_written(
    picture: Path, words: tuple[str, ...], said: str
) -> None:
    outcome = washboard("part", "scan", "disc.png", "disc.png", *words)
    assert outcome.code == 2
    assert said in outcome.err
    assert [each.name for each in picture.iterdir()] == ["disc.png"]
