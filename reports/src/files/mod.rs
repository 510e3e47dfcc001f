//! Files: how they are opened, and written whole or not at all.

pub mod shown_text;
pub mod causes;
pub mod regular_file;
pub mod new_file;
pub mod archive;
pub mod unfinished;
pub mod whole_file;
pub mod hidden_folder;
pub mod claimed_name;
pub mod new_folders;
pub mod whole_set;
pub mod fixed_decimals;
pub(crate) mod exact_number;
pub mod csv_rows;
#[cfg(test)]
pub(crate) mod texts;
