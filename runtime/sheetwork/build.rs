//! Passes the optimisation level of this crate to its source.

fn main() {
    let level = std::env::var("OPT_LEVEL").unwrap_or_default();
    println!("cargo::rustc-env=SHEETWORK_OPT_LEVEL={level}");
    println!("cargo::rerun-if-changed=build.rs");
}
