"""A slice of ``tools/interrupt_commands.py``: outputs are old or new, nothing is left, one line and 130."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.long
def test_commands_that_are_killed_or_interrupted_at_random_moments() -> None:
    words = ["--kills", "1", "--interrupts", "2", "--only", "plan", "--only", "import", "--only", "save"]
    run = subprocess.run(
        [sys.executable, ROOT / "tools" / "interrupt_commands.py", *words],
        env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.endswith("1 kills, 2 interrupts, 0 faults\n")
