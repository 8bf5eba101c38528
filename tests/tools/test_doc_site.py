"""The site of `make docs`: every page is in it, links lead somewhere, and nothing is loaded from elsewhere."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from doc_site.pages import ROOT, api_page, examples_page, on_post_page, site_path, spaced_lists
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File
from mkdocs.structure.pages import Page

import washboard


def build(*options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mkdocs", "build", *options]
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    return subprocess.run(command, cwd=ROOT, env=quiet, capture_output=True, text=True, check=False)


@pytest.mark.slow
@pytest.mark.long
def test_the_site_has_every_page_and_loads_nothing_from_elsewhere(tmp_path: Path) -> None:
    done = build("--site-dir", str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    pages = {page.relative_to(tmp_path).with_suffix("").as_posix() for page in tmp_path.rglob("*.html")}
    for document in (ROOT / "docs").rglob("*.md"):
        name = document.relative_to(ROOT / "docs").with_suffix("").as_posix()
        assert name.replace("README", "index") in pages
    assert {"api", "examples", "contributing", "changes"} <= pages
    loaded = r"<(?:script|link|img|iframe)[^>]*(?:src|href)=\"([^\"]*)"
    texts = [page.read_text("utf-8") for page in tmp_path.rglob("*.html")]
    assert [target for text in texts for target in re.findall(loaded, text) if "//" in target] == []
    assert "load" in (tmp_path / "search" / "search_index.js").read_text("utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("link", ["gone.md", "README.md#gone", "#gone"])
def test_a_link_that_leads_nowhere_fails_the_build(link: str, tmp_path: Path) -> None:
    settings = (ROOT / "mkdocs.yml").read_text("utf-8")
    strict = settings[settings.index("validation:") : settings.index("nav:\n")]
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "README.md").write_text(f"# Here\n[there]({link})\n", "utf-8")
    (tmp_path / "mkdocs.yml").write_text(f"site_name: x\nstrict: true\n{strict}", "utf-8")
    done = build("--config-file", str(tmp_path / "mkdocs.yml"))
    assert done.returncode == 1
    assert link in done.stderr


def test_a_page_that_loads_from_elsewhere_is_refused() -> None:
    page = Page("Page", File("page.md", "docs", "site", False), MkDocsConfig())
    for text in ('<a href="https://x.org">x</a>', '<script src="assets/x.js">', "<code>https://x.org</code>"):
        assert on_post_page(text, page, MkDocsConfig()) == text
    for text in ('<script src="https://x.org/x.js">', '<link rel="stylesheet" href="//x.org/x.css">'):
        with pytest.raises(PluginError, match=r"page\.md loads from elsewhere: "):
            on_post_page(text, page, MkDocsConfig())


@pytest.mark.parametrize(
    ("file", "place"),
    [
        ("docs/recipe.md", "recipe.md"),
        ("docs/adr/README.md", "adr/README.md"),
        ("docs/../CHANGELOG.md", "changes.md"),
        ("robotcell/library/LICENCES.md", "licences.md"),
        ("examples", "examples"),
    ],
)
def test_a_file_of_the_repository_has_its_place_in_the_site(file: str, place: str) -> None:
    assert site_path(ROOT / file) == place


@pytest.mark.parametrize(
    ("written", "spaced"),
    [
        ("text\n- one\n- two", "text\n\n- one\n- two"),
        ("1. one\n   goes on\n2. two", "1. one\n    goes on\n2. two"),
        ("- one\n\n  more of it\n\ntext", "- one\n\n    more of it\n\ntext"),
        ("text\n  indented", "text\n  indented"),
        ("- one\n\ntext\n  indented", "- one\n\ntext\n  indented"),
    ],
)
def test_lists_are_written_as_python_markdown_requires(written: str, spaced: str) -> None:
    assert "\n".join(spaced_lists(written.split("\n"))) == spaced


def test_every_example_and_every_public_name_has_its_place() -> None:
    examples = examples_page()
    for file in (ROOT / "examples").glob("*.py"):
        assert f"\n## {file.stem}\n" in examples
        assert file.read_text("utf-8") in examples
    for name in washboard.__all__:
        assert re.search(rf"^::: [\w.]+\.{name}$", api_page(), re.MULTILINE), name
