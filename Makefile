# wucht: two commands are all the set-up there is: `make demo` and `make test`.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
# Processes of the tests; the tests of one file share what they build.
WORKERS ?= 2
# What is compiled is kept for the next start, whatever the shell says: the tests start many processes.
PYTEST = PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n $(WORKERS) --dist loadfile

.PHONY: demo test test-all lint docs numbers pictures bench mutants errata clean

$(STAMP): pyproject.toml constraints.txt hatch_build.py $(wildcard src/wucht/web/*.ts src/wucht/web/*.css src/wucht/web/*.json)
	$(PYTHON) -c 'import sys; sys.exit("wucht needs Python 3.11 or newer; give one: make PYTHON=python3.11 ...") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[test,lint]'
	touch $@

demo: $(STAMP)
	$(BIN)/wucht run practice/laundry-drum -o demo
	@echo "Look at demo/run-up.png"

test: $(STAMP)
	$(PYTEST) -m "not slow"

# Everything that the machine allows; what it could not run stands at the end.
test-all: $(STAMP)
	$(PYTEST) -rs

OXLINT = NODE_USE_SYSTEM_CA=1 $(BIN)/npx --fetch-retries=1 --fetch-timeout=20000 --yes oxlint@1.94.0

lint: $(STAMP)
	$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy
	@if $(OXLINT) --version > /dev/null 2>&1; then $(OXLINT) src/wucht/web; else echo "TypeScript is not linted: npm reaches no registry"; fi

errata: $(STAMP)  # docs/errata.md from the checks
	$(BIN)/python -m tests.validation.errata

# What the catalogue answers is kept in build/gallery. GALLERY=all: also what takes minutes; GALLERY=kept: nothing is computed.
GALLERY ?= quick

$(VENV)/.docs: $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[docs]'
	touch $@

docs: $(VENV)/.docs
	$(BIN)/python -m docs.site --gallery $(GALLERY)

numbers: $(STAMP)  # numbers in pages of docs from the results that state them
	$(BIN)/python -m docs.site.numbers

pictures: $(STAMP)  # docs/pictures from the gallery, and of the live machine in a browser
	$(BIN)/python -m docs.site.pictures
	$(BIN)/python -m docs.site.live_pictures

bench: $(STAMP)
	$(BIN)/python -m benchmarks

mutants: $(STAMP)  # the errors of benchmarks/errors put in, one after the other: which test notices each
	$(BIN)/python -m benchmarks errors

clean:
	rm -rf $(VENV) build demo results .pytest_cache .mypy_cache .ruff_cache .hypothesis
