# rallygap: `make help` lists what there is.
SHELL := /bin/bash
PYTHON ?= python3.11
# An index with CPU builds of torch, for example https://download.pytorch.org/whl/cpu. Empty: pip's
# own default, which on Linux brings several gigabytes of CUDA libraries.
TORCH_INDEX ?=
# The folder with the measured sets (spindoe, tt3d, ...), for `make real` and the tests marked `real`.
DATA ?= $(RALLYGAP_DATA)

export PATH := $(CURDIR)/.venv/bin:$(PATH)
export RALLYGAP_DATA := $(DATA)
export MLFLOW_DISABLE_TELEMETRY := true
export DO_NOT_TRACK := true

PIP := .venv/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

.DEFAULT_GOAL := help
.PHONY: help reproduce real exam test test-all faults lint audit pictures bench ui

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  \1\t/' | expand -t 18

# Written last: an environment without it was left half-made, and is made anew.
.venv/ready: pyproject.toml constraints.txt
	@test -e $@ || $(PYTHON) -m venv --clear .venv
	@rm -f $@
	$(PIP) pip
	$(PIP) $(if $(TORCH_INDEX),--extra-index-url $(TORCH_INDEX)) torch
	$(PIP) --build-constraint constraints.txt --editable '.[pipeline,dev,docs]'
	@touch $@

reproduce: .venv/ready ## run the whole pipeline on the embedded data
	@rallygap check
	@rallygap mend
	@dvc repro

real: .venv/ready ## run the pipeline on the measured sets in DATA and keep the results in reports/real
	@rallygap real

exam: .venv/ready ## hours: sit the whole blind exam and keep its sheets; goes on where it was killed
	@python -m pipeline.exam.run
	@dvc repro hidden_effects

test: .venv/ready ## the quick tests, a file after another on every core
	@pytest --numprocesses logical --dist loadfile

test-all: .venv/ready ## every test but the faults, the slow ones too
	@pytest -m 'not faults'

faults: .venv/ready ## an hour and a half, as root: damage files, kill every stage, fill disks; write reports/reliability
	@pytest -m faults -v --tables

lint: .venv/ready ## style, types, import arrows
	ruff check .
	ruff format --check .
	mypy
	lint-imports

audit: .venv/ready ## look up every pinned package among known vulnerabilities; needs pipx and the network
	pipx run pip-audit --strict --requirement constraints.txt --no-deps --disable-pip

pictures: .venv/ready ## photograph MLflow's pages for docs/compare.md; needs Chromium
	@pytest -m slow tests/pipeline/test_comparing_pages.py --pictures docs/images

bench: .venv/ready ## half an hour: the ball simulator and the learning beside their peers, and what predictors cost
	@python -m benchmarks.ball_simulator
	@python -m benchmarks.policy_training
	@test ! -d artifacts/train_predictor || rallygap costs
	@python -m benchmarks.learning

ui: .venv/ready ## the MLflow pages of this repository's runs, on this machine only
	@rallygap ui
