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

# Modules are compiled when they are first imported, since most of what is installed never is.
export PYTHONDONTWRITEBYTECODE :=
PIP := .venv/bin/python -m pip install --no-compile --quiet --disable-pip-version-check --constraint constraints.txt

.DEFAULT_GOAL := help
.PHONY: help reproduce real everything exam learning-curves paper-network arenas spread-policies swap-study simulators real-scenes test test-naming test-all faults lint audit pictures bench docs ui

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  \1\t/' | expand -t 18

# Runs what needs the predictors of `make reproduce`, or says that it is left out.
if_trained = if test -d artifacts/train_predictor; then $(1); else echo "left out, run make reproduce first: $(1)"; fi

# Written last: an environment without this file is incomplete and is created again.
.venv/ready: pyproject.toml constraints.txt
	@test -e $@ || $(PYTHON) -m venv --clear .venv
	@rm -f $@
	$(PIP) pip
	$(PIP) $(if $(TORCH_INDEX),--extra-index-url $(TORCH_INDEX)) torch
	$(PIP) --build-constraint constraints.txt --editable '.[pipeline,dev,docs]'
	@touch $@

reproduce: .venv/ready ## run the whole pipeline on simulated data
	@rallygap check
	@dvc repro

real: .venv/ready ## run the pipeline on the measured sets in DATA and keep the results in reports/real
	@rallygap real
	@$(call if_trained,python -m rallygap.pipeline.real_forecasts.run)

everything: .venv/ready ## a day: all results that the repository keeps, by this commit; it resumes
	@rallygap everything

exam: .venv/ready ## hours: run the whole blind exam and write its records; stop it with Ctrl-C, it resumes
	@python -m rallygap.pipeline.exam.full_run
	@dvc repro hidden_effects

learning-curves: .venv/ready ## an hour and a half: predictors by the number of training recordings; after `make reproduce`
	@python -m rallygap.pipeline.learning_curves.run

paper-network: .venv/ready ## ten minutes on a GPU: the transformer in the paper's size; it resumes
	@python -m rallygap.pipeline.paper_network.run

arenas: .venv/ready ## two and a half hours: the gap workflow and networks on twenty fresh arenas; it resumes
	@python -m rallygap.pipeline.arenas.run

spread-policies: .venv/ready ## a quarter of an hour: policies that observe how sure forecasts are; after `make reproduce`
	@python -m rallygap.pipeline.spread_policies.run

swap-study: .venv/ready ## hours: when swapping the predictor helps; after `make reproduce`; it resumes
	@python -m rallygap.pipeline.swap_study.run

simulators: .venv/ready ## minutes: scenes of MuJoCo and PyBullet with something wrong, diagnosed and amended
	@python -m rallygap.pipeline.simulator_scenes.run

real-scenes: .venv/ready ## minutes: published scenes of MuJoCo on the measured sets in DATA, before and after
	@python -m rallygap.pipeline.simulator_scenes.real

test: .venv/ready ## the quick tests, in parallel on all cores
	@pytest --numprocesses logical --dist loadfile

test-naming: .venv/ready ## minutes: the slow tests of naming causes
	@pytest -m slow --numprocesses logical --dist loadfile tests/models/gap

test-all: .venv/ready ## all tests but the fault injection, the slow ones included
	@pytest -m 'not faults'

faults: .venv/ready ## an hour, as root: damage files, kill every stage, fill disks; write reports/reliability
	@pytest -m faults -v --tables

lint: .venv/ready ## style, types, import contracts
	ruff check .
	ruff format --check .
	mypy
	lint-imports

audit: .venv/ready ## check the pinned packages for known vulnerabilities; needs pipx and the network
	pipx run pip-audit --strict --requirement constraints.txt --no-deps --disable-pip

pictures: .venv/ready ## take the screenshots of MLflow for docs/daily.md; needs Chromium
	@pytest -m slow tests/pipeline/test_comparing_pages.py --pictures docs/images

bench: .venv/ready ## one to two hours: compare speed with other programs; write reports/costs
	@python -m benchmarks.ball_simulator
	@python -m benchmarks.policy_training
	@$(call if_trained,rallygap costs)
	@$(call if_trained,python -m benchmarks.live)
	@python -m benchmarks.drift
	@python -m benchmarks.learning

docs: .venv/ready ## write the tables of the pages and build the site in docs/_build; a warning is an error
	@python -m rallygap.pipeline.documentation
	@sphinx-build --fail-on-warning --keep-going --quiet --builder html docs docs/_build/html
	@echo docs/_build/html/index.html

ui: .venv/ready ## serve the MLflow pages of this repository's runs on 127.0.0.1
	@rallygap ui
