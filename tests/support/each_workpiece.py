"""A workpiece of each kind with recipe, program and tables, and commands that run on them in a folder of their own."""

import re
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile, copytree

import numpy as np
import pytest
from command import Outcome, contents, washboard
from PIL import Image
from small_parts import block

import cleaning
from boards.load import board_library
from robotcell.placement.placement_map import MapGrid

BOARD_RECIPE = """
recipe: brief
functions: {wash: {solution: saponifier-15, temperature_c: 60, pressure_bar: 3.5, max_speed_mm_s: 120}}
nozzles:
  ring60: {pattern: hollow_cone, half_angle_deg: 30, ring_sigma_deg: 3, flow_lpm: 2, at_bar: 3, tool: 1}
classes: {any: {}}
templates: {lines: {path: raster, height_mm: 60, speed_mm_s: 60, pitch_mm: 30}}
limits: {park_height_mm: 120}
sequence: [{function: wash, nozzle: ring60, paths: [lines]}]
"""
PART_RECIPE = """
recipe: faces
functions: {wash: {solution: water, pressure_bar: 3, max_speed_mm_s: 120}}
nozzles: {ring60: {pattern: full_cone, half_angle_deg: 15, flow_lpm: 1, body: {radius_mm: 8, length_mm: 100}}}
classes: {}
templates: {all: {path: surface, standoff_mm: 60, required_s: 0.2, repair: false, width_mm: 30}}
sequence: [{function: wash, nozzle: ring60, paths: [all]}]
"""
KINDS = ("board", "panel", "part", "cloud")
SOURCES = {"board": "small.tri", "panel": "two.yaml", "part": "plate.yaml", "cloud": "points.xyz"}
RECIPES = {"board": "brief.yaml", "panel": "brief.yaml", "part": "faces.yaml", "cloud": "faces.yaml"}
CELL = "gantry"
DEMO = Path(cleaning.__path__[0]) / "library" / "demo"
COAT = """recipe: coat
functions: {coat: {solution: saponifier-15, temperature_c: 25, pressure_bar: 3.0, max_speed_mm_s: 700}}
nozzles: {fan: {pattern: radial, radius_mm: 40, at_mm: 200, flow_lpm: 0.0301593, at_bar: 3.0}}
classes: {other: {}}
templates: {sweep: {path: raster, height_mm: 200, speed_mm_s: 400}}
sequence: [{function: coat, nozzle: fan, paths: [sweep]}]
"""

FEW_PLACES = 40
"""A search of a place is short: whether an option is heard does not depend on how far it gets; but for some."""


@dataclass(frozen=True, slots=True)
class CoarseGrid(MapGrid):
    """Where a map is, with few nodes."""

    counts: tuple[int, int, int] = (6, 5, 4)


def make_inputs(folder: Path) -> Path:
    """A workpiece of each kind with its recipe, another recipe and its program, and the tables that options name."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(folder)
        write_inputs(folder)
        for kind in KINDS:
            done = washboard("plan", SOURCES[kind], RECIPES[kind], "-o", f"{kind}.wash")
            assert done.code == 0, (kind, done.err)
    return folder


def write_obj(file: Path, patches: np.ndarray) -> None:
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in patches.reshape(-1, 3)]
    lines += [f"f {3 * n + 1} {3 * n + 2} {3 * n + 3}" for n in range(len(patches))]
    file.write_text("\n".join(lines) + "\n", "utf-8")


def _changed(recipe: str) -> str:
    return (
        recipe.replace("recipe: faces", "recipe: faces-2")
        .replace("flow_lpm: 2", "flow_lpm: 3")
        .replace("required_s: 0.2", "required_s: 0.9")
    )


def write_inputs(folder: Path) -> None:
    tiny = board_library()["tiny"].read_text("utf-8")
    nominal = re.sub(r"(object C1 .*)", r"\1 x-height=assumed", tiny)
    assert nominal != tiny
    (folder / "small.tri").write_text(nominal, "utf-8")
    (folder / "small-2.tri").write_text(nominal.replace("value=SENSOR", "value=OTHER"), "utf-8")
    (folder / "two.yaml").write_text("panel: {board: small.tri, nx: 2, pitch_mm: [50, 0]}\n", "utf-8")
    write_obj(folder / "plate.obj", block((0, 0, 0), (60, 40, 10)))
    ignored = "faces: {ignore: [face-2, face-3, face-4, face-5, face-6]}"
    (folder / "plate.yaml").write_text(f"part: plate\nbody: {{file: plate.obj}}\n{ignored}\n", "utf-8")
    (folder / "two-2.yaml").write_text("panel: {board: small-2.tri, nx: 2, pitch_mm: [50, 0]}\n", "utf-8")
    write_obj(folder / "plate-2.obj", block((0, 0, 0), (60, 44, 10)))
    (folder / "plate-2.yaml").write_text(f"part: plate\nbody: {{file: plate-2.obj}}\n{ignored}\n", "utf-8")
    x, y = np.mgrid[0:41:1.0, 0:31:1.0].reshape(2, -1)
    for name, bend in (("points", 0.002), ("points-2", 0.003)):
        np.savetxt(folder / f"{name}.xyz", np.column_stack([x, y, bend * (x - 20) ** 2]), fmt="%.3f")
    recipes = {"brief": BOARD_RECIPE, "faces": PART_RECIPE}
    for name, text in recipes.items():
        (folder / f"{name}.yaml").write_text(text, "utf-8")
        (folder / f"{name}-2.yaml").write_text(_changed(text), "utf-8")
    (folder / "coat.yaml").write_text(COAT, "utf-8")
    other = "parameters: other\nextends: default\nlimits: {gap_residue_clean: 0.0001}\n"
    (folder / "other.yaml").write_text(other, "utf-8")
    (folder / "measured.csv").write_text("component,method,value,unit,limit\nU1,ic,3,ug/cm2,2\n", "utf-8")
    (folder / "table.csv").write_text("Designator,Package,Height\nU1,SOIC-8,2.5\nC1,C_0805,3.5\n", "utf-8")
    for name in ("ring", "pattern", "coupons"):
        copyfile(DEMO / f"{name}.csv", folder / f"{name}.csv")
    x, y = np.mgrid[0:140, 0:140] - 69.5
    Image.fromarray(np.where(x**2 + y**2 < 50**2, 20, 235).astype(np.uint8)).save(folder / "disc.png")


def run_in(folder: Path, inputs: Path, words: tuple[str, ...], places: int) -> tuple[Outcome, dict[str, bytes]]:
    """What a command prints, and the files that it leaves besides its inputs; a search looks at so many places."""
    copytree(inputs, folder)
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(folder)
        monkeypatch.setattr("robotcell.placement.optimise.MOST_EVALUATIONS", places)
        monkeypatch.setattr("robotcell.placement.optimise._COUNTS", {1: (4, 6, 3), 2: (4, 6, 3), 3: (3, 4, 2)})
        monkeypatch.setattr("robotcell.placement.placement_map.MapGrid", CoarseGrid)
        outcome = washboard(*words)
    before = contents(inputs)
    return outcome, {name: data for name, data in contents(folder).items() if before.get(name) != data}
