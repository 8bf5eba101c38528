import json
from pathlib import Path

import pytest
from command import washboard


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("planned") / "tiny.wash"
    assert washboard("plan", "tiny", "-o", path).code == 0
    return path


@pytest.mark.slow
def test_boards_are_analysed_in_the_bath_of_their_moment(program: Path, tmp_path: Path) -> None:
    data = tmp_path / "bath.json"
    options = ("--litres", "20", "--flux-mg", "500", "--drag-out-ml", "4", "--boards", "400,1,2000", "--json", data)
    done = washboard("bath", program, *options)
    assert done.code == 1
    told = json.loads(data.read_text("utf-8"))
    assert told["flux_g"] == 0.5
    assert f"change it after {told['change_after']} boards, for 3 % non-volatile residue" in done.out
    assert [each["number"] for each in told["boards"]] == [1, 400, 2000]
    residues = [each["residue_pct"] for each in told["boards"]]
    assert residues[0] == 1.0
    assert residues[1] < 3.0 < residues[2]
    assert [each["verdict"] == told["boards"][0]["verdict"] for each in told["boards"]] == [True, True, True]
    assert "400               1.96 %" in done.out


@pytest.mark.slow
def test_a_bath_that_serves_all_ends_with_zero(program: Path) -> None:
    done = washboard("bath", program, "--boards", "1")
    assert done.code == 0
    assert "never reaches 3 % non-volatile residue: it settles at " in done.out


@pytest.mark.slow
def test_a_bath_in_use_begins_where_it_is(program: Path, tmp_path: Path) -> None:
    data = tmp_path / "bath.json"
    options = ("--flux-mg", "500", "--litres", "20", "--boards", "1", "--begin-pct", "2.9", "--json", data)
    done = washboard("bath", program, *options)
    told = json.loads(data.read_text("utf-8"))
    assert told["begin_pct"] == told["boards"][0]["residue_pct"] == 2.9
    assert 0 < told["change_after"] < 200
    assert done.code == 0
    assert "begins with 2.9 % residue; change it after " in done.out


@pytest.mark.slow
def test_rinse_tanks_are_followed_with_the_bath(program: Path, tmp_path: Path) -> None:
    """The last tank ends where it settles; the board that is named is the first whose water is below the limit."""
    tanks, data = tmp_path / "tanks.yaml", tmp_path / "bath.json"
    tanks.write_text(
        "parameters: own\nextends: default\n"
        "liquids: {first: {use: rinse, resistivity_mohm_cm: 1}}\n"
        "rinse: {cascade: {tanks: [{solution: first, volume_l: 5}, {solution: di-water, volume_l: 5}], fresh_l: 0.2}}\n"
        "provenance:\n  liquids.first: {known: proposed, source: us}\n  rinse.cascade: {known: proposed, source: us}\n"
    )
    done = washboard("bath", program, "--boards", "1,40,4000", "--flux-mg", "0", "--parameters", tanks, "--json", data)
    told = json.loads(data.read_text("utf-8"))
    last = [each["rinse_water"]["tanks"][-1]["resistivity_mohm_cm"] for each in told["boards"]]
    assert last[0] == pytest.approx(1.0)
    assert last[0] > last[1] > last[2]
    assert last[1] > told["rinse_limit_mohm_cm"] > last[2] or told["rinse_below_after"] < 39
    assert f"di-water falls below 0.2 MΩ·cm after {told['rinse_below_after']} boards" in done.out
    assert ">first" not in done.out


@pytest.mark.parametrize("words", ["", "0", "-3", "1,x", "1.5", "9" * 5000, ",".join(map(str, range(1, 14)))])
def test_boards_that_are_no_numbers_are_refused(program: Path, words: str) -> None:
    done = washboard("bath", program, "--boards", words)
    assert done.code == 2
    assert "whole numbers from 1 on" in done.err


@pytest.mark.slow
def test_a_liquid_flux_brings_its_solids(program: Path, tmp_path: Path) -> None:
    data = tmp_path / "bath.json"
    done = washboard("bath", program, "--boards", "1", "--flux", "kester-951:3", "--json", data)
    assert done.code in (0, 1)
    assert json.loads(data.read_text("utf-8"))["flux_g"] == pytest.approx(0.048_84)


@pytest.mark.parametrize(
    ("words", "because"),
    [
        (("--flux", "kester-95:3"), "did you mean 'kester-951'"),
        (("--flux", "kester-951"), "give millilitres from 0 to 1000"),
        (("--flux", "kester-951:nan"), "give millilitres from 0 to 1000"),
        (("--flux", "kester-951:3", "--flux-mg", "4"), "not both"),
    ],
)
def test_a_flux_that_is_not_known_is_refused(program: Path, words: tuple[str, ...], because: str) -> None:
    done = washboard("bath", program, *words)
    assert done.code == 2
    assert because in " ".join(done.err.split())
