"""The gap height that counts: parameter set, board file, package family, in this order."""

import pytest

from boards.packages.undersides import gap_height

SOIC = "SOIC-8_3.9x4.9mm_P1.27mm"
SET_MM = (0.03, 0.08)


@pytest.mark.parametrize("package", [SOIC, "MODULE", ""])
@pytest.mark.parametrize("file_mm", [0.2, 0.0, None])
def test_a_parameter_set_comes_before_board_file_and_family(package: str, file_mm: float | None) -> None:
    found = gap_height(package, file_mm, SET_MM)
    assert (found.nominal_mm, found.bounds_mm) == (0.03, SET_MM)
    assert found.source == found.bounds_source == "stated in the parameter set"


@pytest.mark.parametrize("package", [SOIC, "MODULE", ""])
@pytest.mark.parametrize("file_mm", [0.2, 0.0])
def test_the_board_file_comes_before_the_family(package: str, file_mm: float) -> None:
    found = gap_height(package, file_mm)
    assert (found.nominal_mm, found.bounds_mm) == (file_mm, (file_mm, file_mm))
    assert found.source == found.bounds_source == "stated"


def test_the_family_gives_its_nominal_height_and_both_bounds() -> None:
    found = gap_height(SOIC, None)
    assert found.bounds_mm is not None
    assert found.nominal_mm is not None
    assert found.bounds_mm[0] <= found.nominal_mm <= found.bounds_mm[1]
    assert found.source == "family SOIC (JEDEC MS-012)"
    assert found.bounds_source == "family SOIC: 0.1 to 0.25 mm (JEDEC MS-012 A1)"


@pytest.mark.parametrize("package", ["MODULE", ""])
def test_without_any_source_the_gap_height_is_unknown(package: str) -> None:
    found = gap_height(package, None)
    assert (found.nominal_mm, found.bounds_mm) == (None, None)
    assert (found.source, found.bounds_source) == ("unknown", "unknown")
