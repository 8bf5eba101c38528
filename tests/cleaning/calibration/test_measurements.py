"""Tables of measurements are read as they are, or refused with their line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cleaning.calibration.measurements import Column, Measurements, read_measurements
from cleaning.errors import CleaningError

KNOWN = {"a": Column(0.0, 10.0), "b": Column(-1.0, 1.0, default=0.5), "c": Column(0.0, 1.0, optional=True)}


def read(folder: Path, text: str | bytes) -> Measurements:
    file = folder / "table.csv"
    file.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return read_measurements(file, KNOWN, 2)


def test_what_is_left_out_has_its_default_or_is_not_there(tmp_path: Path) -> None:
    table = read(tmp_path, "# why\n\n a \n1\n# between\n2.5e0\n")
    assert table.columns["a"].tolist() == [1.0, 2.5]
    assert table.columns["b"].tolist() == [0.5, 0.5]
    assert set(table.columns) == {"a", "b"}
    assert (table.lines.tolist(), table.header_line, len(table)) == ([4, 6], 3, 2)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("begin", ["", "\ufeff"])
def test_tables_of_other_programs_are_read_too(tmp_path: Path, begin: str, end: str) -> None:
    table = read(tmp_path, end.join([f"{begin}b;a", '"1";2', "0;3", ""]))
    assert table.columns["a"].tolist() == [2.0, 3.0]
    assert table.columns["b"].tolist() == [1.0, 0.0]


def test_the_hash_is_that_of_the_file_and_the_name_has_no_folders(tmp_path: Path) -> None:
    (tmp_path / "x").mkdir()
    here, there = read(tmp_path, "a\n1\n2\n"), read(tmp_path / "x", "a\n1\n2\n")
    assert here.source == there.source
    assert here.source.startswith("table.csv, sha256 ")
    assert here.source != read(tmp_path, "a\n1\n3\n").source


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("a\n1\n1_0\n", "table.csv:3: a: must be a number with a decimal point, not '1_0'"),
        ("a;b\n1;0\n1,5;0\n", "table.csv:3: a: must be a number with a decimal point, not '1,5'"),
        ("a\n1\n\ninf\n", "table.csv:4: a: must be a finite number"),
        ("a\n1\n11\n", "table.csv:3: a: must lie in 0 to 10, not 11"),
        ("a\n" + "1\n" * 50_001, "table.csv:1: 50,001 rows are too many"),
        ("a\n1\n\0\n", "table.csv:3: "),
        (b"a\n1\n\xff\n", "table.csv:3: is not UTF-8 text"),
    ],
)
def test_a_bad_table_is_told_with_its_line(tmp_path: Path, text: str | bytes, wanted: str) -> None:
    with pytest.raises(CleaningError) as caught:
        read(tmp_path, text)
    assert wanted in str(caught.value)


@given(st.text("ab,;\t\"'#\n\r 0.1e-_n\0\u2028é", max_size=60).map(lambda text: f"a,b\n{text}"))
@example('a,b\n1,"0\n"')
@example("a\n1\n1")
@settings(max_examples=80)
def test_any_text_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    try:
        table = read(tmp_path_factory.mktemp("any"), text)
    except CleaningError:
        return
    assert len(table) >= 2
    assert all(np.isfinite(values).all() for values in table.columns.values())
