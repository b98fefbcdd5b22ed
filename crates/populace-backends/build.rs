//! Reads `POPULACE_SKIP`. With `POPULACE_SKIP=opencl`, tests that need a device are ignored;
//! without it, they fail if there is no device.

fn main() {
    println!("cargo:rustc-check-cfg=cfg(skip_opencl)");
    println!("cargo:rerun-if-env-changed=POPULACE_SKIP");
    let skipped = std::env::var("POPULACE_SKIP").unwrap_or_default();
    if skipped.split(',').any(|word| word.trim() == "opencl") {
        println!("cargo:rustc-cfg=skip_opencl");
    }
}
