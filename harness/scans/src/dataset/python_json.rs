//! JSON as Python writes it: numbers may be NaN, Infinity and -Infinity, which JSON has no words for.
//!
//! These words are put into quotes before the text is parsed, and [`number`] and [`numbers`] take them as numbers. So each
//! format decides which of them it accepts, and an error can say where they stand.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Read};

use serde::de::{Deserialize, Deserializer, Error, Unexpected, Visitor};

/// Bytes that are read at once.
const N_BUFFERED: usize = 1 << 18;

/// The text of `inner` with those words in quotes.
pub fn python_json<R: Read>(inner: R) -> impl Read {
    Quoting { inner, place: Place::default(), plain: vec![0; N_BUFFERED], quoted: Vec::new(), n_taken: 0 }
}

/// `text` with those words in quotes.
pub fn quoted(text: &str) -> Cow<'_, str> {
    if !text.contains(['N', 'I']) {
        return text.into();
    }
    let (mut place, mut bytes) = (Place::default(), Vec::with_capacity(text.len()));
    text.bytes().for_each(|it| place.take(it, &mut |it| bytes.push(it)));
    place.end(&mut |it| bytes.push(it));
    // Nothing but quotes was added.
    String::from_utf8(bytes).map_or_else(|_| text.into(), Cow::Owned)
}

/// Place in a text.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum Place {
    #[default]
    Between,
    InString,
    /// Behind a backslash.
    InEscape,
    /// Behind a minus that has not been passed on.
    Minus,
    /// In a word that needs quotes.
    Word,
}

impl Place {
    /// Takes the next byte, and passes on the bytes that it becomes.
    fn take(&mut self, byte: u8, push: &mut impl FnMut(u8)) {
        match *self {
            Self::Word if byte.is_ascii_alphabetic() => return push(byte),
            Self::Word => push(b'"'),
            Self::Minus if byte == b'I' => {
                *self = Self::Word;
                return [b'"', b'-', b'I'].into_iter().for_each(push);
            }
            Self::Minus => push(b'-'),
            _ => {}
        }
        *self = match (*self, byte) {
            (Self::InString, b'\\') => Self::InEscape,
            (Self::InString, b'"') => Self::Between,
            (Self::InEscape | Self::InString, _) | (_, b'"') => Self::InString,
            (_, b'-') => return *self = Self::Minus,
            (_, b'N' | b'I') => {
                push(b'"');
                Self::Word
            }
            _ => Self::Between,
        };
        push(byte);
    }

    fn end(&mut self, push: &mut impl FnMut(u8)) {
        match std::mem::take(self) {
            Self::Word => push(b'"'),
            Self::Minus => push(b'-'),
            _ => {}
        }
    }
}

struct Quoting<R> {
    inner: R,
    place: Place,
    plain: Vec<u8>,
    // Bytes of which the first `n_taken` have been passed on.
    quoted: Vec<u8>,
    n_taken: usize,
}

impl<R: Read> Read for Quoting<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        // A single minus is kept for later; returning no bytes would mean the end.
        while self.n_taken == self.quoted.len() {
            self.quoted.clear();
            self.n_taken = 0;
            let n_read = self.inner.read(&mut self.plain)?;
            let mut push = |byte| self.quoted.push(byte);
            self.plain[..n_read].iter().for_each(|it| self.place.take(*it, &mut push));
            if n_read == 0 {
                self.place.end(&mut push);
                break;
            }
        }
        let n = buffer.len().min(self.quoted.len() - self.n_taken);
        buffer[..n].copy_from_slice(&self.quoted[self.n_taken..self.n_taken + n]);
        self.n_taken += n;
        Ok(n)
    }
}

/// A number as Python writes it.
struct PythonNumber(f64);

impl<'de> Deserialize<'de> for PythonNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberVisitor;
        impl Visitor<'_> for NumberVisitor {
            type Value = PythonNumber;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a number")
            }

            fn visit_f64<E>(self, value: f64) -> Result<PythonNumber, E> {
                Ok(PythonNumber(value))
            }

            fn visit_i64<E>(self, value: i64) -> Result<PythonNumber, E> {
                Ok(PythonNumber(value as f64))
            }

            fn visit_u64<E>(self, value: u64) -> Result<PythonNumber, E> {
                Ok(PythonNumber(value as f64))
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<PythonNumber, E> {
                match word {
                    "NaN" => Ok(PythonNumber(f64::NAN)),
                    "Infinity" => Ok(PythonNumber(f64::INFINITY)),
                    "-Infinity" => Ok(PythonNumber(f64::NEG_INFINITY)),
                    _ => Err(E::invalid_value(Unexpected::Str(word), &self)),
                }
            }
        }
        deserializer.deserialize_any(NumberVisitor)
    }
}

/// Types of numbers that a file may have.
pub trait Float: Sized {
    /// The number nearest to `value`.
    fn of(value: f64) -> Self;
}

impl Float for f64 {
    fn of(value: f64) -> Self {
        value
    }
}

impl Float for f32 {
    fn of(value: f64) -> Self {
        value as Self
    }
}

/// A number, which may be NaN or infinite; for `#[serde(deserialize_with = …)]`.
pub fn number<'de, D: Deserializer<'de>, T: Float>(deserializer: D) -> Result<T, D::Error> {
    PythonNumber::deserialize(deserializer).map(|it| T::of(it.0))
}

/// A number or null.
pub fn number_or_none<'de, D: Deserializer<'de>, T: Float>(deserializer: D) -> Result<Option<T>, D::Error> {
    Ok(Option::<PythonNumber>::deserialize(deserializer)?.map(|it| T::of(it.0)))
}

/// `N` numbers.
pub fn numbers<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Float,
{
    numbers_or_none(deserializer)?
        .ok_or_else(|| D::Error::invalid_type(Unexpected::Unit, &"a list of numbers"))
}

/// `N` numbers or null.
pub fn numbers_or_none<'de, D, T, const N: usize>(deserializer: D) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Float,
{
    let Some(read) = Option::<Vec<PythonNumber>>::deserialize(deserializer)? else { return Ok(None) };
    let values: Vec<T> = read.into_iter().map(|it| T::of(it.0)).collect();
    let n = values.len();
    let of_length = <[T; N]>::try_from(values);
    of_length.map(Some).map_err(|_| D::Error::invalid_length(n, &&*format!("{N} numbers")))
}

/// Makes sure that `values` are finite; the file calls them `name`. Errors are the rest of a sentence about the object.
pub fn check_finite(name: &str, values: &[f64]) -> Result<(), String> {
    match values.iter().find(|it| !it.is_finite()) {
        Some(value) => Err(format!("has {} in its {name}", in_python(*value))),
        None => Ok(()),
    }
}

/// Python's word for a number that is not finite.
fn in_python(value: f64) -> &'static str {
    match value {
        f64::INFINITY => "Infinity",
        f64::NEG_INFINITY => "-Infinity",
        _ => "NaN",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(serde::Deserialize)]
    struct Record {
        #[serde(deserialize_with = "numbers")]
        at: [f64; 3],
        #[serde(default, deserialize_with = "number_or_none")]
        score: Option<f32>,
    }

    #[test]
    fn words_of_python_are_numbers() {
        let text = r#"{"at": [NaN,-Infinity, Infinity],"score":-1.5e-3}"#;
        for record in [
            serde_json::from_str::<Record>(&quoted(text)),
            serde_json::from_reader(python_json(text.as_bytes())),
        ] {
            let Record { at, score } = record.unwrap();
            assert!(at[0].is_nan() && at[1..] == [f64::NEG_INFINITY, f64::INFINITY], "{at:?}");
            assert_eq!(score, Some(-0.0015));
        }
        let none: Record = serde_json::from_str(r#"{"at": [1, -2, 3.5], "score": null}"#).unwrap();
        assert_eq!((none.at, none.score), ([1.0, -2.0, 3.5], None));
    }

    #[test]
    fn other_words_and_lengths_are_refused() {
        let problem = |text: &str| {
            let Err(error) = serde_json::from_str::<Record>(&quoted(text)) else { panic!("{text}") };
            error.to_string()
        };
        assert!(problem(r#"{"at": [1, 2, Nope]}"#).contains("string \"Nope\", expected a number"));
        assert!(problem(r#"{"at": [1, 2]}"#).contains("invalid length 2, expected 3 numbers"));
        assert!(problem(r#"{"at": null}"#).contains("expected a list of numbers"));
        assert!(problem(r#"{"at": [1, 2, "3"]}"#).contains("expected a number"));
    }

    #[test]
    fn names_are_left_alone() {
        for text in [r#"{"Name \" N": "I -Infinity NaN \\"}"#, r#"["é NaN", -1, 2e-5, null]"#, "-", "\"N"] {
            assert_eq!(quoted(text), text);
        }
        assert_eq!(quoted("NaN"), "\"NaN\"");
        assert_eq!(check_finite("size", &[1.0, f64::NAN]), Err("has NaN in its size".to_owned()));
    }

    proptest! {
        #[test]
        fn sound_json_stays_as_it_is(names in prop::collection::vec(".*", 0..5), number in -1e9..1e9_f64) {
            let text = serde_json::json!({"names": names, "number": number}).to_string();
            prop_assert_eq!(&*quoted(&text), text.as_str());
            let mut read = String::new();
            python_json(text.as_bytes()).read_to_string(&mut read).unwrap();
            prop_assert_eq!(read, text);
        }
    }
}
