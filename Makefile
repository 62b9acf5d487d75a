# The front door. Everything real is in CMake; this installs what is missing and says what to call.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

# Two gigabytes a compiler, and at least one of them.
JOBS ?= $(shell awk -v cores=$$(nproc) '/MemAvailable/ { fit = int($$2 / 2e6) } \
          END { print fit < 1 ? 1 : fit < cores ? fit : cores }' /proc/meminfo)
STEPS ?= 10000
PREFIX ?= /usr/local
# Debian's, whose packages are the ones installed; another may stand first on PATH.
PYTHON := /usr/bin/python3

# $(call cmake_build,PRESET,TARGETS)
cmake_build = $(PYTHON) docker/build.py $(1) $(JOBS) $(2)

.PHONY: help packages packages-fuzz build build-run build-programs build-python build-tests build-bench run test test-long \
        fuzz bench bench-peers bench-build image sanitize format install bare clean

help: ## what there is (this text)
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-11s %s\n", $$1, $$2 }' Makefile

packages: ## install the Debian packages that building and testing need
	@docker/packages.sh build test

packages-fuzz:
	@docker/packages.sh fuzz

build/fuzz/build.ninja: | packages-fuzz

# Configuring says much; it is shown only when it fails.
build/%/build.ninja: | packages
	@mkdir -p $(@D)
	@cmake --preset $* > $(@D)/configure.log 2>&1 || { cat $(@D)/configure.log; rm -f $@; exit 1; }

build: build/release/build.ninja ## compile library, server and clients into build/release
	@$(call cmake_build,release,all)

# The engine with its server, and the Python client: neither the command nor the C++ client.
build-run: build/release/build.ninja
	@$(call cmake_build,release,stiefel-server stiefel_python)

# What a container holds, and what tests it.
build-programs: build/release/build.ninja
	@$(call cmake_build,release,stiefel-server stiefel stiefel_python)

build-python: build/release/build.ninja
	@$(call cmake_build,release,stiefel_python)

build-tests: build/release/build.ninja
	@$(call cmake_build,release,all stiefel_tests)

build-bench: build/release/build.ninja
	@$(call cmake_build,release,all stiefel_bench)

run: build-run ## simulate asteroid Toutatis, or SCENE=file.json STEPS=10000; writes build/run
	@export PYTHONPATH=build/release/python STIEFEL_SERVER=build/release/bin/stiefel-server; \
	if [ -n "$(SCENE)" ]; then \
	  $(PYTHON) client/examples/run_scene.py "$(SCENE)" --steps $(STEPS) --output build/run; \
	else \
	  $(PYTHON) client/examples/toutatis.py --output build/run; \
	fi

test: build-tests ## compile and run the tests
	@ctest --preset release -j $(JOBS)

test-long: build-bench build-tests ## the tests that take minutes, too, and the fuzz targets
	@ctest --preset long -j $(JOBS)
	@$(MAKE) --no-print-directory fuzz

fuzz: build/fuzz/build.ninja ## a minute of libFuzzer on each target, under the sanitizers
	@$(call cmake_build,fuzz,stiefel_fuzz)
	@ctest --preset fuzz

bench: build-bench ## measure, every figure beside a rival in the same run
	@$(PYTHON) tests/bench/run.py build/release

bench-peers: build-bench ## and beside MuJoCo, heyoka, Drake, Basilisk and SciPy, fetched from PyPI into build/peers
	@docker/packages.sh peers
	@$(PYTHON) tests/bench/peers/environment.py build/peers
	@$(PYTHON) tests/bench/run.py build/release --peers

bench-build: ## processor time of `make run` and `make test` from nothing, of BEFORE=commit and of the tree as it stands
	@$(PYTHON) tests/bench/build_time.py "$(BEFORE)" .

sanitize: build/asan/build.ninja build/tsan/build.ninja ## the tests under the sanitizers
	@$(call cmake_build,asan,all stiefel_tests)
	@ctest --preset asan -j $(JOBS)
	@$(call cmake_build,tsan,all stiefel_tests)
	@ctest --preset tsan -j $(JOBS)

image: packages ## build the container, of the programs in build/release on Debian 12, and test it while it runs
	@tests/docker/image.sh

bare: ## run and test a clone in a bare Debian 12, as root
	@docker/packages.sh image
	@tests/docker/bare_debian.sh

format: ## clang-format every source in place
	@docker/packages.sh format
	@git ls-files '*.cc' '*.h' | xargs clang-format -i

install: build ## install library, server and command under PREFIX
	@cmake --install build/release --prefix "$(PREFIX)"

clean: ## remove build/
	@rm -rf build
