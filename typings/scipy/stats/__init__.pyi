from typing import Any

spearmanr: Any
truncnorm: Any
