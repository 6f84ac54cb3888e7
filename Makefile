# One word each, the same here and in continuous integration. `make` alone lists them.
#
# Needs Python 3.11 or newer and nothing else: every command makes what it
# needs in .venv first, from the locked and hashed packages, and again only when
# a lock changes. Another interpreter: make run BASE_PYTHON=/path/to/python

SHELL := /bin/sh
VENV := .venv
PYTHON := $(VENV)/bin/python
PIP := $(PYTHON) -m pip --disable-pip-version-check
UV ?= uv
PORT ?=
ARGS ?=

.DEFAULT_GOAL := help
.PHONY: help run test lint format bench bench-jobs bench-peers bench-surface figures openapi lock clean

help: ## list the commands
	@sed -n 's/^\([a-z-]*\):.*## /  make \1	/p' Makefile | expand -t 20

run: $(VENV)/.run $(VENV)/.kernels ## serve on port 8000 (make run PORT=8123; data in TAPELINE_DATA_DIR)
	@$(if $(PORT),TAPELINE_PORT=$(PORT)) exec $(PYTHON) -m service

# The geometry's tests and the others take two cores side by side; what the others say comes last.
test: lint $(VENV)/.kernels ## check style and types, then run all tests
	@$(PYTHON) -m pytest --ignore=tests/core -o cache_dir=$(VENV)/.pytest_others >$(VENV)/.others.log 2>&1 & others=$$!; \
	trap 'kill $$others' INT TERM; failed=0; \
	$(PYTHON) -m pytest tests/core || failed=1; \
	wait $$others || failed=1; cat $(VENV)/.others.log; exit $$failed

lint: $(VENV)/.test ## check style and types
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .
	$(PYTHON) -m mypy

format: $(VENV)/.test ## put the code in the style that `make lint` checks
	$(PYTHON) -m ruff check --fix .
	$(PYTHON) -m ruff format .

bench: $(VENV)/.test $(VENV)/.kernels ## measure accuracy and time (minutes)
	$(PYTHON) -m benchmarks

bench-peers: $(VENV)/.test $(VENV)/.kernels ## measure beside other programs, installed apart (make bench-peers ARGS=--quick)
	$(PYTHON) -m benchmarks.peers $(ARGS)

bench-jobs: $(VENV)/.test $(VENV)/.kernels ## measure jobs under kills and load (make bench-jobs ARGS=--quick)
	$(PYTHON) -m benchmarks.jobs $(ARGS)

bench-surface: $(VENV)/.test $(VENV)/.kernels ## measure surfaces beside Open3D, installed apart (make bench-surface ARGS=--quick)
	$(PYTHON) -m benchmarks.surface $(ARGS)

figures: $(VENV)/.test $(VENV)/.kernels ## redraw the paper's figures from our own results
	$(PYTHON) -m benchmarks.figures

openapi: $(VENV)/.run ## write the OpenAPI document
	$(PYTHON) -m service.openapi openapi/openapi.json

# setuptools is locked with the rest: it builds the project itself, without going to the index again
lock: ## renew the locks (needs uv)
	printf 'setuptools>=77\n' | $(UV) pip compile pyproject.toml - --universal --generate-hashes --no-header --quiet \
		--upgrade --output-file requirements.lock
	printf 'setuptools>=77\n' | $(UV) pip compile pyproject.toml - --extra test --constraint requirements.lock \
		--universal --generate-hashes --no-header --quiet --upgrade --output-file requirements-test.lock

clean: ## remove everything that can be made again
	rm -rf $(VENV) build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# --- the environment ------------------------------------------------------------------------------

$(VENV)/.run: requirements.lock pyproject.toml | $(VENV)/.made
	$(call install,requirements.lock)

$(VENV)/.test: requirements-test.lock pyproject.toml | $(VENV)/.made
	$(call install,requirements-test.lock)

define install
@echo "Installing what $(1) lists into $(VENV) (a minute or two, the first time)"
@$(PIP) install --quiet --require-hashes --requirement $(1)
@$(PIP) install --quiet --no-index --no-build-isolation --no-deps --editable .
@touch $@
endef

# A cached kernel is not compiled anew when a kernel that it calls in another module changes:
# after any change in core all of them are.
$(VENV)/.kernels: $(shell find core -name '*.py') | $(VENV)/.made
	@find core -name __pycache__ -type d -prune -exec rm -rf {} +
	@touch $@

$(VENV)/.made:
	@$(find_python); \
	if ! $(PYTHON) -c 'import pip' 2>/dev/null; then \
		rm -rf $(VENV); \
		echo "Making $(VENV) with $$("$$python" --version)"; \
		"$$python" -m venv $(VENV); \
	fi
	@touch $@

# The newest Python that will do and can make environments; else say what to install.
define find_python
set -e; python=; bare=; \
for name in $(BASE_PYTHON) python3.14 python3.13 python3.12 python3.11 python3; do \
	if "$$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
		if "$$name" -c 'import ensurepip, venv' 2>/dev/null; then python="$$name"; break; fi; \
		bare="$${bare:-$$name}"; \
	fi; \
done; \
if [ -z "$$python" ] && [ -n "$$bare" ]; then \
	echo "$$bare cannot make environments: its venv module is missing." >&2; \
	echo "  Debian, Ubuntu:  sudo apt install $$("$$bare" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')" >&2; \
	exit 1; \
elif [ -z "$$python" ]; then \
	echo "Python 3.11 or newer is needed, and none was found." >&2; \
	echo "  Debian 12, Ubuntu 24.04 or newer:  sudo apt install python3 python3-venv" >&2; \
	echo "  macOS:                             brew install python" >&2; \
	echo "  elsewhere installed:               make run BASE_PYTHON=/path/to/python" >&2; \
	exit 1; \
fi
endef
