# Every target works from a bare checkout: what it needs is installed into .venv first, with plain pip.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ARGS ?=
TABLE2_MINUTES ?= 30
RECORDED_CAPTURES ?= 100

# One thread per process: the arrays are small, and two pools of threads on the same cores cost more than they bring.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

.DEFAULT_GOAL := help
.PHONY: help demo test test-fast check format bench bench-volume bench-sim bench-data bench-network table1 table-coverage table2 table2-terms table2-recorded volume-nbv volume-held-out loop-nbv shapes-nbv setup clean

help: ## List the targets
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## / {printf "  make %-15s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: $(VENV)/demo.stamp ## Run the worked example and write demo-report/
	$(BIN)/viewgain demo --out demo-report

test: $(VENV)/dev.stamp ## Run every test (under 20 minutes)
	$(BIN)/python -m pytest -n 2 $(ARGS)

test-fast: $(VENV)/dev.stamp ## Run the tests that are not slow (under 5 minutes)
	$(BIN)/python -m pytest -n 2 -m "not slow" $(ARGS)

check: $(VENV)/dev.stamp ## Lint, format, types and layers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --strict src
	$(BIN)/lint-imports

format: $(VENV)/dev.stamp ## Sort imports and format the code in place
	$(BIN)/ruff check --fix-only .
	$(BIN)/ruff format .

bench: $(VENV)/dev.stamp ## Run the benchmarks (ARGS="..." is passed on)
	$(BIN)/python -m benchmarks $(ARGS)

bench-volume: $(VENV)/dev.stamp ## Print every accuracy table of docs/accuracy.md; ARGS="--scenes 20" is the quick look
	$(BIN)/python -m benchmarks volume accuracy calibration fusion stacks not-a-box enclosing real $(ARGS)

bench-sim: $(VENV)/dev.stamp ## Time the simulator, with the whole synthetic set of the paper
	$(BIN)/python -m benchmarks simulation --captures 1000 $(ARGS)

bench-data: $(VENV)/dev.stamp ## Time labels and data sets beside their slow twins
	$(BIN)/python -m benchmarks data data-labels $(ARGS)

bench-network: $(VENV)/dev.stamp ## Time the networks on one thread, the textbook's EdgeConv beside ours
	$(BIN)/python -m benchmarks network $(ARGS)

table1: $(VENV)/dev.stamp ## Judge the shipped networks on fresh objects and write tables/table1.md (docs/results.md)
	$(BIN)/viewgain evaluate table1 --fresh 20 --workers 2 --out tables $(ARGS)

table-coverage: $(VENV)/dev.stamp ## The same over ten views: coverage beside random, farthest and greedy oracle, tables/coverage.md
	$(BIN)/viewgain evaluate coverage --fresh 10 --workers 2 --out tables $(ARGS)

# Trains a recipe (1) on a data set (2), in a run of its name or another (3), with options (4): one that finished is left as it is, one
# that was interrupted goes on, else it begins. run.json is there from the first step on, so only a stamp written last says that a run
# has finished.
define trained
run=runs/$(or $(3),$(1)); test -e $$run/finished || { \
	if test -e $$run/run.json; \
	then $(BIN)/viewgain train --resume $$run --data $(2) --minutes $(TABLE2_MINUTES); \
	else $(BIN)/viewgain train $(1) --data $(2) --out $$run --minutes $(TABLE2_MINUTES) $(4); \
	fi && touch $$run/finished; }
endef

table2: $(VENV)/dev.stamp ## Build the paper's boxes, train briefly, print its Table 2 (hours; TABLE2_MINUTES of training per network)
	$(BIN)/viewgain dataset build boxes_paper --out data/boxes --workers 2 --resume --errors lines_published
	$(call trained,volume_paper_short,data/boxes)
	$(BIN)/viewgain export runs/volume_paper_short --out runs/volume_paper_short.onnx
	$(BIN)/viewgain evaluate table2 --data data/boxes --models runs/volume_paper_short.onnx --out tables/table2 $(ARGS)
	$(call trained,volume_paper_tally,data/boxes)
	$(BIN)/viewgain export runs/volume_paper_tally --out runs/volume_paper_tally.onnx
	$(BIN)/viewgain evaluate table2 --data data/boxes --models runs/volume_paper_tally.onnx --target tally:4,3,2,2:0 --out tables/table2-tally $(ARGS)

table2-terms: $(VENV)/dev.stamp ## The same with each constraint of time of flight and without, on a tenth of the scans (half an hour)
	$(BIN)/viewgain dataset build boxes_paper_tenth --out data/tenth --workers 2 --resume --errors lines_published
	$(BIN)/viewgain evaluate labels --data data/tenth --out tables/table2-labels
	for terms in "" +incidence +border +incidence+border; do \
		target=histogram:lines_published:soft$$terms; \
		$(call trained,volume_paper_short,data/tenth,terms$$terms,--target $$target --iterations 1200) && \
		$(BIN)/viewgain export $$run --out $$run.onnx && \
		$(BIN)/viewgain evaluate table2 --data data/tenth --models $$run.onnx --target $$target --out tables/table2-terms$$terms $(ARGS) || exit; \
	done

# Each recording draws from a seed of its own, so that no two share their noise; boxes.toml comes last and says that all are there.
data/recordings-simulated/boxes.toml: | $(VENV)/dev.stamp
	@mkdir -p $(@D); rm -f $@.part; seed=0; \
	for camera in pico_zense xtion; do for box in "large 0.60 0.40 0.30" "medium 0.40 0.30 0.20" "small 0.30 0.22 0.26"; do \
		set -- $$box; seed=$$((seed + 1)); to=$(@D)/$$1_$$camera; \
		test -e $$to/truth.json || $(BIN)/viewgain simulate --dims $$2 $$3 $$4 --camera $$camera --rig recorded4 \
			--captures $(RECORDED_CAPTURES) --seed $$seed --by-station --formats png --workers 2 --out $$to || exit; \
		echo "$$1_$$camera = [$$2, $$3, $$4]" >> $@.part; \
	done; done; mv $@.part $@

table2-recorded: data/recordings-simulated/boxes.toml ## Simulate recordings as the paper's, train briefly, print their Table 2 (docs/recording.md)
	$(BIN)/viewgain dataset build boxes_recorded_paper --recordings $(<D) --out data/recorded --workers 2 --resume --errors lines_published
	$(call trained,volume_recorded_short,data/recorded)
	$(BIN)/viewgain export runs/volume_recorded_short --out runs/volume_recorded_short.onnx
	$(BIN)/viewgain evaluate table2 --data data/recorded --models runs/volume_recorded_short.onnx --folds 3 --leave 1 --recipe volume_recorded_short --out tables/table2-recorded $(ARGS)

# The networks that come with the package, alone and with the model, beside everything that needs none.
volume_policies = network:pose_scores-$(1)-camera combined:pose_scores-$(1)-camera combined_around:pose_scores-$(1)-camera \
	expected expected_around covariance farthest random constant oracle
# A decision of these takes ten seconds with a pico flexx, half a minute with an Xtion, fused most of a minute.
rehearsing = rehearsed:pose_scores-$(1)-camera rehearsed_around:pose_scores-$(1)-camera

volume-nbv: $(VENV)/dev.stamp ## Print how well the next view for a box's volume is chosen, on fresh boxes (hours; goes on where it was)
	$(BIN)/viewgain evaluate volume --boxes 300 --seed 7 --workers 2 --policies $(call volume_policies,irregular4) $(call rehearsing,irregular4) informed --out tables/volume $(ARGS)
	$(BIN)/viewgain evaluate volume --boxes 300 --seed 7 --workers 2 --policies $(call volume_policies,irregular4) $(call rehearsing,irregular4) --estimator lines_published --out tables/volume-lines $(ARGS)
	$(BIN)/viewgain evaluate volume --boxes 100 --seed 7 --workers 2 --policies $(call volume_policies,irregular) $(call rehearsing,irregular) informed --rig ring8 --fused --captures 4 --out tables/volume-fused $(ARGS)

# What no training of volumes saw: a camera, a rig, and boxes larger than any, from farther away.
held_out = $(BIN)/viewgain evaluate volume --boxes 60 --seed 7 --captures 8 --workers 2 --policies $(call volume_policies,irregular4) $(call rehearsing,irregular4)

volume-held-out: $(VENV)/dev.stamp ## The same with a camera, a rig and sizes that no training saw (hours; goes on where it was)
	$(held_out) --camera xtion --out tables/volume-xtion $(ARGS)
	$(held_out) --rig ring8 --out tables/volume-ring8 $(ARGS)
	$(held_out) --rig ring8 --side 1.2 1.6 --distance 2.6 --out tables/volume-large $(ARGS)

loop-nbv: $(VENV)/dev.stamp ## Print how many views planners need until a box's volume is certain, on fresh boxes (hours; goes on where it was)
	$(BIN)/viewgain evaluate loop --boxes 100 --seed 7 --workers 2 --out tables/loop $(ARGS)

shapes-nbv: $(VENV)/dev.stamp ## Print how well a second view is chosen for the volume of objects of any shape (minutes; goes on where it was)
	$(BIN)/viewgain evaluate shapes --objects 96 --seed 7 --workers 2 --out tables/shapes $(ARGS)

setup: $(VENV)/dev.stamp ## Make .venv with everything for development

clean: ## Remove .venv and everything that was generated
	rm -rf $(VENV) build dist demo-report tables .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

# A stamp is written last, so what died halfway is made again; a change of the two files below makes .venv anew from nothing.
# The stamps stand in one chain: two pip runs never write into .venv at once, even under make -j.
$(VENV)/venv.stamp: pyproject.toml constraints.txt
	$(PYTHON) -m venv --clear $(VENV)
	@touch $@

$(VENV)/demo.stamp: $(VENV)/venv.stamp
	@echo "Installing viewgain into $(VENV); this happens once and takes a minute or two."
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[report]"
	@touch $@

$(VENV)/dev.stamp: $(VENV)/demo.stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[dev]"
	@touch $@
