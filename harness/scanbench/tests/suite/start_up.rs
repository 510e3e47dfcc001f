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
