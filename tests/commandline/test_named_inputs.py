"""What inputs name is an input too, such as the board of a panel."""

from pathlib import Path

import pytest
from command import contents, washboard
from each_workpiece import write_inputs

IMPORTED = ("board", "import", "two.yaml", "-o", "small.tri")


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (IMPORTED, "small.tri"),
        ((*IMPORTED[:-1], "link.tri"), "link.tri"),
        ((*IMPORTED[:-1], "hard.tri"), "hard.tri"),
        (("operate", "two.wash", "--cell", "gantry", "--dry", "--log", "small.tri"), "small.tri"),
    ],
)
def test_what_an_input_names_is_not_written_over(
    words: tuple[str, ...], named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_inputs(tmp_path)
    (tmp_path / "link.tri").symlink_to("small.tri")
    (tmp_path / "hard.tri").hardlink_to("small.tri")
    if "two.wash" in words:
        assert washboard("plan", "two.yaml", "brief.yaml", "-o", "two.wash").code == 0
        words = (*words, "--board", "two.yaml")
    before = contents(tmp_path)
    outcome = washboard(*words)
    assert (outcome.code, outcome.out) == (2, "")
    assert f"{named}: cannot be written: it is read by this command" in outcome.err
    assert contents(tmp_path) == before
