"""What is installed: the lock has all that pyproject.toml requires, with hashes, and no address."""

import re
import tomllib
from importlib import metadata
from itertools import accumulate
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
EXTRAS: dict[str, list[str]] = PROJECT["project"]["optional-dependencies"]
SETS = ("robot", "dev", "mutants", "supply")
"""Files in lock/; each has what the earlier ones lack, as in the Makefile."""
TEXTS = {name: (ROOT / "lock" / f"{name}.txt").read_text("utf-8") for name in SETS}
LOCKED = re.compile(r"(?m)^([^\s;\\]+==[^\s;\\]+(?: ; [^\\\n]+)?) \\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)")


def environment(version: str) -> dict[str, str]:
    """Values of markers with a version of Python on Linux."""
    linux = {"sys_platform": "linux", "platform_system": "Linux", "platform_machine": "x86_64", "os_name": "posix"}
    python = {"implementation_name": "cpython", "platform_python_implementation": "CPython"}
    return {**linux, **python, "python_full_version": version, "python_version": version.rpartition(".")[0]}


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def required(extra: str) -> list[Requirement]:
    """Requirements of an extra, of Washboard itself and of its build."""
    found = [*PROJECT["project"]["dependencies"], *PROJECT["build-system"]["requires"], *EXTRAS[extra]]
    texts = [text for each in found for text in (inner(each) if each.startswith("washboard[") else [each])]
    return [Requirement(text) for text in texts]


def inner(own: str) -> list[str]:
    return [text for name in Requirement(own).extras for text in EXTRAS[name]]


def locked_in(name: str, here: dict[str, str] | None = None) -> dict[str, str]:
    """Versions by name that a set and those before it have for an environment, this one if none is given."""
    texts, versions = dict(zip(SETS, accumulate(TEXTS.values()), strict=True))[name], dict[str, str]()
    for locked in (Requirement(found[1]) for found in LOCKED.finditer(texts)):
        if locked.marker is None or locked.marker.evaluate(here):
            assert locked.name not in versions, "two versions"
            versions[locked.name] = str(locked.specifier).removeprefix("==")
    return versions


@pytest.mark.parametrize("version", ["3.11.2", "3.11.9", "3.12.0", "3.13.1"])
@pytest.mark.parametrize("extra", EXTRAS)
def test_the_lock_has_what_each_extra_requires(extra: str, version: str) -> None:
    here = environment(version)
    versions = locked_in(extra if extra in SETS else "dev", here)
    for each in required(extra):
        if each.marker is None or each.marker.evaluate(here):
            found = versions.get(canonical(each.name))
            assert found in each.specifier if found else False, f"{each}: run `make lock`"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["robot", "dev"])
def test_the_lock_has_what_its_packages_require(name: str) -> None:
    versions = locked_in(name)
    for package, version in versions.items():
        try:
            installed = metadata.distribution(package)
        except metadata.PackageNotFoundError:
            continue  # of another environment, as where a set was left out
        for each in map(Requirement, (installed.requires or []) if installed.version == version else []):
            if each.marker is None or each.marker.evaluate({"extra": ""}):
                assert canonical(each.name) in versions, f"{package} requires {each}: run `make lock`"


def test_the_lock_has_hashes_and_no_address() -> None:
    for name, text in TEXTS.items():
        assert "".join(found[0] for found in LOCKED.finditer(text)) == text, f"lock/{name}.txt: run `make lock`"


def test_no_package_is_locked_twice() -> None:
    names = [{Requirement(found[1]).name for found in LOCKED.finditer(text)} for text in TEXTS.values()]
    assert len(set().union(*names)) == sum(map(len, names))
