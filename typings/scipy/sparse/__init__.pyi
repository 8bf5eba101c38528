from typing import Any

class coo_array(Any): ...
class csc_array(Any): ...
class csr_array(Any): ...

hstack: Any
vstack: Any
block_diag: Any
bmat: Any
diags_array: Any
eye_array: Any
kron: Any
