"""The examples run as they stand."""

import runpy
import sys
from pathlib import Path

import pytest
from each_workpiece import write_inputs

ROOT = Path(__file__).parents[1]
EXAMPLES = {
    "01_plan_and_look": (["tiny", "rinse-only", "plan.svg"], "tiny with rinse-only: 8.3 s", "plan.svg"),
    "02_components": ([], "tiny: 5 components", ""),
    "03_edit_a_recipe": ([], "templates.around.speed_mm_s: must be at least 0.01 mm/s, not -5", "mine.yaml"),
    "04_what_it_cleans": (["tiny", "rinse-only"], "the worst verdict is ", ""),
    "05_speed_and_verdicts": (["tiny", "around", "60", "20"], "around at 20 mm/s: ", ""),
    "06_through_a_cell": ([], "ur5e-bench: can carry out the program", "robot-program"),
    "07_at_the_pace_of_a_robot": ([], "s within the limits of the recipe, ", ""),
    "08_a_part": (["plate.yaml", "faces.yaml"], "plate.yaml: ", "part.png"),
    "09_a_panel": ([], "2 boards, 10 components", "panel.yaml"),
    "10_tune": (["tiny", "rinse-only", "2"], "written tuned.yaml", "tuned.yaml"),
    "11_study": ([], "begun again: 0 jobs left", "speeds/study.html"),
    "12_reports": ([], "cleaning.html, job.wash, paths.svg, plan.json", "reports/cleaning.html"),
    "13_your_own_loop": ([], "sweep keeps ", ""),
}
"""What each is called with, a text that it prints, and a file that it writes."""


def test_every_example_is_tried() -> None:
    assert sorted(EXAMPLES) == sorted(file.stem for file in (ROOT / "examples").glob("*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_does_what_its_docstring_states(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words, printed, written = EXAMPLES[name]
    monkeypatch.chdir(tmp_path)
    write_inputs(tmp_path)
    monkeypatch.setattr(sys, "argv", [name, *words])
    runpy.run_path(str(ROOT / "examples" / f"{name}.py"), run_name="__main__")
    done = capsys.readouterr()
    assert done.err == ""
    assert printed in done.out
    assert (tmp_path / written).exists()
