"""Capability: shares of clean parts under the stated ranges, compared with sets of values that are worked out whole."""

from pathlib import Path

import numpy as np
import pytest

from boards.load import load_board
from cleaning.analyse import analyse_on
from cleaning.errors import CleaningError
from cleaning.parameters.load import load_parameters, read_parameters_text
from cleaning.parameters.model import Provenance
from cleaning.parameters.provenance import with_values
from cleaning.prepared_board import prepare
from cleaning.uncertainty.capability import ValueRange, capability_of, draw_positions, ranges_of
from recipes.load import load_recipe
from reports.tables.cleaning_tables import capability_table, capability_words, sure_words
from rulesengine.planning.pipeline import run

PARAMETERS = load_parameters()
SETS = 40


def with_known(parameters, **entries):
    known = {**parameters.provenance, **{path.replace("__", "."): entry for path, entry in entries.items()}}
    return parameters.model_copy(update={"provenance": known})


def stated(**known):
    return Provenance(**({"known": "proposed", "source": "us"} | known))


@pytest.fixture(scope="module")
def board():
    return load_board(Path("tiny"))


@pytest.fixture(scope="module")
def program(board):
    return run(load_recipe("smt-aqueous"), board)


def analysed(board, program, parameters):
    prepared = prepare(board, parameters, lambda *_: None)
    return analyse_on(prepared, program.program, program.recipe, "sketch", sensitivity=False), prepared


def sure_of(found):
    """Shares of the components that keep all limits as the values are stated: a sketch misses some of the others."""
    return {each.component: each.clean_share for each in found.parts if each.component not in found.left_out}


@pytest.fixture(scope="module")
def capable(board, program):
    report, prepared = analysed(board, program, PARAMETERS)
    return report, capability_of(report, prepared)


def test_a_range_lies_about_its_value_and_an_interval_where_the_fit_has_it():
    fitted = stated(known="calibrated", interval=(0.01, 0.02), samples=9)
    parameters = with_known(PARAMETERS, soil__k1_per_s=fitted, soil__k_m_per_s=stated(within_factor=4.0))
    found = {each.path: each for each in ranges_of(parameters)}
    k1, k_m = found["soil.k1_per_s"], found["soil.k_m_per_s"]
    assert (k1.low, k1.value, k1.high, k1.is_interval) == (0.01, 0.012, 0.02, True)
    assert (k_m.low, k_m.value, k_m.high, k_m.is_interval) == (0.0125, 0.05, 0.2, False)
    assert "soil.front_um" not in found  # none is stated
    assert "liquids.saponifier-15.viscosity_mpa_s" not in {each.path for each in ranges_of(parameters, ["di-water"])}


def test_the_factor_of_a_block_is_clipped_where_a_value_ends():
    """Water that is its own agent is 100 % agent and never 125 %; a share is 1 at most."""
    water = load_parameters("water-soluble")
    parameters = with_known(
        water,
        liquids=stated(within_factor=1.25),
        soil=stated(within_factor=3.0),
        **{"liquids__di-water-wash": stated(within_factor=1.25)},
    )
    found = {each.path: each for each in ranges_of(parameters)}
    agent = found["liquids.di-water-wash.concentration_pct"]
    assert (agent.low, agent.value, agent.high) == (80.0, 100.0, 100.0)
    assert found["liquids.di-water-wash.contact_board_deg"].high == 93.75
    with_factor = with_known(PARAMETERS, soil=stated(within_factor=3.0))
    bare = {path: each for path, each in with_factor.provenance.items() if not path.startswith("soil.")}
    share = {each.path: each for each in ranges_of(with_factor.model_copy(update={"provenance": bare}))}
    assert share["soil.retained"].high == 1.0
    assert share["soil.paste_factor"].high == 3.0


def test_between_unequal_ends_values_are_drawn_evenly_on_a_logarithmic_scale():
    """A range that ends at its value is not heaped up there."""
    one_sided = ValueRange("liquids.x.concentration_pct", 80.0, 100.0, 100.0)
    both = ValueRange("soil.k1_per_s", 0.5, 1.0, 4.0)
    drawn = draw_positions([one_sided, both], 1000)
    values = [[each.at(at) for at in drawn[:, column]] for column, each in enumerate((one_sided, both))]
    for each, found in zip((one_sided, both), values, strict=True):
        shares = np.log(np.sort(found) / each.low) / np.log(each.high / each.low)
        np.testing.assert_allclose(shares, (np.arange(1000) + 0.5) / 1000, atol=1e-3)


def test_values_are_set_where_their_paths_lead():
    path = "liquids.saponifier-15.viscosity_mpa_s"
    changed = with_values(PARAMETERS, {"soil.k1_per_s": 0.5, path: 0.9, "limits.gap_marginal": 0.07})
    assert (changed.soil.k1_per_s, changed.limits.gap_marginal) == (0.5, 0.07)
    assert changed.liquids["saponifier-15"].viscosity_mpa_s == 0.9
    assert changed.liquids["di-water"] == PARAMETERS.liquids["di-water"]
    assert PARAMETERS.soil.k1_per_s == 0.012
    named = PARAMETERS.model_copy(update={"liquids": {"soap.2": PARAMETERS.liquids["saponifier-15"]}})
    assert with_values(named, {"liquids.soap.2.concentration_pct": 9.0}).liquids["soap.2"].concentration_pct == 9.0


def test_a_range_beyond_what_a_value_may_be_is_refused_with_its_line():
    entry = "soil.retained: {known: proposed, source: us, within_factor: 3}"
    text = f"parameters: own\nextends: default\nprovenance:\n  {entry}\n"
    with pytest.raises(CleaningError, match=r"leads to 1\.35, which soil\.retained cannot be; lower it") as caught:
        read_parameters_text(text, file="own.yaml")
    assert caught.value.line == 4


@pytest.mark.slow
def test_without_ranges_everything_is_as_it_is_stated(board, program):
    bare = {path: entry.model_copy(update={"within_factor": None}) for path, entry in PARAMETERS.provenance.items()}
    report, prepared = analysed(board, program, PARAMETERS.model_copy(update={"provenance": bare}))
    found = capability_of(report, prepared)
    assert found.varied == ()
    assert set(sure_of(found)) == {"U1", "C1", "R1", "R2"}
    assert set(sure_of(found).values()) == {1.0}
    assert found.together == 1.0


@pytest.mark.slow
def test_the_shares_are_those_of_sets_that_are_worked_out_whole(board, program, capable):
    """Every set of values is analysed from the board on, and judged without the margin."""
    _, found = capable
    ranges = ranges_of(PARAMETERS, ["saponifier-15", "di-water"])
    random = np.random.default_rng(7)
    clean = dict.fromkeys((each.component for each in found.parts), 0)
    for _ in range(SETS):
        drawn = {each.path: each.low * (each.high / each.low) ** random.random() for each in ranges}
        report, _ = analysed(board, program, with_values(PARAMETERS, drawn | {"limits.margin": 1.0}))
        for part in (*report.parts, report.bare):
            wrong = [
                each for each in part.judgements if each.verdict in ("dirty", "marginal") and each.rule.id != "R12"
            ]
            clean[part.component] += not wrong
    for each in found.parts:
        truth = clean[each.component] / SETS
        # Three standard errors of so few sets, and 0.04 for what is interpolated.
        allowed = 0.04 + 3.0 * np.sqrt(max(truth * (1.0 - truth), 0.02) / SETS)
        assert each.clean_share == pytest.approx(truth, abs=allowed), each.component


@pytest.mark.slow
def test_the_same_report_gives_the_same_and_the_words_have_the_numbers(board, program, capable):
    report, found = capable
    again, prepared = analysed(board, program, PARAMETERS)
    assert capability_of(again, prepared) == found
    assert 0.5 < found.together <= min(sure_of(found).values()) < 0.9
    u1 = next(each for each in found.parts if each.component == "U1")
    assert u1.strongest == "soil.k1_per_s"
    assert sum(share for _, share in u1.broken) == pytest.approx(1.0 - u1.clean_share)
    told = report.__class__(**{name: getattr(report, name) for name in report.__slots__} | {"capability": found})
    assert f"in {100 * found.together:.0f} of 100 sets of values, with {len(found.varied)} values" in capability_words(
        told
    )
    assert sure_words(u1).startswith(f"clean in {100 * u1.clean_share:.0f} of 100 sets of values; else R7 (")
    assert any("U1" in str(row[0]) for row in capability_table(told).rows)


@pytest.mark.slow
def test_what_is_worse_by_its_values_is_less_sure(board, program):
    """With a chemistry that is twice as quick hardly any set fails."""
    quick = with_values(PARAMETERS, {"soil.k1_per_s": 0.024})
    report, prepared = analysed(board, program, quick)
    sure = capability_of(report, prepared)
    assert min(sure_of(sure).values()) > 0.95
