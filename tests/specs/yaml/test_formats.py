"""Files of every kind and of every version of its format are read; older ones are converted, later ones refused."""

import importlib
from dataclasses import replace
from pathlib import Path

import pytest

from recipes.errors import RecipeError
from recipes.load import RECIPE
from specs.yaml.edit import set_value
from specs.yaml.file_kind import FORMAT, FileKind
from specs.yaml.load import parse_spec, read_text, resolve_text
from specs.yaml.located import present_text, read_yaml

ROOT = Path(__file__).parents[3]
FILES = Path(__file__).parent / "formats"
PACKAGES = ("boards", "cleaning", "programs", "recipes", "reports", "robotcell", "rulesengine", "studies", "webui")


def file_kinds():
    """All kinds of YAML file, wherever a module of the house declares one."""
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            if "= FileKind(" in path.read_text("utf-8"):
                name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
                kinds = (each for each in vars(importlib.import_module(name)).values() if isinstance(each, FileKind))
                found |= {kind.noun: kind for kind in kinds}
    return [found[noun] for noun in sorted(found)]


def sample(kind, version):
    return FILES / f"{kind.noun.replace(' ', '-')}-{version}.yaml"


def parsed(text, kind, file="<sample>"):
    return parse_spec(resolve_text(text, file, kind), kind)


KINDS = file_kinds()
VERSIONS = [pytest.param(kind, version, id=f"{kind.noun} {version}") for kind in KINDS
            for version in range(1, kind.format + 1)]  # fmt: skip


def test_every_kind_is_there():
    assert {kind.noun for kind in KINDS} == {
        "cell", "columns file", "library of chemistries", "panel", "parameter set", "part", "recipe", "reference",
        "robot", "study",
    }  # fmt: skip


@pytest.mark.parametrize(("kind", "version"), VERSIONS)
def test_a_file_of_each_version_is_read(kind, version):
    """Whoever changes a format adds a sample of the new one, and the old one stays."""
    file = sample(kind, version)
    assert file.exists(), f"store a {kind.noun} of format {version} as {file.relative_to(ROOT)}"
    text = file.read_text("utf-8")
    found = parsed(text, kind)
    assert parsed(read_text(file, kind), kind) == found
    stated = read_yaml(text, file, kind)
    assert stated.get(FORMAT) is None, "no value of the model"
    if version == 1 and "\nformat:" in f"\n{text}":
        plain = "\n".join(line for line in text.split("\n") if not line.startswith("format:"))
        assert parsed(plain, kind) == found, "what states no format is of the first"


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.noun)
def test_every_older_version_has_a_converter(kind):
    assert sorted(kind.converters) == list(range(1, kind.format))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.noun)
def test_the_schema_has_the_key(kind):
    assert kind.schema()["properties"][FORMAT]["enum"] == [kind.format]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.noun)
def test_a_later_version_is_refused_with_its_line(kind):
    text = f"# a comment\nformat: {kind.format + 1}\n{sample(kind, kind.format).read_text('utf-8')}"
    text = "\n".join(line for at, line in enumerate(text.split("\n")) if at < 2 or not line.startswith("format:"))
    with pytest.raises(kind.error) as refused:
        resolve_text(text, "own.yaml", kind)
    assert str(refused.value) == (
        f"own.yaml:2: format: {kind.format + 1} is written for a later version of Washboard; install it, or write the "
        f"{kind.noun} for format {kind.format}"
    )


@pytest.mark.parametrize("stated", ["0", "-1", "1.0", "true", "one", "[1]"])
def test_what_is_no_version_is_refused(stated):
    with pytest.raises(RecipeError, match=r"own\.yaml:1: format: must be a whole number from 1 to 1$"):
        resolve_text(f"format: {stated}\nrecipe: own\nextends: smt-aqueous\n", "own.yaml", RECIPE)


def _second(text):
    return set_value(text.replace("old_mm:", "clearance:"), (FORMAT,), 2)


def _third(text):
    return set_value(text.replace("clearance:", "clearance_mm:"), (FORMAT,), 3)


LATER = replace(RECIPE, format=3, converters={1: _second, 2: _third}, library=lambda: {})


RECIPE_TEXT = """# A recipe of ours.
recipe: base
functions: {clean: {solution: soap, pressure_bar: 3, max_speed_mm_s: 60}}
nozzles: {ring: {pattern: hollow_cone, flow_lpm: 2, half_angle_deg: 30}}
classes: {all: {}}
templates:
  # to and fro
  sweep: {path: raster, height_mm: 40, speed_mm_s: 30}
limits:
  KEY: 6  # of ours
sequence: [{function: clean, nozzle: ring, paths: [sweep]}]
"""


def complete(key, version):
    """A recipe as it would have been in a format with another name for a key."""
    text = RECIPE_TEXT.replace("KEY", key)
    return text if version is None else f"format: {version}\n{text}"


@pytest.mark.parametrize(("key", "version"), [("old_mm", None), ("old_mm", 1), ("clearance", 2), ("clearance_mm", 3)])
def test_an_older_file_is_converted_step_by_step_and_keeps_its_comments(tmp_path, key, version):
    file = tmp_path / "own.yaml"
    file.write_text(complete(key, version), "utf-8")
    text = read_text(file, LATER)
    comments = [line.partition("#")[2] for line in file.read_text("utf-8").split("\n") if "#" in line]
    assert [line.partition("#")[2] for line in text.split("\n") if "#" in line] == comments
    assert "  clearance_mm: 6  # of ours" in text
    assert "format: 3" in text
    assert present_text(text, file, LATER) == text
    assert parsed(text, LATER).limits.clearance_mm == 6
    assert parsed(file.read_text("utf-8"), LATER).limits.clearance_mm == 6


@pytest.mark.parametrize("versions", [(None, 3), (3, None), (2, 1)])
def test_each_file_of_a_chain_has_a_format_of_its_own(tmp_path, versions):
    keys = {None: "old_mm", 1: "old_mm", 2: "clearance", 3: "clearance_mm"}
    base, own = versions
    (tmp_path / "base.yaml").write_text(complete(keys[base], base), "utf-8")
    text = f"recipe: own\nextends: base.yaml\nlimits: {{{keys[own]}: 7}}\n"
    text = text if own is None else f"format: {own}\n{text}"
    found = parsed(text, LATER, tmp_path / "own.yaml")
    assert (found.recipe, found.limits.clearance_mm) == ("own", 7)
    found = parsed(f"format: {own or 1}\nrecipe: own\nextends: base.yaml\n", LATER, tmp_path / "own.yaml")
    assert found.limits.clearance_mm == 6
