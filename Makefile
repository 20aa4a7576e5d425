PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
STUDIES := paper radius-sweep random plane discretisation basins bias scale convergence ladder proofs

.DEFAULT_GOAL := help
.PHONY: help study studies reference test rooms check bench lock clean

help:  ## list the targets
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 12

$(READY): requirements.lock pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

study: $(READY)  ## run the experiments paper and radius-sweep and write the report
	$(BIN)/dubins-study run paper
	$(BIN)/dubins-study run radius-sweep --jobs 2
	$(BIN)/dubins-study report results/paper results/radius-sweep --out results/report

studies: $(READY)  ## run every experiment but the reference and write one report of all
	for name in $(STUDIES); do $(BIN)/dubins-study run $$name --jobs 2 || exit $$?; done
	$(BIN)/dubins-study report $(STUDIES:%=results/%) --out results/studies

reference: $(READY)  ## make the committed reference run anew
	$(BIN)/dubins-study run reference --out results/reference --restart

test: $(READY)  ## run the tests
	$(BIN)/python -m pytest $(ARGS)

rooms: $(READY)  ## print each room with its promise, its size and what it imports
	$(BIN)/python -m tests.unit.test_layers

check: $(READY)  ## lint, format and type checks
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: $(READY)  ## measure speed beside peers and print a table of ratios
	$(BIN)/python -m benchmarks

lock: $(READY)  ## resolve the dependencies anew and pin them with hashes
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
	    --no-annotate --custom-compile-command 'make lock' \
	    --all-extras pyproject.toml -o requirements.lock

clean:  ## remove the environment and caches
	rm -rf $(VENV) build dist .mypy_cache .pytest_cache .ruff_cache
