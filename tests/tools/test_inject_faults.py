"""A slice of ``tools/inject_faults.py``: outputs are old or new, nothing is left, one line; and a defect is found."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TOOL = ROOT / "tools" / "inject_faults.py"
START = "import runpy, sys\nsys.argv = {words}\n{before}\nrunpy.run_path({tool!r}, run_name='__main__')"
BEFORE = """import os, specs.output_file as o, specs.temporary as t
def w(file, text):
    with open(file.path, "wb") as stream:
        stream.write(o._utf8(text))
        os.fsync(stream.fileno())
"""
DEFECTS = {
    "flush": ("o._write_flushed = lambda descriptor, content: os.write(descriptor, content)", "before it is flushed"),
    "litter": ("t._remove = lambda *owners: None; t.sweep = lambda folder: None", " is left"),
    "in place": ("o.OutputFile.write = lambda file, text, known_as=None: w(file, text)", "neither old nor new"),
}


def injected(*words: str, before: str = "") -> subprocess.CompletedProcess[str]:
    """Run the tool, after some lines of Python."""
    start = START.format(words=["inject_faults", *words], before=before, tool=str(TOOL))
    run, environment = [sys.executable, "-c", start], os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(run, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.slow
@pytest.mark.long
def test_what_the_page_saves_and_a_log_stay_whole_at_a_slice_of_the_calls() -> None:
    done = injected("--only", "ui", "--only", "operate", "--every", "20", "--moments", "1")
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert done.stdout.endswith(" points, 0 wrong\n")
    assert {line.split()[1] for line in done.stdout.splitlines()[:-1]} == {
        "ENOSPC", "EIO", "EINTR", "EMFILE", "short", "kill", "interrupt",
    }  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", DEFECTS)
def test_a_defect_is_found(kind: str) -> None:
    defect, words = DEFECTS[kind]
    done = injected("--only", "ui", "--fault", "kill", "--every", "4", before=f"{BEFORE}{defect}")
    assert done.returncode == 1
    assert words in done.stdout + done.stderr
