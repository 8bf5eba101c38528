# Two commands: `make demo` and `make test`. Everything they need goes into .venv; only the installation needs the network.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check install --quiet
# One thread per process: the tests run side by side, and results do not depend on the machine's cores.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
# What Python compiles is kept, also where the environment says otherwise: compiling all tests takes each process 8 s.
unexport PYTHONDONTWRITEBYTECODE
# Each test process begins with its share of the tests in their order, so that what a file prepares is mostly made once.
PYTEST := $(BIN)/pytest -q --dist worksteal

.PHONY: demo test check controller quick all types imports style documents docs format clean mutants

demo: $(VENV)/.installed
	$(BIN)/washboard demo

test: style
	@$(MAKE) --no-print-directory --jobs 2 types all imports

check: style
	@$(MAKE) --no-print-directory --jobs 2 types quick imports

# LinuxCNC's real controller drives whole programs: it counts in real time, and is idle for most of it.
controller: $(VENV)/.compiled
	$(PYTEST) -n 2 -m controller

style: $(VENV)/.dev-installed
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

imports: $(VENV)/.dev-installed
	$(BIN)/lint-imports

quick: $(VENV)/.compiled
	$(PYTEST) -n 2 -m "not slow and not controller"

# Three processes: tests of the page wait for a browser every now and then.
all: $(VENV)/.compiled
	$(PYTEST) -n 3 -m "not controller"

# Most of what it reads lives long: fewer and larger collections spare a fifth of its time.
types: $(VENV)/.dev-installed
	NODE_OPTIONS=--max-semi-space-size=256 $(BIN)/pyright

# The dry runs compile the hot loops once, so that the test processes find them in the cache. An analysis ends with
# 1 where the board is not predicted clean, as here: that is an answer and no failure.
$(VENV)/.compiled: $(VENV)/.dev-installed $(shell grep -rlE --include=*.py --exclude-dir=.venv '^@(compiled|quick|vectorised)' .)
	$(BIN)/washboard plan smt-demo > $(VENV)/warm.log
	$(BIN)/washboard plan tiny --output $(VENV)/warm.wash > $(VENV)/warm.log
	$(BIN)/washboard check $(VENV)/warm.wash ur5e-bench > $(VENV)/warm.log
	$(BIN)/washboard check $(VENV)/warm.wash gantry > $(VENV)/warm.log
	$(BIN)/washboard check $(VENV)/warm.wash kr6-bench > $(VENV)/warm.log || test $$? -eq 1
	$(BIN)/washboard plan f-bracket part-degrease --output $(VENV)/warm-part.wash > $(VENV)/warm.log
	$(BIN)/washboard analyse $(VENV)/warm.wash --verify U1 > $(VENV)/warm.log || test $$? -eq 1
	touch $@

# Small deliberate bugs, and the share of them that the tests notice; COUNT=20 for a look.
mutants: $(VENV)/.dev-installed
	$(PIP) --editable ".[mutants]"
	$(BIN)/python tools/mutants.py --count $(or $(COUNT),150)

# Pictures and printed output in README.md and two of the docs, made anew by running the product.
documents: $(VENV)/.installed
	$(BIN)/python tools/run_examples.py
	$(BIN)/python tools/run_notebook.py

# Tutorials, guides, reference and Python API as one site in site/. A broken link fails it; nothing is loaded from elsewhere.
docs: $(VENV)/.docs-installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build

format: $(VENV)/.dev-installed
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

$(VENV)/bin/python:
	$(PYTHON) -c "import sys; sys.exit(0 if sys.version_info >= (3, 11) else 'Washboard needs Python 3.11 or newer, this is ' + sys.version.split()[0] + ': make PYTHON=python3.12 ...')"
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: $(VENV)/bin/python pyproject.toml
	$(PIP) --editable ".[robot]"
	touch $@

$(VENV)/.dev-installed: $(VENV)/bin/python pyproject.toml
	$(PIP) --editable ".[dev]"
	touch $@ $(VENV)/.installed $(VENV)/.docs-installed

$(VENV)/.docs-installed: $(VENV)/bin/python pyproject.toml
	$(PIP) --editable ".[docs]"
	touch $@

clean:
	rm -rf $(VENV) washboard-demo build dist site
