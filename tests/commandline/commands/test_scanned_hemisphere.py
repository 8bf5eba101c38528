"""A hemisphere that is scanned goes the way of any part: planned, checked and fed by the same commands."""

import re
from pathlib import Path

import numpy as np
import pytest
from command import washboard
from PIL import Image

from recipes.load import recipe_library
from robotcell.cell.load import cell_library

RADIUS_MM, MM_PER_PIXEL, FINER = 20.0, 0.25, 8
SHORTER = {"tcp: {xyz_mm: [0, 0, 180]}  ": "tcp: {xyz_mm: [0, 0, 140]}  ", "155]": "115]", "173]": "133]"}
"""The tool is 40 mm shorter: around the equator it points at the robot and away from it, level."""
HOME = "home_deg_mm: [-100, -110, -60, -60, 90, 0]"
SHORT_TOOL = """  1:
    name: short
    tcp: {xyz_mm: [0, 0, 60]}
    bodies:
      changer: {kind: cylinder, from_mm: [0, 0, 0], to_mm: [0, 0, 25], radius_mm: 28}
      nozzle: {kind: capsule, from_mm: [0, 0, 25], to_mm: [0, 0, 53], radius_mm: 7}
"""


def silhouette(file: Path) -> Path:
    """A half disc with grey edges, as a camera sees it."""
    width, height = int((2 * RADIUS_MM + 20) / MM_PER_PIXEL), int((RADIUS_MM + 10) / MM_PER_PIXEL)
    y, x = np.mgrid[0 : height * FINER, 0 : width * FINER] + 0.5
    x, z = x / FINER - width / 2, height - 5 - y / FINER
    inside = (np.hypot(x, z) * MM_PER_PIXEL <= RADIUS_MM) & (z >= 0.0)
    share = inside.reshape(height, FINER, width, FINER).mean(axis=(1, 3))
    Image.fromarray(np.round(235 - 215 * share).astype(np.uint8)).save(file)
    return file


def raised_cell() -> str:
    """The library's UR5e with the hemisphere at the height of its shoulder."""
    text = cell_library()["ur5e-bench"].read_text()
    knife = text.index("  2:\n    name: knife")
    tool = text[:knife]
    for before, after in SHORTER.items():
        tool = tool.replace(before, after)
    text = tool + text[knife:]
    text = re.sub(r"^home_deg_mm: .*$", HOME, text, count=1, flags=re.MULTILINE)
    text = re.sub(r"pose: \{xyz_mm: \[[^\]]*\]\}", "pose: {xyz_mm: [438, -20, 330]}", text, count=1)
    text = re.sub("  jet30: .*", "  jet30: {valve: doRing60, min_pulse_s: 0.05, round: true}", text)
    return "\n".join(line for line in text.splitlines() if "language-server" not in line) + "\n"


def cairo_cell() -> str:
    """The arm of the Cairo paper with a tool of 60 mm, the hemisphere on a stand 500 mm before it, 300 mm up."""
    text = cell_library()["cairo-bench"].read_text()
    first, second = text.index("  1:\n    name: cone"), text.index("  2:\n    name: knife")
    text = text[:first] + SHORT_TOOL + text[second:]
    text = text.replace("pose: {xyz_mm: [420, -50, 150]}", "pose: {xyz_mm: [480, -20, 300]}", 1)
    stand = "  stand: {kind: box, size_mm: [20, 20, 295], at: {xyz_mm: [500, 0, 147.5]}}"
    text = re.sub(r"^  holder: .*$", stand, text, flags=re.MULTILINE)
    text = re.sub("  jet30: .*", "  jet30: {valve: doRing60, min_pulse_s: 0.05, round: true}", text)
    return "\n".join(line for line in text.splitlines() if "language-server" not in line) + "\n"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program for the hemisphere, beside it."""
    folder = tmp_path_factory.mktemp("hemisphere")
    front, side = silhouette(folder / "front.png"), silhouette(folder / "side.png")
    part, recipe, planned = folder / "hemisphere.tri", folder / "near.yaml", folder / "hemisphere.wash"
    scale = ("--mm-per-pixel", MM_PER_PIXEL, "--symmetry", "revolution")
    assert washboard("part", "scan", front, side, *scale, "-o", part).code == 0
    text = recipe_library()["part-degrease"].read_text().replace("standoff_mm: 60", "standoff_mm: 30")
    recipe.write_text(text.replace("width_mm: auto", "width_mm: 12.5"))  # circles of one distance, as in the paper
    assert washboard("plan", part, recipe, "-o", planned).code == 0
    return planned


@pytest.mark.slow
def test_a_scanned_hemisphere_is_planned_checked_and_fed(program: Path, tmp_path: Path) -> None:
    cell = tmp_path / "raised.yaml"
    cell.write_text(raised_cell())
    checked = washboard("check", program, cell)
    assert checked.code == 0, checked.out
    assert "can be done" in checked.out
    # At the equator the jet is level and the wrist nearly singular: slowed to the joints' limits, and printed.
    fifth = re.search(r"^wrist_2 +(-?[\d.]+) +(-?[\d.]+) deg ", checked.out, re.MULTILINE)
    assert fifth is not None
    assert min(abs(float(fifth[1])), abs(float(fifth[2]) - 180)) < 10
    assert "speed-not-held" in checked.out
    assert "is at its greatest acceleration" in checked.out
    speeds = [int(each) for each in re.findall(r"(\d+) deg/s ", checked.out)]
    assert len(speeds) == 6
    assert 100 < max(speeds) <= 180
    log = tmp_path / "dry.csv"
    fed = washboard("operate", program, "--cell", cell, "--dry", "--log", log)
    assert fed.code == 0, fed.err
    assert washboard("operate", "--replay", log).code == 0


@pytest.mark.slow
def test_the_arm_of_the_cairo_paper_does_the_hemisphere_with_a_short_tool(program: Path, tmp_path: Path) -> None:
    """Slowed around the equator, where the wrist is near singular: joints 4 and 6 turn against each other at once."""
    cell = tmp_path / "cairo.yaml"
    cell.write_text(cairo_cell())
    checked = washboard("check", program, cell)
    assert checked.code == 0, checked.out
    assert "in cairo-bench (cairo): can be done" in checked.out
    assert "speed-not-held" in checked.out
    assert "near-singular" in checked.out
    assert "is at its greatest acceleration" in checked.out
    rows = re.findall(r"^J\d .* (\d+) deg/s +(\d+)% +(\d+) deg/s. +(\d+)%$", checked.out, re.MULTILINE)
    assert len(rows) == 6
    assert [int(rows[joint][3]) for joint in (3, 5)] == [100, 100]
    assert max(int(share) for _, share, _, _ in rows) < 100
    taken, programmed = map(
        float, re.findall(r"^time +([\d.]+) s, programmed ([\d.]+) s", checked.out, re.MULTILINE)[0]
    )
    assert programmed < taken < 1.25 * programmed
