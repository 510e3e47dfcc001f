//! Writes the schemas of JSON files and the columns of CSV files into a folder.
//!
//! ```sh
//! cargo run --release --package reports --features schemas --example schemas -- FOLDER
//! ```

use std::path::PathBuf;

use reports::schemas::{columns_page, json_schemas};

fn main() -> std::io::Result<()> {
    let folder: PathBuf =
        std::env::args_os().nth(1).ok_or_else(|| std::io::Error::other("no folder given"))?.into();
    std::fs::create_dir_all(&folder)?;
    for (name, schema) in json_schemas() {
        std::fs::write(folder.join(format!("{name}.schema.json")), schema)?;
    }
    std::fs::write(folder.join("columns.md"), columns_page())
}
