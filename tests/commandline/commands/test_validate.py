"""``washboard validate``: what it prints and writes, how it ends; the document is what it writes."""

import json
from pathlib import Path
from shutil import copytree

import pytest
from command import washboard

import washboard as wb
from cleaning.validation.reference import reference_library

ROOT = Path(__file__).parents[3]
DOCUMENT = ROOT / "docs" / "validation.md"


@pytest.mark.slow
def test_the_document_is_what_the_command_writes(tmp_path: Path) -> None:
    page, picture, data = tmp_path / "validation.md", tmp_path / "images" / "validation.png", tmp_path / "v.json"
    picture.parent.mkdir()
    result = washboard("validate", "--document", page, "--picture", picture, "--json", data)
    assert (result.code, result.err) == (0, "")
    assert page.read_text("utf-8") == DOCUMENT.read_text("utf-8"), (
        "washboard validate --document docs/validation.md --picture docs/images/validation.png writes it anew"
    )
    assert picture.read_bytes().startswith(b"\x89PNG")
    found = json.loads(data.read_text("utf-8"))
    assert found["as_expected"] is True
    assert {each["reference"] for each in found["references"]} == set(reference_library())
    assert "needs" in next(each for each in found["references"] if each["reference"] == "film-jump")["expected_failure"]
    assert wb.validate().data() == found


@pytest.mark.parametrize(
    ("change", "code"), [(("[0.5, 2]", "[0.5, 2]"), 0), (("[0.5, 2]", "[1.5, 2]"), 1), (("[0.5, 2]", "[1, x]"), 2)]
)
def test_it_ends_with_what_was_found(tmp_path: Path, change: tuple[str, str], code: int) -> None:
    place = tmp_path / "own"
    copytree(reference_library()["blow-off"].parent, place)
    file = place / "reference.yaml"
    file.write_text(file.read_text("utf-8").replace(*change), "utf-8")
    result = washboard("validate", place, "--json", tmp_path / "out.json")
    assert result.code == code
    assert ("reference.yaml:" in result.err) == (code == 2)
    assert (tmp_path / "out.json").exists() == (code < 2)


def test_a_law_is_never_counted_as_an_experiment() -> None:
    result = washboard("validate", "lane-width", "blow-off")
    assert result.code == 0
    assert "1 of 1 reference with readings hold; 0 of 1 law hold; 1 expected failure" in result.out
    assert "Needs: The removal law" in result.out


def test_from_python_it_is_the_same(tmp_path: Path) -> None:
    found = wb.validate("lane-width")
    assert found.as_expected
    assert [row.standing for row in found.checks] == ["expected failure"]
    assert "0 of 1 law hold" in found._repr_html_()
    with pytest.raises(wb.JobError, match="lane-width"):
        wb.validate("lane-with")
