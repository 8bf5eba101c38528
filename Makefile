# Two commands: `make demo` and `make test`. Everything they need goes into .venv; only the installation needs the network.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
# Wheels of the locked versions with the hashes of their files, then Washboard itself as it lies here.
PIP    := $(BIN)/python -m pip --disable-pip-version-check install --quiet
LOCKED := $(PIP) --require-hashes --only-binary :all:
SELF   := $(PIP) --no-deps --no-build-isolation --editable .
# Each has what the earlier ones lack: `make demo` needs the first, `make test` two.
LOCKS  := robot dev mutants supply
RESOLVE := $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header --no-annotate pyproject.toml
# One thread per process: the tests run side by side, and results do not depend on the machine's cores.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
# What Python compiles is kept, also where the environment says otherwise: compiling all tests takes each process 8 s.
unexport PYTHONDONTWRITEBYTECODE
# Each test process begins with its share of the tests in their order, so that what a file prepares is mostly made once.
PYTEST := $(BIN)/pytest -q --dist worksteal

.PHONY: demo test check controller controller-all quick all types imports style documents docs format clean mutants fuzz faults lock sbom audit wheel

demo: $(VENV)/.installed
	$(BIN)/washboard demo

test: style
	@$(MAKE) --no-print-directory --jobs 2 types all imports

check: style
	@$(MAKE) --no-print-directory --jobs 2 types quick imports

# LinuxCNC's real controller drives whole programs: it counts in real time, and is idle for most of it.
controller: $(VENV)/.compiled
	$(PYTEST) -n 2 -m "controller and not whole"

# With whole boards, one of them from both sides, and a panel.
controller-all: $(VENV)/.compiled
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

# Mutated inputs of every reader and every parameter of the command; CASES=10000 for a look. Faulty ones go to build/fuzz.
# CASES=50000 SEED=7 INTO=build/rows is one of several runs; INTO gathers them into one table.
fuzz: $(VENV)/.compiled
	$(BIN)/python tools/fuzz.py --cases $(or $(CASES),1000000) --seed $(or $(SEED),1) --jobs 2 --save build/fuzz \
	  $(if $(INTO),--into $(INTO))

# Small deliberate bugs, and the share of them that the tests notice; COUNT=20 for a look.
mutants: $(VENV)/.dev-installed
	$(LOCKED) -r lock/robot.txt -r lock/dev.txt -r lock/mutants.txt
	$(BIN)/python tools/mutants.py --count $(or $(COUNT),150)

# Errors, kills and interrupts at every system call on files of commands; EVERY=20 for a look.
faults: $(VENV)/.compiled
	$(BIN)/python tools/inject_faults.py --moments 10 --every $(or $(EVERY),1)

# What the lock lists, as CycloneDX; known defects of it, where the database of advisories can be reached.
sbom: $(VENV)/.supply-installed
	mkdir -p build
	cat lock/*.txt > $(VENV)/lock.txt
	$(BIN)/cyclonedx-py requirements --pyproject pyproject.toml --output-reproducible --output-file build/sbom.json $(VENV)/lock.txt

audit: $(VENV)/.supply-installed
	$(BIN)/pip-audit --strict --disable-pip --require-hashes $(LOCKS:%=--requirement lock/%.txt) > $(VENV)/audit.log 2>&1 || { code=$$?; \
	  ! grep -qE "not found on PyPI|Connection|HTTPError" $(VENV)/audit.log || echo "No database of advisories can be reached from here:"; \
	  tail -20 $(VENV)/audit.log; exit $$code; }

# The same wheel twice, byte for byte, into dist/; whatever date the environment states.
wheel: export SOURCE_DATE_EPOCH = 1580601600
wheel: $(VENV)/.installed
	@! git ls-files --others --exclude-standard 2> /dev/null | sed 's/^/not in the repository, and would be in the wheel: /' | grep .
	rm -f dist/*.whl $(VENV)/again/*.whl
	$(BIN)/hatchling build --target wheel --directory dist > $(VENV)/wheel.log
	umask 077 && $(BIN)/hatchling build --target wheel --directory $(VENV)/again > $(VENV)/wheel.log
	cmp dist/*.whl $(VENV)/again/*.whl && sha256sum dist/*.whl

# Pictures and printed output in README.md and two of the docs, made anew by running the product.
documents: $(VENV)/.installed
	$(BIN)/python tools/run_examples.py
	$(BIN)/python tools/run_notebook.py

# Tutorials, guides, reference and Python API as one site in site/. A broken link fails it; nothing is loaded from elsewhere.
docs: $(VENV)/.dev-installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build

format: $(VENV)/.dev-installed
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

$(VENV)/bin/python:
	$(PYTHON) -c "import sys; sys.exit(0 if sys.version_info >= (3, 11) else 'Washboard needs Python 3.11 or newer, this is ' + sys.version.split()[0] + ': make PYTHON=python3.12 ...')"
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: $(VENV)/bin/python pyproject.toml lock/robot.txt
	$(LOCKED) -r lock/robot.txt
	$(SELF)
	touch $@

$(VENV)/.dev-installed: $(VENV)/bin/python pyproject.toml lock/robot.txt lock/dev.txt
	$(LOCKED) -r lock/robot.txt -r lock/dev.txt
	$(SELF)
	touch $@ $(VENV)/.installed

$(VENV)/.supply-installed: $(VENV)/.installed $(wildcard lock/*.txt)
	$(LOCKED) $(LOCKS:%=-r lock/%.txt)
	touch $@

# The lock made anew after a change of requirements; versions stay where they can, or `make lock UPGRADE=--upgrade`.
lock: $(VENV)/.supply-installed
	cat lock/*.txt > $(VENV)/lock.txt
	$(BIN)/python -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['build-system']['requires'], sep='\n')" > $(VENV)/build.txt
	$(RESOLVE) $(VENV)/build.txt $(LOCKS:%=--extra %) $(UPGRADE) --output-file $(VENV)/lock.txt > $(VENV)/lock.log
	: > $(VENV)/earlier.txt
	for set in $(LOCKS); do \
	  $(RESOLVE) $(VENV)/build.txt --extra $$set --constraint $(VENV)/lock.txt > $(VENV)/set.txt && \
	  sed -n 's/==.*//p' $(VENV)/set.txt | grep -vxFf $(VENV)/earlier.txt > $(VENV)/names.txt && \
	  awk -F== 'NR == FNR {names[$$1]; next} /^[^ ]/ {keep = $$1 in names} keep' $(VENV)/names.txt $(VENV)/lock.txt > lock/$$set.txt && \
	  cat $(VENV)/names.txt >> $(VENV)/earlier.txt || exit 1; done

clean:
	rm -rf $(VENV) washboard-demo build dist site
