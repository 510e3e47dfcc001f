//! What the program does before it gets to work.

use crate::program::Workplace;

#[test]
fn a_model_may_come_from_files() {
    let workplace = Workplace::with_drive(1);
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../detector/src/params");
    let directory = format!("vehicle_model.groupings_directory={shipped:?}");
    let detect = |options: &[&str]| {
        let arguments = [&["detect", "street", "--scan", "0", "-d", "hierarchical"], options].concat();
        workplace.succeed(&arguments);
    };
    detect(&["-P", &directory, "-o", "of_files.csv"]);
    detect(&["-o", "shipped.csv"]);
    assert_eq!(workplace.read("of_files.csv"), workplace.read("shipped.csv"));
}

#[test]
fn errors_of_the_command_line_come_before_anything_is_loaded() {
    let workplace = Workplace::new();
    // No model can be read from there, but that is found out later.
    let broken = ["-P", "vehicle_model.groupings_directory=\"/nowhere\""];
    for (arguments, exit_code, part) in [
        (vec!["run", "street-narrow", "-d", "nonsense"], 2, "nonsense"),
        (vec!["run", "street-narrow", "-P", "nonsense=1"], 2, "nonsense"),
    ] {
        let arguments = [&arguments[..], &broken[..]].concat();
        let ended = workplace.end_with(&arguments, exit_code, &[]);
        assert!(ended.stderr.contains(part) && !ended.stderr.contains("nowhere"), "{ended:#?}");
    }
}
