"""A recipe holds for each board of a panel: its strokes are those of the single board, in one order for all."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from analysed import WASH, recipe_of
from installations import small_cell
from shapely import box

from boards.board import Board, Body
from boards.formats.prism import prism
from boards.load import load_board
from boards.panel import PanelLayout, compose_panel, turned_over
from boards.understand import understand
from programs.export import export
from programs.plan import SprayPass
from recipes.load import load_recipe
from recipes.recipe import Recipe
from rulesengine.planning.board_job import BoardJob, open_board_job
from rulesengine.planning.pipeline import run
from rulesengine.planning.stroke_order import move_stroke, order_strokes
from rulesengine.strokes.stroke import PlanCache
from specs.source import Source

PANEL = """panel:
  board: tiny
  nx: 2
  ny: 3
  pitch_mm: [40, 32]
  instances: [{}, {turn_deg: 90}, {side: bottom, turn_deg: 30, at: [-60, 30]}, {skip: true}]
  rails_mm: {left: 6, right: 6}
"""


@cache
def recipe() -> Recipe:
    return load_recipe("low-standoff")


@pytest.fixture(scope="module")
def panel(tmp_path_factory: pytest.TempPathFactory) -> Board:
    file = tmp_path_factory.mktemp("panel") / "six.yaml"
    file.write_text(PANEL, "utf-8")
    return load_board(file)


def job_of(board: Board) -> BoardJob:
    return open_board_job(recipe(), board, PlanCache())


@pytest.mark.slow
def test_strokes_are_those_of_the_single_board_after_the_transform(panel: Board) -> None:
    """Checked with a rotation and a translation written out here, on the top and on the bottom."""
    tiny = load_board(Path("tiny"))
    faces = {"1": tiny, "2": tiny, "3": turned_over(tiny), "5": tiny, "6": tiny}
    whole = job_of(panel)
    singles = {name: open_board_job(whole.recipe, board, PlanCache()) for name, board in faces.items()}
    compared = 0
    for index, step in enumerate(whole.recipe.sequence):
        for template in dict.fromkeys(step.paths):
            placed = list(whole.strokes(index, step, template).strokes)
            for instance in panel.instances:
                single = singles[instance.name]
                if not single.serves(step):
                    continue
                cos, sin = np.cos(instance.turn_rad), np.sin(instance.turn_rad)
                for known in single.strokes(index, step, template).strokes:
                    stroke = placed.pop(0)
                    x, y, z = known.tcp.T
                    moved = np.column_stack([cos * x - sin * y + instance.x_mm, sin * x + cos * y + instance.y_mm, z])
                    np.testing.assert_allclose(stroke.tcp, moved, atol=1e-9)
                    u, v, w = known.approach.T
                    turned = np.column_stack([cos * u - sin * v, sin * u + cos * v, w])
                    np.testing.assert_allclose(stroke.approach, turned, atol=1e-9)
                    np.testing.assert_array_equal(stroke.delays, known.delays)
                    assert stroke.speed_mm_s == known.speed_mm_s
                    assert stroke.made_by.components == tuple(
                        f"{name}@{instance.name}" for name in known.made_by.components
                    )
                    compared += 1
            assert not placed
    assert compared > 50


def between(strokes: tuple, start: np.ndarray) -> float:
    length = 0.0
    for stroke in strokes:
        length += float(np.linalg.norm(stroke.tcp[0] - start))
        start = stroke.tcp[-1]
    return length


@pytest.mark.slow
def test_one_order_over_the_panel_is_no_longer_than_board_after_board(panel: Board) -> None:
    whole = job_of(panel)
    step = next(step for step in whole.recipe.sequence if "around" in step.paths and step.side == "top")
    index = whole.recipe.sequence.index(step)
    made_by = Source(index, "around")
    together = whole.strokes(index, step, "around")
    assert together.freedom == "free"
    start = np.array([0.0, 0.0, 60.0])
    ordered = order_strokes(together, start, made_by)
    here, single = start, 0.0
    for instance in panel.instances:
        own = tuple(s for s in together.strokes if s.made_by.components[0].endswith(f"@{instance.name}"))
        if own:
            done = order_strokes(replace(together, strokes=own), here, made_by)
            single += between(done.strokes, here)
            here = done.strokes[-1].tcp[-1]
    assert between(ordered.strokes, start) <= single + 1e-6


def test_a_skipped_board_is_material_and_nothing_else(panel: Board) -> None:
    assert [instance.name for instance in panel.instances] == ["1", "2", "3", "5", "6"]
    assert not [each.name for each in panel.components if each.name.endswith("@4")]
    assert len(panel.components) == 5 * 5
    tiny = load_board(Path("tiny"))
    assert panel.outline.area > 6 * tiny.outline.area


def test_a_board_that_was_turned_over_lies_with_its_top_below(panel: Board) -> None:
    sides = {each.name: each.side for each in panel.components}
    assert {side for name, side in sides.items() if name.endswith("@3")} == {"bottom"}
    assert {side for name, side in sides.items() if not name.endswith("@3")} == {"top"}
    single = {each.name: each for each in load_board(Path("tiny")).components}
    for each in panel.components:
        known = single[each.name.partition("@")[0]]
        assert each.height_mm == pytest.approx(known.height_mm, abs=1e-6)
        assert each.area_mm2 == pytest.approx(known.area_mm2, rel=0.03)  # outlines are simplified within 0.05 mm


@pytest.mark.slow
def test_the_program_sprays_every_board_that_is_not_skipped(panel: Board) -> None:
    short = recipe_of(WASH, WASH.replace("paths", "side: bottom, paths"))
    done = run(short, panel)
    followed = {
        name.partition("@")[2]
        for item in done.plan.items
        if isinstance(item, SprayPass)
        for name in item.made_by.components
    }
    assert followed == {"1", "2", "3", "5", "6"}
    assert {each.component for each in done.classified} == {each.name for each in panel.components}
    assert not [finding for finding in done.findings if finding.severity == "error"]
    text = "\n".join(export(done.program, small_cell("abb"), "abb").files.values())
    assert "MoveL" in text


@pytest.mark.slow
def test_only_strokes_that_would_touch_a_neighbour_are_raised() -> None:
    """A tall part at the edge of the next board is in the way of the lane around this one."""
    tall = understand(
        [
            Body("pcb", "board", *prism(box(0, 0, 40, 30), -1.6, 0.0)),
            Body("J1", "component", *prism(box(1, 5, 6, 25), 0.0, 60.0), package="Header", side="top", pins=4),
            Body("R1", "component", *prism(box(20, 10, 26, 14), 0.0, 1.0), package="R_1206", side="top", pins=2),
        ],
        "tall",
    )
    layout = PanelLayout.model_validate_json('{"board": "tall", "nx": 2, "pitch_mm": [41, 0]}')
    panel = compose_panel(layout, tall, "pair")
    whole, single = job_of(panel), job_of(tall)
    changed = kept = 0
    for index, step in enumerate(whole.recipe.sequence):
        for template in dict.fromkeys(step.paths) if step.side == "top" and step.enabled else ():
            known = single.strokes(index, step, template).strokes
            placed = whole.strokes(index, step, template)
            raised = [each for each in placed.findings if each.rule.id == "raised-over-body"]
            floors, before = whole.ways("top").floors, changed
            for number, stroke in enumerate(placed.strokes):
                instance = panel.instances[number // len(known)]
                own = move_stroke(known[number % len(known)], instance)
                same = stroke.tcp.shape == own.tcp.shape and np.allclose(stroke.tcp, own.tcp, atol=1e-9)
                kept, changed = kept + same, changed + (not same)
                for begin, end in pairwise(stroke.tcp):
                    line = np.array([begin[:2], end[:2]])
                    spans = floors.spans(line, 0.0)
                    assert all(max(begin[2], end[2]) >= floor - 1e-3 for _, _, floor in spans)
            assert bool(raised) or changed == before
    assert changed > 0
    assert kept > 0
