from typing import Any

export_glb: Any
