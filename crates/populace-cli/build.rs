//! Sets the cfgs that ignore tests.
//!
//! `POPULACE_SKIP=opencl,gl` ignores the tests that need an OpenCL device or OpenGL; without it
//! they fail if it is missing. Tests on real characters are ignored unless `POPULACE_TEST_DATA`
//! names their folder.

fn main() {
    println!("cargo:rerun-if-env-changed=POPULACE_SKIP");
    let skipped = std::env::var("POPULACE_SKIP").unwrap_or_default();
    for requirement in ["opencl", "gl"] {
        println!("cargo:rustc-check-cfg=cfg(skip_{requirement})");
        if skipped.split(',').any(|word| word.trim() == requirement) {
            println!("cargo:rustc-cfg=skip_{requirement}");
        }
    }
    println!("cargo:rerun-if-env-changed=POPULACE_TEST_DATA");
    println!("cargo:rustc-check-cfg=cfg(no_test_data)");
    if std::env::var_os("POPULACE_TEST_DATA").is_none() {
        println!("cargo:rustc-cfg=no_test_data");
    }
}
