from typing import Any

splu: Any
