"""What a start lacks is noticed before anything is imported: packages of our own, memory, descriptors."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from commandline.process import MARKER, PACKAGES, find_foreign

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """An installation whose packages are no more than their ``__init__``, but for the start."""
    site = tmp_path / "site"
    for name in PACKAGES:
        (site / name).mkdir(parents=True)
        shutil.copy(ROOT / name / "__init__.py", site / name)
    for name in ("start", "process"):
        shutil.copy(ROOT / "commandline" / f"{name}.py", site / "commandline")
    return site


def start(site: Path, folder: Path, *before: str) -> subprocess.CompletedProcess[str]:
    """Start ``washboard --version`` in a folder, with no other installation in sight."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([*before, str(site)])}
    code = "from commandline.start import main; main()"
    words = [sys.executable, "-S", "-P", "-c", code, "--version"]
    return subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_every_root_of_the_project_is_marked_and_looked_at() -> None:
    assert {*PACKAGES} == set(PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"])
    for name in PACKAGES:
        assert MARKER in (ROOT / name / "__init__.py").read_bytes()
    assert PROJECT["project"]["scripts"]["washboard"] == "commandline.start:main"
    assert find_foreign() is None


@pytest.mark.slow
@pytest.mark.parametrize("name", ["specs", "boards", "webui"])
def test_an_overwritten_package_ends_the_start_with_a_sentence(name: str, site: Path, tmp_path: Path) -> None:
    (site / name / "__init__.py").write_text("raise SystemExit('imported')\n")
    other = site / "planks-1.0.dist-info"
    other.mkdir()
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: planks\nVersion: 1.0\n")
    (other / "RECORD").write_text(f"{name}/__init__.py,,\n")
    run = start(site, tmp_path)
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.startswith(f"error: the package '{name}' in {site / name} is not washboard's: ")
    assert "the distribution planks has put its own in that place" in run.stderr
    assert "pipx install" in run.stderr
    assert run.stderr.count("\n") == 1


def test_a_folder_that_is_found_first_is_named(site: Path, tmp_path: Path) -> None:
    mine = tmp_path / "work" / "recipes"
    mine.mkdir(parents=True)
    (mine / "__init__.py").write_text("raise SystemExit('imported')\n")
    run = start(site, mine.parent, str(mine.parent))
    assert (run.returncode, run.stdout) == (2, "")
    assert f"the package 'recipes' in {mine} is not washboard's" in run.stderr
    assert run.stderr.count("\n") == 1


def test_a_folder_without_init_shadows_nothing(site: Path, tmp_path: Path) -> None:
    (tmp_path / "work" / "boards").mkdir(parents=True)
    run = start(site, tmp_path / "work", str(tmp_path / "work"))
    assert "is not washboard's" not in run.stderr


@pytest.mark.parametrize("name", ["boards", "webui"])
def test_a_package_that_was_removed_is_named(name: str, site: Path, tmp_path: Path) -> None:
    (site / name / "__init__.py").unlink()
    assert "has no __init__.py" in start(site, tmp_path).stderr
    shutil.rmtree(site / name)
    run = start(site, tmp_path)
    assert f"the package '{name}' of washboard is missing in {site}" in run.stderr
    assert (run.returncode, run.stderr.count("\n")) == (2, 1)


@pytest.mark.parametrize(
    ("limit", "reason"),
    [
        ("-v 300000", "the memory of this process is limited to 307 MB, and washboard needs 1,000 MB at least: raise"),
        ("-n 5", r"washboard cannot start \(.*Too many open files.*: raise the limit \(`ulimit -n`\)\.$"),
    ],
)
def test_limits_that_nothing_loads_with_are_named(limit: str, reason: str, tmp_path: Path) -> None:
    code = "from commandline.start import main; main()"
    command = f"ulimit {limit} && exec {sys.executable} -S -P -c '{code}' --version"
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    run = subprocess.run(
        ["sh", "-c", command], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stdout) == (2, "")
    assert re.match(f"error: {reason}", run.stderr)
    assert run.stderr.count("\n") == 1
