from typing import Any

class Server(Any): ...

ua: Any
