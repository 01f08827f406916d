# rallygap: `make help` lists what there is.
SHELL := /bin/bash
PYTHON ?= python3.11
# A further index to take torch from. On Linux, pip's default brings several gigabytes of CUDA
# libraries, so without a GPU of NVIDIA it is the one with CPU builds. Where it cannot be reached,
# pip takes what other indices have, after ten seconds of retries a package; so it is asked for torch
# alone. Empty: no further index.
TORCH_INDEX ?= $(if $(filter Linux,$(shell uname)),$(if $(shell command -v nvidia-smi),,https://download.pytorch.org/whl/cpu))
# The folder with the measured sets (spindoe, tt3d, ...), for experiments and the tests marked `real`.
DATA ?= $(RALLYGAP_DATA)

export PATH := $(CURDIR)/.venv/bin:$(PATH)
export RALLYGAP_DATA := $(DATA)
export MLFLOW_DISABLE_TELEMETRY := true
export DO_NOT_TRACK := true

# Modules are compiled when they are first imported, since most of what is installed never is.
export PYTHONDONTWRITEBYTECODE :=
PIP := .venv/bin/python -m pip install --no-compile --quiet --disable-pip-version-check --constraint constraints.txt

.DEFAULT_GOAL := help
.PHONY: help reproduce experiments test test-naming test-all lint audit pictures docs ui

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  \1\t/' | expand -t 18

WITH_TORCH_INDEX = $(if $(TORCH_INDEX),--extra-index-url $(TORCH_INDEX))

# The file ready is written last. An environment that make began and did not finish is created
# again; one that it did not create is used as it is, and never cleared.
.venv/ready: pyproject.toml constraints.txt
	@if test ! -e .venv || test -e .venv/by-make -a ! -e $@; then \
	  rm -rf .venv && mkdir .venv && touch .venv/by-make && $(PYTHON) -m venv .venv; \
	elif test ! -e .venv/by-make; then \
	  echo "make: the environment .venv is there already; what is missing is installed into it"; \
	fi
	@rm -f $@
	@.venv/bin/python -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || \
	  { echo "make: .venv is not of Python 3.11, which the pipeline needs; move it away" >&2; exit 1; }
	$(PIP) pip
	$(PIP) --no-deps $(WITH_TORCH_INDEX) torch
	$(PIP) --build-constraint constraints.txt --editable '.[pipeline,dev,docs]'
	@touch $@

reproduce: .venv/ready ## run the whole pipeline on simulated data
	@rallygap check
	@dvc repro

experiments: .venv/ready ## hours: what is out of date in experiments/dvc.yaml, and not frozen; it resumes
	@dvc repro experiments/dvc.yaml

test: .venv/ready ## the quick tests, in parallel on all cores
	@pytest --numprocesses logical --dist loadfile

test-naming: .venv/ready ## minutes: the slow tests of naming causes
	@pytest -m slow --numprocesses logical --dist loadfile tests/models/gap

test-all: .venv/ready ## all tests, the slow ones included
	@pytest -m ''

lint: .venv/ready ## style, types, import contracts
	ruff check .
	ruff format --check .
	mypy
	lint-imports

constraints: .venv/ready ## write constraints.txt with the newest versions of all packages; test them next
	@.venv/bin/python -m pip install --dry-run --ignore-installed --quiet --report .venv/report.json \
	  $(WITH_TORCH_INDEX) pip hatchling editables '.[pipeline,dev,docs]'
	@.venv/bin/python .ci/constraints.py .venv/report.json > .venv/constraints.txt
	@mv .venv/constraints.txt constraints.txt

audit: .venv/ready ## check the pinned packages for known vulnerabilities; needs pipx and the network
	pipx run pip-audit --strict --requirement constraints.txt --no-deps --disable-pip

pictures: .venv/ready ## take the screenshots of MLflow for docs/daily.md; needs Chromium
	@pytest -m slow tests/pipeline/test_comparing_pages.py --pictures docs/images

docs: .venv/ready ## write the tables of the pages and build the site in docs/_build; a warning is an error
	@python -m rallygap.pipeline.documentation
	@sphinx-build --fail-on-warning --keep-going --quiet --builder html docs docs/_build/html
	@echo docs/_build/html/index.html

ui: .venv/ready ## serve the MLflow pages of this repository's runs on 127.0.0.1
	@rallygap ui
