# Each target works alone on a fresh clone; it needs Python >= 3.11, make and pip.
PYTHON ?= python3
# Test processes at a time.
JOBS ?= auto
# Neighbours stay in one process, where they share fixtures; who is done takes over from the others.
SPREAD = -n $(JOBS) --dist worksteal
# More options for pytest: make test PYTEST_ARGS='-k ranging'.
PYTEST_ARGS ?=

BIN := .venv/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

.NOTPARALLEL:
.PHONY: help setup demo test check explore lint bench table board docs clients clean

help: ## show this list
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/make \1	\2/p' $(MAKEFILE_LIST)

setup: .venv/.done ## create .venv with everything the other targets need

demo: .venv/.base ## fly the rule of the paper beside others and learned agents, and print the scores (some two minutes on two idle cores)
	$(BIN)/rss-gym demo

test: .venv/.done ## run all tests; skipped ones are listed with their reasons
	$(BIN)/python -m pytest -ra $(SPREAD) $(PYTEST_ARGS)

check: lint ## before each commit, under two minutes on two idle cores: the linters, and the tests not marked slow
	$(BIN)/python -m pytest $(SPREAD) -m 'not slow' $(PYTEST_ARGS)

explore: .venv/.done ## run the property tests with fresh examples (HYPOTHESIS_PROFILE=explore); `make test` always draws the same
	HYPOTHESIS_PROFILE=explore $(BIN)/python -m pytest -ra $(SPREAD) -m hypothesis $(PYTEST_ARGS)

lint: .venv/.done ## style, types and layers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: .venv/.bench ## step rates on one core, beside other environments
	$(BIN)/python benchmarks/speed.py

table: .venv/.done ## fly the policies and write their tables (half an hour on two idle cores; goes on where it was interrupted)
	$(BIN)/rss-gym study opponents --pages .

docs: .venv/.done ## build the site in build/docs; a warning or a broken link is an error
	$(BIN)/python -m sphinx -W --keep-going -q -b html -d build/doctrees docs build/docs
	@echo "site: build/docs/index.html"

clients: .venv/.base ## run other libraries against this package, each in an environment of its own (an hour; not in CI)
	$(BIN)/python tests/clients/run.py

# A season of the package's own policies in runs/board, its secret and key beside it; nothing of it is published by itself.
BOARD_SUITES ?= encounter-v0 encounter3d-v0 range-only-v0 gnss-v0 radios-v0 turning-v0 degenerate-v0 separating-v0 merging-v0 highway-v0:100
BOARD_ENCOUNTERS ?= 1000
board: .venv/.done ## fly a sealed season of all policies and write its pages, runs/board/site (goes on where it was interrupted)
	test -f runs/board/season.json || $(BIN)/rss-gym board new runs/board/season.json --name own --suites $(BOARD_SUITES) \
	  --public $(BOARD_ENCOUNTERS) --sealed $(BOARD_ENCOUNTERS)
	$(BIN)/rss-gym board fly --season runs/board/season.json --board runs/board/lines --workers 2
	$(BIN)/rss-gym board site runs/board/lines --season runs/board/season.json --out runs/board/site --overwrite

clean: ## remove build products and caches; .venv stays
	rm -rf build dist docs/gallery docs/generated docs/api/generated *.egg-info .coverage .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find rss_gym baselines train eval tests -name __pycache__ -type d -prune -exec rm -rf {} +

# One stamp for each set of packages: the demo needs no test tools.
.venv/.base: pyproject.toml constraints.txt | $(BIN)/python
	@echo "Installing rss-gym into .venv ..."
	@$(INSTALL) -e .
	@touch $@

.venv/.done: pyproject.toml constraints.txt | $(BIN)/python
	@echo "Installing rss-gym with test tools and PyTorch into .venv (a few minutes the first time) ..."
	@$(INSTALL) -e '.[dev,train]'
	@touch .venv/.base $@

.venv/.bench: pyproject.toml constraints.txt | $(BIN)/python
	@echo "Installing rss-gym with the packages of the benchmark into .venv ..."
	@$(INSTALL) -e '.[bench]'
	@touch .venv/.base $@

# Where the standard library comes without ensurepip (as some Linux distributions split it), $(PYTHON)'s own pip fills the venv.
$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "rss_gym needs Python 3.11 or newer, and '$(PYTHON)' is not: try 'make PYTHON=python3.13 ...'." >&2; exit 1; }
	@if $(PYTHON) -c 'import ensurepip' 2>/dev/null; then $(PYTHON) -m venv .venv; \
	else $(PYTHON) -m venv --without-pip .venv && $(PYTHON) -m pip --python $@ install --quiet pip || { rm -rf .venv; exit 1; }; fi
