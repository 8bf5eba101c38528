from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import PartOverride
from cleaning.parameters.provenance import assumptions_of


def test_every_value_is_listed_once_with_where_it_comes_from():
    parameters = load_parameters()
    found = {each.path: each for each in assumptions_of(parameters)}
    assert len(found) == len(assumptions_of(parameters))
    assert found["soil.k1_per_s"].value == "0.012"
    assert found["soil.k1_per_s"].known == "derived"
    assert found["film.decay_mm"].known == "proposed", "its block's provenance covers it"
    assert found["liquids.saponifier-15.window_c"].value == "[40, 71]"


def test_what_is_left_out_and_what_names_the_set_are_no_assumptions():
    paths = [each.path for each in assumptions_of(load_parameters())]
    assert "limits.ionic_ug_cm2" not in paths
    assert not any(path.startswith(("provenance", "description", "parameters")) for path in paths)


def test_what_is_known_of_single_parts_is_listed_by_its_place():
    override = PartOverride(match=["QFN*"], standoff_um=(50.0, 75.0))
    parameters = load_parameters().model_copy(update={"parts": [override]})
    values = {each.path: each.value for each in assumptions_of(parameters)}
    assert values["parts[0].match"] == '["QFN*"]'
    assert values["parts[0].standoff_um"] == "[50, 75]"
