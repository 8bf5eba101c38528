"""The order of the objects in a file changes neither program nor report."""

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from command import washboard

from boards.board import Part, Surface
from boards.formats.tri.tri import write_tri
from boards.load import load_board
from boards.part.load import load_part
from boards.part.sources import part_library


def written(folder: Path, workpiece: Path, recipe: str) -> list[bytes]:
    """Program, plan report and report of the analysis."""
    folder.mkdir()
    program, plan, analysis = folder / "a.wash", folder / "plan.json", folder / "analysis.json"
    planned = washboard("plan", workpiece, recipe, "--output", program, "--report", plan)
    assert planned.code == 0, planned.err
    analysed = washboard("analyse", program, workpiece, "--json", analysis)
    assert analysed.code in (0, 1), analysed.err
    return [file.read_bytes().replace(str(folder).encode(), b"") for file in (program, plan, analysis)]


def described(part: Part) -> tuple[object, ...]:
    faces = [(face.name, face.patches.tolist(), face.serve) for face in part.faces]
    return part.sha256, [body.name for body in part.bodies], faces, part.findings


@pytest.mark.slow
def test_shuffled_objects_of_a_board_give_the_same_bytes(tmp_path: Path) -> None:
    bodies, dice = list(load_board(Path("two-sided")).bodies), random.Random(11)
    file, found = tmp_path / "two-sided.tri", list[list[bytes]]()
    for number in range(2):
        dice.shuffle(bodies)
        file.write_text(write_tri(bodies), "utf-8")
        found.append(written(tmp_path / str(number), file, "smt-aqueous"))
    assert found[0] == found[1]


@pytest.mark.slow
def test_shuffled_instances_of_a_panel_give_the_same_bytes(tmp_path: Path) -> None:
    instances = [{"at": [0, 0]}, {"at": [33, 0], "turn_deg": 90}, {"at": [0, 44], "side": "bottom"}, {"at": [33, 44]}]
    file, found = tmp_path / "p.yaml", list[list[bytes]]()
    for order in ((0, 1, 2, 3), (2, 3, 1, 0)):
        panel = {"board": "tiny", "instances": [instances[number] for number in order]}
        file.write_text(yaml.safe_dump({"panel": panel}), "utf-8")
        found.append(written(tmp_path / str(order[0]), file, "rinse-only"))
    assert found[0] == found[1]


@pytest.mark.slow
def test_shuffled_fixtures_of_a_part_give_the_same_part(tmp_path: Path) -> None:
    source = part_library()["f-bracket"]
    (tmp_path / "f-bracket.obj").write_bytes(source.with_name("f-bracket.obj").read_bytes())
    stated, found = yaml.safe_load(source.read_text("utf-8")), list[tuple[object, ...]]()
    for step in (1, -1):
        shuffled = {**stated, "fixtures": dict(list(stated["fixtures"].items())[::step])}
        (tmp_path / "f.yaml").write_text(yaml.safe_dump(shuffled, sort_keys=False), "utf-8")
        found.append(described(load_part(tmp_path / "f.yaml")))
    assert found[0] == found[1]


@pytest.mark.slow
def test_shuffled_bodies_of_a_part_give_the_same_part(tmp_path: Path) -> None:
    """Two bodies that are cleaned, and two that hold them."""
    part = load_part("f-bracket")
    patches = np.add(part.own_bodies[0].patches, [0.0, 0.0, 600.0])
    surfaces = (Surface("whole", len(patches)),)
    second = replace(part.own_bodies[0], name="part-2", patches=patches, surfaces=surfaces, extra=())
    bodies, dice, found = [*part.bodies, second], random.Random(5), list[tuple[object, ...]]()
    for number in range(4):
        dice.shuffle(bodies)
        file = tmp_path / f"p{number}.tri"
        file.write_text(write_tri(bodies), "utf-8")
        found.append(described(load_part(file)))
    assert all(each == found[0] for each in found)
