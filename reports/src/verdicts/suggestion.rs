//! What somebody may have meant by a name that there is not.

/// How alike two names have to be, from 0 to 1, for one to be a slip of the other.
const LEAST_LIKENESS: f64 = 0.6;

/// `; did you mean …?` with the name of `known` that is most like `name`, or a list of them if none is.
pub(super) fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a String>) -> String {
    let known: Vec<&String> = known.collect();
    let likeness = |it: &&&String| strsim::normalized_damerau_levenshtein(name, it);
    match known.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b))) {
        Some(closest) if likeness(&closest) >= LEAST_LIKENESS => format!("; did you mean {closest:?}?"),
        Some(_) => {
            let known: Vec<&str> = known.iter().map(|it| it.as_str()).collect();
            format!("; choose from {}", known.join(", "))
        }
        None => String::new(),
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
    fn a_slip_is_told_from_another_name() {
        check("al", "; did you mean \"all\"?");
        check("range/0-20", "; did you mean \"range/0-15\"?");
        check("clas/car", "; did you mean \"class/car\"?");
        check("occlusion/none", "; choose from all, range/0-15, range/15-30, class/car");
    }
}
