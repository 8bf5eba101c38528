from typing import Any

label: Any
