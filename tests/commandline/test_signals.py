"""Ctrl-C and the like, at moments that Python's own exception does not survive."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
IN_IMPORT = "ready(); time.sleep(60)"
IN_CLASS = """
class Waits:
    def __set_name__(self, owner, name):
        ready(); time.sleep(60)
class Owner:
    waits = Waits()
"""
SWALLOWED = """
while True:
    try:
        ready(); time.sleep(60)
    except BaseException:
        pass
"""
IN_DESTRUCTOR = """
class Waits:
    def __del__(self):
        ready(); time.sleep(60)
Waits()
"""
IN_NATIVE_CODE = "import hashlib; ready(); hashlib.pbkdf2_hmac('sha256', b'', b'', 2_000_000_000)"
AT_EXIT = "import atexit; atexit.register(time.sleep, 60); atexit.register(ready); raise SystemExit"
WITH_WORKERS = """
from concurrent.futures import ThreadPoolExecutor
with ThreadPoolExecutor(2) as pool:
    pool.submit(time.sleep, 60); pool.submit(time.sleep, 60); ready()
"""
WATCHED = "import os, signal, time; from commandline.process import watch; watch(); "
MOMENTS = {
    "import": IN_IMPORT, "class": IN_CLASS, "swallowed": SWALLOWED, "destructor": IN_DESTRUCTOR,
    "native": IN_NATIVE_CODE, "exit": AT_EXIT, "workers": WITH_WORKERS,
}  # fmt: skip


def waiting(tmp_path: Path, moment: str) -> subprocess.Popen[str]:
    """The real start, whose command is a module that is at some moment."""
    made = f"import sys, time\ndef ready():\n    print('ready', flush=True)\n{moment}\n"
    (tmp_path / "moment.py").write_text(made)
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import types; stand_in = types.ModuleType('m')\n"
        "def main():\n    import moment\n"
        "stand_in.main = main; sys.modules['commandline.main'] = stand_in\n"
        "from commandline.start import main as start; start()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("moment", MOMENTS)
def test_an_interrupt_is_one_line_and_130(moment: str, tmp_path: Path) -> None:
    process = waiting(tmp_path, MOMENTS[moment])
    process.send_signal(signal.SIGINT)
    assert process.communicate()[1] == "error: interrupted; nothing was written\n"
    assert process.returncode == 130


def test_five_interrupts_are_one(tmp_path: Path) -> None:
    process = waiting(tmp_path, SWALLOWED)
    for _ in range(5):
        process.send_signal(signal.SIGINT)
    assert process.communicate()[1] == "error: interrupted; nothing was written\n"
    assert process.returncode == 130


def test_sigterm_is_one_line_and_143(tmp_path: Path) -> None:
    process = waiting(tmp_path, IN_CLASS)
    process.send_signal(signal.SIGTERM)
    assert process.communicate()[1] == "error: ended by SIGTERM; nothing was written\n"
    assert process.returncode == 143


def test_what_was_written_before_is_named_and_the_rest_is_removed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    moment = (
        "from pathlib import Path; from specs.temporary import temporary_file\n"
        "from specs.output_file import OutputFile\n"
        f"out = Path({str(out)!r}); OutputFile(out / 'a.wash').write(b'x')\n"
        "with temporary_file(out):\n    ready(); time.sleep(60)\n"
    )
    process = waiting(tmp_path, moment)
    process.send_signal(signal.SIGINT)
    assert process.communicate()[1] == f"error: interrupted; written before, and complete: {out / 'a.wash'}\n"
    assert [each.name for each in out.iterdir()] == ["a.wash"]


def test_a_signal_that_is_ignored_from_outside_stays_ignored(tmp_path: Path) -> None:
    code = f"{WATCHED}os.kill(os.getpid(), signal.SIGHUP); print('on')"
    start = f"trap '' HUP; exec '{sys.executable}' -c \"{code}\""
    run = subprocess.run(["sh", "-c", start], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "on\n", "")


@pytest.mark.slow
def test_a_closed_error_stream_is_no_obstacle(tmp_path: Path) -> None:
    code = f"{WATCHED}os.kill(os.getpid(), signal.SIGINT); time.sleep(60)"
    run = subprocess.run(["sh", "-c", f"exec '{sys.executable}' -c '{code}' 2>&-"], cwd=ROOT, check=False)
    assert run.returncode == 130
