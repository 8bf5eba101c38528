"""Parameter sets: what the library holds, what a set inherits, which mistakes are told and where."""

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from cleaning.errors import CleaningError
from cleaning.parameters.load import (
    PARAMETERS,
    load_parameters,
    parameter_library,
    parameters_keys,
    parameters_schema,
    parameters_sha256,
    read_parameters,
    read_parameters_text,
)
from cleaning.parameters.model import Parameters

HEAD = "parameters: mine\nextends: default\n"
BASE = load_parameters()
REAL = "{known: calibrated, source: coupons of ours, date: 2026-11-21, samples: 24, rms: 0.02}"


def extend(text: str) -> Parameters:
    return read_parameters_text(HEAD + text, file="mine.yaml")


def refusal(text: str) -> str:
    with pytest.raises(CleaningError) as caught:
        extend(text)
    return str(caught.value)


@pytest.mark.parametrize("name", parameter_library())
def test_library_sets_load_and_none_of_them_claims_to_be_measured(name: str) -> None:
    parameters = load_parameters(name)
    assert parameters.parameters == name
    assert parameters.description
    assert not parameters.calibrated
    for entry in parameters.provenance.values():
        assert entry.known not in ("calibrated", "synthetic")


def test_the_sets_rank_the_residues_as_they_are_known_to_give_way() -> None:
    rates = [load_parameters(name).soil.k1_per_s for name in ("aged", "no-clean-leadfree", "default", "water-soluble")]
    assert rates == sorted(rates)


def test_nothing_said_nothing_changed() -> None:
    own = {"parameters": "mine", "extends": "default", "description": ""}
    assert extend("") == BASE.model_copy(update=own)


def test_a_description_is_of_the_set_that_it_stands_in() -> None:
    assert BASE.description
    assert extend("").description == ""
    assert extend("description: Ours.\n").description == "Ours."
    assert extend("description: null\n").description == ""
    assert read_parameters("aged").parameters.description.startswith("Rosin residue that hardened")


def test_a_changed_value_is_changed_alone_and_says_where_it_comes_from() -> None:
    mine = extend("soil: {front_um: 120}\nprovenance: {soil.front_um: {known: proposed, source: a guess}}\n")
    assert mine.soil == BASE.soil.model_copy(update={"front_um": 120.0})
    assert mine.known("soil.front_um").source == "a guess"
    assert mine.known("soil.k_m_per_s") == BASE.known("soil.k_m_per_s")


def test_a_changed_value_does_not_keep_the_provenance_of_another() -> None:
    message = refusal("soil:\n  k1_per_s: 0.02\n")
    assert message.startswith("mine.yaml:4: soil.k1_per_s: is stated here")
    assert "soil.k1_per_s: {known: proposed" in message


def test_a_new_liquid_is_asked_for_its_provenance_once() -> None:
    message = refusal("liquids:\n  mix: {use: wash, concentration_pct: 5, bath_nvr_pct: 1}\n")
    assert message.startswith("mine.yaml:4: liquids.mix: is stated here")
    assert "more" not in message


def test_null_removes_a_liquid() -> None:
    text = "liquids: {saponifier-15: null}\nprovenance:\n  liquids.saponifier-15.surface_tension_mn_m: null\n"
    assert set(extend(text + "  liquids.saponifier-15.window_c: null\n").liquids) == {"di-water", "hot-air"}


def test_provenance_of_what_was_removed_is_a_mistake() -> None:
    message = refusal("liquids: {saponifier-15: null}\n")
    assert "mine.yaml:3: liquids.saponifier-15: does not suit" in message
    assert "provenance.liquids.saponifier-15.window_c, inherited from default: names nothing" in message


def test_provenance_names_single_parts_too() -> None:
    told = "{known: source, source: data sheet}"
    parts = "parts: [{match: [Q*], most_kpa: 3}]\n"
    assert extend(f"{parts}provenance: {{'parts[0]': {told}, 'parts[0].most_kpa': {told}}}\n").parts
    assert "provenance.parts[1]: names nothing" in refusal(f"{parts}provenance: {{'parts[1]': {told}}}\n")


def test_a_file_extends_the_one_beside_it(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(HEAD + "limits: {front_s: 1}\nprovenance: {limits: " + REAL + "}\n", "utf-8")
    (tmp_path / "b.yaml").write_text("parameters: b\nextends: a.yaml\n", "utf-8")
    loaded = read_parameters(tmp_path / "b.yaml")
    assert loaded.parameters.limits.front_s == 1
    assert Path(loaded.root.at(("limits", "front_s")).mark.file).name == "a.yaml"


def test_kinetics_count_as_calibrated_only_where_both_rates_were_measured() -> None:
    both = f"soil.k1_per_s: {REAL}, soil.k_m_per_s: {REAL}"
    assert extend(f"provenance: {{{both}}}\n").calibrated
    assert not extend(f"provenance: {{soil.k1_per_s: {REAL}}}\n").calibrated
    assert not extend(f"provenance: {{{both.replace('calibrated', 'synthetic')}}}\n").calibrated


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("soyl: {}\n", "mine.yaml:3: soyl: unknown key; did you mean 'soil'?"),
        ("soil: {k1_per_s: -1}\n", "mine.yaml:3: soil.k1_per_s: must be at least 1e-09 1/s, not -1"),
        ("soil: {k1_per_s: .nan}\n", "mine.yaml:3: soil.k1_per_s: must be a finite number"),
        ("soil: {k1_per_s: fast}\n", "mine.yaml:3: soil.k1_per_s: must be a number, not 'fast'"),
        ("spray: {flow_exponent: {air_knife: null}}\n", "spray.flow_exponent: is missing for air_knife"),
        ("provenance: {soil.k1: {known: proposed, source: x}}\n", "did you mean 'soil.k1_per_s'?"),
        ("provenance: {oil: {known: proposed, source: x}}\n", "provenance.oil: names nothing of this set; did you"),
        ("provenance: {soil: {known: guessed, source: x}}\n", "'guessed' is not known"),
        ("provenance: {soil.k_m_per_s: {known: calibrated, source: x}}\n", "needs samples and rms too"),
        (
            "provenance: {soil.k_m_per_s: {known: proposed, source: x, interval: [1, 2]}}\n",
            "provenance.soil.k_m_per_s.interval: 0.05 lies outside 1 to 2",
        ),
        ("provenance: {soil.k_m_per_s: {known: proposed, source: x, interval: [2, 1]}}\n", "the lower number comes"),
        ("provenance: {soil: {known: proposed, source: x, interval: [0, 1]}}\n", "is that of one value"),
        ("provenance: {soil: {known: proposed, source: x, date: today}}\n", "provenance.soil.date: 'today' does not"),
        (
            "provenance: {soil: {known: proposed, source: x, date: 2026-13-45}}\n",
            "mine.yaml:3: provenance.soil.date: '2026-13-45' is no day of the calendar",
        ),
        (
            "provenance: {soil: {known: proposed, source: x, date: '2026-02-29'}}\n",
            "provenance.soil.date: '2026-02-29' is no day of the calendar",
        ),
        ("liquids: {di-water: {window_c: [60, 40]}}\n", "liquids.di-water.window_c: [60, 40]: the lower number"),
        ("liquids: {saponifier-15: {concentration_pct: 0}}\n", "must be above 0 for washing"),
        ("limits: {gap_marginal: 0.3}\n", "limits.gap_marginal: must be at most gap_dirty, 0.2, not 0.3"),
        ("limits: {rinse_fail_mohm: 3}\n", "limits.rinse_fail_mohm: must be at most rinse_warn_mohm"),
        ("drying: {receding_deg: 90}\n", "drying.receding_deg: must be at most advancing_deg, 70, not 90"),
        ("drying: {bake_min: 9}\n", "drying.bake_min: needs the temperature of the bake too"),
        ("drying: {bake_c: 90}\n", "drying.bake_c: needs the time of the bake too"),
        ("parts: [{match: [Q*], standoff_um: [9, 3]}]\n", "parts[0].standoff_um: [9, 3]: the lower number"),
        ("extends: nothing\n", "key 'extends' stands twice"),
    ],
)
def test_a_mistake_is_told_with_its_place(text: str, wanted: str) -> None:
    assert wanted in refusal(text)


@pytest.mark.parametrize(
    ("source", "wanted"), [("defalt", "Did you mean 'default'?"), ("nowhere.yaml", "no such file; `washboard param")]
)
def test_a_set_that_is_not_there_is_told(source: str, wanted: str) -> None:
    with pytest.raises(CleaningError, match=r"parameter set|parameters list") as caught:
        load_parameters(source)
    assert wanted in str(caught.value)


def test_a_circle_is_told(tmp_path: Path) -> None:
    for name, other in ("ab", "ba"):
        (tmp_path / f"{name}.yaml").write_text(f"parameters: {name}\nextends: {other}.yaml\n", "utf-8")
    with pytest.raises(CleaningError, match="goes in a circle"):
        load_parameters(tmp_path / "a.yaml")


def test_the_set_that_the_documents_show_loads() -> None:
    page = (Path(__file__).parents[3] / "docs" / "parameters.md").read_text("utf-8")
    (block,) = re.findall(r"^```yaml\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    assert read_parameters_text(block).known("liquids.saponifier-15.concentration_pct").known == "source"


@pytest.mark.slow
@given(front=st.floats(1, 1e4), note=st.text("abc ", min_size=1))
@settings(max_examples=20)
def test_the_hash_is_that_of_the_content_not_of_how_it_is_written(front: float, note: str) -> None:
    changed = f"soil: {{front_um: {front}}}\nprovenance: {{soil.front_um: {{known: proposed, source: '{note}x'}}}}\n"
    first = extend(changed)
    again = read_parameters_text(f"# {note}\nextends: default\n{changed}parameters: mine\n")
    assert parameters_sha256(first) == parameters_sha256(again)
    assert (parameters_sha256(first) == parameters_sha256(extend(""))) is (first == extend(""))


ROOT = Path(__file__).parents[3]
VALIDATOR = jsonschema.Draft202012Validator(json.loads(parameters_schema()))
DEFAULT = parameter_library()["default"].read_text("utf-8")


def errors(text: str) -> list[str]:
    return [error.message for error in VALIDATOR.iter_errors(YAML(typ="safe", pure=True).load(text))]


def test_the_committed_schema_is_that_of_the_model() -> None:
    committed = (ROOT / "cleaning" / "parameters.schema.json").read_text("utf-8")
    assert committed == parameters_schema(), "run: washboard parameters schema > cleaning/parameters.schema.json"


def test_the_committed_table_of_keys_is_that_of_the_model() -> None:
    committed = (ROOT / "docs" / "parameter-keys.md").read_text("utf-8")
    assert committed == parameters_keys(), "run: washboard parameters keys > docs/parameter-keys.md"


def test_the_table_has_every_key_of_every_part() -> None:
    whole: dict[str, Any] = PARAMETERS.schema()
    for name, part in {**whole["$defs"], "Parameters": whole}.items():
        for key, schema in part["properties"].items():
            assert f"| `{key}` |" in parameters_keys(), f"{name}.{key}"
            assert len(schema.get("description", "see there")) > 3, f"{name}.{key}"


@pytest.mark.parametrize("name", parameter_library())
def test_library_sets_fit_the_schema_and_name_it(name: str) -> None:
    text = parameter_library()[name].read_text("utf-8")
    assert errors(text) == []
    assert text.startswith("# yaml-language-server: $schema=../parameters.schema.json\n")
    assert (parameter_library()[name].parent / "../parameters.schema.json").exists()


@pytest.mark.parametrize(
    "text",
    [
        DEFAULT.replace("k1_per_s: 0.012", "k1_per_sec: 0.012"),
        DEFAULT.replace("k1_per_s: 0.012", "k1_per_s: 0"),
        DEFAULT.replace("use: wash", "use: soak"),
        DEFAULT.replace("soil: {known: proposed", "soil: {known: sure"),
        "parameters: mine\nextends: default\nsoil: {k1: 1}\n",
    ],
)
def test_an_editor_marks_mistakes(text: str) -> None:
    assert errors(text)


def test_a_set_that_extends_another_needs_nothing_else_and_may_remove() -> None:
    assert errors("parameters: mine\nextends: default\nliquids: {di-water: null}\nsoil: {front_um: 3}\n") == []
