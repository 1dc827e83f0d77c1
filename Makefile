# `make paper` reproduces the paper, `make test` runs the tests; each installs what it needs.
# Needs python3 (3.11 or later) and make. OPTIONS are snakemake's, as in
# `make resume OPTIONS="--workflow-profile profiles/slurm"`; CONFIG names another study.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CONFIG :=
OPTIONS :=
RUN := PATH="$(CURDIR)/$(BIN):$$PATH"
SNAKEMAKE = $(RUN) snakemake $(OPTIONS)
# Snakemake itself meets a file that it cannot read with a traceback.
CHECKED = $(if $(CONFIG),$(RUN) squeezefilm config $(CONFIG) >/dev/null)
STUDIES ?= paper paper-inertia quick
OURS := levitation paper paper-inertia plate quick sweep synthetic vibrometer
REPORT ?= results/report.html
DOCS ?= docs/_build/html
PIP_LOG := $(VENV)/pip.log
# Stages may run side by side (.ci/run); Debian's packages are installed by one at a time.
debian = [ "$$(id -u)" != 0 ] || flock $(VENV)/debian.lock sh -c "apt-get -q update \
	&& DEBIAN_FRONTEND=noninteractive apt-get -qy install --no-install-recommends $(1)" || true
# A command whose words go to a log, the last of them to the terminal where it fails.
quietly = $(1) >>$(PIP_LOG) 2>&1 || { tail -n 20 $(PIP_LOG); exit 1; }
COMPILE := $(BIN)/uv pip compile --quiet --universal --fork-strategy fewest --python-version 3.11 \
	--generate-hashes --no-header --no-annotate

# Snakemake calls .venv's Python without quotes around its path.
AWKWARD := $(if $(word 2,x$(CURDIR)x),blanks )$(foreach mark,' " ( ) & ; * ? $$ `,$(findstring $(mark),$(CURDIR)))
ifneq ($(strip $(AWKWARD)),)
$(error The path of this folder, $(CURDIR), has $(strip $(AWKWARD)): \
Snakemake runs no script there. Move the folder to a path without)
endif

.DEFAULT_GOAL := help
.PHONY: help paper paper-inertia quick check reference report benchmarks test test-check test-docs test-faults test-browser test-install test-device test-stability mutants docs pictures lint format lock resume clean test-cluster test-fresh

help:
	@echo "make paper            reproduce the paper: simulations, fits, designs, tables, figures; 4 minutes"
	@echo "make paper-inertia    the same with gas inertia, and the two studies compared"
	@echo "make quick            a small study by the same rules; two to four minutes"
	@echo "make check            make three studies and compare them with the stored reference"
	@echo "make report           a study's results on one HTML page: $(REPORT)"
	@echo "make resume           continue a run that was killed"
	@echo "make clean            remove .venv, logs, built pages and this repository's results; keep yours"
	@echo
	@echo "make test             the tests; 5 minutes"
	@echo "make test-browser     the HTML pages in a headless browser"
	@echo "make test-check       faults put into a study, which the check must find"
	@echo "make test-cluster     jobs on a Slurm of this machine, installed where it is missing"
	@echo "make test-device      every kernel in Oclgrind, and large work-groups"
	@echo "make test-docs        the commands of the documentation, on small studies"
	@echo "make test-faults      killed runs and full disks"
	@echo "make test-fresh       a new Debian 12 and 13; FRESH=quick: in short; root only"
	@echo "make test-install     the library installed from its wheel; needs a network"
	@echo "make test-stability   stiff and extreme films; minutes"
	@echo "make mutants          wrong signs put into formulas, which the tests must find; minutes"
	@echo "make lint             style, types, imports between layers, Snakemake's lint"
	@echo "make format           format the code"
	@echo
	@echo "make docs             the documentation as HTML: $(DOCS)"
	@echo "make pictures         the pictures of the documentation; minutes, on an idle machine"
	@echo "make benchmarks       the tables of run times; minutes, on an idle machine"
	@echo "make reference        a new stored reference for make check"
	@echo "make lock             pin the newest versions of all packages"
	@echo
	@echo "Variables: CONFIG=config/mine.yaml (report, resume), STUDIES=mine (check, reference),"
	@echo "           OPTIONS=... of snakemake (targets too), PYTHON=python3.12"

paper: $(VENV)/.run
	@echo "Reproducing the paper: some minutes on two cores. Finished results are kept;"
	@echo "'make resume' continues a run that was killed."
	@$(SNAKEMAKE)

paper-inertia: paper
	$(SNAKEMAKE) --configfile config/paper-inertia.yaml

quick: $(VENV)/.run
	$(SNAKEMAKE) --configfile config/quick.yaml

# All studies are checked, also when one fails.
check: $(VENV)/.run
	failed=0; for study in $(STUDIES); do \
		$(SNAKEMAKE) check --configfile config/$$study.yaml || failed=1; done; exit $$failed

reference: $(VENV)/.run
	set -e; for study in $(STUDIES); do \
		$(RUN) snakemake checked --configfile config/$$study.yaml; \
		$(RUN) squeezefilm reference results/$$study --config config/$$study.yaml \
			--output tests/reference/$$study; done

report: $(VENV)/.run
	@$(CHECKED)
	$(SNAKEMAKE) everything $(if $(CONFIG),--configfile $(CONFIG))
	$(RUN) snakemake everything $(if $(CONFIG),--configfile $(CONFIG)) --report $(REPORT)

benchmarks: paper
	$(SNAKEMAKE) work_precision
	$(RUN) squeezefilm-verification run-times --output docs/data

test: $(VENV)/.dev
	$(RUN) OPENBLAS_NUM_THREADS=1 pytest -n 2

test-check: $(VENV)/.dev
	$(RUN) pytest tests/check

test-docs: $(VENV)/.dev
	$(RUN) pytest tests/docs

test-faults: $(VENV)/.dev
	$(RUN) pytest tests/faults

# A root user of Debian gets the browser too; elsewhere the tests say what is missing.
test-browser: $(VENV)/.dev
	@{ command -v chromium && command -v chromedriver; } >/dev/null \
		|| $(call debian,chromium chromium-driver)
	$(RUN) pytest tests/browser

# Of a network: the library is installed from its wheel, as a user of it alone would.
test-install: $(VENV)/.dev
	$(RUN) pytest tests/install

# Not in .ci/run: minutes of installation. FRESH=quick is its short form.
test-fresh: $(VENV)/.dev
	@command -v mmdebstrap >/dev/null || $(call debian,mmdebstrap)
	$(RUN) pytest -s -o faulthandler_timeout=7200 --durations=0 tests/fresh $(if $(FRESH),-k $(FRESH))

# Warnings are errors: a link that leads nowhere is one.
docs: $(VENV)/.dev
	$(RUN) sphinx-build -q -W --keep-going -b html docs $(DOCS)

# A root user of Debian gets Oclgrind too; elsewhere its tests are skipped and say so.
test-device: $(VENV)/.dev
	@command -v oclgrind >/dev/null || $(call debian,oclgrind)
	$(RUN) pytest tests/device

# Not in .ci/run: run times are drawn too, so nothing else should run. Some minutes.
pictures: $(VENV)/.dev
	$(RUN) python docs/pictures.py

test-stability: $(VENV)/.run
	$(SNAKEMAKE) results/paper/numerics/stability.csv

# Not in .ci/run: each compiles kernels anew.
mutants: $(VENV)/.dev
	$(RUN) OPENBLAS_NUM_THREADS=1 python tests/mutants.py

# A root user of Debian gets Slurm too; elsewhere its tests are skipped and say so.
test-cluster: $(VENV)/.dev
	@{ command -v slurmctld && command -v munged; } >/dev/null \
		|| $(call debian,slurmctld slurmd slurm-client munge)
	$(RUN) pytest -v -s tests/cluster

lint: $(VENV)/.dev
	$(RUN) ruff check .
	$(RUN) ruff format --check .
	$(RUN) mypy
	$(RUN) PYTHONPATH=workflow lint-imports --no-cache
	$(RUN) snakefmt --check Snakefile workflow
	$(RUN) snakemake --lint

format: $(VENV)/.dev
	$(RUN) ruff check --fix .
	$(RUN) ruff format .
	$(RUN) snakefmt Snakefile workflow

resume: $(VENV)/.run
	@$(CHECKED)
	$(SNAKEMAKE) --unlock $(if $(CONFIG),--configfile $(CONFIG))
	$(SNAKEMAKE) --rerun-incomplete $(if $(CONFIG),--configfile $(CONFIG))

lock: $(VENV)/.dev
	$(COMPILE) --upgrade --output-file requirements.lock requirements.in
	$(COMPILE) --upgrade --output-file requirements-dev.lock requirements-dev.in

# Studies of the user's own stay: their results may have taken days. So do Snakemake's records, by
# which a later edit makes them anew; a record of what is removed does no harm.
clean:
	rm -rf $(OURS:%=results/%) results/report.html
	@find results -mindepth 1 -maxdepth 1 ! -name README.md -exec echo "kept: {}" \;
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache benchmarks logs build docs/_build docs/reference/_generated
	@! test -d .snakemake || find .snakemake -mindepth 1 -maxdepth 1 ! -name metadata -exec rm -rf {} +
	@cache="$${XDG_CACHE_HOME:-$$HOME/.cache}"; echo "outside this folder, yours to remove:" \
		"compiled kernels in $${POCL_CACHE_DIR:-$$cache/pocl}, $$cache/pyopencl and $$cache/pytools"

# The packages as pinned, checked by their hashes; the library itself in place.
$(VENV)/.run: requirements.lock pyproject.toml | $(BIN)/python
	@echo "Setting up $(VENV): 0.8 GB, a minute or two, once; pip's output is in $(PIP_LOG)"
	@$(call quietly,$(BIN)/python -m pip install --require-hashes --requirement requirements.lock)
	@$(call quietly,$(BIN)/python -m pip install --no-deps --no-build-isolation --editable .)
	@touch $@

$(VENV)/.dev: requirements-dev.lock $(VENV)/.run
	@echo "Adding what tests and linters need; pip's output is in $(PIP_LOG)"
	@$(call quietly,$(BIN)/python -m pip install --require-hashes --requirement requirements-dev.lock)
	@touch $@

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "Python 3.11 or later is needed; name one: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	$(PYTHON) -m venv $(VENV)
