"""Write the sample boards of the library anew, each from its description in ``sample_boards``."""

from pathlib import Path

from sample_boards.write_samples import write_samples

if __name__ == "__main__":
    write_samples(Path(__file__).resolve().parent.parent / "boards" / "library")
