//! `--protocol`: rows of scans under protocols of others.

use std::collections::{BTreeMap, BTreeSet};

use evaluation::protocols::chosen_protocols::{ChosenProtocols, have_ground};
use evaluation::run::sink::{JudgedScan, WatchedDataset};
use reports::rows::official_rows::OfficialRows;
use reports::rows::ranked_box_row::BoxKind;
use reports::vocabulary::protocol::{Protocol, ProtocolFamily};

use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::{print_detail, print_diagnostic};

/// Evaluates scans under some protocols.
pub struct OfficialEvaluation {
    chosen: ChosenProtocols,
    protocols: Vec<Protocol>,
    dataset: String,
    format: String,
    // By protocol, the names of annotations with the classes that they count as.
    names: BTreeMap<Protocol, BTreeMap<String, String>>,
    // Detectors that did not predict ground in some scan of the data set.
    without_ground: BTreeSet<&'static str>,
}

impl OfficialEvaluation {
    /// An evaluation under `protocols`; `None` if there are none.
    pub fn of(protocols: &[Protocol]) -> Option<Self> {
        let chosen = ChosenProtocols::of(protocols)?;
        let [dataset, format] = [String::new(), String::new()];
        let protocols = protocols.to_vec();
        Some(Self {
            chosen,
            protocols,
            dataset,
            format,
            names: BTreeMap::new(),
            without_ground: BTreeSet::new(),
        })
    }

    pub fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.without_ground.clear();
        self.names.clear();
        let description = watched.dataset.description();
        self.dataset.clone_from(&description.id);
        self.format.clone_from(&description.format);
        Ok(self.chosen.check(watched.dataset)?)
    }

    pub fn rows(&mut self, judged: &JudgedScan<'_>) -> Result<OfficialRows, Failure> {
        let results = judged.results;
        let scan = self.chosen.scan(judged.watched.dataset, judged.scan_idx(), results.scan)?;
        let mut rows = OfficialRows::default();
        for (result, detector) in results.results.iter().zip(results.detectors) {
            let of_detector = scan.rows(result.detector, &**detector, &result.output);
            if self.chosen.ask_for_ground() && !have_ground(&of_detector) {
                self.without_ground.insert(result.detector);
            }
            add_names(&mut self.names, &of_detector);
            rows.append(of_detector);
        }
        Ok(rows)
    }

    /// Prints as which classes names of annotations count, where they are not those of the protocol. Warns of protocols that
    /// evaluate none of them, and of detectors that did not predict what a protocol asks for.
    pub fn end_dataset(&self) {
        let of_boxes = self.protocols.iter().filter(|it| it.family() == ProtocolFamily::RankedBoxes);
        for protocol in of_boxes {
            let id = &self.dataset;
            let Some(names) = self.names.get(protocol) else {
                print_diagnostic(format_args!(
                    "warning: --protocol {protocol} evaluates no class that is annotated in {id:?}: its numbers are undefined"
                ));
                continue;
            };
            let mapped: Vec<String> = names
                .iter()
                .filter(|(name, class)| name != class)
                .map(|(name, class)| format!("{name} as {class}"))
                .collect();
            let line = format!("--protocol {protocol} on {id}: {}", mapped.join(", "));
            // Data sets in the format of the protocol have the names that it knows.
            if !mapped.is_empty() && self.format != protocol.name() {
                print_diagnostic(line);
            } else if !mapped.is_empty() {
                print_detail(line);
            }
        }
        for name in &self.without_ground {
            print_diagnostic(warning_of_no_ground(name));
        }
    }
}

/// Adds the names of the annotations in `rows`, with the classes that they count as.
fn add_names(of_protocols: &mut BTreeMap<Protocol, BTreeMap<String, String>>, rows: &OfficialRows) {
    for row in rows.boxes.iter().filter(|it| it.ranked_box.kind == BoxKind::Annotation) {
        let names = of_protocols.entry(row.protocol).or_default();
        if !names.contains_key(&row.ranked_box.name) {
            names.insert(row.ranked_box.name.clone(), row.ranked_box.class.to_owned());
        }
    }
}

/// The warning that a detector has no numbers of ground.
pub fn warning_of_no_ground(detector: &str) -> String {
    format!(
        "warning: {detector:?} does not predict which points are ground: it has no numbers under the protocol ground"
    )
}
