from typing import Any

expm: Any
solveh_banded: Any
