from typing import Any

label: Any
uniform_filter1d: Any
