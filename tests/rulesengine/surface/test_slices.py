"""Slices over free-form faces: evenly apart, the fewest of all directions, the same however the part lies."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from curved_parts import grid, tube, wave, wavy_sheet
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation
from small_parts import part_of

from boards.board import Part
from boards.part.understand import understand_part
from programs.plan import SprayPass
from recipes.load import parse_recipe
from recipes.paths import Slices
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import run
from rulesengine.surface.site import build_site
from rulesengine.surface.striping import divide
from rulesengine.surface.striping.divide import Sliced, stripe_slices
from specs.source import Source

RECIPE = """
recipe: small
functions: {clean: {solution: water, pressure_bar: 3, max_speed_mm_s: 120}}
nozzles: {jet: {pattern: full_cone, half_angle_deg: 15, flow_lpm: 1, body: {radius_mm: 8, length_mm: 100}}}
classes: {}
templates: {all: {path: slices, standoff_mm: 60, %s}}
limits: {clearance_mm: 2}
sequence: [{function: clean, nozzle: jet, paths: [all]}]
"""
STARTS = pytest.mark.parametrize("start", ["geodesic", "plane"])


def slices_recipe(keys: str = "repair: false") -> Recipe:
    return parse_recipe(RECIPE % keys)


def sliced(part: Part, keys: str) -> Sliced:
    recipe = slices_recipe(keys)
    spec = recipe.templates["all"]
    assert isinstance(spec, Slices)
    site = build_site(part, recipe, Source(0, "all"))
    (face,) = part.served
    return stripe_slices(site, spec, face)


def long_sheet() -> Part:
    return part_of(wavy_sheet(10.0, (80.0, 160.0)), split_deg=60)


def open_tube() -> Part:
    return part_of(tube(20.0, 50.0, 36, 6), split_deg=60)


@pytest.mark.slow
@STARTS
@pytest.mark.parametrize("part_like", [long_sheet, open_tube])
def test_no_other_direction_has_fewer_curves(start: str, part_like, monkeypatch: pytest.MonkeyPatch) -> None:
    part = part_like()
    keys = f"start: {start}, spacing_mm: 15"
    chosen = sliced(part, keys)
    every, found = divide.directions_over, list[int]()
    tried = 13 if part_like is open_tube else 12
    for number in range(tried):
        monkeypatch.setattr(divide, "directions_over", lambda *at, number=number: every(*at)[[number]])
        found.append(len(sliced(part, keys).stripes))
    assert len(chosen.stripes) == min(found) < max(found)
    assert f"the fewest of {tried} directions tried" in chosen.text


def test_neighbouring_curves_of_a_geodesic_start_are_evenly_apart_over_the_surface() -> None:
    stripes = sliced(long_sheet(), "start: geodesic, spacing_mm: 20").stripes
    rows = sorted((each for each in stripes if len(each.targets) > 30), key=lambda each: each.targets[:, 0].mean())
    assert len(rows) == 5  # the start, and two on either side: four would do without it
    for one, two in pairwise(rows):
        dense = np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(one.targets)])
        apart = KDTree(dense).query(two.targets[8:-8])[0]
        assert apart.max() <= 20.0
        assert apart.min() >= 0.95 * apart.max()
    for each in rows:
        np.testing.assert_allclose(each.targets[:, 2], wave(*each.targets[:, :2].T), atol=0.15)
        assert (each.normals[:, 2] > 0.9).all()


@pytest.mark.slow
def test_a_cone_has_no_geodesic_that_halves_it_and_is_cut_by_planes() -> None:
    cone = grid(
        lambda a, z: np.column_stack([z * np.cos(a), z * np.sin(a), 60 - 1.5 * z]),
        np.linspace(0, 2 * np.pi, 25), np.linspace(40, 0, 7),
    )  # fmt: skip
    assert (
        "curves in parallel planes, the fewest of 12 directions"
        in sliced(part_of(cone, split_deg=60), "spacing_mm: 20").text
    )


@STARTS
def test_a_tube_is_gone_around_in_rings_that_close(start: str) -> None:
    stripes = sliced(open_tube(), f"start: {start}").stripes
    heights = sorted(each.targets[:, 2].mean() for each in stripes)
    assert len(stripes) == 3 if start == "geodesic" else 2
    assert np.diff(heights).max() <= 0.78 * 2 * 60 * np.tan(np.radians(15)) + 1e-6
    for each in stripes:
        assert each.closed
        np.testing.assert_allclose(each.targets[0], each.targets[-1], atol=1e-9)
        assert np.ptp(each.targets[:, 2]) < 0.5


@pytest.mark.slow
def test_nearly_all_of_a_sheet_is_held_and_the_finding_states_its_slices() -> None:
    done = run(slices_recipe("spacing_mm: auto"), long_sheet())
    covering = done.coverings[0]
    assert covering.share >= 0.99
    assert 0.85 <= covering.uniform_share < covering.share
    text = next(each.message for each in done.findings if each.rule.id == "surface-slices")
    assert text.startswith(f"face-1: {covering.stripes} curves parallel to a geodesic of 165 mm with ")
    assert "the fewest of 12 directions tried" in text


@pytest.mark.slow
@STARTS
def test_a_part_moved_and_turned_has_the_same_slices_and_each_time_the_same_bytes(start: str) -> None:
    bump = grid(
        lambda u, v: np.column_stack([u, v, 20 * np.exp(-(((u - 35) / 40) ** 2) - ((v - 55) / 30) ** 2)]),
        np.linspace(0, 90, 13), np.linspace(0, 140, 17),
    )  # fmt: skip
    part = part_of(bump, split_deg=60)
    turn = Rotation.from_euler("xyz", [20, -35, 70], degrees=True).as_matrix()
    shift = np.array([300.0, -120.0, 55.5])
    bodies = [
        replace(each, patches=each.patches @ turn.T + shift, normals=each.normals @ turn.T) for each in part.bodies
    ]
    keys = f"start: {start}, spacing_mm: 15"
    here, there = sliced(part, keys), sliced(understand_part(bodies, part.name, None), keys)
    again = sliced(part, keys)
    assert len(here.stripes) == len(there.stripes) > 4
    for one, two, same in zip(here.stripes, there.stripes, again.stripes, strict=True):
        np.testing.assert_allclose(two.targets, one.targets @ turn.T + shift, atol=0.05)
        np.testing.assert_allclose(two.normals, one.normals @ turn.T, atol=1e-3)
        assert same.targets.tobytes() == one.targets.tobytes()


@STARTS
@pytest.mark.parametrize("count", [1, 4, 7])
@pytest.mark.parametrize(("along", "cosine"), [((1, 0, 0), 0.98), ((0, -3, 0), 0.98), ((1, 1, 0.2), 0.95)])
def test_a_recipe_states_how_many_curves_run_which_way(start: str, count: int, along, cosine: float) -> None:
    found = sliced(long_sheet(), f"start: {start}, slices: {count}, along: {list(along)}")
    ways = np.array([each.targets[-1] - each.targets[0] for each in found.stripes])
    unit = np.array(along) / np.linalg.norm(along)
    assert len(ways) == count
    assert (np.abs(ways @ unit) / np.linalg.norm(ways, axis=1)).min() > cosine
    assert "along the stated direction" in found.text
    aside = np.cross(unit, (0, 0, 1))
    rows = sorted(found.stripes, key=lambda each: float(each.targets.mean(axis=0) @ aside))
    apart = [KDTree(one.targets).query(two.targets)[0].mean() for one, two in pairwise(rows)]
    assert count < 2 or max(apart) < 1.25 * min(apart)


@STARTS
def test_curves_along_the_axis_of_a_tube_are_lines_on_it(start: str) -> None:
    stripes = sliced(open_tube(), f"start: {start}, along: [0, 0, 2], slices: 3").stripes
    assert len(stripes) == 6  # each plane cuts it twice
    for each in stripes:
        assert not each.closed
        assert np.ptp(each.targets, axis=0)[:2] == pytest.approx([0, 0], abs=0.5)


def test_a_direction_that_stands_up_on_a_face_leaves_the_choice() -> None:
    chosen, left = sliced(long_sheet(), "along: [0, 0, 1]"), sliced(long_sheet(), "along: auto")
    assert [each.targets.tolist() for each in chosen.stripes] == [each.targets.tolist() for each in left.stripes]
    assert "as the face stands up along the stated direction" in chosen.text


@STARTS
def test_the_jet_runs_on_past_the_rim_straight_along_the_surface(start: str) -> None:
    keys = f"start: {start}, slices: 3, along: [0, 1, 0]"
    plain, over = (sliced(long_sheet(), f"{keys}, overshoot_mm: {each}").stripes for each in (0, 25))
    for short, long in zip(plain, over, strict=True):
        added = (len(long.targets) - len(short.targets)) // 2
        assert long.targets[added:-added].tolist() == short.targets.tolist()
        for ends, rim, inner in (
            (long.targets[: added + 1], short.targets[0], short.targets[1]),
            (long.targets[::-1][: added + 1], short.targets[-1], short.targets[-2]),
        ):
            assert np.linalg.norm(ends[0] - rim) == pytest.approx(25)
            assert np.cross(ends[0] - rim, rim - inner) == pytest.approx([0, 0, 0], abs=1e-6)
        assert (long.normals[:added] == short.normals[0]).all()
    rings = (sliced(open_tube(), f"start: {start}, overshoot_mm: {each}").stripes for each in (0, 25))
    assert len({str([each.targets.tolist() for each in one]) for one in rings}) == 1


@pytest.mark.slow
def test_a_plan_sprays_as_far_past_the_rim() -> None:
    plan = run(slices_recipe("slices: 5, along: [0, 1, 0], overshoot_mm: 25"), long_sheet()).plan
    y = np.concatenate([each.tcp[:, 1] for each in plan.items if isinstance(each, SprayPass)])
    assert (y.min(), y.max()) == pytest.approx((-25, 185), abs=8)  # the jet leans with the rim
