"""The library of solutions: names, provenance, precedence, and that sets of published coupons are those coupons."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from boards.load import load_board
from cleaning.analyse import analyse
from cleaning.parameters.chemistries import chemistries, fluxes, with_chemistries
from cleaning.parameters.load import load_parameters, parameter_library, read_parameters_text
from cleaning.parameters.model import Parameters
from cleaning.parameters.provenance import assumptions_of
from cleaning.process.stages import stages_of
from cleaning.verdicts.process_rules import judge_process
from recipes.load import load_recipe, parse_recipe
from rulesengine.planning.pipeline import run

LIBRARY = Path(__file__).parents[3] / "cleaning" / "library"
COUPONS = list(
    csv.DictReader(
        line
        for line in (LIBRARY / "chemistries" / "turi_coupons.csv").read_text("utf-8").splitlines()
        if not line.startswith("#")
    )
)
GAS_J = 8.314462618


@pytest.mark.parametrize("name", chemistries())
def test_every_value_states_how_it_is_known_and_nothing_else_does(name):
    chemistry = chemistries()[name]
    stated = chemistry.liquid.model_fields_set - {"use"}
    assert {"all"} <= set(chemistry.provenance) <= {*stated, "all"}
    own = with_chemistries(load_parameters(), [name])
    listed = {each.path: each.known for each in assumptions_of(own) if each.path.startswith(f"liquids.{name}.")}
    assert {f"liquids.{name}.{key}" for key in stated} <= set(listed)
    for key, entry in chemistry.provenance.items():
        assert key == "all" or listed[f"liquids.{name}.{key}"] == entry.known
    assert Parameters.model_validate(own.model_dump(exclude_unset=True)) == own
    assert name not in load_parameters().liquids


def test_a_set_that_has_the_name_has_precedence_and_unknown_names_change_nothing():
    parameters = load_parameters("water-soluble")
    assert with_chemistries(parameters, ["di-water-wash", "nobody-has-it"]) is parameters
    text = "parameters: own\nextends: default\nliquids: {tap-water: {use: rinse, resistivity_mohm_cm: 0.01}}\n"
    own = read_parameters_text(text + "provenance: {liquids.tap-water: {known: proposed, source: us}}\n")
    assert with_chemistries(own, ["tap-water"]).liquids["tap-water"].resistivity_mohm_cm == 0.01


def removed(product: str, percent: float) -> float:
    rows = [row for row in COUPONS if row["product"] == product and float(row["concentration_pct"]) == percent]
    return float(np.mean([float(row["removed_pct"]) for row in rows if percent != 100 or row["trial"] == "1"]))


@pytest.mark.parametrize(
    ("name", "product", "percent"), [("turi-swr-one", "swr-one", 10), ("turi-bio-t-max", "bio-t-max", 100)]
)
def test_the_rate_of_a_set_of_published_coupons_follows_from_them(name, product, percent):
    """-ln(1 - removed) / 300 s at 130 degrees F, carried to 60 degrees C with the activation energy of the set."""
    soil = load_parameters(name).soil
    rate = -math.log(1.0 - 0.01 * removed(product, percent)) / 300.0
    bath_k = (130.0 - 32.0) / 1.8 + 273.15
    rate *= math.exp(1000.0 * soil.activation_kj_mol / GAS_J * (1.0 / bath_k - 1.0 / 333.15))
    assert soil.k1_per_s == pytest.approx(rate, rel=0.01)
    assert soil.reference_pct == percent
    assert load_parameters(name).known("soil.k1_per_s").known == "derived"


def test_every_set_of_a_flux_names_its_kind():
    kinds = {name: load_parameters(name).soil.flux for name in parameter_library()}
    assert kinds == {
        "default": "rosin",
        "aged": "rosin",
        "no-clean-leadfree": "no_clean",
        "water-soluble": "water_soluble",
        "turi-swr-one": "rosin",
        "turi-bio-t-max": "rosin",
    }


def analysed(solution: str, parameters: Parameters):
    text = f"recipe: own\nextends: rinse-only\nfunctions: {{rinse: {{solution: {solution}, temperature_c: 60}}}}\n"
    board, recipe = load_board(Path("tiny")), parse_recipe(text)
    return analyse(run(recipe, board).program, board, recipe, parameters, "sketch")


def test_a_recipe_picks_a_solution_by_its_name():
    report = analysed("tap-water", load_parameters())
    assert {stage.liquid.resistivity_mohm_cm for stage in report.stages} == {0.003}
    assert "liquid-unknown" not in {each.rule.id for each in report.findings}
    known = {each.path: each for each in assumptions_of(report.parameters)}
    assert known["liquids.tap-water.resistivity_mohm_cm"].provenance.source.startswith("tap water of about 333")
    assert "liquids.hot-di-water.window_c" not in known
    (judgement, *_) = [each for each in report.process if each.rule.id == "R10"]
    assert judgement.verdict == "dirty"
    assert "tap-water has 0.003 MOhm cm" in judgement.because


def washed_with(solution: str, parameters: Parameters, **changes):
    """Judgements of R13 on a wash with a solution of the library."""
    board, recipe = load_board(Path("tiny")), load_recipe("smt-aqueous")
    known = with_chemistries(parameters, [solution])
    staged = stages_of(run(recipe, board).program, recipe, known, 6.0).stages
    liquid = known.liquids[solution].model_copy(update=changes)
    wash = next(stage for stage in staged if stage.use == "wash")
    found = judge_process([replace(wash, solution=solution, liquid=liquid)], known)
    return [(each.variant, each.verdict) for each in found if each.rule.id == "R13"]


@pytest.mark.slow
def test_a_solution_that_does_not_remove_this_flux_is_found():
    """Hot water is its own agent; without this rule it counted as one of 100 % for rosin too."""
    assert washed_with("water-with-wetting-agent", load_parameters()) == [("solution", "dirty")]
    assert washed_with("water-with-wetting-agent", load_parameters("no-clean-leadfree")) == [("solution", "dirty")]
    assert washed_with("water-with-wetting-agent", load_parameters("water-soluble")) == []
    assert washed_with("amine-alkoxypropanol", load_parameters("water-soluble")) == []


@pytest.mark.slow
def test_a_concentration_beyond_its_window_is_marginal():
    own = load_parameters()
    assert washed_with("amine-alkoxypropanol", own) == []
    assert washed_with("amine-alkoxypropanol", own, concentration_pct=5.0) == [("solution", "marginal")]
    assert washed_with("amine-alkoxypropanol", own, concentration_pct=26.0) == [("solution", "marginal")]


@pytest.mark.slow
def test_a_bare_material_that_a_solution_attacks_is_found_on_its_component():
    text = "parameters: own\nextends: default\nparts: [{match: [U1], materials: [aluminium]}]\n"
    own = read_parameters_text(text + "provenance: {parts: {known: source, source: the drawing}}\n")
    board, base = load_board(Path("tiny")), load_recipe("smt-aqueous")
    functions = {**base.functions}
    for solution, expected in (("amine-alkoxypropanol", ["material"]), ("ph-neutral-agent", [])):
        functions["clean"] = base.functions["clean"].model_copy(update={"solution": solution})
        recipe = base.model_copy(update={"functions": functions})
        report = analyse(run(recipe, board).program, board, recipe, own, "sketch")
        found = {
            part.component: {each.variant for each in part.judgements if each.rule.id == "R13"} for part in report.parts
        }
        assert sorted(found["U1"]) == expected
        assert not found["C1"]


def test_solids_of_a_flux_by_hand():
    """3 ml of a flux of 2 % solids at 0.814 g/ml leave 49 mg."""
    assert fluxes()["kester-951"].solids_g(3.0) == pytest.approx(3.0 * 0.814 * 0.02)
    for flux in fluxes().values():
        assert {"all"} <= set(flux.provenance) <= {"all", "kind", "solids_pct", "density_kg_m3"}
        assert flux.known("kind") == flux.provenance["all"]
