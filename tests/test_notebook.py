"""The notebook of the examples is executed, and shows what it has in its file."""

from pathlib import Path

import pytest
import run_notebook


@pytest.mark.slow
def test_the_notebook_runs_and_each_result_shows_itself(tmp_path: Path) -> None:
    notebook = run_notebook.execute(tmp_path)
    shown = [each.data for cell in notebook.cells for each in cell.get("outputs", ()) if "data" in each]
    assert sum("text/html" in each for each in shown) == 4
    assert sum("image/png" in each for each in shown) == 1
    assert (tmp_path / "program" / "tiny__smt_aqueous.script").exists()
    stored = run_notebook.nbformat.read(run_notebook.NOTEBOOK, as_version=4)
    assert [cell.source for cell in stored.cells] == [cell.source for cell in notebook.cells]
    assert all(cell.outputs for cell in stored.cells[3:] if cell.cell_type == "code")
    assert run_notebook.NOTEBOOK.stat().st_size < 600_000
