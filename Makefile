# `make demo` sets the machine up, builds, and draws a street. `make test` builds and tests the
# libraries, `make test-slow` the program and whatever takes long.

demo:
	@sh scripts/setup.sh --ask
	cargo run -p populace-cli --no-default-features -- demo --out populace-demo.png

.PHONY: demo test test-slow test-long native-faults mutants fuzz soak conformance
.PHONY: gpu-budget setup setup-tests lint doc release

# Installs nothing: a missing driver is named here, and the tests that need it fail. Says at its end
# how many tests passed, and how many checks on how many devices they ran.
test:
	@sh scripts/setup.sh --check || true
	@sh scripts/run-tests.sh $(LIBRARIES)

LIBRARIES := --workspace --exclude populace-cli --exclude populace-viewer

# Test programs of the libraries that take long, such as the street; tests in modules named `slow`,
# such as the conformance suite in more shapes of devices; and the program as users run it, its
# window, random sequences of calls, and independent references.
test-slow:
	@sh scripts/setup.sh --check || true
	cargo test $(LIBRARIES) --no-fail-fast --test street --test skate --test motions \
		--test prepare --test stages
	cargo test $(LIBRARIES) --no-fail-fast --lib --test conformance --test script \
		-- --ignored slow::
	POPULACE_LANES=8 cargo test -p populace --no-fail-fast --test agreement --test controls \
		--test script
	cargo test -p populace-cli -p populace-viewer --no-fail-fast --lib --test cast \
		--test interop --test program --test python --test reference --test retarget \
		--test sequences --test window

# The slow tests, and faults on purpose, in kernels and in calls to OpenCL. For nightly runs.
test-long: test-slow
	cargo test -p populace-opencl --lib faults -- --ignored
	cargo test -p populace --test device_faults -- --ignored

# Single faults in the Rust text of stages, in a copy of the workspace: each must be noticed.
native-faults:
	python3 -B scripts/native-faults.py

# Changes of the leaf arithmetic, each of which a unit test must notice. Needs cargo-mutants.
mutants:
	CARGO_PROFILE_DEV_OPT_LEVEL=0 CARGO_PROFILE_DEV_DEBUG=0 cargo mutants --output target/mutants

# All fuzz targets, TIME seconds each. Needs the nightly toolchain and cargo-fuzz.
fuzz:
	python3 -B scripts/fuzz.py $(or $(TIME),60)

# An OpenCL driver for the CPU, EGL and Mesa's software driver, as root or with sudo.
setup:
	sh scripts/setup.sh

# What the tests need besides: a display without a screen, for those of the window.
setup-tests: setup
	sh scripts/setup.sh --tests

lint:
	cargo fmt --all --check
	sh scripts/check-width.sh
	sh scripts/check-docs.sh
	cargo clippy --workspace --all-targets -- -D warnings
	cargo clippy -p populace --no-default-features -- -D warnings
	cargo clippy -p populace-cli --no-default-features -- -D warnings
	cargo clippy -p populace-trajectory --no-default-features --all-targets -- -D warnings

doc:
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

# The program, at target/release/populace.
release:
	cargo build --release -p populace-cli

# Two crowds of 10,000 members on different devices, in which everything changes, for an hour.
soak:
	cargo test -p populace-cli --test sequences -- --soak-minutes $(or $(MINUTES),60)

# Registers, spills, stack, local memory and occupancy of the kernels on GPUs, without a GPU, held
# to crates/populace-opencl/gpu-budget.csv; RENEW=1 writes that file. Compilers are fetched by
# apt-get and pip into the target folder, and nothing is installed.
gpu-budget:
	python3 -B scripts/gpu-budget.py $(if $(RENEW),--renew)

# Tests on another OpenCL driver: DRIVER=intel, oclgrind or pocl. It is fetched into the target
# folder, and nothing is installed.
conformance:
	python3 -B scripts/conformance.py $(DRIVER)
