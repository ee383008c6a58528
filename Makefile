# make demo   sets everything up and checks the toggle press
# make test   sets everything up and runs the tests
# make lint   types, style and the direction of imports
# make wheels asks the package index whether Windows, Linux and macOS need no compiler
# make bench  runs the benchmarks, writes bench/results.json
# make trade  compares the rungs with solids, writes the bars of the ladder and docs/trade.md (hours)
# make documents  compares the documents' published values, writes docs/documents.md, docs/hammer_leaf.md
# make fuzz   checks 10 000 mutated designs, an hour at most, writes bench/fuzz.json
# make screens  checks all machines, writes the pictures of their reports in docs/screens
# make docs   builds the documentation as a site, build/site/index.html, without a network; seconds
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
PEERS := $(VENV)/peers
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# Where nothing compiled is kept every process of the tests compiles everything anew.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: demo test slow lint style types windows_types imports docs wheels fuzz bench trade documents screens setup clean
.DEFAULT_GOAL := demo

setup: $(READY)

$(READY): pyproject.toml requirements.txt tools/system_libraries.sh
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "ballesta: needs Python 3.11 or newer, $(PYTHON) is older" >&2; exit 2; }
	@tools/system_libraries.sh $(PYTHON)
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --requirement requirements.txt
	@$(BIN)/python -m pip install --quiet --no-deps --editable .
	@touch $(READY)

# What tests and benchmarks compare with, and the browser; they say so where it is missing.
$(PEERS): $(READY)
	@tools/system_libraries.sh $(PYTHON) peers
	@touch $(PEERS)

# The demo judges nothing: the press' own verdict (exit code 1 for FAIL or UNDECIDED) is its result.
demo: $(READY)
	@$(BIN)/ballesta check designs/toggle_press.toml --out out || test $$? -eq 1
	@echo "ballesta in this shell: . .venv/bin/activate; then: ballesta new four-bar --file four_bar.toml"

# Each process takes one thread (tests/conftest.py): threads of their own would wait for each other.
# The tests of a file stay in one process, which shares what a module has computed; slow tests, each
# as long as a file, are shared out one by one. What lasts longest begins (tests/longest_first.py).
SHARED := --maxprocesses 4 --max-worker-restart 0 --durations 15 --durations-min 5
# Browsers, batches and supervised commands wait an eighth of the time: one process more than cores.
ONE_MORE := $$($(BIN)/python -c 'import os; print(os.cpu_count() + 1)')

test: $(PEERS)
	@$(BIN)/python -m pytest -m "not slow" $(SHARED) --numprocesses $(ONE_MORE) --dist loadfile --no-loadscope-reorder

slow: $(PEERS)
	@$(BIN)/python -m pytest -m "slow or ballesta" $(SHARED) --numprocesses auto --dist load --maxschedchunk 1 tests designs

lint: $(READY)
	@$(MAKE) --no-print-directory --jobs 4 --output-sync=target style types windows_types imports

style types windows_types imports: $(READY)

style:
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .

types:
	@$(BIN)/mypy

windows_types:
	@$(BIN)/mypy --platform win32 --cache-dir .mypy_cache/win32

imports:
	@$(BIN)/lint-imports

# A link that leads nowhere, a page outside of the navigation or one that loads from the network ends it.
docs: $(READY)
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

wheels: $(READY)
	@$(BIN)/python tools/wheels.py

# At most an hour on 4 cores; ends with 1 where a mutant crashes, hangs, warns or takes too much.
fuzz: $(PEERS)
	@$(BIN)/python -m bench.fuzz

bench: $(PEERS)
	@$(BIN)/python bench/run.py

# Hours of solids, resumed where they stopped; bars, verdicts, costs and docs/trade.md after them.
trade: $(PEERS)
	@$(BIN)/python -m bench.rung_truth
	@$(BIN)/python -m bench.rung_bands
	@$(BIN)/python -m bench.rung_verdicts
	@$(BIN)/python -m bench.auto_cost
	@$(BIN)/python -m bench.contact_truth
	@$(BIN)/python -m bench.trade_page

documents: $(READY)
	@$(BIN)/python tools/compare_documents.py
	@$(BIN)/python tools/hammer_leaf.py

screens: $(PEERS)
	@$(BIN)/python tools/screens.py

clean:
	rm -rf $(VENV) out build *.egg-info .mypy_cache .ruff_cache .pytest_cache
