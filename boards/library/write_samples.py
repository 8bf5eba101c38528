"""Write the sample boards beside this file: ``python -m boards.library.write_samples``."""

import gzip
from pathlib import Path

from boards.formats.tri import write_tri
from boards.library.assemble import assemble
from boards.library.sensor_hub import SENSOR_HUB
from boards.library.smt_demo import SMT_DEMO
from boards.library.tiny import TINY
from boards.library.two_sided import TWO_SIDED

_FILES = {
    "smt-demo.tri.gz": SMT_DEMO,
    "sensor-hub.tri.gz": SENSOR_HUB,
    "two-sided.tri.gz": TWO_SIDED,
    "tiny.tri": TINY,
}


def render_samples() -> dict[str, str]:
    """Return the text of each sample's file by the file's name."""
    return {file: write_tri(assemble(sample)) for file, sample in _FILES.items()}


def write_samples(folder: Path) -> None:
    """Write every sample into a folder; packed files carry no date, so that the same text gives the same file."""
    for file, text in render_samples().items():
        content = text.encode()
        (folder / file).write_bytes(gzip.compress(content, mtime=0) if file.endswith(".gz") else content)


if __name__ == "__main__":
    write_samples(Path(__file__).parent)
