"""Programs in robots' languages, shown and kept as native ones."""

from pathlib import Path

import pytest
from command import washboard
from installations import for_language, small_cell
from robot_programs import PROGRAMS

from programs.export import export
from programs.load import load_program


@pytest.fixture
def text(tmp_path: Path) -> Path:
    """A program in RAPID of some cell of the library's ABB robot."""
    (content,) = export(PROGRAMS["loop"](), for_language(small_cell(), "abb"), "abb").files.values()
    file = tmp_path / "tiny.mod"
    file.write_text(content, "ascii")
    return file


def test_what_was_read_is_kept_as_a_native_program(text: Path) -> None:
    out = text.with_name("kept.wash")
    outcome = washboard("show", text, "--cell", "irb1200-bench", "-o", out)
    assert outcome.code == 0, outcome.err
    assert f"Program  {out}" in outcome.out
    kept, planned = load_program(out), PROGRAMS["loop"]()
    assert (kept.origin.board, kept.origin.recipe_sha256) == (planned.origin.board, planned.origin.recipe_sha256)
    assert kept.totals.moves > 5
    assert washboard("show", out).code == 0


def test_a_text_that_does_not_name_its_recipe_is_not_kept(text: Path) -> None:
    text.write_text(text.read_text().replace("! Recipe ", "! From "))
    out = text.with_name("kept.wash")
    outcome = washboard("show", text, "--cell", "irb1200-bench", "-o", out)
    assert outcome.code == 2
    assert "does not name its recipe" in outcome.err
    assert not out.exists()
    assert washboard("show", text, "--cell", "irb1200-bench").code == 0
