//! Files with placeholders that are filled in.

/// `template` with a value in each placeholder such as `{{name}}`. Placeholders within a value stay as they are.
///
/// # Panics
///
/// If a placeholder has no value, or a value has no placeholder: templates are part of the program.
pub fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let has_placeholder = |it: &&(&str, &str)| template.contains(&format!("{{{{{}}}}}", it.0));
    assert!(values.iter().all(|it| has_placeholder(&it)), "a value without a placeholder");
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, placeholder)) = rest.split_once("{{") {
        let (name, after) = placeholder.split_once("}}").expect("a placeholder has an end");
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
