"""The registry of the verdict rules is complete, is the documented one, and holds the only copies of their ids."""

import ast
import re
import tomllib
from pathlib import Path

from cleaning.verdicts.rules import RULES, VERDICTS

ROOT = Path(__file__).parents[3]


def test_the_rules_are_numbered_from_1_to_15_and_each_has_a_title_of_its_own():
    assert [rule.id for rule in RULES] == [f"R{number}" for number in range(1, 16)]
    assert len({rule.title for rule in RULES}) == len(RULES)
    assert all(rule.meaning.endswith(".") for rule in RULES)


def test_verdicts_of_a_rule_are_listed_worst_first():
    for rule in RULES:
        assert rule.verdicts
        assert list(rule.verdicts) == [verdict for verdict in VERDICTS if verdict in rule.verdicts]


def test_the_documentation_has_each_rule_at_its_anchor():
    for rule in RULES:
        page, anchor = rule.page.split("#")
        row = f'| <a id="{anchor}"></a>{rule.id} | {rule.meaning} | {rule.grade} |'
        assert row in (ROOT / page).read_text("utf-8")


def test_ids_of_rules_stand_in_the_registry_alone():
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["root_packages"]
    found = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for package in packages
        for path in sorted((ROOT / package).rglob("*.py"))
        if re.search(r"['\"]R\d", text := path.read_text("utf-8"))
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and re.fullmatch(r"R\d{1,2}", node.value)
    ]
    assert {place.split(":")[0] for place in found} == {"cleaning/verdicts/rules.py"}
