PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
# one worker a core where no time is quoted
JOBS := $(shell nproc 2> /dev/null || echo 2)
STUDIES := paper radius-sweep-full random plane basins bias convergence ladder routes kaya convex

.DEFAULT_GOAL := help
.PHONY: help study studies benchmark test test-all adversary rooms check docs bench lock clean

help:  ## list the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 12

# byte code of the libraries is kept in the environment, whatever the caller's habit: it halves what
# each later process takes to start
unexport PYTHONDONTWRITEBYTECODE

UV := $(BIN)/uv pip install --quiet --python $(BIN)/python --index-strategy unsafe-best-match
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

# uv is many times faster than pip but does not read pip's configuration: where uv finds no package
# index, pip may. Both check every file against the hashes of the lock.
$(READY): requirements.lock pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	sed -n '/^uv==/,/[^\\]$$/p' requirements.lock > $(VENV)/uv.lock
	$(PIP) --require-hashes -r $(VENV)/uv.lock
	$(UV) --require-hashes -r requirements.lock \
	    || { echo 'make: uv could not install; pip tries' >&2; \
	         $(PIP) --require-hashes -r requirements.lock; }
	$(BIN)/uv pip install --quiet --python $(BIN)/python --no-deps --no-build-isolation -e . \
	    || $(PIP) --no-deps --no-build-isolation -e .
	$(BIN)/python -m dubins_study.asking.compile_loops
	touch $@

study: $(READY)  ## run the experiments paper and radius-sweep; write their page and the benchmark's
	$(BIN)/dubins-study run paper
	$(BIN)/dubins-study run radius-sweep --jobs $(JOBS)
	$(BIN)/dubins-study report results/benchmark --out results/benchmark-report > /dev/null
	$(BIN)/dubins-study report results/paper results/radius-sweep --out results/report
	@echo 'benchmark: results/benchmark-report/index.html'

studies: $(READY)  ## run every experiment but the benchmark and write one report of all
	for name in $(STUDIES); do $(BIN)/dubins-study run $$name --jobs 2 || exit $$?; done
	$(BIN)/dubins-study report $(STUDIES:%=results/%) --out results/studies

# one job, so that nothing else takes time from a solve; begun again, it goes on where it was stopped
SUITES := tour route pose leg search proof
benchmark: $(READY)  ## run the benchmark's six suites and the convex problems (144 minutes) and write their report
	$(BIN)/dubins-study run convex --out results/benchmark/convex --jobs 1
	for suite in $(SUITES); do \
	    $(BIN)/dubins-study run benchmark-$$suite --out results/benchmark/$$suite --jobs 1 || exit $$?; \
	done
	$(BIN)/dubins-study report results/benchmark --out results/benchmark-report

# a group keeps the tests that watch time, memory or processes in one worker
PYTEST := $(BIN)/python -m pytest -n $(JOBS) --dist loadgroup $(ARGS)

test: $(READY)  ## run the tests, but for the slow ones
	$(BIN)/python -m dubins_study.asking.compile_loops
	$(PYTEST)

test-all: $(READY)  ## run all tests
	$(BIN)/python -m dubins_study.asking.compile_loops
	$(PYTEST) --slow

N ?= 100000
ROUTES ?= 2000
SEED ?= 0
adversary: $(READY)  ## attack the package with N hard cases and ROUTES routes, and with dense tours; exit 1 if one is wrong
	$(BIN)/python -m dubins_study.asking.compile_loops
	$(BIN)/python -m tests.adversary.campaign $(N) $(ROUTES) --seed $(SEED) --workers $(JOBS)
	WHOLE=1 $(PYTEST) --slow tests/adversary

rooms: $(READY)  ## print each room with its promise, what it imports and its size beside its budget
	$(BIN)/python -m tests.unit.test_layers

check: $(READY)  ## lint, format and type checks
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# a page that does not build cleanly, a link to nowhere or a notebook that fails ends the build
docs: $(READY)  ## build the documentation into build/site
	$(BIN)/sphinx-build -q -E -W --keep-going docs build/site
	@echo build/site/index.html

bench: $(READY)  ## measure speed beside peers and print a table of ratios
	$(BIN)/python -m benchmarks

lock: $(READY)  ## resolve the dependencies anew and pin them with hashes
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
	    --no-annotate --custom-compile-command 'make lock' \
	    --index-strategy unsafe-best-match --all-extras pyproject.toml -o requirements.lock

clean:  ## remove the environment and caches
	rm -rf $(VENV) build dist .mypy_cache .pytest_cache .ruff_cache
