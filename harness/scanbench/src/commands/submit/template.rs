//! Files with places that are filled in.

/// `template` with a value in each place such as `{{name}}`. What looks like a place in a value stays as it is.
///
/// # Panics
///
/// If a place has no value, or a value has no place: templates are part of the program.
pub fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let has_place = |it: &&(&str, &str)| template.contains(&format!("{{{{{}}}}}", it.0));
    assert!(values.iter().all(|it| has_place(&it)), "a value without a place");
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, place)) = rest.split_once("{{") {
        let (name, after) = place.split_once("}}").expect("a place has an end");
        let value = values.iter().find(|it| it.0 == name).unwrap_or_else(|| panic!("no value for {name}"));
        text += before;
        text += value.1;
        rest = after;
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_not_looked_into() {
        assert_eq!(filled("a {{x}} {{y}} ${z}", &[("x", "{{y}}"), ("y", "b")]), "a {{y}} b ${z}");
    }
}
