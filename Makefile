# Two commands matter: `make demo` and `make test`. `make help` lists the rest.
PYTHON ?= python3
.DEFAULT_GOAL := help
.PHONY: help setup build

help: ## list the targets
	@sed -n 's/^\([a-z]*\):.*## /\1\t/p' Makefile

setup: ## make .venv with ROS 2 Jazzy (nothing to do where ROS is sourced)
	@test -x .venv/bin/colcon || { $(PYTHON) -m venv .venv && .venv/bin/pip install -r tools/requirements.in; }
	@.venv/bin/python tools/make_underlay.py

build: setup ## colcon build of all packages
	@bash -c '. .venv/setup.bash && colcon build --symlink-install'
