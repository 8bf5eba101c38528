from typing import Any

FramerType: Any
