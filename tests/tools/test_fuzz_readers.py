"""A slice of the fuzz of readers; `python tools/fuzz_readers.py --cases 200000` runs all of it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[2] / "tools" / "fuzz_readers.py"


def fuzz(*words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([sys.executable, str(TOOL), *words], capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_a_slice_of_the_fuzz_finds_no_fault() -> None:
    run = fuzz("--cases", "240", "--seed", "5")
    assert run.returncode == 0, run.stdout + run.stderr
    rows = re.findall(r"^(\S+) +(\d+) +(\d+) +(\d+) ", run.stdout, re.MULTILINE)
    assert sum(int(row[1]) for row in rows if row[0] != "reader") >= 240
    assert all(int(refused) + int(accepted) == int(cases) for _, cases, refused, accepted in rows)


@pytest.mark.slow
def test_readers_that_are_most_exposed_stand_a_few_cases() -> None:
    run = fuzz("--cases", "60", "--seed", "6", "--only", "kicad,idf,obj,gltf,parts,urdf")
    assert run.returncode == 0, run.stdout + run.stderr
