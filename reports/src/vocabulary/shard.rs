//! A part of a run that is made by itself, and put together with the others afterwards.

use std::fmt;
use std::str::FromStr;

/// More parts than this are a slip of the keyboard.
pub const MOST_SHARDS: u32 = 1_000_000;

/// One of several parts, counted from 1: `3/8` is the third of eight.
///
/// There is no part 0, so that counting from 0 gives an error at once.
///
/// ```
/// use reports::vocabulary::shard::Shard;
///
/// let third: Shard = "3/8".parse().unwrap();
/// assert_eq!((third.index(), third.count(), third.to_string()), (3, 8, "3/8".to_owned()));
/// assert_eq!(third.folder_name(), "shard-3-of-8");
/// assert!("0/8".parse::<Shard>().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    // Invariant: 1 ≤ index ≤ count ≤ MOST_SHARDS.
    index: u32,
    count: u32,
}

/// Why something is no part of a run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ShardError(String);

impl Shard {
    /// All in one piece.
    pub const ONLY: Self = Self { index: 1, count: 1 };

    /// Part `index` of `count`, counted from 1.
    ///
    /// # Errors
    ///
    /// [`ShardError`] if there is no such part.
    pub fn new(index: u32, count: u32) -> Result<Self, ShardError> {
        Err(ShardError(match index {
            _ if !(1..=MOST_SHARDS).contains(&count) => {
                format!("{count} shards cannot be made; their number is from 1 to {MOST_SHARDS}")
            }
            0 => format!(
                "there is no shard 0: shards are counted from 1, the first of {count} is 1/{count}, the last {count}/{count}"
            ),
            index if index > count => {
                format!("there is no shard {index} of {count}: shards are counted from 1 to {count}")
            }
            index => return Ok(Self { index, count }),
        }))
    }

    /// Which one, from 1.
    pub fn index(self) -> u32 {
        self.index
    }

    /// How many there are.
    pub fn count(self) -> u32 {
        self.count
    }

    /// The name of its folder, beside those of the others. The names of all parts sort as their numbers do.
    pub fn folder_name(self) -> String {
        let n_digits = self.count.to_string().len();
        format!("shard-{:0n_digits$}-of-{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let is_number = |it: &str| !it.is_empty() && it.bytes().all(|byte| byte.is_ascii_digit());
        let parts = text.split_once('/').filter(|(index, count)| is_number(index) && is_number(count));
        let numbers = parts.and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        let not_so = || format!("{text:?} is no shard; write I/N, such as 3/8 for the third of eight");
        let (index, count) = numbers.ok_or_else(|| ShardError(not_so()))?;
        Self::new(index, count)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn check_refused(text: &str, part: &str) {
        let error = text.parse::<Shard>().unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }

    #[test]
    fn parts_are_counted_from_one() {
        assert_eq!("1/1".parse(), Shard::new(1, 1));
        assert_eq!("8/8".parse(), Shard::new(8, 8));
        check_refused("0/8", "the first of 8 is 1/8, the last 8/8");
        check_refused("9/8", "there is no shard 9 of 8");
        check_refused("0/0", "0 shards cannot be made");
        check_refused("1/1000001", "1000001 shards cannot be made");
    }

    #[test]
    fn what_is_written_otherwise_is_refused() {
        for text in ["", "3", "3/", "/8", "3/8/2", "3 / 8", "-1/8", "+1/8", "3:8", "1/99999999999"] {
            check_refused(text, "write I/N, such as 3/8");
        }
    }

    #[test]
    fn folders_sort_as_their_numbers() {
        let names: Vec<String> = (1..=12).map(|it| Shard::new(it, 12).unwrap().folder_name()).collect();
        assert!(names.is_sorted(), "{names:?}");
        assert_eq!(names[0], "shard-01-of-12");
    }

    proptest! {
        #[test]
        fn what_is_printed_reads_back(count in 1_u32..2000, share in 0.0_f64..1.0) {
            let shard = Shard::new(1 + (share * f64::from(count)) as u32, count).unwrap();
            prop_assert_eq!(shard.to_string().parse(), Ok(shard));
        }
    }
}
