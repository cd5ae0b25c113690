# farm.mk - one bake in SHARDS processes:   make -j8 -f farm.mk OUT=dragon.csm SCENE=dragon.glb SHARDS=8
# A bake that was stopped goes on: shards that are there are not baked again.   make -f farm.mk ... clean
BAKE      ?= build/bake
TECHNIQUE ?= csm
SHARDS    ?= 8
SETTINGS  ?=
numbers := $(shell seq $(SHARDS))
# A bake into a model (ao, light) is joined with that model.
model   := $(filter-out $(if $(filter csm shadowfield,$(TECHNIQUE)),%),$(SCENE))
parts   := $(foreach i,$(numbers),$(OUT).$(i)of$(SHARDS))

$(OUT): $(parts)
	$(BAKE) merge -o $@ $(model) $(parts)
$(OUT).%of$(SHARDS): $(filter-out builtin:%,$(SCENE))
	$(BAKE) $(TECHNIQUE) $(SCENE) -o $@ --shard $*/$(SHARDS) --threads 1 $(SETTINGS)
clean:
	rm -f $(parts)
.PHONY: clean
