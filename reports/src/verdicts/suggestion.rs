//! Suggestions for an unknown name.

/// How similar two names have to be, from 0 to 1, for one to be a typing error of the other.
const LEAST_LIKENESS: f64 = 0.6;

/// The name of `known` that `name` may be a typing error of.
pub fn closest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let likeness = |it: &&str| strsim::normalized_damerau_levenshtein(name, it);
    known.max_by(|a, b| likeness(a).total_cmp(&likeness(b))).filter(|it| likeness(it) >= LEAST_LIKENESS)
}

/// `; did you mean …?` with the name of `known` that is most like `name`, or a list of them if none is.
pub(super) fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a String>) -> String {
    let known: Vec<&str> = known.map(String::as_str).collect();
    match closest(name, known.iter().copied()) {
        Some(closest) => format!("; did you mean {closest:?}?"),
        None if known.is_empty() => String::new(),
        None => format!("; choose from {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(name: &str, expected: &str) {
        let known = ["all", "range/0-15", "range/15-30", "class/car"].map(str::to_owned);
        assert_eq!(did_you_mean(name, known.iter()), expected);
    }

    #[test]
    fn a_slip_and_another_name_are_distinguished() {
        check("al", "; did you mean \"all\"?");
        check("range/0-20", "; did you mean \"range/0-15\"?");
        check("clas/car", "; did you mean \"class/car\"?");
        check("occlusion/none", "; choose from all, range/0-15, range/15-30, class/car");
    }
}
