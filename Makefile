# Two commands matter: `make demo` and `make test`. `make help` lists the rest.
PYTHON ?= python3
SURFACE ?= dry
CAR ?= car
LAW ?= curve
OUT ?= out
EFFORT ?= 1
PARTS ?= slope abs identification real_car slip smart_tyre measured fuzz bags live
CAMPAIGNS := faults fuzz live soak
options_slope ?= --seeds 100
options_abs ?= --seeds 20
options_identification ?= --seeds 200
options_real_car ?= --studies random --seeds 12
options_slip ?= --seeds 2 --cars 4
options_smart_tyre ?= --seeds 10
options_fuzz ?= --messages 100000
options_live ?= --seconds 10
options_bags ?= --minutes 1 --processes 1
run := tools/run.bash

.DEFAULT_GOAL := help
.PHONY: help setup build test lint demo bench report mdf parquet browser fleet bags docs clean

help: ## list the targets
	@sed -n 's/^\([a-z]*\):[^#]*## \(.*\)/  make \1	\2/p' Makefile

setup: ## make .venv with ROS 2 Jazzy (where ROS is sourced: with the few extra tools)
	@tools/run.bash --setup $(PYTHON)

build: setup ## colcon build of all packages; afterwards: source install/setup.bash
	@$(run) python tools/build.py

lint: setup ## ruff and mypy
	@$(run) ruff check
	@$(run) ruff format --check
	@$(run) mypy

test: build lint ## everything that must hold: lint, format, types, tests
	@$(run) pytest -n auto --dist loadfile --max-worker-restart 0

demo: build ## a car braking in the loop over DDS: SURFACE=dry|wet|cobblestone|snow|split|"dry snow"|"1.28,24,0.52" CAR=car|corner LAW=curve|slope_sign, or BAG=path [MAP=name|file] to replay; VEHICLE=name|file
	@$(run) python -m friction_bringup demo $(if $(BAG),--bag "$(BAG)",--surface "$(SURFACE)" --car $(CAR)) --law $(LAW) \
		$(if $(MAP),--map "$(MAP)") $(if $(VEHICLE),--vehicle "$(VEHICLE)") --out "$(OUT)/demo"

bench: build ## every table of the evaluation as text and JSON (20 minutes), or PARTS="slope abs"
	@failed=0; $(foreach part,$(PARTS),$(run) python -m $(if $(filter $(part),$(CAMPAIGNS)),campaigns,benchmarks) $(part) \
		$(options_$(part)) --json "$(OUT)/bench/$(part).json" || failed=1;) exit $$failed

report: build ## every table and figure of the chapter as one page; EFFORT=0.1 for a quick one
	@$(run) python -m book --out build/report --effort $(EFFORT)

mdf: build ## install asammdf (209 MB), which reads MDF logs, and test it
	@$(run) python3 -m pip install --quiet asammdf
	@$(run) pytest src/friction_bags/test/test_friction_bags_mdf.py

parquet: build ## install pyarrow (170 MB), which reads Parquet tables, and test it
	@$(run) python3 -m pip install --quiet pyarrow
	@$(run) pytest src/friction_bags/test/test_friction_bags_parquet.py

browser: build ## install playwright (48 MB) and test the page of a drive with the Chromium on the path (apt install chromium)
	@command -v chromium chromium-browser google-chrome >/dev/null || { echo "no Chromium on the path: apt install chromium" >&2; exit 1; }
	@$(run) python3 -m pip install --quiet playwright
	@$(run) pytest src/friction_report/test/test_friction_report_browser.py

fleet: build ## install what friction_fleet needs, with a local object store (400 MB), and test it
	@$(run) python3 -m pip install --quiet -r tools/requirements-fleet.txt
	@$(run) pytest src/friction_fleet/test benchmarks/test/test_benchmarks_engine.py

bags: build ## make the recorded experiments of bags/ again, from fixed seeds
	@$(run) python -m friction_bags library

docs: build ## write parameter files, parameter tables and pictures, generated from the code
	@$(run) python -m tools.docs
	@$(run) python tools/draw_layers.py
	@$(run) python -m tools.draw_slip_stop
	@$(run) python -m tools.draw_grip_drive

clean: ## remove the files that the targets above made
	rm -rf .venv build install log out .mypy_cache .ruff_cache .pytest_cache .hypothesis
