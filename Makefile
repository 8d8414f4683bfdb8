# `make demo`, `make test`, `make docs` set up .venv first; a second run does not reinstall. `make wheel`, `make pythons` and
# `make lowest` work in environments of their own, which they remove.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# small matrices: BLAS threads that wait for a busy core cost more than they bring
export OPENBLAS_NUM_THREADS := 1
STAMP := $(VENV)/.installed
DOCS_STAMP := $(VENV)/.installed_docs

.PHONY: demo test lint types suite slow studies docs wheel pythons lowest clean

demo: $(STAMP)
	$(BIN)/physident demo

test: lint types suite

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/basedpyright

suite: $(STAMP)
	$(BIN)/pytest -n 2 -m "not slow"

slow: $(STAMP)
	$(BIN)/pytest -n 2 -m slow

studies: $(STAMP)
	for study in $$(grep -l '^# fast' studies/*/run.py); do echo "== $$study"; $(BIN)/python $$study || exit 1; done

docs: $(DOCS_STAMP)
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict
	@echo "built: build/site/index.html"

wheel:
	PYTHON=$(PYTHON) .ci/wheel

pythons:
	.ci/pythons

lowest:
	.ci/lowest

$(DOCS_STAMP): $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	touch $(DOCS_STAMP)

$(STAMP): pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "physident needs Python 3.11 or newer: make PYTHON=python3.11 demo")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	touch $(STAMP)

clean:
	rm -rf $(VENV) demo .pytest_cache .ruff_cache .coverage build *.egg-info
