"""What the documents point at exists: links, anchors, commands, options, recipes."""

import re
import shlex
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
import run_examples
from command import washboard
from typer.core import TyperGroup
from typer.main import get_command

from commandline.main import app
from recipes.load import load_recipe

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
DECISIONS = ROOT / "docs" / "adr"
FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"!?\[[^]]*\]\(([^)\s]+)\)")
CALL = re.compile(r"washboard (?P<words>[^|>;&]*)(?P<rest>.*)")
"""A call of washboard, and the pipe or redirection behind it"""
YAML_PAGES = ("docs/getting-started.md", "docs/recipe.md")

every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())


def anchors(page: Path) -> set[str]:
    """The names of a page's headings, as GitHub makes them."""
    names: list[str] = []
    for heading in re.findall(r"^#+ +(.+)$", FENCE.sub("", page.read_text("utf-8")), re.MULTILINE):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
        name = re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")
        names.append(f"{name}-{names.count(name)}" if name in names else name)
    return set(names)


def broken_links(page: Path) -> Iterator[str]:
    for target in LINK.findall(FENCE.sub("", page.read_text("utf-8"))):
        if target.startswith(("https://", "mailto:")):
            continue
        name, _, anchor = target.partition("#")
        file = page.parent / name if name else page
        if not file.exists() or (anchor and anchor not in anchors(file)):
            yield target


@every_page
def test_every_relative_link_leads_somewhere(page: Path) -> None:
    assert list(broken_links(page)) == []


def test_a_broken_link_is_noticed(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# One, two\n[good](#one-two) [web](https://x.org) [no file](gone.md) [no heading](#three)\n", "utf-8"
    )
    assert list(broken_links(page)) == ["gone.md", "#three"]


def listed(index: Path) -> set[Path]:
    return {(index.parent / target).resolve() for target in LINK.findall(index.read_text("utf-8"))}


def test_the_index_lists_every_document() -> None:
    index = ROOT / "docs" / "README.md"
    documents = {page for page in PAGES if page.is_relative_to(ROOT / "docs") and page.parent != DECISIONS}
    assert documents - listed(index) == {index}
    assert DECISIONS / "README.md" in listed(index)


def test_the_index_of_decisions_lists_each_of_them_by_its_number() -> None:
    index = DECISIONS / "README.md"
    assert set(DECISIONS.glob("*.md")) - listed(index) == {index}
    for target in re.findall(r"\| \[(\d+)\. [^]]*\]\((\d+)-[^)]*\)", index.read_text("utf-8")):
        assert int(target[0]) == int(target[1])


def test_changes_and_decisions_stay_short() -> None:
    assert (ROOT / "CHANGELOG.md").stat().st_size < 8_000
    decisions = sorted(DECISIONS.glob("[0-9]*.md"))
    assert 0 < len(decisions) <= 40
    assert [page.name for page in decisions if len(page.read_text("utf-8").split()) > 320] == []


@pytest.mark.parametrize("page", sorted(DECISIONS.glob("[0-9]*.md")), ids=lambda page: page.name)
def test_a_decision_has_its_number_context_decision_and_consequences(page: Path) -> None:
    text = page.read_text("utf-8")
    assert text.startswith(f"# {int(page.name[:4])}. ")
    assert [part for part in ("Context", "Decision", "Consequences") if f"**{part}.**" not in text] == []


def test_every_decision_that_code_names_exists() -> None:
    """``docs/adr/0017`` in a docstring, in any package."""
    packages = (folder for folder in ROOT.iterdir() if (folder / "__init__.py").exists())
    named = {
        number
        for folder in packages
        for module in folder.rglob("*.py")
        for number in re.findall(r"docs/adr/(\d{4})", module.read_text("utf-8"))
    }
    assert named
    assert named <= {page.name[:4] for page in DECISIONS.glob("[0-9]*.md")}


def commands(text: str, program: str) -> Iterator[list[str]]:
    """Each call of a program in code: the words of a line after its name, up to a pipe, a comment or a column of text.

    Calls that a document shows because they are refused are left out.
    """
    fenced = [line for kind, body in FENCE.findall(text) if kind != "console error" for line in body.splitlines()]
    for code in [*fenced, *re.findall(r"`([^`\n]+)`", FENCE.sub("", text))]:
        call = re.match(rf"(?:\$ )?(?:.*; |.*\$\(|\.venv/bin/)?{program} ([^|>;#`)]*)", code)
        if call:
            yield shlex.split(call[1].split("   ")[0])


built_command = cache(lambda: get_command(app))


def complaint(words: list[str]) -> str | None:
    """Say what in a call of washboard does not exist; ``COMMAND`` stands for any."""
    command = built_command()
    for word in words:
        if word.startswith("-"):
            options = {"--help", "--install-completion"}.union(*(each.opts for each in command.params))
            if word.split("=")[0] not in options:
                return f"{' '.join(words)}: there is no option {word}"
        elif isinstance(command, TyperGroup) and not word.isupper():
            if word not in command.commands:
                return f"{' '.join(words)}: there is no command {word}"
            command = command.commands[word]
    return None


@every_page
def test_every_command_that_is_named_exists(page: Path) -> None:
    called = commands(page.read_text("utf-8"), "washboard")
    assert [each for each in map(complaint, called) if each] == []


def test_a_command_that_does_not_exist_is_noticed() -> None:
    text = (
        "`washboard plan a --pictures x.png`\n```sh\n$ washboard recipe invent | head\n```\n`washboard show x.wash`\n"
    )
    found = [complaint(words) for words in commands(text, "washboard")]
    assert [each is None for each in found] == [False, False, True]
    assert len(list(commands((ROOT / "README.md").read_text("utf-8"), "washboard"))) >= 6


@every_page
def test_every_make_target_that_is_named_exists(page: Path) -> None:
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
    named = {word for words in commands(page.read_text("utf-8"), "make") for word in words if "=" not in word}
    assert named <= targets


@pytest.mark.parametrize("name", YAML_PAGES)
def test_every_recipe_that_is_shown_loads(name: str, tmp_path: Path) -> None:
    shutil.copyfile(ROOT / "recipes" / "library" / "smt-aqueous.yaml", tmp_path / "my-board.yaml")
    blocks = [body for kind, body in FENCE.findall((ROOT / name).read_text("utf-8")) if kind == "yaml"]
    assert blocks
    for number, block in enumerate(blocks):
        title = re.match(r"# ([\w-]+\.yaml)\n", block)
        file = tmp_path / (title[1] if title else f"block-{number}.yaml")
        file.write_text(block if "recipe:" in block else completed(block), "utf-8")
        assert load_recipe(str(file)).sequence


def completed(fragment: str) -> str:
    """A fragment is a piece of a recipe, or, indented, of its templates."""
    head = "recipe: fragment\nextends: smt-aqueous\n"
    return f"{head}templates:\n{fragment}" if fragment.startswith(" ") else head + fragment


@pytest.mark.slow
@pytest.mark.long
def test_the_python_that_is_shown_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "python.md").read_text("utf-8")
    exec("\n".join(body for kind, body in FENCE.findall(text) if kind == "python"), {})
    assert {file.name for file in tmp_path.iterdir()} == {
        *("slower.yaml", "tiny.wash", "tiny.png", "tiny.json", "tiny.html", "robot")
    }
    assert "speed_mm_s" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("page", run_examples.DOCUMENTS, ids=lambda page: page.name)
def test_the_examples_run_and_print_what_the_documents_show(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numbers may differ, words may not; ``make documents`` renews both."""

    def run_here(command: str, folder: Path) -> tuple[int, str]:
        monkeypatch.chdir(folder)
        return run_in_this_process(command, folder, tmp_path)

    monkeypatch.setattr(run_examples, "IMAGES", tmp_path)
    copy = Path(shutil.copy(page, tmp_path))
    run_examples.run_document(copy, run_here)
    shown, renewed = (words_of(each.read_text("utf-8")) for each in (page, copy))
    assert renewed == shown, "run `make documents` and review the diff"


def run_in_this_process(line: str, folder: Path, aside: Path) -> tuple[int, str]:
    """Run a line that begins with washboard: that in this process, and what a shell makes of its output in a shell.

    Starting dozens of processes takes longer than what they do; ``make documents`` starts them. Other lines, and those
    that begin with something else, are run as they stand.
    """
    call = CALL.match(line)
    if not call:
        return run_examples.run_in_shell(line, folder)
    done = washboard(*shlex.split(call["words"]), columns=None if "|" in line else run_examples.COLUMNS)
    (aside / "out").write_text(done.out, "utf-8")
    (aside / "err").write_text(done.err, "utf-8")
    again = f"washboard() {{ cat {aside}/out; cat {aside}/err >&2; return {done.code}; }}; washboard {call['rest']}"
    return run_examples.run_in_shell(again, folder)


def words_of(text: str) -> list[str]:
    return re.sub(r"[\d.,]+", "0", text).split()
