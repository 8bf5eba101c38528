"""Designs: grids in order, Latin hypercubes with each part of each range once, deviations as distributed."""

from typing import Any

import numpy as np

from studies.study import Study, Tolerances, design_points, draw_deviations, latin_hypercube

STUDY: dict[str, Any] = {"study": "x", "boards": ["tiny"], "recipes": ["smt-aqueous"]}


def study(**keys: Any) -> Study:
    return Study.model_validate(STUDY | keys)


def test_a_study_without_variables_has_one_point() -> None:
    assert design_points(study()) == [()]


def test_a_grid_has_every_combination_in_order() -> None:
    variables = [{"path": "a", "values": [40, "auto"]}, {"path": "b", "low": 1, "high": 2, "steps": 3}]
    points = design_points(study(variables=variables))
    assert points == [(40, 1), (40, 1.5), (40, 2), ("auto", 1), ("auto", 1.5), ("auto", 2)]


def test_a_latin_hypercube_has_each_part_of_each_range_once_and_is_seeded() -> None:
    variables = [{"path": "a", "low": 0, "high": 20}, {"path": "b", "values": ["x", "y"]}]

    def points(seed: int) -> list[Any]:
        design = {"method": "latin_hypercube", "points": 20, "seed": seed}
        return design_points(study(variables=variables, design=design))

    drawn = points(3)
    assert sorted(int(each[0]) for each in drawn) == list(range(20))
    assert [each[1] for each in drawn].count("x") == 10
    assert drawn == points(3) != points(4)


def test_shares_fill_every_part_in_every_column() -> None:
    shares = latin_hypercube(50, 3, seed=7)
    assert np.array_equal(np.sort((shares * 50).astype(int), axis=0), np.repeat(np.arange(50)[:, None], 3, axis=1))


def test_deviations_are_distributed_as_stated() -> None:
    deviations = {
        "standoff_mm": {"distribution": "normal", "mean": 1.0, "sigma": 0.5},
        "turn_deg": {"distribution": "uniform", "low": -2.0, "high": 1.0},
    }
    tolerances = Tolerances.model_validate({"samples": 1000, "seed": 5, "deviations": deviations})
    drawn = draw_deviations(tolerances)
    standoff = np.array([dict(each)["standoff_mm"] for each in drawn])
    turn = np.array([dict(each)["turn_deg"] for each in drawn])
    assert abs(standoff.mean() - 1.0) < 0.01
    assert abs(standoff.std() - 0.5) < 0.01
    assert abs(np.mean(np.abs(standoff - 1.0) < 0.5) - 0.6827) < 0.005
    assert turn.min() < -1.99
    assert turn.max() > 0.99
    assert abs(turn.mean() + 0.5) < 0.01
    assert abs(np.corrcoef(standoff, turn)[0, 1]) < 0.1
    assert drawn == draw_deviations(tolerances)
