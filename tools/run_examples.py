"""Run the examples in the README and in some documents, and renew what they print and draw.

A document is followed from top to bottom, as a reader would, in an empty folder of its own:

- a block ```` ```yaml ```` whose first line is ``# NAME.yaml`` is saved under that name;
- every line ``$ COMMAND`` of a block ```` ```console ```` is run, and what is below it is replaced by what it prints.
  All commands have to succeed, in a block ```` ```console error ```` they have to be refused (exit status 2);
- a picture ``docs/images/NAME.png`` that the document shows is replaced by the ``NAME.png`` a command wrote. Those
  named ``guide-...`` are taken in the browser, by ``make_guide.py``, and stay as they are.

Run it with ``make documents`` and review the diff, pictures included.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
DOCUMENTS = (
    ROOT / "README.md",
    *(ROOT / "docs" / name for name in ("getting-started.md", "command-line.md", "film.md")),
)
COLUMNS = 110
BLOCK = re.compile(r"^```(?P<kind>console error|console|yaml)\n(?P<body>.*?)^```$", re.DOTALL | re.MULTILINE)
PICTURE = re.compile(r"!\[[^]]*\]\([^)]*?images/(?P<name>(?!guide-)[\w.-]+)\)")

Shell: TypeAlias = Callable[[str, Path], tuple[int, str]]
"""Runs a line in a folder: its exit status, and what it prints on either stream."""


def run_in_shell(command: str, folder: Path) -> tuple[int, str]:
    """Run one command as a reader does.

    A command that prints to the terminal sees one of 110 columns; one that prints into a pipe sees no width.
    """
    path = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"} | {"PATH": path}
    if "|" not in command:
        environment["COLUMNS"] = str(COLUMNS)
    run = subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return run.returncode, run.stdout


def run_document(document: Path, shell: Shell = run_in_shell) -> None:
    """Follow one document and write it anew.

    Args:
        document: Renewed in place.
        shell: Runs its commands.

    Raises:
        RuntimeError: a command ended otherwise than the document says, or did not write a picture that is shown.
    """
    text = document.read_text("utf-8")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        document.write_text(BLOCK.sub(lambda block: _renewed(block, folder, shell), text), "utf-8")
        for name in PICTURE.findall(text):
            if not (folder / name).exists():
                raise RuntimeError(f"{document.name} shows {name}, but no command in it writes {name}")
            shutil.copyfile(folder / name, IMAGES / name)


def _renewed(block: re.Match[str], folder: Path, shell: Shell) -> str:
    """Return a block with the output of its commands; a file is saved and stays as it is."""
    kind, body = block["kind"], block["body"]
    if kind == "yaml":
        if name := re.match(r"# ([\w-]+\.yaml)\n", body):
            (folder / name[1]).write_text(body, "utf-8")
        return block[0]
    expected = 2 if kind == "console error" else 0
    commands = [line[2:] for line in body.splitlines() if line.startswith("$ ")]
    shown = "\n".join(f"$ {command}\n{_printed_by(command, folder, expected, shell)}" for command in commands)
    return f"```{kind}\n{shown}```"


def _printed_by(command: str, folder: Path, expected: int, shell: Shell) -> str:
    """Run one command and return what it prints, without blanks at line ends."""
    code, printed = shell(command, folder)
    if code != expected or (expected == 0 and "error: " in printed):
        raise RuntimeError(f"{command}: ended with {code} instead of {expected}:\n{printed}")
    return "".join(line.rstrip() + "\n" for line in printed.splitlines())


if __name__ == "__main__":
    for each in DOCUMENTS:
        run_document(each)
