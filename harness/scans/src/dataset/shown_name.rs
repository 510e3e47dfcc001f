//! Names from files, as they are shown.

pub use reports::files::shown_text::{is_printable, shown};
