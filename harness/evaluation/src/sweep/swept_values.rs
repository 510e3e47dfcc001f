//! The values that a sweep gives to parameters, as the command line writes them.

use std::str::FromStr;

use reports::run_folder::sweep_entry::SweptParameter;

use crate::run::config::override_option::OverrideOption;

/// Most values of one parameter; more are taken for a typing error.
const MOST_VALUES: i128 = 10_000;

/// An option `-P NAME=…` of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub enum SweepOption {
    /// `NAME=VALUE`: one value at all points.
    Fixed(OverrideOption),
    /// `NAME=START:STOP:STEP`; the name need not be the full one.
    Swept(SweptParameter),
    /// `NAME=NUMBER/SWEPT`: tied to another parameter.
    Tied(TiedValue),
}

/// `NAME=VALUE,VALUE,…` of `-L`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ListOption(pub SweptParameter);

/// A parameter whose value is a number divided by the value of a swept one, such as the number of cells of a swept size that
/// make a length.
#[derive(Debug, Clone, PartialEq)]
pub struct TiedValue {
    /// The name of the parameter.
    pub name: String,
    /// The dividend.
    pub dividend: f64,
    /// The name of the swept parameter.
    pub divisor: String,
}

impl FromStr for SweepOption {
    type Err = String;

    fn from_str(written: &str) -> Result<Self, String> {
        let Some((name, value)) = written.split_once('=') else {
            return Err("expected NAME=START:STOP:STEP, NAME=VALUE or NAME=NUMBER/SWEPT".to_owned());
        };
        let (name, value) = (name.trim().to_owned(), value.trim());
        let is_of_range = |it: char| it.is_ascii_digit() || ".:+-".contains(it);
        if value.contains(':') && value.chars().all(is_of_range) && !name.is_empty() {
            return Ok(Self::Swept(SweptParameter { name, values: range(value)? }));
        }
        if let Some((dividend, divisor)) = value.split_once('/')
            && let Ok(dividend) = dividend.trim().parse::<f64>()
            && !name.is_empty()
        {
            let divisor = divisor.trim().to_owned();
            if !(dividend.is_finite() && dividend > 0.0) || divisor.is_empty() {
                return Err(format!(
                    "{value} is not NUMBER/SWEPT, a positive number divided by a swept parameter"
                ));
            }
            return Ok(Self::Tied(TiedValue { name, dividend, divisor }));
        }
        let of_ranges = |error| format!("{error}; a range is START:STOP:STEP, such as 0.2:1.0:0.1");
        written.parse().map(Self::Fixed).map_err(of_ranges)
    }
}

impl FromStr for ListOption {
    type Err = String;

    fn from_str(written: &str) -> Result<Self, String> {
        let (name, values) = written.split_once('=').ok_or("expected NAME=VALUE,VALUE,…")?;
        let values: Vec<String> = values.split(',').map(|it| it.trim().to_owned()).collect();
        for (idx, value) in values.iter().enumerate() {
            // Each value of a list must be valid as a single value.
            format!("{name}={value}").parse::<OverrideOption>()?;
            if values[..idx].contains(value) {
                return Err(format!("{value} is given twice"));
            }
        }
        Ok(Self(SweptParameter { name: name.trim().to_owned(), values }))
    }
}

/// A number with a fixed number of decimals: `units` / 10^`n_decimals`.
struct Decimal {
    units: i128,
    n_decimals: u32,
}

/// The values of `START:STOP:STEP`, written with as many decimals as the longest of the three. STOP is included if a whole
/// number of steps leads there. Steps are counted in decimal digits, without rounding errors.
fn range(written: &str) -> Result<Vec<String>, String> {
    let parts: Vec<&str> = written.split(':').collect();
    let [start, stop, step] = parts[..] else {
        return Err(format!("{written} is not START:STOP:STEP, such as 0.2:1.0:0.1"));
    };
    let parse =
        |part: &str| decimal(part).ok_or_else(|| format!("{part:?} in {written} is not a decimal number"));
    let parts = [parse(start)?, parse(stop)?, parse(step)?];
    let n_decimals = parts.iter().map(|it| it.n_decimals).max().unwrap_or(0);
    let [start, stop, step] = parts.map(|it| it.units * 10_i128.pow(n_decimals - it.n_decimals));
    if step == 0 {
        return Err(format!("the step of {written} is 0"));
    }
    let n_steps = (stop - start) / step;
    if (stop - start).signum() * step.signum() < 0 {
        return Err(format!("the step of {written} has the wrong sign"));
    }
    if n_steps >= MOST_VALUES {
        return Err(format!("{written} has more than {MOST_VALUES} values"));
    }
    Ok((0..=n_steps).map(|it| text_of(start + it * step, n_decimals)).collect())
}

/// Reads a number with up to 15 digits before the point and up to nine after it; `None` if it is no such number.
fn decimal(text: &str) -> Option<Decimal> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text.strip_prefix('+').unwrap_or(text)),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let is_number = |it: &str| it.bytes().all(|byte| byte.is_ascii_digit());
    let is_sound = !whole.is_empty()
        && whole.len() <= 15
        && fraction.len() <= 9
        && is_number(whole)
        && is_number(fraction);
    if !is_sound || digits.ends_with('.') {
        return None;
    }
    let units: i128 = format!("{whole}{fraction}").parse().ok()?;
    Some(Decimal { units: sign * units, n_decimals: fraction.len() as u32 })
}

fn text_of(units: i128, n_decimals: u32) -> String {
    let sign = if units < 0 { "-" } else { "" };
    let one = 10_i128.pow(n_decimals);
    let (whole, fraction) = (units.abs() / one, units.abs() % one);
    match n_decimals {
        0 => format!("{sign}{whole}"),
        _ => format!("{sign}{whole}.{fraction:0width$}", width = n_decimals as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(written: &str, expected: &[&str]) {
        match written.parse() {
            Ok(SweepOption::Swept(swept)) => {
                assert_eq!(
                    (swept.name.as_str(), swept.values),
                    ("a", expected.iter().map(|it| (*it).to_owned()).collect())
                );
            }
            other => panic!("{written}: {other:?}"),
        }
    }

    #[test]
    fn the_stop_of_a_range_is_in_it_whatever_the_step_is_in_binary() {
        check("a=0.1:0.5:0.1", &["0.1", "0.2", "0.3", "0.4", "0.5"]);
        check("a=0:0.3:0.1", &["0.0", "0.1", "0.2", "0.3"]);
        check("a = 1:3:1", &["1", "2", "3"]);
        check("a=0.25:1:0.25", &["0.25", "0.50", "0.75", "1.00"]);
        check("a=2:2:0.5", &["2.0"]);
    }

    #[test]
    fn a_range_ends_at_its_last_whole_step() {
        check("a=0.2:1.0:0.3", &["0.2", "0.5", "0.8"]);
    }

    #[test]
    fn ranges_go_down_and_below_zero() {
        check("a=0.1:-0.1:-0.1", &["0.1", "0.0", "-0.1"]);
        check("a=-2:-1:+0.5", &["-2.0", "-1.5", "-1.0"]);
    }

    #[track_caller]
    fn check_refused<T: FromStr<Err = String>>(written: &str, message: &str) {
        let error = written.parse::<T>().err().unwrap_or_else(|| panic!("{written} was taken"));
        assert!(error.contains(message), "{written}: {error}");
    }

    #[test]
    fn ranges_that_make_no_sense_are_refused() {
        let check_range = check_refused::<SweepOption>;
        check_range("a=0.2:2.0", "not START:STOP:STEP");
        check_range("a=1:2:3:4", "not START:STOP:STEP");
        check_range("a=1:2:0", "the step of 1:2:0 is 0");
        check_range("a=2:1:0.1", "the step of 2:1:0.1 has the wrong sign");
        check_range("a=1:2:-0.1", "the step of 1:2:-0.1 has the wrong sign");
        check_range("a=0:1:0.00001", "more than 10000 values");
        check_range("a=0.3-0.9", "a range is START:STOP:STEP");
        check_range("a=0:1:1e-3", "1e-3 is not a valid value");
        check_range("a=.5:1:0.1", "\".5\" in .5:1:0.1 is not a decimal number");
        check_range("a=--1:1:0.1", "\"--1\"");
        check_range("a", "expected NAME=START:STOP:STEP");
        check_range("=1:2:1", "expected NAME=VALUE");
    }

    #[test]
    fn what_is_no_range_is_the_same_at_all_points() {
        let option: SweepOption = "a=0.5".parse().unwrap();
        assert_eq!(option, SweepOption::Fixed("a=0.5".parse().unwrap()));
        let path: SweepOption = "directory=\"c:/models\"".parse().unwrap();
        assert!(matches!(path, SweepOption::Fixed(_)));
    }

    #[test]
    fn a_length_over_a_swept_size_is_tied_to_it() {
        let tied = TiedValue { name: "cells".to_owned(), dividend: 7.2, divisor: "size_m".to_owned() };
        assert_eq!("cells=7.2/size_m".parse(), Ok(SweepOption::Tied(tied)));
        check_refused::<SweepOption>(
            "cells=-7.2/size_m",
            "-7.2/size_m is not NUMBER/SWEPT, a positive number",
        );
        check_refused::<SweepOption>("cells=7.2/", "7.2/ is not NUMBER/SWEPT, a positive number");
    }

    #[test]
    fn a_list_has_every_value_once() {
        let list: ListOption = "foreground=short, refined".parse().unwrap();
        assert_eq!(
            list.0,
            SweptParameter { name: "foreground".to_owned(), values: vec!["short".into(), "refined".into()] }
        );
        check_refused::<ListOption>("xi=2,3,2", "2 is given twice");
        check_refused::<ListOption>("xi=2,,3", "expected NAME=VALUE");
        check_refused::<ListOption>("xi", "expected NAME=VALUE,VALUE");
    }
}
