"""The two stages of the order, against proofs by constraint programming."""

import numpy as np
import pytest
from ortools.sat.python import cp_model

from rulesengine.surface.order import order_pieces, shortest_ways
from rulesengine.surface.site import Piece

STEP_MM = 0.05


def piece(face: str, begin, end) -> Piece:
    tcp = np.array([begin, end], dtype=np.float64)
    down = np.tile([0.0, 0.0, -1.0], (2, 1))
    return Piece(face, tcp, tcp, down, np.zeros(2), np.ones(1), np.zeros(2))


def random_pieces(count: int, faces: int, seed: int) -> list[Piece]:
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, 200, (count, 2, 3))
    return [piece(f"face-{number % faces}", *place) for number, place in enumerate(places)]


def proved_mm(ends: list[list[tuple[np.ndarray, np.ndarray, float]]], start: np.ndarray | None) -> float:
    """Least travel through one way of each stroke, each given as entry, exit and its own cost; proved by CP-SAT."""
    model, arcs, cost = cp_model.CpModel(), [], []
    nodes = [(stroke, way) for stroke, ways in enumerate(ends) for way in range(len(ways))]
    index = {node: number + 1 for number, node in enumerate(nodes)}

    def arc(tail: int, head: int, length: float):
        literal = model.new_bool_var("")
        arcs.append((tail, head, literal))
        cost.append(round(length / STEP_MM) * literal)
        return literal

    used = {node: model.new_bool_var("") for node in nodes}
    for node in nodes:
        enter, leave, own = ends[node[0]][node[1]]
        arcs.append((index[node], index[node], ~used[node]))
        cost.append(round(own / STEP_MM) * used[node])
        arc(0, index[node], 0.0 if start is None else float(np.linalg.norm(enter - start)))
        arc(index[node], 0, 0.0)
        for other in nodes:
            if other[0] != node[0]:
                arc(index[node], index[other], float(np.linalg.norm(ends[other[0]][other[1]][0] - leave)))
    for stroke, ways in enumerate(ends):
        model.add_exactly_one(used[stroke, way] for way in range(len(ways)))
    model.add_circuit(arcs)
    model.minimize(sum(cost))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.random_seed = 1
    assert solver.solve(model) == cp_model.OPTIMAL
    return solver.objective_value * STEP_MM


def both_ways(each: Piece) -> list[tuple[np.ndarray, np.ndarray, float]]:
    return [(each.tcp[0], each.tcp[-1], 0.0), (each.tcp[-1], each.tcp[0], 0.0)]


@pytest.mark.parametrize("count", [2, 7, 9])
def test_the_way_through_a_face_is_the_shortest_that_can_be_proved(count: int) -> None:
    pieces = random_pieces(count, 1, seed=count)
    ways = shortest_ways(pieces, list(range(count)))
    assert ways[0].air_mm == pytest.approx(proved_mm([both_ways(each) for each in pieces], None), abs=STEP_MM * count)


@pytest.mark.slow
def test_with_twelve_stripes_each_stage_is_the_shortest_that_can_be_proved() -> None:
    pieces, start = random_pieces(12, 1, seed=3), np.array([100.0, 100.0, 300.0])
    ways = shortest_ways(pieces, list(range(12)))
    assert ways[0].air_mm == pytest.approx(proved_mm([both_ways(each) for each in pieces], None), abs=STEP_MM * 12)
    one = order_pieces(pieces, start, "one_stage")
    assert one.air_mm == pytest.approx(proved_mm([both_ways(each) for each in pieces], start), abs=STEP_MM * 13)


def test_faces_are_ordered_as_edges_from_entry_to_exit() -> None:
    pieces, start = random_pieces(12, 4, seed=8), np.array([0.0, 0.0, 250.0])
    ends = []
    for face in range(4):
        members = [number for number in range(12) if number % 4 == face]
        ways = shortest_ways(pieces, members)
        entry = [pieces[way.order[0]].tcp[-1 if way.turned[0] else 0] for way in ways]
        leave = [pieces[way.order[-1]].tcp[0 if way.turned[-1] else -1] for way in ways]
        ends.append([(*both, way.air_mm) for *both, way in zip(entry, leave, ways, strict=True)])
    ordered = order_pieces(pieces, start, "two_stage")
    assert ordered.air_mm == pytest.approx(proved_mm(ends, start), abs=STEP_MM * 16)
    faces = [each.face for each in ordered.pieces]
    assert len(list(dict.fromkeys(faces))) == sum(a != b for a, b in zip([None, *faces], faces, strict=False))
    assert sorted(ordered.number) == list(range(12))


def test_equal_ways_and_both_senses_of_a_face_are_kept() -> None:
    rows = [piece("face-1", (0, y, 0), (100, y, 0)) for y in (0, 20, 40)]
    ways = shortest_ways(rows, [0, 1, 2])
    assert {(way.order, way.turned) for way in ways} == {
        (order, turned) for order in ((0, 1, 2), (2, 1, 0)) for turned in ((False, True, False), (True, False, True))
    }
    assert all(way.air_mm == pytest.approx(40) for way in ways)


def test_one_stage_is_never_longer_than_two() -> None:
    pieces, start = random_pieces(11, 3, seed=5), np.array([50.0, 50.0, 300.0])
    assert order_pieces(pieces, start, "one_stage").air_mm <= order_pieces(pieces, start, "two_stage").air_mm + 0.5
