"""What the site has beside the files of docs/, and how a page written for GitHub becomes one of the site.

``mkdocs.yml`` names this module as a hook: MkDocs calls the ``on_...`` functions. Pages that lie outside of docs/ are
taken along, links to them follow, and the Python API and the examples get pages of their own. A page that would load
anything from elsewhere fails the build.
"""

import ast
import os
import re
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]
TAKEN_ALONG = {
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
    "LICENSE": "license.txt",
    "NOTICE": "notice.txt",
    "robotcell/library/LICENCES.md": "licences.md",
    "tools/doc_site/iframe-worker.js": "assets/iframe-worker.js",
}
"""Files of the repository, and where they are in the site"""
LINK = re.compile(r"(!?\[[^]]*\]\()([^)\s#]+)(#[^)\s]*)?\)")
ITEM = re.compile(r" *([-*]|\d+\.) ")
FOREIGN = re.compile(r"""<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=["']?(?:https?:)?//""")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that docs/ does not have."""
    for source, target in TAKEN_ALONG.items():
        files.append(File.generated(config, target, content=(ROOT / source).read_text("utf-8")))
    for notebook in sorted((ROOT / "examples").glob("*.ipynb")):
        files.append(File.generated(config, f"examples/{notebook.name}", content=notebook.read_text("utf-8")))
    files.append(File.generated(config, "examples.md", content=examples_page()))
    files.append(File.generated(config, "api.md", content=api_page()))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Let links and lists mean in the site what they mean on GitHub."""
    del config, files
    origin = {target: source for source, target in TAKEN_ALONG.items()}.get(page.file.src_uri)
    folder = (ROOT / (origin or f"docs/{page.file.src_uri}")).parent

    def follow(link: re.Match[str]) -> str:
        if "://" in link[2] or page.file.src_uri in {"examples.md", "api.md"}:
            return link[0]
        target, anchor = site_path(folder / link[2]), link[3] or ""
        if target == "examples":
            target = "examples.md"
        elif target.startswith("examples/") and target.endswith(".py"):
            target, anchor = "examples.md", f"#{Path(target).stem}"
        return f"{link[1]}{os.path.relpath(target, Path(page.file.src_uri).parent)}{anchor})"

    return "".join(
        piece if piece.startswith("```") else "\n".join(spaced_lists(LINK.sub(follow, piece).split("\n")))
        for piece in re.split(r"(^```.*?^```$)", markdown, flags=re.DOTALL | re.MULTILINE)
    )


def site_path(file: Path) -> str:
    """Return where a file of the repository is in the site, or where it would be."""
    path = Path(os.path.normpath(file)).relative_to(ROOT).as_posix()
    return TAKEN_ALONG.get(path) or path.removeprefix("docs/")


def spaced_lists(lines: list[str]) -> Iterator[str]:
    """Put a blank line before a list, and indent by four what belongs to an item: Python-Markdown requires both."""
    before, in_list = "", False
    for line in lines:
        item = ITEM.match(line)
        if item and before.strip() and not in_list:
            yield ""
        in_list = bool(item) or (in_list and (line.startswith("  ") or not line.strip() or bool(before.strip())))
        yield f"    {line.lstrip()}" if in_list and not item and line.startswith("  ") else line
        before = line


def examples_page() -> str:
    """Return the examples, one after the other, each under its name."""
    pieces = ["# Python examples\n\nEach is a file in `examples/`, and is run as a test.\n"]
    for file in sorted((ROOT / "examples").glob("*.py")):
        text = file.read_text("utf-8")
        title = (ast.get_docstring(ast.parse(text)) or file.stem).partition("\n")[0]
        pieces.append(f"## {file.stem}\n\n{title}\n\n```python\n{text}```\n")
    return "\n".join(pieces)


def public_names() -> dict[str, tuple[str, ...]]:
    """Return what the package ``washboard`` offers, by the module that has it, without importing it."""
    module = ast.parse((ROOT / "washboard" / "__init__.py").read_text("utf-8"))
    values = (
        each.value for each in module.body if isinstance(each, ast.Assign) and ast.unparse(each.targets[0]) == "_PLACES"
    )
    return ast.literal_eval(next(values))


TITLES = {
    "inputs": "Open",
    "planned": "Plan",
    "cleaned": "Analyse",
    "checked": "Check and export",
    "tuned": "Tune",
    "studied": "Study",
    "rows": "Tables",
    "errors": "Errors",
}
"""Of the modules of the face, in the order of a job"""


def api_page() -> str:
    """Return the page that mkdocstrings fills with signatures and docstrings: functions first, then what they give."""
    pieces = [
        "# Python API\n\nAll of these are names of `washboard`: `import washboard as wb`. "
        "[How to use them](python.md), [examples](examples.md).\n"
    ]
    modules = {module.rpartition(".")[2]: module for module in [*public_names(), "specs.rows"]}
    names = {**public_names(), "specs.rows": ("Rows",)}
    for stem in [*(each for each in TITLES if each in modules), *sorted(modules.keys() - TITLES.keys())]:
        pieces.append(f"## {TITLES.get(stem, stem)}\n")
        found = sorted(names[modules[stem]], key=lambda name: (name[0].isupper(), name))
        pieces += [f"::: {modules[stem]}.{name}\n" for name in found]
    return "\n".join(pieces)


def on_post_page(output: str, page: Page, config: MkDocsConfig) -> str:
    """Refuse a page that loads something from elsewhere."""
    del config
    if found := FOREIGN.search(output):
        raise PluginError(f"{page.file.src_uri} loads from elsewhere: {output[found.start() : found.end() + 60]}")
    return output
