"""What the jet achieves: exposure, flow under components, residue, rinse, drying, verdicts.

``analyse.analyse`` takes a program, its board and recipe and a parameter set, and gives a ``CleaningReport``. Rooms:

- ``parameters``: the inputs of the model and their provenance; ``calibration`` fits some of them to measurements.
- ``process``: the stages of a program; ``jet``: flow, speed and distribution of a spray; ``surface``: facets and rays.
- ``exposure``: what reaches each cell; ``film``: pressure of jet and film on the edges of undersides.
- ``gap``: Hele-Shaw flow under a package and flushing; ``undersides``: entry, residue, rinse and drying of one gap.
- ``verdicts``: the registry of the rules and their judgements; ``report``: the result as plain data.
- ``uncertainty``: how far a prediction holds: under ranges of parameters, for many boards, against measurements.
- ``validation``: the model against what others published.

SI units, except where a name ends in another (``_mm``, ``_um``, ``_c``, ``_bar``). Numbers without meaning raise
``errors.CleaningError``.
"""

DISTRIBUTION = "washboard"
