//! `POPULACE_SKIP=opencl,gl` shows the tests that need a device or OpenGL as ignored; without it
//! they fail if it is missing.

fn main() {
    println!("cargo:rerun-if-env-changed=POPULACE_SKIP");
    let skipped = std::env::var("POPULACE_SKIP").unwrap_or_default();
    for requirement in ["opencl", "gl"] {
        println!("cargo:rustc-check-cfg=cfg(skip_{requirement})");
        if skipped.split(',').any(|word| word.trim() == requirement) {
            println!("cargo:rustc-cfg=skip_{requirement}");
        }
    }
}
