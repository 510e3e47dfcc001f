//! Numbers of detectors under a protocol in the classes that they give, in a few columns.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::pools::Pool;
use crate::protocols::given_classes::GivenClasses;
use crate::protocols::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolNumber};
use crate::protocols::protocol_report::ProtocolReport;
use crate::run_folder::manifest::Manifest;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::vocabulary::protocol::Protocol;

/// A line for each detector, on all data sets of one origin together.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtocolInShort {
    /// The protocol.
    pub protocol: Protocol,
    // With the data sets in its title.
    parts: Vec<Part>,
    not_given: Option<String>,
}

impl ProtocolInShort {
    /// The tables of `report`, in the order of protocols.
    pub fn all(report: &ProtocolReport, manifest: &Manifest, given: &GivenClasses) -> Vec<Self> {
        let of_protocol = |protocol: Protocol| {
            let numbers: Vec<&ProtocolNumber> =
                report.rows.iter().filter(|it| it.protocol == protocol).collect();
            let parts = manifest.pools().into_iter().filter_map(|it| part(&numbers, manifest, &it, given));
            Self { protocol, parts: parts.collect(), not_given: not_given(&numbers, protocol, given) }
        };
        let all = Protocol::ALL.into_iter().map(of_protocol);
        all.filter(|it| !it.parts.is_empty() || it.not_given.is_some()).collect()
    }
}

impl Tabular for ProtocolInShort {
    fn sheet(&self) -> Sheet {
        let published = self.protocol.published().map(str::to_owned);
        Sheet::of_parts(self.parts.clone(), self.not_given.iter().cloned().chain(published).collect())
    }
}

/// Whether a number is one of those that a detector is known by: of a class that is given, or of no class.
fn is_shown(number: &ProtocolNumber, given: &GivenClasses) -> bool {
    let (class, id) = (number.metric.class.as_str(), number.metric.id.as_str());
    let protocol = number.protocol;
    if protocol.family().has_classes() {
        protocol.principal_metrics().contains(&id) && given.has(protocol, class)
    } else {
        number.is_principal()
    }
}

fn part(numbers: &[&ProtocolNumber], manifest: &Manifest, pool: &Pool, given: &GivenClasses) -> Option<Part> {
    let dataset = pool.extent.name();
    let shown: Vec<&ProtocolNumber> =
        numbers.iter().copied().filter(|it| it.dataset == dataset && is_shown(it, given)).collect();
    let protocol = shown.first()?.protocol;
    let mut metrics: Vec<&ProtocolNumber> = Vec::new();
    for it in &shown {
        if metrics.iter().all(|known| known.metric != it.metric) {
            metrics.push(it);
        }
    }
    let mut columns = vec![Column::left("detector")];
    for it in &metrics {
        let group = format!("{}, n {}", it.metric.class, it.metric.n);
        columns.push(Column::number(it.metric.id.clone()).within(group.clone()));
        columns.push(Column::number("95 %").within(group));
    }
    let lines = manifest.detectors.iter().map(|detector| {
        let cells = metrics.iter().flat_map(|it| {
            let of_detector =
                shown.iter().find(|other| other.detector == detector.name && other.metric == it.metric);
            of_detector.map_or_else(|| [Cell::new("–"), Cell::default()], |it| number_cells(it))
        });
        let cells = [Cell::new(detector.name.as_str())].into_iter().chain(cells).collect();
        Line { kind: LineKind::Dataset, cells }
    });
    let title = format!("Protocol {protocol} on {}. n: annotations, points or scans.", pool.in_words());
    Some(Part { title: Some(title), grid: Grid { columns, lines: lines.collect() } })
}

/// Classes that are annotated, but that no detector gives.
fn not_given(numbers: &[&ProtocolNumber], protocol: Protocol, given: &GivenClasses) -> Option<String> {
    if !protocol.family().has_classes() {
        return None;
    }
    let mut classes: Vec<&str> = Vec::new();
    for it in numbers {
        let class = it.metric.class.as_str();
        let is_class = ![ALL_CLASSES, PRESENT_CLASSES].contains(&class) && it.metric.n > 0;
        if is_class && !given.has(protocol, class) && !classes.contains(&class) {
            classes.push(class);
        }
    }
    (!classes.is_empty()).then(|| {
        format!(
            "Annotated, but not given by any detector: {} ({protocol}). Means over all classes count them as not found.",
            classes.join(", ")
        )
    })
}

/// The value and its interval.
pub(crate) fn number_cells(number: &ProtocolNumber) -> [Cell; 2] {
    let Some(value) = number.value else { return [Cell::new("–"), Cell::default()] };
    let interval = number.interval.map_or_else(Cell::default, |it| {
        Cell::interval(it.ends.map(|end| fixed_decimals(end, 4)).join(" to "), it.blocks)
    });
    [Cell::new(fixed_decimals(value, 4)), interval]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_published_is_what_the_docs_have() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/published.md");
        let docs = std::fs::read_to_string(path).unwrap();
        let numbers =
            Protocol::ALL.into_iter().filter_map(Protocol::published).flat_map(str::split_whitespace);
        let numbers: Vec<&str> = numbers
            .filter(|it| !it.ends_with('.') && it.contains('.') && it.parse::<f64>().is_ok())
            .collect();
        assert_eq!(numbers.len(), 11, "{numbers:?}");
        assert!(numbers.iter().all(|it| docs.contains(&format!("| {it} |"))), "{numbers:?}");
    }
}
