"""The order of strokes against OR-Tools and against long runs of our own, for random strokes and for those of boards.

Run: ``OMP_NUM_THREADS=1 python benchmarks/route.py [--seconds 60] [--random 40 150 ...] [BOARD.tri ...]``

A board stands for the strokes whose order the planner is free to choose with the recipe smt-aqueous. OR-Tools is its
routing solver, guided local search, each way through a stroke a node and exactly one of them visited. The best known is
the best of all that was found: by us, by OR-Tools, and by us with twenty times the effort and other random numbers.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from ortools.constraint_solver import pywrapcp, routing_enums_pb2

import rulesengine.planning.stroke_order
from boards.formats.tri.tri import read_tri
from boards.understand import understand
from geometry.arrays import Indices, Points
from geometry.coverage.local_search import choose_ways, search_order
from geometry.coverage.route import Choices, Route, shortest_route
from geometry.coverage.tour import MICRONS_PER_MM, ROUNDING, Network, build_network
from recipes.load import load_recipe
from rulesengine.planning.pipeline import make_plan

LONG_RUNS = 2
LONG_EFFORT = 20.0


def random_strokes(count: int) -> tuple[Choices, Points]:
    """Open strokes of about 25 mm on a square of 200 mm, in any direction, either sense."""
    rng = np.random.default_rng(count)
    begin = rng.uniform(0, 200, (count, 2))
    ends = np.stack((begin, begin + rng.normal(0, 20, (count, 2))), axis=1)
    ends = np.concatenate((ends, np.full((count, 2, 1), 40.0)), axis=2)
    return Choices(tuple(ends), tuple(ends[:, ::-1])), np.array([100.0, 100.0, 60.0])


def board_strokes(path: Path) -> list[tuple[Choices, Points]]:
    """Every set of strokes that the planner hands over to be ordered, and where the nozzle is then."""
    asked: list[tuple[Choices, Points]] = []

    def listen(choices: Choices, start: Points, end: Points | None = None) -> Route:
        asked.append((choices, start))
        return shortest_route(choices, start, end)

    bodies, findings = read_tri(path)
    rulesengine.planning.stroke_order.shortest_route = listen
    make_plan(load_recipe("smt-aqueous"), understand(bodies, path.stem, findings))
    rulesengine.planning.stroke_order.shortest_route = shortest_route
    return asked


def by_ortools(network: Network, seconds: float) -> int:
    """Micrometres of the best route that OR-Tools finds."""
    ways = len(network.stroke)
    away = np.linalg.norm(network.exit[:, None] - network.entry[None], axis=2)
    legs = np.floor(away * MICRONS_PER_MM + ROUNDING).astype(np.int64)
    legs[:, ways - 1] = 0
    manager = pywrapcp.RoutingIndexManager(ways, 1, [ways - 2], [ways - 1])
    model = pywrapcp.RoutingModel(manager)
    nodes = [manager.IndexToNode(index) for index in range(manager.GetNumberOfIndices())]
    model.SetArcCostEvaluatorOfAllVehicles(model.RegisterTransitMatrix(legs.tolist()))
    for s in range(len(network.first) - 3):
        model.AddDisjunction(
            [manager.NodeToIndex(way) for way in range(network.first[s], network.first[s + 1])], 10**9, 1
        )
    search = pywrapcp.DefaultRoutingSearchParameters()
    search.first_solution_strategy = routing_enums_pb2.FirstSolutionStrategy.PATH_CHEAPEST_ARC
    search.local_search_metaheuristic = routing_enums_pb2.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    search.time_limit.FromMilliseconds(round(1000 * seconds))
    found = model.SolveWithParameters(search)
    stops: list[int] = [model.Start(0)]
    while not model.IsEnd(stops[-1]):
        stops.append(found.Value(model.NextVar(stops[-1])))
    order = network.stroke[[nodes[stop] for stop in stops]]
    assert len(order) == len(network.first) - 1, "OR-Tools left strokes out"
    return length_um(network, order)


def length_um(network: Network, order: Indices) -> int:
    return int(choose_ways(network, order)[0])


def compare(name: str, choices: Choices, start: Points, seconds: float) -> None:
    """Print one line of the table."""
    begin = time.process_time()
    network = build_network(choices.entries, choices.exits, start, None)
    ours = length_um(network, search_order(network))
    spent = time.process_time() - begin
    theirs = by_ortools(network, seconds)
    longer = [length_um(network, search_order(network, LONG_EFFORT, seed)) for seed in range(1, LONG_RUNS + 1)]
    best = min(ours, theirs, *longer)
    print(
        f"| {name} | {len(choices.entries)} | {len(network.stroke) - 2} | {ours / 1000:.1f} | {spent:.2f} "
        f"| {theirs / 1000:.1f} | {ours / max(theirs, 1):.4f} | {best / 1000:.1f} | {ours / max(best, 1):.4f} |",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("boards", nargs="*", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--random", nargs="*", type=int, default=[40, 150, 500, 2000])
    asked = parser.parse_args()
    warm, start = random_strokes(12)
    shortest_route(warm, start)
    print(
        "| strokes of | strokes | ways | ours, mm | s | OR-Tools, mm | ours / OR-Tools | best known, mm | ours / best |"
    )
    print("| --- | --: | --: | --: | --: | --: | --: | --: | --: |")
    for path in asked.boards:
        for choices, start in board_strokes(path):
            compare(path.stem, choices, start, asked.seconds)
    for count in asked.random:
        compare("random", *random_strokes(count), asked.seconds)


if __name__ == "__main__":
    main()
