"""How far a prediction holds: under the ranges of its parameters, for later boards of a bath, against measurements.

``criteria`` is what they share: whether a gap keeps the limit of each rule, and by how much. ``capability`` uses it for
samples of the parameters, ``comparison`` for the rule that was nearest to its limit where a ``measured_table``
contradicts the prediction; ``bath`` follows what many boards leave in a bath.
"""
