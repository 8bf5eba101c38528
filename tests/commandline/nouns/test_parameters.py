"""``washboard parameters``, as a person at a terminal uses it."""

from pathlib import Path

import pytest
from command import washboard

from cleaning.parameters.chemistries import chemistries, fluxes
from cleaning.parameters.load import load_parameters, parameter_library, parameters_keys, parameters_schema
from commandline.arguments import complete_parameters


def test_list_names_each_set_with_what_it_holds_for() -> None:
    result = washboard("parameters", "list")
    assert result.code == 0
    names = [*parameter_library(), *chemistries(), *fluxes()]
    assert [line.split()[0] for line in result.out.splitlines() if line.startswith("  ")] == names
    for name in parameter_library():
        assert f"{load_parameters(name).description}\n" in result.out
    for name, chemistry in chemistries().items():
        assert any(line.split()[0] == name and line.endswith(chemistry.description) for line in result.out.splitlines())


@pytest.mark.parametrize("name", ["amine-alkoxypropanol", "kester-951"])
def test_a_solution_or_a_flux_is_shown_with_where_its_values_come_from(name: str) -> None:
    result = washboard("parameters", "show", name)
    assert (result.code, result.err) == (0, "")
    known = {**chemistries(), **fluxes()}[name].provenance
    assert all(entry.source[:40] in " ".join(result.out.split()) for entry in known.values())


@pytest.mark.parametrize("name", parameter_library())
def test_show_says_how_the_kinetics_are_known(name: str) -> None:
    result = washboard("parameters", "show", name)
    assert (result.code, result.err) == (0, "")
    (rate,) = [line for line in result.out.splitlines() if line.startswith("k1_per_s")]
    parameters = load_parameters(name)
    assert rate.split()[1] == f"{parameters.soil.k1_per_s:g}"
    assert parameters.known("soil.k1_per_s").source in rate
    assert "UNCALIBRATED" in result.out


def test_show_tells_inherited_values_from_own_ones() -> None:
    lines = washboard("parameters", "show", "aged").out.splitlines()
    written = {line.split()[0]: line.rstrip().rsplit("  ", 1)[-1].strip() for line in lines if line.strip()}
    assert written["k1_per_s"].startswith("line ")
    assert written["k_m_per_s"].startswith("default:")


def test_show_of_a_calibrated_set_gives_its_interval_and_its_parts(tmp_path: Path) -> None:
    fitted = "{known: calibrated, source: coupons.csv, samples: 24, rms: 0.02, interval: [0.01, 0.06]}"
    file = tmp_path / "mine.yaml"
    file.write_text(
        "parameters: mine\nextends: default\nparts: [{match: ['QFN*'], most_kpa: 3}]\n"
        f"provenance: {{soil.k1_per_s: {fitted}, soil.k_m_per_s: {fitted}}}\n",
        "utf-8",
    )
    out = washboard("parameters", "show", file).out
    assert "0.012 (0.01 to 0.06)" in out
    assert "parts[0]  QFN*: most_kpa 3" in out
    assert "UNCALIBRATED" not in out
    assert "grade B" in out


def test_a_set_that_cannot_be_used_is_one_line_on_stderr(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("parameters: mine\nextends: default\nsoil: {k2: 1}\n", "utf-8")
    result = washboard("parameters", "show", file)
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith(f"error: {file}:3: soil.k2: unknown key")


def test_schema_and_keys_are_printed_as_they_are() -> None:
    assert washboard("parameters", "schema").out == parameters_schema()
    assert washboard("parameters", "keys").out == parameters_keys()


def test_the_shell_completes_names() -> None:
    assert complete_parameters("wa") == ["water-soluble"]
    assert set(complete_parameters("")) == set(parameter_library())
