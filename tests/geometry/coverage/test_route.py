"""The order of strokes: proved best for few strokes, and always a fair order that moves with the strokes."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ortools.sat.python import cp_model

from geometry.coverage.route import Choices, forget_routes, shortest_route

KINDS = ("segments", "rings", "clustered", "collinear", "fixed", "mixed")
PROVABLE = {"rings": 10, "collinear": 30}
"""Strokes up to which CP-SAT's proof takes seconds where it takes minutes for more"""
END = np.array([110.0, 0.0, 60.0])
START = np.array([-10.0, -10.0, 60.0])


def lines(begin, end):
    """Open strokes that may be done either way."""
    return [(np.array([a, b]), np.array([b, a])) for a, b in zip(begin, end, strict=True)]


def flat(places):
    return np.column_stack((places, np.full(len(places), 40.0)))


def grid_of_rings(rng, count):
    across = int(np.ceil(np.sqrt(count)))
    made = []
    for number in range(count):
        angle = np.arange(rng.integers(4, 9)) * 0.7 + rng.uniform(0, 1)
        offset = 14.0 * np.array([number % across, number // across]) + rng.uniform(-1, 1, 2)
        ring = flat(offset + np.stack((np.cos(angle), np.sin(angle)), axis=1) * rng.uniform(1, 5, 2))
        made.append((ring, ring))
    return made


def mixed_strokes(rng, count):
    made = []
    for number in range(count):
        a = rng.uniform(0, 100, 3)
        b = a + rng.normal(0, 20, 3)
        ring = a + rng.normal(0, 4, (3, 3))
        made += [[(a[None], b[None])], lines([a], [b]), [(ring, ring)]][number % 3]
    return made


def strokes_of(kind, count, seed):
    rng = np.random.default_rng([seed, count, KINDS.index(kind)])
    begin = rng.uniform(0, 100, (count, 2))
    if kind == "rings":
        made = grid_of_rings(rng, count)
    elif kind == "mixed":
        made = mixed_strokes(rng, count)
    elif kind == "clustered":
        begin = begin[rng.integers(0, 1 + count // 6, count)] + rng.normal(0, 3, (count, 2))
        made = lines(flat(begin), flat(begin + rng.normal(0, 4, (count, 2))))
    elif kind == "collinear":
        along = rng.integers(0, 300, count)
        reach = along + rng.integers(-30, 31, count)
        made = lines(flat(np.stack((along, 0 * along), axis=1)), flat(np.stack((reach, 0 * along), axis=1)))
    else:
        made = lines(flat(begin), flat(begin + rng.normal(0, 15, (count, 2))))
        made = [(a[:1], b[:1]) for a, b in made] if kind == "fixed" else made
    return Choices(tuple(a for a, _ in made), tuple(b for _, b in made))


def legs_um(choices, start, end):
    """(w + 1, w + 1) from the exit of each way to the entry of each, the start, and the end, which come last."""
    entry, leave = np.vstack((*choices.entries, start)), np.vstack((*choices.exits, start))
    legs = np.linalg.norm(leave[:, None] - entry[None], axis=2)
    legs[:, -1] = 0.0 if end is None else np.linalg.norm(leave - end, axis=1)
    return np.floor(1000 * legs + 0.4567).astype(int)


def proved_best_um(choices, start, end, hint):
    """The length of the best route with CP-SAT's proof: a circuit over the ways, and one over whole strokes.

    The second circuit follows from the first; without it the bound stays far below what can be reached. The hint only
    tells where to look first.
    """
    counts = [*(len(entry) for entry in choices.entries), 1]
    stroke = np.repeat(np.arange(len(counts)), counts)
    first = np.cumsum([0, *counts])
    legs = legs_um(choices, start, end)
    model = cp_model.CpModel()
    used = [model.new_bool_var("") for _ in stroke]
    pairs = [(a, b) for a in range(len(stroke)) for b in range(len(stroke)) if stroke[a] != stroke[b]]
    arcs = {pair: model.new_bool_var("") for pair in pairs}
    model.add_circuit([*((a, b, arc) for (a, b), arc in arcs.items()), *((a, a, ~way) for a, way in enumerate(used))])
    between = {}
    for (a, b), arc in arcs.items():
        between.setdefault((int(stroke[a]), int(stroke[b])), []).append(arc)
    model.add_circuit([(s, t, sum_of(model, found)) for (s, t), found in between.items()])
    for s in range(len(counts)):
        model.add_exactly_one(used[first[s] : first[s + 1]])
    model.minimize(sum(int(legs[pair]) * arc for pair, arc in arcs.items()))
    ways = [len(stroke) - 1, *(first[s] + way for s, way in zip(hint.order, hint.choice, strict=True))]
    taken = set(zip(ways, [*ways[1:], ways[0]], strict=True))
    for pair, arc in arcs.items():
        model.add_hint(arc, pair in taken)
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.linearization_level = 2
    solver.parameters.cp_model_probing_level = 0  # half of the time, and the proof does not need it
    solver.parameters.max_time_in_seconds = 120
    status = solver.solve(model)
    assert status == cp_model.OPTIMAL, solver.status_name(status)
    return round(solver.objective_value)


def sum_of(model, literals):
    """A literal that holds if exactly one of others does, where at most one can."""
    one = model.new_bool_var("")
    model.add(sum(literals) == one)
    return one


def walked_um(choices, start, end, route):
    """The length of a route, counted leg by leg."""
    legs = legs_um(choices, start, end)
    first = np.cumsum([0, *(len(entry) for entry in choices.entries)])
    ways = [first[s] + way for s, way in zip(route.order, route.choice, strict=True)]
    stops = [len(legs) - 1, *ways, len(legs) - 1]
    return int(sum(legs[a, b] for a, b in pairwise(stops)))


def check_best(kind, count, seed, end):
    choices = strokes_of(kind, count, seed)
    route = shortest_route(choices, START, end)
    assert round(1000 * route.length_mm) == proved_best_um(choices, START, end, route)


@pytest.mark.slow
@pytest.mark.parametrize("end", [None, END], ids=["open", "end"])
@pytest.mark.parametrize("kind", KINDS)
def test_five_strokes_are_in_the_best_order(kind, end):
    check_best(kind, 5, 1, end)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "rings"])
def test_ten_strokes_are_in_the_best_order(kind):
    check_best(kind, 10, 2, END if kind == "mixed" else None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "count", "end"),
    [
        (kind, count, (None, END)[(number + step) % 2])
        for number, kind in enumerate(KINDS)
        for step, count in enumerate((10, 20, 40))
        if count <= PROVABLE.get(kind, 40)
    ],
)
def test_up_to_forty_strokes_are_in_the_best_order(kind, count, end):
    check_best(kind, count, 3, end)


@st.composite
def instances(draw):
    count = draw(st.integers(1, 14))
    choices = strokes_of(draw(st.sampled_from(KINDS)), count, draw(st.integers(0, 10_000)))
    return choices, draw(st.sampled_from([None, END]))


@pytest.mark.slow
@given(instances())
@settings(max_examples=25)
def test_every_stroke_is_done_once_and_the_length_is_that_of_the_legs(instance):
    choices, end = instance
    route = shortest_route(choices, START, end)
    assert sorted(route.order) == list(range(len(choices.entries)))
    assert all(0 <= way < len(choices.entries[s]) for s, way in zip(route.order, route.choice, strict=True))
    assert walked_um(choices, START, end, route) == round(1000 * route.length_mm)
    assert route.length_mm <= route.given_length_mm


@pytest.mark.slow
@given(instances())
@settings(max_examples=15)
def test_strokes_given_in_the_order_found_are_not_done_in_a_longer_one(instance):
    choices, end = instance
    route = shortest_route(choices, START, end)
    again = Choices(tuple(choices.entries[s] for s in route.order), tuple(choices.exits[s] for s in route.order))
    second = shortest_route(again, START, end)
    assert second.given_length_mm <= route.length_mm
    assert second.length_mm <= route.length_mm


@pytest.mark.slow
@given(instances(), st.floats(-180, 180), st.floats(-500, 500), st.floats(-500, 500))
@settings(max_examples=25)
def test_order_moves_with_the_strokes(instance, angle_deg, x, y):
    choices, end = instance
    sin, cos = np.sin(np.radians(angle_deg)), np.cos(np.radians(angle_deg))

    def moved(points):
        return points @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]) + [x, y, 0.0]

    there = Choices(tuple(map(moved, choices.entries)), tuple(map(moved, choices.exits)))
    here = shortest_route(choices, START, end)
    route = shortest_route(there, moved(START), None if end is None else moved(end))
    assert (route.order, route.choice, route.length_mm) == (here.order, here.choice, here.length_mm)


@pytest.mark.parametrize("count", [0, 1])
def test_nothing_to_order(count):
    route = shortest_route(strokes_of("segments", count, 0), START, END)
    assert route.order == tuple(range(count))
    if count == 0:
        assert route.length_mm == pytest.approx(np.linalg.norm(END - START))


def test_a_single_line_begins_at_the_end_that_is_nearer():
    far_end_first = Choices(*([made] for made in lines([[90.0, 0, 0]], [[10.0, 0, 0]])[0]))
    route = shortest_route(far_end_first, np.zeros(3))
    assert route.choice == (1,)
    assert route.length_mm == pytest.approx(10)


@pytest.mark.parametrize("count", [2, 9, 10, 30])
def test_strokes_in_one_place_are_done_without_travel(count):
    places = tuple(np.zeros((2, 3)) for _ in range(count))
    route = shortest_route(Choices(places, places), np.array([0.0, 0.0, 5.0]))
    assert sorted(route.order) == list(range(count))
    assert route.length_mm == pytest.approx(5)


def test_identical_strokes_are_done_there_and_back():
    same = lines([[10.0, 0, 0]] * 12, [[30.0, 0, 0]] * 12)
    route = shortest_route(Choices(tuple(a for a, _ in same), tuple(b for _, b in same)), np.zeros(3))
    assert route.length_mm == pytest.approx(10)
    assert len(set(pairwise(route.choice))) == 2


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2])
def test_few_strokes_with_very_many_ways(count):
    angle = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    rings = tuple(flat(np.stack((np.cos(angle) + 10 * n, np.sin(angle)), axis=1)) for n in range(1, count + 1))
    route = shortest_route(Choices(rings, rings), np.array([0.0, 0.0, 40.0]))
    assert route.length_mm == pytest.approx([9, 19][count - 1], abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=pytest.mark.slow if kind in ("clustered", "fixed") else ()) for kind in KINDS],
)
def test_a_sketch_is_a_route_that_is_no_longer_than_the_given_one_nor_shorter_than_the_full_one(kind):
    choices = strokes_of(kind, 30, 1)
    forget_routes()
    sketch, full = (shortest_route(choices, START, effort=effort) for effort in ("sketch", "full"))
    assert sorted(sketch.order) == list(range(30))
    assert full.length_mm <= sketch.length_mm <= sketch.given_length_mm
    assert full.settled
    assert not sketch.settled


@pytest.mark.slow
def test_a_sketch_is_the_route_itself_where_that_is_known_or_found_at_once():
    known, few = strokes_of("segments", 30, 1), strokes_of("segments", 5, 1)
    forget_routes()
    route = shortest_route(known, START)
    assert shortest_route(known, START, effort="sketch") == route
    sketch = shortest_route(few, START, effort="sketch")
    assert sketch.settled
    forget_routes()
    assert shortest_route(few, START) == sketch


@pytest.mark.slow
def test_whoever_is_told_how_far_the_search_is_may_end_it():
    def stop(what, done):
        told.append((what, done))
        if done >= 0.5:
            raise InterruptedError

    choices, told = strokes_of("rings", 30, 2), []
    forget_routes()
    with pytest.raises(InterruptedError):
        shortest_route(choices, START, progress=stop)
    assert 20 <= len(told) <= 30
    assert {what for what, _ in told} == {"refining the order of 30 strokes"}
    whole = shortest_route(choices, START, progress=lambda *_: None)
    forget_routes()
    assert shortest_route(choices, START) == whole
