"""The house: how many modules a room holds, and the words that the code and its documents do not use."""

import ast
import re
import tokenize
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = tuple(tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["root_packages"])
MODULES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
DOCUMENTS = [*sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
MOST_MODULES = 14

_RETIRED = """
tell tells told telling retell retold say says said saying ask asks asked asking want wants wanted wanting wish wishes
wished hope hopes hoped hopeless trust trusts trusted despair disappointed foretell foretells foretold knob knobs leap
leaps torn posture postures leant glimpse narrate narrates paced
"""
COMPILED = {"compiled", "quick", "inner", "inlined", "vectorised"}
RETIRED = frozenset(_RETIRED.split())
RETIRED_NAMES = RETIRED | {"course", "deck", "shop", "visitor", "starters", "garbage"}
"""In identifiers alone: in a sentence some of them are the right word."""
"""Of a private dialect; docs/glossary.md has the field's words for what they stood for."""


@cache
def suspects(package: str) -> list[Path]:
    """Modules in whose text a retired word stands anywhere: few, and only they are taken apart."""
    return [
        path
        for path in MODULES
        if path.relative_to(ROOT).parts[0] == package
        and retired_words(re.sub(r"(?<=[a-z])(?=[A-Z])|_", " ", path.read_text("utf-8")), RETIRED_NAMES)
    ]


@cache
def tokens(path: Path) -> list[tokenize.TokenInfo]:
    with path.open("rb") as file:
        return list(tokenize.tokenize(file.readline))


def names(path: Path) -> Iterator[tuple[int, str]]:
    """Identifiers with their lines."""
    for token in tokens(path):
        if token.type == tokenize.NAME:
            yield token.start[0], token.string


def retired_parts(name: str) -> set[str]:
    """Retired words that an identifier in snake or camel case is made of."""
    return {part.lower() for part in re.split(r"_|(?<=[a-z])(?=[A-Z])", name)} & RETIRED_NAMES


def retired_words(text: str, words: frozenset[str] = RETIRED) -> set[str]:
    return set(re.findall(r"[a-z]+", text.lower())) & words


def test_a_room_holds_at_most_so_many_modules() -> None:
    rooms = {path.parent for path in MODULES}
    counts = {str(room.relative_to(ROOT)): sum(1 for _ in room.glob("[!_]*.py")) for room in rooms}
    assert {room: count for room, count in counts.items() if count > MOST_MODULES} == {}


def test_every_package_has_a_contract_for_its_rooms() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    contained = {each["containers"][0] for each in contracts if each.get("exhaustive")}
    inits = [path for path in MODULES if path.name == "__init__.py"]
    with_rooms = {
        ".".join(path.parent.relative_to(ROOT).parts)
        for path in inits
        if any(other.parent.parent == path.parent for other in inits)
    }
    assert with_rooms <= contained


def test_no_signed_number_is_shown_as_minus_zero() -> None:
    shown = {path.name: re.findall(r":\+\.\d[fg%]", path.read_text("utf-8")) for path in MODULES}
    assert {name: found for name, found in shown.items() if found} == {}, "write it with z, as in :+z.1f"


@pytest.mark.parametrize("package", PACKAGES)
def test_no_identifier_is_made_of_retired_words(package: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in suspects(package)
        for line, name in names(path)
        if retired_parts(name)
    ]
    assert found == []


@pytest.mark.parametrize("package", PACKAGES)
def test_no_docstring_message_or_comment_uses_retired_words(package: str) -> None:
    found: list[str] = []
    for path in suspects(package):
        texts = [
            (node.lineno, node.value)
            for node in ast.walk(ast.parse(path.read_text("utf-8")))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        ]
        texts += [(token.start[0], token.string) for token in tokens(path) if token.type == tokenize.COMMENT]
        found += [
            f"{path.relative_to(ROOT)}:{line}: {sorted(retired_words(text))}"
            for line, text in texts
            if retired_words(text)
        ]
    assert found == []


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_no_document_uses_retired_words(path: Path) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{number}: {sorted(retired_words(line))}"
        for number, line in enumerate(path.read_text("utf-8").splitlines(), start=1)
        if retired_words(line)
    ]
    assert found == []


def _decorators(node: ast.AST) -> set[str]:
    return {each.id for each in getattr(node, "decorator_list", []) if isinstance(each, ast.Name)}


def _called(node: ast.AST, is_compiled: bool = False) -> Iterator[tuple[str, bool]]:
    """Names that are read, and whether the innermost function around them is compiled."""
    for child in ast.iter_child_nodes(node):
        inside = bool(_decorators(child) & COMPILED) if isinstance(child, ast.FunctionDef) else is_compiled
        if isinstance(child, ast.Name) and isinstance(child.ctx, ast.Load):
            yield child.id, is_compiled
        yield from _called(child, inside)


def test_what_has_no_way_in_from_python_is_called_by_compiled_code_alone() -> None:
    """Called from Python it would end the process without a word."""
    trees = {
        path: ast.parse(path.read_text("utf-8")) for path in MODULES if "compiled import" in path.read_text("utf-8")
    }
    inner = {node.name for tree in trees.values() for node in tree.body if "inner" in _decorators(node)}
    assert inner
    tests = [path for path in (ROOT / "tests").rglob("*.py") if path != Path(__file__)]
    for path in tests:
        imported = {
            each.name
            for node in ast.parse(path.read_text("utf-8")).body
            if isinstance(node, ast.ImportFrom)
            for each in node.names
        }
        assert not imported & inner, path
    for path, tree in trees.items():
        assert not {name for name, by_compiled in _called(tree) if name in inner and not by_compiled}, path
