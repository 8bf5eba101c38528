import json
from pathlib import Path

import pytest
from command import contents, washboard

from programs.load import load_program
from programs.program import SetNozzle
from rulesengine.timing.time_plan import ACCELERATION_SHARE


@pytest.mark.slow
def test_a_plan_for_a_cell_states_it_with_its_price_and_gives_the_same_bytes(tmp_path: Path) -> None:
    pytest.importorskip("coal")
    words = ("plan", "tiny", "rinse-only", "--cell", "kr6-bench")
    done = washboard(*words, "-o", tmp_path / "a.wash", "--report", tmp_path / "a.json")
    assert done.code == 0, done.err
    assert "kr6-bench (kr6-r900): " in done.out
    assert "longer than the recipe's limits allow" in done.out
    program, data = load_program(tmp_path / "a.wash"), json.loads((tmp_path / "a.json").read_text())
    assert program.origin.cell == "kr6-bench"
    assert data["cell"] == {"name": "kr6-bench", "sha256": program.origin.cell_sha256}
    assert data["robot"]["planned_s"] == pytest.approx(program.totals.duration_s, abs=1e-3)
    assert data["robot"]["robot_s"] <= 1.03 * data["robot"]["planned_s"]
    assert washboard(*words, "-o", tmp_path / "b.wash").code == 0
    assert (tmp_path / "b.wash").read_bytes() == (tmp_path / "a.wash").read_bytes()
    assert washboard("check", tmp_path / "a.wash", "ur5e-bench").code == 0  # another cell takes it too


def test_a_cell_that_does_not_exist_is_one_error_and_nothing_is_written(tmp_path: Path) -> None:
    done = washboard("plan", "tiny", "--cell", "ur5-bensh", "-o", tmp_path / "a.wash")
    assert done.code == 2
    assert done.err.startswith("error: ")
    assert "ur5-bensh" in done.err
    assert contents(tmp_path) == {}


def test_a_program_does_not_replace_the_cell_it_is_planned_for(tmp_path: Path) -> None:
    cell = tmp_path / "cell.wash"
    cell.write_text("cell: mine\n")
    done = washboard("plan", "tiny", "--cell", cell, "-o", cell)
    assert done.code == 2
    assert "read by this command" in done.err
    assert cell.read_text() == "cell: mine\n"


PLATE = """board-tri 1
units mm
objects 1
object board surfaces 2 role=board
surface top patches 2
0 0 0 600 0 0 600 400 0 0 0 1
0 0 0 600 400 0 0 400 0 0 0 1
surface bottom patches 2
0 0 -1.6 600 400 -1.6 600 0 -1.6 0 0 -1
0 0 -1.6 0 400 -1.6 600 400 -1.6 0 0 -1
"""
SEGMENT = "  segment_{}: {{path: straight_line, from: [{}, {}], to: [{}, {}], height_mm: 100, speed_mm_s: 600}}\n"
CAIRO = """recipe: cairo-plate
functions:
  clean: {{solution: saponifier-15, temperature_c: 60, pressure_bar: 3.5, max_speed_mm_s: 600}}
nozzles:
  cone: {{pattern: full_cone, half_angle_deg: 15, flow_lpm: 1.2}}
classes: {{all: {{}}}}
templates:
{segments}limits: {{acceleration_mm_s2: {acceleration}, transfer_speed_mm_s: 600, blend_mm: 0, park_height_mm: 150}}
sequence:
  - {{function: clean, nozzle: cone, paths: [{names}]}}
"""


@pytest.mark.parametrize(("count", "seconds"), [(1, 1.2), (9, 12.866)])
def test_the_plate_of_the_cairo_paper_takes_its_time(count: int, seconds: float, tmp_path: Path) -> None:
    """Section 5: 60 x 40 cm at 10 cm, segments 5 cm apart, 0.6 m/s and 3 m/s2; links go from rest to rest."""
    ways = [(0, 600) if number % 2 == 0 else (600, 0) for number in range(count)]
    segments = [SEGMENT.format(number, a, 50 * number, b, 50 * number) for number, (a, b) in enumerate(ways)]
    names = ", ".join(f"segment_{number}" for number in range(count))
    text = CAIRO.format(segments="".join(segments), acceleration=3000.0 / ACCELERATION_SHARE, names=names)
    (tmp_path / "plate.tri").write_text(PLATE)
    (tmp_path / "cairo.yaml").write_text(text)
    done = washboard("plan", tmp_path / "plate.tri", tmp_path / "cairo.yaml", "-o", tmp_path / "plate.wash")
    assert done.code == 0, done.err
    switched = [
        item.time_s for item in load_program(tmp_path / "plate.wash").instructions if isinstance(item, SetNozzle)
    ]
    assert len(switched) == 2 * count
    assert round(switched[-1] - switched[0], 3) == seconds
