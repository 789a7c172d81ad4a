# The two commands of the README are `make demo` and `make test`; each first installs what is missing, or says what is.

# Some graphics drivers complain on stderr where no desktop session has set this.
export XDG_RUNTIME_DIR ?= /tmp

PARAFOVEA = cargo run --release --quiet --

.PHONY: demo test lint docs bench window fuzz need

demo: need ## Run the calibration with a simulated observer, from pictures to report
	cargo build --release
	$(PARAFOVEA) demo

test: need ## Every test of the workspace
	cargo test --release --workspace

lint: need ## Formatting, lints and the documentation build
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps --document-private-items

bench: need ## Milliseconds a frame, per QUEST+ trial and per fit; what renderers save is `parafovea bench renderers`
	cargo bench

window: need ## Real windows on a virtual display, with injected keys and mouse: ten trials, one of every protocol, and a replay
	cargo build --release
	tests/window/drive
	tests/window/tour
	tests/window/replay

fuzz: ## Ten minutes for each reader of what comes from outside; needs a nightly compiler and cargo-fuzz
	fuzz/run

need:
	@scripts/need
