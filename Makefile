# Everything runs from two commands: `make demo` and `make test`. They create .venv on first use.
PYTHON ?= python3
BIN := .venv/bin
# One core each: on matrices as small as ours, threads of BLAS that wait for one another cost much on a busy machine.
export OPENBLAS_NUM_THREADS := 1
# Bytecode is kept: each of the hundred processes that the tests start would compile our sources anew.
unexport PYTHONDONTWRITEBYTECODE

STUDIES := paper speed sensors quiet thrust trace missions live vehicles whole_vehicle dives control hold
.PHONY: demo test test-all lint docs bench table1 $(STUDIES) pictures tutorials clean

demo: .venv/ready  ## the main job, end to end, in a quarter of an hour
	$(BIN)/incsvr demo

# A file's tests run in one process: what they share is made once.
test: .venv/ready  ## the quick tests: before every commit, as `make lint`
	$(BIN)/pytest -n 2 --dist loadfile -m "not slow"

test-all: .venv/ready lint  ## lint and every test: what must hold before main moves
	$(BIN)/pytest -n 2 --dist worksteal

lint: .venv/ready  ## ruff and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: .venv/ready  ## the site, in out/site/html; a broken link ends it
	$(BIN)/python docs/site.py

# The long studies: each keeps its last results, with command and date, in benchmarks/results/.
table1: .venv/ready
	$(BIN)/incsvr table1 --seeds 20 --first-seed 720000 --json benchmarks/results/table1.json > benchmarks/results/table1.txt
	cat benchmarks/results/table1.txt

bench: .venv/ready
	$(BIN)/incsvr bench --json benchmarks/results/bench.json > benchmarks/results/bench.txt
	cat benchmarks/results/bench.txt

$(STUDIES): .venv/ready  ## what a study measures is the first line of its file in benchmarks/
	$(BIN)/python -m benchmarks.$@

pictures: .venv/ready  ## every picture of README and docs, from the last demo's recording and a browser
	test -f out/leng.rrd || $(BIN)/incsvr demo
	$(BIN)/python -m tests.docs.pictures out/leng.rrd docs/pictures

tutorials: .venv/ready  ## writes what the tutorials' commands print now into their pages
	$(BIN)/python -m tests.docs.regenerate

.venv/ready: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed: make PYTHON=python3.11 …")'
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[viewer,report,bench,docs,dev]'
	touch $@

clean:
	rm -rf .venv build dist out *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
