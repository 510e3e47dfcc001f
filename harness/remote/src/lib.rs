//! Copies files from object stores and web servers into folders; the only crate that knows `object_store`.
//!
//! An [`address::Address`] says where objects lie, a [`store::Store`] reaches them, a [`session::Session`] lists and fetches
//! them, many at a time. What it leaves is a folder of files like any other. A file that has its name is whole:
//! [`transfer`] says how.

pub mod error;
mod local_file;
pub mod address;
pub mod sums;
pub mod space;
pub mod patience;
pub mod store;
pub mod transfer;
pub mod session;
pub mod unpack;

pub use error::RemoteError;
