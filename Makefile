# SPDX-License-Identifier: GPL-3.0-or-later
# Each command sets up what it needs: apt where it is root (otherwise it prints the line to run), pip into build/venv.

export CCACHE_DIR ?= $(CURDIR)/build/ccache

.PHONY: help demo pictures test test-all attack bench bench-test bench-peers bench-report bench-quality bench-limbs bench-followers compare performance wheel api zip zips lint format asan tsan clang clean

help:
	@echo "make demo    poses and bakes the sample creature in a real Blender; pictures in build/demo"
	@echo "make pictures  takes the pictures of the README and the user guide in windows of Blender; docs/images"
	@echo "make test    native, Python, headless Blender and window tests; BLENDERS=\"path ...\" adds more Blenders"
	@echo "make attack  bad meshes up to 512,000 vertices, random calls and random acts for 20 minutes each; OPTIONS=SEED"
	@echo "make test-all   the same in every bpy of PyPI that is supported, not only in the newest"
	@echo "make bench   times of bind, set_constraints, iteration and of a frame in Blender; build/bench/*.json"
	@echo "make bench-peers    ours beside libigl, Open3D and CGAL       make bench-report   a student report's tables"
	@echo "make bench-quality  how poses look at three densities, plain beside rotation nodes; build/bench/quality.json"
	@echo "make bench-limbs    twisted and bent limbs, a surface beside a solid; build/bench/limbs.json"
	@echo "make bench-followers  what is worn goes along, beside Blender's Surface Deform; build/bench/followers.json"
	@echo "make compare        all models, ours and other libraries', on the same tasks; build/bench/compare.json"
	@echo "             all take OPTIONS=..., and meshes from ARAP_BENCH_MESHES: OFF files and folders, with colons between"
	@echo "make bench-test     tests of what measures          make performance    writes what was measured into docs"
	@echo "make wheel   wheels of arap-native for the Pythons found; build/dist/wheels"
	@echo "make api     the reference of the Python module, a web page: build/api/arap_native.html"
	@echo "make zip     the add-on for this machine; build/dist"
	@echo "make zips    a release: zips and wheels for Windows, Linux and macOS; build/dist/release (docs/release.md)"
	@echo "make lint    clang-format, clang-tidy, ruff, mypy          make format   formats everything"
	@echo "make asan    native tests under the address and undefined-behaviour sanitizers"
	@echo "make tsan    native tests under the thread sanitizer       make clang    native tests, built by Clang"

demo:
	@.ci/demo

pictures:
	@.ci/pictures

test:
	@command -v python3 >/dev/null || .ci/setup native
	@.ci/test

test-all:
	@.ci/test --all

attack:
	@.ci/attack $(OPTIONS)

bench:
	@.ci/bench $(OPTIONS)

bench-peers bench-report bench-quality bench-limbs bench-followers:
	@.ci/bench-run $(@:bench-%=%) $(OPTIONS)

compare:
	@.ci/bench-run compare $(OPTIONS)

bench-test:
	@.ci/bench-test

performance:
	@.ci/performance

wheel:
	@.ci/setup native
	@.ci/wheels build/dist/wheels

api:
	@.ci/api

zip:
	@.ci/setup native
	@.ci/zip

zips:
	@.ci/zips

lint:
	@.ci/lint

format:
	@.ci/lint --fix

asan tsan clang:
	@.ci/native $@

clean:
	rm -rf build/native build/dist build/test build/demo build/bench build/lint build/validate build/wheels build/api
