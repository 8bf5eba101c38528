"""The model against references: what is checked, what counts as expected, how a broken reference is refused."""

from pathlib import Path
from shutil import copytree

import numpy as np
import pytest

from cleaning.errors import CleaningError
from cleaning.parameters.load import load_parameters
from cleaning.validation.compare import Comparison, compare, comparison_data, exponent, validate
from cleaning.validation.quantities import Rows
from cleaning.validation.reference import load_reference, reference_library

ROWS = {
    "blow-off", "drying-practice", "drying-vapour", "film-jump", "flux-beaker", "front-growth", "gap-study",
    "lane-width", "oil-temperature", "posts", "pressure-plateau", "rotating-disc", "spray-distance", "spray-speed",
}  # fmt: skip
BLOWER = "blow-off"


@pytest.fixture(scope="module")
def found() -> dict[str, Comparison]:
    return {each.reference.reference: each for each in validate()}


def own(folder: Path, name: str, *changes: tuple[str, str], table: tuple[str, str] = ("", "")) -> Path:
    """A copy of a reference with other text."""
    place = folder / name
    copytree(reference_library()[name].parent, place)
    text = (place / "reference.yaml").read_text("utf-8")
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    (place / "reference.yaml").write_text(text, "utf-8")
    data = (place / "data.csv").read_text("utf-8")
    assert table[0] in data
    (place / "data.csv").write_text(data.replace(*table), "utf-8")
    return place


def standing(place: Path) -> str:
    return compare(load_reference(place), load_parameters()).standing


@pytest.mark.slow
def test_every_reference_stands_as_expected(found: dict[str, Comparison]) -> None:
    assert set(found) == ROWS
    assert {name for name, each in found.items() if not each.as_expected} == set()


@pytest.mark.slow
def test_a_law_is_named_as_such_in_its_table_and_readings_never(found: dict[str, Comparison]) -> None:
    for name, each in found.items():
        head = reference_library()[name].with_name("data.csv").read_text("utf-8").splitlines()[0]
        assert ("no readings" in head) == (each.reference.holds == "law")


@pytest.mark.slow
def test_first_order_ranks_time_above_temperature(found: dict[str, Comparison]) -> None:
    """Residue is exp(-k t): twice the time squares it, so that its gain is 1 over it; ten degrees gain less."""
    gains = dict(zip(found["gap-study"].compared.rows.labels, found["gap-study"].compared.predicted, strict=True))
    assert gains["time_s"] == pytest.approx(13.1, rel=0.02)
    assert gains["temperature_c"] == pytest.approx(2.77, rel=0.02)


@pytest.mark.slow
def test_the_film_knows_no_flow(found: dict[str, Comparison]) -> None:
    film = found["film-jump"]
    assert exponent(film.compared.rows, film.compared.predicted, "flow_g_s") == pytest.approx(0.0, abs=1e-9)
    assert exponent(film.compared.rows, film.compared.rows.published, "flow_g_s") == pytest.approx(0.75, abs=0.01)


@pytest.mark.slow
def test_data_state_no_number_where_there_is_no_prediction(found: dict[str, Comparison]) -> None:
    data = comparison_data([found["front-growth"]])
    assert data["as_expected"] is True
    rows = data["references"][0]["rows"]  # type: ignore[index]
    assert [row["predicted"] for row in rows] == [None] * 4


def test_an_exponent_is_that_of_rows_that_agree_in_all_else() -> None:
    size, flow = np.array([1.0, 1.0, 2.0, 2.0]), np.array([1.0, 4.0, 3.0, 12.0])
    rows = Rows(("",) * 4, {"size": size, "flow": flow}, flow, CleaningError)
    assert exponent(rows, size**3 * flow**0.5, "flow") == pytest.approx(0.5)
    assert exponent(rows, size**3 * flow**0.5, "size") is None
    assert exponent(rows, np.full(4, np.nan), "flow") is None


def test_what_fails_without_being_expected_to_is_a_failure(tmp_path: Path) -> None:
    assert standing(own(tmp_path, BLOWER)) == "holds"
    assert standing(own(tmp_path / "wide", BLOWER, ("[0.5, 2]", "[1.5, 2]"))) == "fails"


def test_a_failure_that_is_expected_and_holds_is_one_too(tmp_path: Path) -> None:
    expected = "\nexpected_failure: {checks: [ratio], reason: none, needs: nothing}\n"
    fails, holds = "accept: {ratio: [1.5, 2]}", "accept: {ratio: [0.5, 2]}"
    assert standing(own(tmp_path, BLOWER, (holds, fails + expected))) == "expected failure"
    assert standing(own(tmp_path / "held", BLOWER, (holds, holds + expected))) == "holds unexpectedly"
    both = "accept: {ratio: [1.5, 2], mean_ratio: [1.5, 2]}"
    assert standing(own(tmp_path / "more", BLOWER, (holds, both + expected))) == "fails"


@pytest.mark.parametrize(
    ("name", "change", "table", "message"),
    [
        (BLOWER, ("quantity: blow_off_gap", "quantity: blow_off"), None, r"reference\.yaml:\d+: quantity: .*blow_off"),
        (BLOWER, ("accept: {ratio: [0.5, 2]}", "accept: {}"), None, r"reference\.yaml:\d+: accept: .*anything"),
        (BLOWER, ("[0.5, 2]", "[2, 0.5]"), None, r"reference\.yaml:\d+: accept\.ratio: .*lower number"),
        (BLOWER, ("quantity", "conditions: {speed: 3}\nquantity"), None, r"reference\.yaml:\d+: conditions\.speed"),
        (BLOWER, ("quantity", "conditions: {air_c: 999}\nquantity"), None, r"conditions\.air_c: must lie in"),
        ("front-growth", ("time_s: [", "tme_s: ["), None, r"reference\.yaml:\d+: accept\.exponent\.tme_s"),
        ("front-growth", ("checks: [exponent.time_s]", "checks: [ratio]"), None, r"expected_failure\.checks\[0\]"),
        ("gap-study", ("order: [temperature_c", "order: [warmth"), None, r"data\.csv:2: accept\.order has 'warmth'"),
        (BLOWER, None, ("50.8,45.6", "fast,45.6"), r"data\.csv:3: speed_m_s: must be a number"),
        (BLOWER, None, ("speed_m_s", "speed"), r"data\.csv:2: unknown column 'speed'"),
        ("pressure-plateau", None, ("\npressure_bar,1.5,3.5", "\nhours,1.5,3.5"), r"data\.csv:2: no lever 'hours'"),
        ("rotating-disc", None, ("first over", "frst over"), r"data\.csv:2: no feature"),
        ("spray-distance", None, ("\n400,0,", "\n400,1,"), r"data\.csv:2: the sheet at 400 mm"),
    ],
)
def test_a_broken_reference_is_refused_with_its_line(
    tmp_path: Path, name: str, change: tuple[str, str] | None, table: tuple[str, str] | None, message: str
) -> None:
    place = own(tmp_path, name, *[change] * (change is not None), table=table or ("", ""))  # type: ignore[list-item]
    with pytest.raises(CleaningError, match=message):
        standing(place)


def test_a_folder_without_its_table_is_refused(tmp_path: Path) -> None:
    place = own(tmp_path, BLOWER)
    (place / "data.csv").unlink()
    with pytest.raises(CleaningError, match=r"data\.csv"):
        load_reference(place)
    with pytest.raises(CleaningError, match="blow-off"):
        load_reference("blow-of")
