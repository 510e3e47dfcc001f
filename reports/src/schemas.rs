//! What is in the files of a run, for programs of others: JSON schemas, and the columns of CSV files. The types of this
//! crate say both.

use std::fmt::Write as _;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;

use crate::files::csv_rows::{CsvField, CsvRow};
use crate::numbers::precision_recall_row::PrecisionRecallRow;
use crate::numbers::processor_time_row::ProcessorTimeRow;
use crate::numbers::run_report::ReportRecord;
use crate::rows::agreement_row::AgreementRow;
use crate::rows::box_row::BoxRow;
use crate::rows::confusion_row::ConfusionRow;
use crate::rows::error_row::ErrorRow;
use crate::rows::kitti_object_row::KittiObjectRow;
use crate::rows::label_score_row::LabelScoreRow;
use crate::rows::match_row::MatchRow;
use crate::rows::partial_row::PartialRow;
use crate::rows::pose_row::PoseRow;
use crate::rows::ranked_box_row::RankedBoxRow;
use crate::rows::scan_row::ScanRow;
use crate::rows::stage_row::StageRow;
use crate::rows::training_row::{CalibrationRow, ImportanceRow};
use crate::run_folder::manifest::Manifest;
use crate::tables::formats::csv::{ProtocolRow, TaskRow};
use crate::tables::formats::json::VerdictRecord;
use crate::tables::studies::ablation_score::AblationRow;
use crate::tables::studies::box_error_row::{BoxErrorRow, BoxPointsRow, FittedBoxRow};
use crate::tables::studies::curve_row::CurveRow;
use crate::tables::studies::gap_table::GapRow;
use crate::tables::studies::robustness_table::ConditionRow;
use crate::tables::studies::streaming_table::StreamingRow;
use crate::tables::verdict::comparison::DifferenceRow;
use crate::verdicts::fitness_verdict::FitnessVerdict;

/// JSON files with their schemas (JSON Schema 2020-12), as they are written.
pub fn json_schemas() -> [(&'static str, String); 3] {
    [
        ("report", schema::<ReportRecord>()),
        ("manifest", schema::<Manifest>()),
        ("gate", schema::<VerdictRecord<'_>>()),
    ]
}

fn schema<T: JsonSchema>() -> String {
    let schema = SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>();
    let mut json = serde_json::to_string_pretty(&schema).expect("a schema is JSON");
    json.push('\n');
    json
}

/// CSV files with the verb that writes them and their fields, in the order of a page.
pub fn csv_files() -> Vec<(&'static str, &'static str, &'static [CsvField])> {
    fn file<Row: CsvRow>(
        verb: &'static str,
        name: &'static str,
    ) -> (&'static str, &'static str, &'static [CsvField]) {
        (verb, name, Row::FIELDS)
    }
    vec![
        file::<MatchRow>("run", "matches.csv"),
        file::<ScanRow>("run", "scans.csv"),
        file::<StageRow>("run", "stages.csv"),
        file::<PoseRow>("run", "poses.csv"),
        file::<ErrorRow>("run", "errors.csv"),
        file::<ConfusionRow>("run", "confusion.csv"),
        file::<PrecisionRecallRow>("run", "precision_recall.csv"),
        file::<TaskRow>("run", "table_<task>.csv"),
        file::<AgreementRow>("run", "agreement.csv"),
        file::<RankedBoxRow>("run --protocol nuscenes", "protocol_boxes.csv"),
        file::<KittiObjectRow>("run --protocol kitti-object", "protocol_kitti_object.csv"),
        file::<LabelScoreRow>("run --protocol semantic-kitti", "protocol_labels.csv"),
        file::<ProtocolRow>("run --protocol", "table_protocol_<name>.csv"),
        file::<ProcessorTimeRow>("merge", "times_of_processors.csv"),
        file::<DifferenceRow>("compare", "comparison.csv"),
        file::<BoxRow>("detect --boxes", "FILE"),
        file::<FitnessVerdict>("sweep", "cell_fitness.csv"),
        file::<AblationRow>("ablation", "ablation.csv"),
        file::<ConditionRow>("robustness", "robustness.csv"),
        file::<GapRow>("gaps", "gaps.csv"),
        file::<StreamingRow>("streaming", "streaming.csv"),
        file::<FittedBoxRow>("boxes", "boxes.csv"),
        file::<BoxPointsRow>("boxes", "box_points.csv"),
        file::<BoxErrorRow>("boxes", "box_errors.csv"),
        file::<PartialRow>("partial", "partial.csv"),
        file::<CurveRow>("data realism", "realism.csv"),
        file::<ImportanceRow>("train", "importance.csv"),
        file::<CalibrationRow>("train", "calibration.csv"),
    ]
}

/// The columns of all CSV files as a page in Markdown.
pub fn columns_page() -> String {
    let mut page = "# Columns of CSV files\n\nUnits are in the names of columns. A value that does not exist is empty.\n".to_owned();
    for (verb, name, fields) in csv_files() {
        write!(page, "\n## `{name}` of `{verb}`\n\n| column | value | what |\n|---|---|---|\n")
            .expect("a string takes all that is written");
        for field in fields {
            let columns: Vec<String> = field.columns.iter().map(|it| format!("`{it}`")).collect();
            let doc: Vec<&str> = field.doc.iter().map(|it| it.trim()).collect();
            let row = [columns.join(", "), value_of(field.kind), without_links(&doc.join(" "))];
            writeln!(page, "| {} |", row.join(" | ")).expect("a string takes all that is written");
        }
    }
    page
}

/// What a value of a type in Rust is in a file.
fn value_of(kind: &str) -> String {
    let within = |outer: &str| kind.strip_prefix(outer)?.strip_suffix('>');
    if let Some(inner) = within("Option<") {
        return format!("{} or empty", value_of(inner));
    }
    if let Some(decimals) = within("Fixed<") {
        return format!("number, {decimals} decimals");
    }
    if let Some((inner, _)) = kind.strip_prefix('[').and_then(|it| it.split_once(';')) {
        return value_of(inner);
    }
    let known = match kind {
        "String" => "text",
        "bool" => "`true` or `false`",
        "u16" | "u32" | "u64" | "usize" => "integer",
        "Exact" | "f64" | "f32" => "number",
        "BoxColumns" => "number, 4 decimals, or empty",
        "ScanName" => "text, text, integer",
        _ => "name",
    };
    known.to_owned()
}

/// Documentation without the paths that links in it lead to.
fn without_links(doc: &str) -> String {
    let mut text = String::new();
    let mut rest = doc;
    while let Some((before, (link, after))) =
        rest.split_once('[').and_then(|(before, it)| Some((before, it.split_once(']')?)))
    {
        text.push_str(before);
        text.push_str(link);
        rest = after.strip_prefix('(').and_then(|it| it.split_once(')')).map_or(after, |(_, it)| it);
    }
    text + rest
}
