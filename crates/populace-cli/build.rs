//! `POPULACE_SKIP=opencl,gl` shows the tests that need a device or GL as ignored; without it a missing one fails them.

fn main() {
    println!("cargo:rerun-if-env-changed=POPULACE_SKIP");
    let skipped = std::env::var("POPULACE_SKIP").unwrap_or_default();
    for what in ["opencl", "gl"] {
        println!("cargo:rustc-check-cfg=cfg(skip_{what})");
        if skipped.split(',').any(|word| word.trim() == what) {
            println!("cargo:rustc-cfg=skip_{what}");
        }
    }
}
