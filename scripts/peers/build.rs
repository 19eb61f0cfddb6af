//! Generates dbc-codegen's messages.

use std::path::PathBuf;

fn main() {
    println!("cargo:rerun-if-changed=bench.dbc");
    let dbc = std::fs::read_to_string("bench.dbc").expect("bench.dbc is beside this file");
    let folder = PathBuf::from(std::env::var("OUT_DIR").expect("cargo gives a folder"));
    dbc_codegen::Config::builder()
        .dbc_name("bench.dbc")
        .dbc_content(&dbc)
        .allow_dead_code(true)
        .build()
        .write_to_file(folder.join("messages.rs"))
        .expect("messages are generated");
}
