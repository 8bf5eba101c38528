from typing import Any

fdtrc: Any
ndtri: Any
stdtrit: Any
