"""Languages of robots: a lowered motion in, the text of a program out, and back.

A new language is a room of its own, with three modules:

* ``write.py``: a ``Syntax`` (``writing/driver.py``). The driver walks routines, steps, events, loops, notes and frames;
  the syntax has the language's words and limits as class attributes, writes one kind of step in each method
  (``writing/steps.py``), and puts the routines into files.
* ``read.py``: a ``Reader`` (``reading/driver.py``). It sorts the files into routines and data (``load``). The forms of
  its ``syntax``, templates such as ``"Delay {ms}"``, are read as they are written (``reading/forms.py``); it adds its
  own (``blocks``), the patterns of their ``fields``, and what no form writes (``grammar``). ``reading/execution.py``
  executes them. A statement that is not listed is an error.
* ``__init__.py``: the ``DIALECT`` (``dialect.py``): title, notes, timing of events (``Capability``), limits,
  and the two classes' ``write`` and ``rebuild``. A language without routines gives two functions instead.

Then a line in ``dialects.py`` and in the layers of ``pyproject.toml``, and a section in ``docs/robot-programs.md``. The
tests of ``tests/programs/posts/test_dialects.py`` enrol every entry: each made-up program is read back and compared
with the plan, as ``proving`` does at every export. ``pytest --update-golden`` writes the sample to review.
"""
