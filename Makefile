# make demo: install and run the paper's first scenario.  make test: install and run every test.
# make lint, make types: style and types.  make package: build wheel and sdist, and try the wheel.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: demo test docs lint types package clean

demo: $(VENV)/installed
	$(BIN)/equipoise run tray

test: $(VENV)/installed-dev
	$(BIN)/python -m pytest -n 2 --dist worksteal

docs: $(VENV)/installed-docs
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs docs/_build/html
	@echo "The site: docs/_build/html/index.html"

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/installed-dev
	$(BIN)/mypy

package: $(VENV)/installed-dev
	rm -rf dist
	$(BIN)/python -m build --outdir dist
	$(BIN)/python tools/check_package.py dist

clean:
	rm -rf $(VENV) runs dist build

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Equipoise needs Python 3.11 or newer; give one: make PYTHON=/path/to/python3.12"; exit 1; }
	@$(PYTHON) -m venv $(VENV) || \
	  { rm -rf $(VENV); echo "No virtual environment could be made; on Debian: apt-get install python3-venv"; exit 1; }

$(VENV)/installed: pyproject.toml $(VENV)/bin/python
	@echo "Installing Equipoise into $(VENV) (about a minute, 1 GB) ..."
	@$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[viewer,plot]'
	@touch $@

$(VENV)/installed-dev: pyproject.toml $(VENV)/installed
	@$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[dev]'
	@touch $@

$(VENV)/installed-docs: pyproject.toml $(VENV)/installed
	@$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[docs]'
	@touch $@
