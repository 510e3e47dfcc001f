//! `scanbench data`.

pub mod list;
pub mod get;
pub mod add;
pub mod check;
pub mod hash;
pub mod convert;
pub mod objects;
pub mod prelabel;
pub mod realism;
