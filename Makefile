# Shortcuts: each target installs missing packages, then calls CMake, CTest or a script.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

# Parallel compilations: one for each 2 GB of free memory, at least one, at most one a core.
JOBS ?= $(shell awk -v cores=$$(nproc) '/MemAvailable/ { fit = int($$2 / 2e6) } \
          END { print fit < 1 ? 1 : fit < cores ? fit : cores }' /proc/meminfo)
# Tests of programs wait for them half of the time: on two cores four tests at a time take 454 s, three 538 s.
TEST_JOBS = $(shell echo $$(( $(JOBS) + 2 )))
STEPS ?= 10000
SUITE ?= bookworm
PREFIX ?= /usr/local
# Debian's Python has the installed packages; another Python may come first on PATH.
PYTHON := /usr/bin/python3

# $(call cmake_build,PRESET,TARGETS)
cmake_build = cmake --build --preset $(1) --target $(2) -j $(JOBS)

# $(call configure,PRESET,OPTIONS). The output is shown only when it fails.
configure = mkdir -p build/$(1) && cmake --preset $(1) $(2) > build/$(1)/configure.log 2>&1 \
            || { cat build/$(1)/configure.log; rm -f build/$(1)/build.ninja; exit 1; }

# A build folder knows the path at which it was configured. In a tree that was moved or copied it is configured again.
moved = [ "$$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' $(1))" -ef . ] || rm -rf $(1) $(dir $(1))build.ninja $(dir $(1))CMakeFiles
$(foreach cache,$(wildcard build/*/CMakeCache.txt),$(shell $(call moved,$(cache))))

.PHONY: help packages packages-build packages-run packages-fuzz build build-run build-programs build-python with-tests \
        build-tests build-bench run test test-long fuzz bench bench-peers bench-build image wheel dist docs sanitize format install bare clean

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-11s %s\n", $$1, $$2 }' Makefile

packages: packages-run ## install the Debian packages that building and testing need
	@docker/packages.sh test daemon

packages-build:
	@docker/packages.sh build

packages-run: packages-build
	@docker/packages.sh run

packages-fuzz:
	@docker/packages.sh fuzz

build/asan/build.ninja build/tsan/build.ninja: | packages
build/fuzz/build.ninja: | packages packages-fuzz

build/%/build.ninja: | packages-build
	@$(call configure,$*,$(options))

# `make run` installs no package of the tests.
build/release/build.ninja: options = -DSTIEFEL_TESTS=OFF

build: build/release/build.ninja ## compile library, server and clients into build/release
	@$(call cmake_build,release,all)

# The engine with its server, and the Python client with the command: not the C++ client.
build-run: packages-run build/release/build.ninja
	@$(call cmake_build,release,stiefel-server stiefel_python)

# What a container holds, and what tests it.
build-programs: build/release/build.ninja
	@$(call cmake_build,release,stiefel)

build-python: packages-run build/release/build.ninja
	@$(call cmake_build,release,stiefel_python)

with-tests: packages build/release/build.ninja
	@grep -qx STIEFEL_TESTS:BOOL=ON build/release/CMakeCache.txt || { $(call configure,release,-DSTIEFEL_TESTS=ON); }

build-tests: with-tests
	@$(call cmake_build,release,all stiefel_tests)

build-bench: with-tests
	@docker/packages.sh bench
	@$(call cmake_build,release,all stiefel_bench)

run: build-run ## simulate asteroid Toutatis, or SCENE=file.json STEPS=10000; writes build/run
	@export PYTHONPATH=build/release/python STIEFEL_SERVER=build/release/bin/stiefel-server; \
	if [ -n "$(SCENE)" ]; then \
	  mkdir -p build/run; \
	  build/release/bin/stiefel report "$(SCENE)" --to $(STEPS) --output build/run/report.html; \
	else \
	  $(PYTHON) client/examples/toutatis.py --output build/run; \
	fi

test: build-tests ## compile and run the tests
	@$(PYTHON) tests/run.py --preset release -j $(TEST_JOBS)

test-long: build-bench build-tests ## run all tests, those that take minutes included, and the fuzz targets
	@docker/packages.sh wheel image browser docs
	@$(PYTHON) tests/run.py --preset long -j $(JOBS)
	@$(MAKE) --no-print-directory fuzz

fuzz: build/fuzz/build.ninja ## run libFuzzer for a minute on each target, under the sanitizers
	@$(call cmake_build,fuzz,stiefel_fuzz)
	@ctest --preset fuzz

bench: build-bench ## measure speed, every figure beside a rival in the same run
	@$(PYTHON) tests/bench/run.py build/release

bench-peers: build-bench ## measure beside MuJoCo, heyoka, Drake, Basilisk and SciPy, fetched from PyPI into build/peers
	@docker/packages.sh peers
	@$(PYTHON) tests/bench/peers/environment.py build/peers
	@$(PYTHON) tests/bench/run.py build/release --peers

bench-build: ## measure the processor time of `make run` and `make test` from nothing, for BEFORE=commit and for this tree
	@[ -n "$(BEFORE)" ] || { echo "which commit to compare with: make bench-build BEFORE=commit" >&2; exit 2; }
	@$(PYTHON) tests/bench/compiling/build_time.py "$(BEFORE)"

sanitize: build/asan/build.ninja build/tsan/build.ninja ## compile and run the tests under the sanitizers
	@$(call cmake_build,asan,all stiefel_tests)
	@$(PYTHON) tests/run.py --preset asan -j $(JOBS)
	@$(call cmake_build,tsan,all stiefel_tests)
	@$(PYTHON) tests/run.py --preset tsan -j $(JOBS)

image: packages ## build the container image and test a running container
	@tests/docker/image.sh

wheel: build-programs ## make the Python wheels: one with server and command for this platform, one for every platform
	@docker/packages.sh wheel
	@$(PYTHON) client/python/wheel/make_wheels.py build/release build/wheel

dist: wheel ## make what a release needs in build/dist: wheels, sources, image, notes, checksums
	@$(PYTHON) docker/dist.py build/wheel build/dist

docs: packages-run build-programs ## build the site of the documentation into build/docs/html, tutorials run and pictures drawn
	@docker/packages.sh docs
	@$(PYTHON) -m sphinx -W --keep-going -q -b html -c docs/site -d build/docs/doctrees . build/docs/html
	@echo "wrote build/docs/html/index.html"

bare: ## run and test a fresh clone in a bare Debian 12, or SUITE=trixie for 13, as root
	@docker/packages.sh image
	@tests/docker/bare_debian.sh --suite $(SUITE)

format: ## format every source in place with clang-format
	@docker/packages.sh format
	@git ls-files '*.cc' '*.h' | xargs clang-format -i

install: build ## install library, server and command under PREFIX
	@cmake --install build/release --prefix "$(PREFIX)"

clean: ## remove build/
	@rm -rf build
