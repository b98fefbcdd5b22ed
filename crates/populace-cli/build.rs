//! `POPULACE_SKIP=opencl,gl` shows the tests that need a device or GL as ignored; without it a
//! missing one fails them. Tests that read real characters show as ignored where
//! `POPULACE_TEST_DATA` names no folder.

fn main() {
    println!("cargo:rerun-if-env-changed=POPULACE_SKIP");
    let skipped = std::env::var("POPULACE_SKIP").unwrap_or_default();
    for what in ["opencl", "gl"] {
        println!("cargo:rustc-check-cfg=cfg(skip_{what})");
        if skipped.split(',').any(|word| word.trim() == what) {
            println!("cargo:rustc-cfg=skip_{what}");
        }
    }
    println!("cargo:rerun-if-env-changed=POPULACE_TEST_DATA");
    println!("cargo:rustc-check-cfg=cfg(no_test_data)");
    if std::env::var_os("POPULACE_TEST_DATA").is_none() {
        println!("cargo:rustc-cfg=no_test_data");
    }
}
