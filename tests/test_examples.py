"""The examples run as they stand."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "arguments", "printed", "written"),
    [
        ("plan_and_look", ["tiny", "rinse-only", "plan.svg"], "tiny with rinse-only: 8.3 s", "plan.svg"),
        ("speed_and_verdicts", ["tiny", "around", "60", "20"], "around at 20 mm/s: ", ""),
        ("through_a_cell", [], "ur5e-bench: can carry out the program", "robot-program"),
    ],
)
def test_an_example_does_what_its_docstring_states(
    name: str, arguments: list[str], printed: str, written: str, tmp_path: Path
) -> None:
    command = [sys.executable, str(ROOT / "examples" / f"{name}.py"), *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert printed in done.stdout
    assert (tmp_path / written).exists()
