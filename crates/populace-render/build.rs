//! Turns `POPULACE_SKIP=gl` into a cfg, so that tests which need OpenGL show as ignored instead of
//! failing.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(skip_gl)");
    println!("cargo::rerun-if-env-changed=POPULACE_SKIP");
    let skip = std::env::var("POPULACE_SKIP").unwrap_or_default();
    if skip.split(',').any(|name| name.trim() == "gl") {
        println!("cargo::rustc-cfg=skip_gl");
    }
}
