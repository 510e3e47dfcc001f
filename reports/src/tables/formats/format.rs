//! Interface of all formats.

/// A way to write `T` as text.
pub trait Format<T: ?Sized> {
    /// Name of the file for `stem`, such as `gate.json` for `gate`.
    fn file_name(&self, stem: &str) -> String;

    /// The content of that file.
    fn text(&self, subject: &T) -> String;
}
