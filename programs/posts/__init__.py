"""Languages of robots: a lowered motion in, the text of a program out, and back.

A new language is one module, among the ``robots`` or, where its blocks name axes, in ``gcode``:

* A ``Syntax`` (``writing/driver.py``). The driver walks routines, steps, events, loops, notes and frames; the syntax
  has the language's words, limits and forms as class attributes, writes one kind of step in each method
  (``writing/steps.py``), and puts the routines into files. A form such as ``"Delay {ms:0}"`` is the one statement of
  how a line looks (``writing/forms.py``).
* A ``Reader`` (``reading/driver.py``). It sorts the files into routines and data (``load``), and reads the forms of
  its ``syntax`` as they are written; it adds what its own do (``blocks``), and the patterns of their texts
  (``texts``). ``reading/execution.py`` executes them. A statement that is not listed is an error.
* The ``DIALECT`` (``dialect.py``): title, notes, timing of events (``Capability``), limits, and the two classes'
  ``write`` and ``rebuild``. A language without routines gives two functions instead.

Then a line in ``dialects.py`` and a section in ``docs/robot-programs.md``. The tests of
``tests/programs/posts/test_dialects.py`` enrol every entry: each made-up program is read back and compared with the
plan, as ``proving`` does at every export. ``pytest --update-golden`` writes the sample to review.
"""
