//! The formats of each kind of content.

use crate::numbers::run_report::RunReport;
use crate::tables::formats::csv::Csv;
use crate::tables::formats::format::Format;
use crate::tables::formats::json::Json;
use crate::tables::formats::junit::JUnit;
use crate::tables::formats::latex::Latex;
use crate::tables::formats::markdown::Markdown;
use crate::tables::formats::services::{BencherMetrics, CustomSmallerIsBetter};
use crate::tables::protocol_table::ProtocolTable;
use crate::tables::task_table::TaskTable;
use crate::verdicts::verdict::Verdict;

/// Files of the table of a task.
pub const TABLE_FORMATS: [&dyn Format<TaskTable>; 3] = [&Csv, &Markdown, &Latex];

/// Files of the table of a protocol of others.
pub fn protocol_formats<'a>() -> [&'a dyn Format<ProtocolTable<'a>>; 3] {
    [&Csv, &Markdown, &Latex]
}

/// Files of a verdict.
pub const VERDICT_FORMATS: [&dyn Format<Verdict>; 3] = [&Json, &Markdown, &JUnit];

/// Files of a report for services that keep numbers over time.
pub const SERVICE_FORMATS: [&dyn Format<RunReport>; 2] = [&CustomSmallerIsBetter, &BencherMetrics];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::sample;

    #[test]
    fn no_two_formats_write_the_same_file() {
        let of_tables = TABLE_FORMATS.map(|it| it.file_name("table_objects"));
        assert_eq!(of_tables, ["table_objects.csv", "table_objects.md", "table_objects.tex"]);
        let of_verdicts = VERDICT_FORMATS.map(|it| it.file_name("gate"));
        assert_eq!(of_verdicts, ["gate.json", "gate.md", "junit.xml"]);
        let of_services = SERVICE_FORMATS.map(|it| it.file_name("gate"));
        assert_eq!(of_services, ["custom-smaller-is-better.json", "bencher.json"]);
    }

    #[test]
    fn every_format_ends_its_last_line() {
        let table = &sample::tables()[0];
        assert!(TABLE_FORMATS.iter().all(|it| it.text(table).ends_with('\n')));
    }
}
