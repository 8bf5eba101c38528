"""The examples run as they stand."""

import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "printed", "written"),
    [
        (["plan_and_look", "tiny", "rinse-only", "plan.svg"], "tiny with rinse-only: 8.3 s", "plan.svg"),
        (["speed_and_verdicts", "tiny", "around", "60", "20"], "around at 20 mm/s: ", ""),
        (["through_a_cell"], "ur5e-bench: can carry out the program", "robot-program"),
    ],
)
def test_an_example_does_what_its_docstring_states(
    words: list[str],
    printed: str,
    written: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", words)
    runpy.run_path(str(ROOT / "examples" / f"{words[0]}.py"), run_name="__main__")
    done = capsys.readouterr()
    assert done.err == ""
    assert printed in done.out
    assert (tmp_path / written).exists()
