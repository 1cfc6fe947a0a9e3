# Everything runs from two commands: `make demo` and `make test`. They create .venv on first use.
PYTHON ?= python3
BIN := .venv/bin
# One core each: on matrices as small as ours, threads of BLAS that wait for one another cost much on a busy machine.
export OPENBLAS_NUM_THREADS := 1
# Bytecode is kept: each of the hundred processes that the tests start would compile our sources anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test test-all lint docs bench table1 tuning policy coverage trace-table missions live-missions bets-level several vehicles trouble \
	fleet six-axes feedforward thrust-faults sensor-faults soak hold recording pictures tutorials clean

demo: .venv/ready  ## the main job, end to end, in about two minutes
	$(BIN)/incsvr demo

test: .venv/ready lint  ## ruff, mypy and the quick tests: before every commit, in three minutes
	$(BIN)/pytest -n 2 --dist worksteal -m "not slow"

test-all: .venv/ready lint  ## the slow tests, too: what must hold before main moves
	$(BIN)/pytest -n 2 --dist worksteal

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: .venv/ready  ## the site, in out/site/html; a broken link ends it
	$(BIN)/python docs/site.py

# The long studies: each keeps its last results, with command and date, in benchmarks/results/.
table1: .venv/ready
	$(BIN)/incsvr table1 --seeds 20 --first-seed 720000 --json benchmarks/results/table1.json > benchmarks/results/table1.txt
	cat benchmarks/results/table1.txt

tuning: .venv/ready  ## which point the search of Section IV-B chooses
	$(BIN)/python -m benchmarks.paper.tuning --seeds 20 --first-seed 730000

policy: .venv/ready
	$(BIN)/python -m benchmarks.learner.policy

coverage: .venv/ready  ## how often the bands of 95 % hold what they should
	$(BIN)/python -m benchmarks.learner.coverage

bench: .venv/ready
	$(BIN)/incsvr bench --json benchmarks/results/bench.json > benchmarks/results/bench.txt
	cat benchmarks/results/bench.txt

trace-table: .venv/ready  ## both simulators, a torque that is the command and one that is measured
	$(BIN)/python -m benchmarks.tracer.trace_table
	$(BIN)/python -m benchmarks.tracer.trace_table --noise measured
	$(BIN)/python -m benchmarks.tracer.second_table

missions: .venv/ready  ## what vehicles do all day: the curve that is served, and what is named
	$(BIN)/python -m benchmarks.tracer.missions

live-missions: .venv/ready  ## an effect that comes on in an hour's mission, quiet hours, and the demo's third act
	$(BIN)/python -m benchmarks.tracer.live_missions

bets-level: .venv/ready  ## how often bets on effects that are not there are won over quiet hours
	$(BIN)/python -m benchmarks.tracer.bets_level

several: .venv/ready  ## damping of several velocities beside least squares with cross terms and a Gaussian process
	$(BIN)/python -m benchmarks.learner.several

vehicles: .venv/ready  ## every axis of every measured vehicle, beside eight other methods
	$(BIN)/python -m benchmarks.vehicles
	$(BIN)/python -m benchmarks.vehicles.whole_vehicle
	$(BIN)/python -m benchmarks.vehicles.changes
	$(BIN)/python -m benchmarks.vehicles.fleet

trouble: .venv/ready  ## faults and effects of real vehicles and logs, drawn anew
	$(BIN)/python -m benchmarks.tracer.trouble

fleet: .venv/ready  ## ten learner processes, one router, a shore station
	$(BIN)/python -m benchmarks.service.fleet

six-axes: .venv/ready  ## all axes of a vehicle file in one process at 100 Hz
	$(BIN)/python -m benchmarks.service.six_axes

feedforward: .venv/ready  ## yaw control with and without the torque that the learner gives for the plan
	$(BIN)/python -m benchmarks.learner.feedforward

thrust-faults: .venv/ready  ## how soon lost thrust is told in missions and measured logs, and how often falsely
	$(BIN)/python -m benchmarks.learner.thrust_faults

sensor-faults: .venv/ready  ## when a failing sensor is named, and what is served meanwhile
	$(BIN)/python -m benchmarks.learner.sensor_faults

soak: .venv/ready  ## half an hour: a day at sea
	$(BIN)/python -m benchmarks.service.soak

hold: .venv/ready  ## an hour: kills, damaged states, restarts, junk, floods, clients that stop, a day of data
	$(BIN)/python -m benchmarks.service.hold

recording: .venv/ready
	$(BIN)/python -m benchmarks.service.recording

pictures: .venv/ready  ## every picture of README and docs, from the last demo's recording and a browser
	test -f out/leng.rrd || $(BIN)/incsvr demo
	$(BIN)/python -m viewer.pictures out/leng.rrd docs/pictures
	$(BIN)/python -m viewer.page.picture docs/pictures/page.png

tutorials: .venv/ready  ## writes what the tutorials' commands print now into their pages
	$(BIN)/python -m tests.docs.regenerate

.venv/ready: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed: make PYTHON=python3.11 …")'
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[viewer,report,bench,docs,dev]'
	touch $@

clean:
	rm -rf .venv build dist out *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
