//! What holds for every enum that files name.

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Each of `all` is written as its name, and read back as what it was.
#[track_caller]
pub(crate) fn check_names<T>(all: &[T], name: fn(T) -> &'static str)
where
    T: Copy + Debug + PartialEq + Serialize + DeserializeOwned,
{
    for it in all {
        let written = serde_json::to_string(it).unwrap();
        assert_eq!(written, format!("{:?}", name(*it)));
        assert_eq!(serde_json::from_str::<T>(&written).unwrap(), *it);
    }
}
