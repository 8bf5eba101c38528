import ast
import re
from pathlib import Path

import pytest

from commandline.process import PACKAGES
from specs import finding_rules
from specs.errors import JobError
from specs.finding import FindingRule
from specs.finding_rules import FINDING_RULES, check_allowed

ROOT = Path(__file__).parents[2]
RULES = [pytest.param(rule, id=rule.id) for rule in FINDING_RULES.values()]


URDF = ROOT / "robotcell" / "robot"
"""``<collision>`` is an element of URDF files too."""


def texts() -> list[tuple[Path, str]]:
    files = [file for package in PACKAGES for file in sorted((ROOT / package).rglob("*.py"))]
    return [(file, file.read_text("utf-8")) for file in files if file.stem != "finding_rules"]


def rows(page: str) -> dict[str, tuple[str, str]]:
    """Give severities and meaning of each rule of a page's table of findings."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    found = re.findall(r"^\| `([a-z-]+)` \| ((?:error|warning|info)(?:, \w+)?) \| (.*) \|$", text, re.MULTILINE)
    return {rule: (severities, meaning) for rule, severities, meaning in found}


@pytest.mark.parametrize("rule", RULES)
def test_the_page_of_a_rule_lists_it_with_its_severities_and_meaning(rule: FindingRule) -> None:
    severities = rule.severity if rule.also is None else f"{rule.severity}, {rule.also}"
    assert rows(rule.page).get(rule.id) == (severities, rule.meaning), f"docs/{rule.page}"


def test_no_page_lists_a_rule_that_does_not_exist_or_another_severity() -> None:
    for page in sorted({rule.page for rule in FINDING_RULES.values()}):
        for rule, (severities, _) in rows(page).items():
            assert severities.split(", ")[0] == FINDING_RULES[rule].severity, f"docs/{page}: {rule}"


def test_a_constant_has_the_name_of_its_rule() -> None:
    constants = {name: value for name, value in vars(finding_rules).items() if isinstance(value, FindingRule)}
    assert [name.lower().replace("_", "-") for name in constants] == [rule.id for rule in constants.values()]
    assert list(constants.values()) == list(FINDING_RULES.values())


def test_no_rule_is_written_out_beside_the_registry() -> None:
    named = re.compile(rf"[\"'](?:{'|'.join(FINDING_RULES)})[\"']")  # parsing every module takes seconds
    bare = [
        f"{file.relative_to(ROOT)}:{node.lineno}: {node.value}"
        for file, text in texts()
        if named.search(text)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in FINDING_RULES
        if not (node.value == "collision" and file.is_relative_to(URDF))
    ]
    assert bare == []


def test_every_rule_is_that_of_a_check() -> None:
    used = {name for _, text in texts() for name in re.findall(r"\b[A-Z][A-Z_]+\b", text)}
    assert [name for name in vars(finding_rules) if name.isupper() and name[0] != "_" and name not in used] == [
        "FINDING_RULES"
    ]


def test_only_rules_that_exist_can_be_allowed() -> None:
    assert check_allowed(["collision", "no-valve"]) == ["collision", "no-valve"]
    with pytest.raises(JobError, match=r"^--allow colision: no finding has this rule; the nearest are collision, "):
        check_allowed(["collision", "colision"])
