"""Write the sample boards into the library: ``python tools/write_sample_boards.py``."""

import gzip
from pathlib import Path

from sample_boards.assemble import assemble
from sample_boards.radio_stick import RADIO_STICK
from sample_boards.sensor_hub import SENSOR_HUB
from sample_boards.smt_demo import SMT_DEMO
from sample_boards.tiny import TINY
from sample_boards.two_sided import TWO_SIDED

from boards.formats.tri.tri import write_tri

_FILES = {
    "smt-demo.tri.gz": SMT_DEMO,
    "sensor-hub.tri.gz": SENSOR_HUB,
    "radio-stick.tri.gz": RADIO_STICK,
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
