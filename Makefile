# Each target makes .venv and installs what it needs; nothing but make and Python 3.11 or newer has to be there.
# PYTHON=/path/to/python chooses the Python.

PYTHON ?= $(shell for python in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$python && break; done)
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet install

# Processes that share the tests: one more than the cores that may be used, as some tests wait for real clocks,
# and at most 16: each takes up to 1.5 GB.
JOBS ?= $(shell $(BIN)/python -c 'from vidstyle.core.machine.cores import available_cores; print(min(available_cores() + 1, 16))')
# What to run, as arguments of pytest; nothing means all tests.
TESTS ?=
TYPESCRIPT := 7.0.2
PYTEST = $(BIN)/python -m pytest --numprocesses $(JOBS) --dist worksteal

.PHONY: demo test thorough check docs site clean

demo: .venv/program.stamp  ## make a short film and restyle it
	$(BIN)/vidstyle demo

test: .venv/dev.stamp  ## run all tests
	$(PYTEST) $(TESTS)

thorough: .venv/dev.stamp  ## run every combination of what `test` tries a part of
	$(PYTEST) -m thorough $(TESTS)

check: .venv/dev.stamp  ## look over the code: layout, lint, types; those of JavaScript where Node.js is there
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	if command -v npx > /dev/null; then npx --yes --package typescript@$(TYPESCRIPT) tsc --project tsconfig.json; fi

docs: .venv/dev.stamp  ## build the API reference, build/api/index.html
	$(BIN)/python -m tools.api_reference

site: .venv/dev.stamp  ## build the web site, build/site/index.html
	$(BIN)/python -m tools.site

clean:  ## remove all that was made here
	rm -rf .venv dist build demo .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/program.stamp: pyproject.toml | .venv/bin/python
	$(PIP) --editable '.[comic,web]'
	@touch $@

.venv/dev.stamp: pyproject.toml | .venv/bin/python
	$(PIP) --editable '.[comic,web,dev]'
	@touch $@ .venv/program.stamp

.venv/bin/python:
	$(if $(PYTHON),,$(error vidstyle needs Python 3.11 or newer; name one with make PYTHON=/path/to/python))
	$(PYTHON) -m venv .venv || { rm -rf .venv; exit 1; }
