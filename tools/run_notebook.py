"""Execute the notebook of the examples, keep what it shows in its file, and take a picture of it for the documents.

python tools/run_notebook.py
"""

import subprocess
import tempfile
from pathlib import Path
from shutil import which

import nbformat
from nbclient import NotebookClient
from nbconvert import HTMLExporter

ROOT = Path(__file__).parents[1]
NOTEBOOK = ROOT / "examples" / "washboard.ipynb"
PICTURE = ROOT / "docs" / "images" / "notebook.png"
_SIZE = (1250, 3150)


def execute(folder: Path) -> nbformat.NotebookNode:
    """Run all cells in a folder; what they show is in the notebook that is returned.

    Raises:
        CellExecutionError: a cell raised an error.
    """
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    ).execute()
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # when it ran
    return notebook


def main() -> None:
    """Write the notebook and its picture."""
    with tempfile.TemporaryDirectory() as folder:
        notebook = execute(Path(folder))
        nbformat.write(notebook, NOTEBOOK)
        page = Path(folder) / "notebook.html"
        page.write_text(HTMLExporter(template_name="basic").from_notebook_node(notebook)[0], "utf-8")
        browser = which("chromium-headless-shell") or which("chromium") or "chromium"
        size = ",".join(map(str, _SIZE))
        words = [browser, "--no-sandbox", "--headless", "--disable-gpu", "--hide-scrollbars", f"--window-size={size}"]
        subprocess.run([*words, f"--screenshot={PICTURE}", page.as_uri()], check=True, capture_output=True)
    print(f"written {NOTEBOOK.relative_to(ROOT)} and {PICTURE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
