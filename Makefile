# `make demo` sets the machine up, builds, and draws a street. `make test` builds and runs all
# tests.

demo:
	@sh scripts/setup.sh --ask
	cargo run -p populace-cli -- demo --out populace-demo.png

.PHONY: demo test test-long setup setup-tests lint doc release

# Installs nothing: a missing driver is named here, and the tests that need it fail.
test:
	@sh scripts/setup.sh --check || true
	cargo test --workspace --no-fail-fast

# Faults on purpose, in kernels and in calls to OpenCL. For nightly runs.
test-long:
	cargo test -p populace-opencl --lib faults -- --ignored
	cargo test -p populace --test device_faults -- --ignored

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
