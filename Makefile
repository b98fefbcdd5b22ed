# `make demo` sets the machine up, builds, and draws a crowd; `make test` does the same and runs all tests.

# Real characters to test with, where they are at hand; without them the tests that need them show as ignored.
POPULACE_TEST_DATA ?= $(realpath $(wildcard ../shared/assets))
ifneq ($(POPULACE_TEST_DATA),)
export POPULACE_TEST_DATA
endif

demo: setup
	cargo run -p populace-cli -- demo

.PHONY: demo test setup lint doc release

test: setup
	cargo test --workspace --no-fail-fast

setup:
	sh scripts/setup.sh

lint:
	cargo fmt --all --check
	cargo clippy --workspace --all-targets -- -D warnings
	cargo clippy -p populace --no-default-features -- -D warnings

doc:
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

# The program, at target/release/populace.
release:
	cargo build --release -p populace-cli
