//! Ground points, by three definitions: rates of all points together, and their means over scans.

use std::collections::BTreeMap;

use super::protocol_number::ProtocolMetric;
use super::scan_terms::{ScanTerms, mean_and_deviation, moments, ratio};
use super::under_protocol::UnderProtocol;
use crate::rows::label_score_row::{GroundCounts, LabelScore};
use crate::rows::scan_name::ScanName;
use crate::vocabulary::ground_definition::GroundDefinition;
use crate::vocabulary::metric::Direction::{HigherIsBetter, LowerIsBetter};

const N_DEFINITIONS: usize = GroundDefinition::ALL.len();
/// Found, false, missed and other points, and moments of four rates of a scan.
const N_TERMS_OF_ONE: usize = 4 + 3 * N_RATES;
const N_TERMS: usize = N_DEFINITIONS * N_TERMS_OF_ONE;

/// Rates that are published as means over scans, too.
const N_RATES: usize = 4;
const RATES: [&str; N_RATES] = ["precision", "recall", "f1", "accuracy"];

/// The classified points of one scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct ScoredGround {
    by_definition: BTreeMap<GroundDefinition, GroundCounts>,
}

impl ScoredGround {
    /// Adds a score; those of other protocols change nothing.
    pub(super) fn add(&mut self, score: &LabelScore) {
        if let LabelScore::Ground(definition, counts) = score {
            self.by_definition.insert(*definition, *counts);
        }
    }

    fn terms(&self) -> [f64; N_TERMS] {
        let mut all = [0.0; N_TERMS];
        for (index, definition) in GroundDefinition::ALL.into_iter().enumerate() {
            let Some(counts) = self.by_definition.get(&definition) else { continue };
            let GroundCounts { n_found, n_false, n_missed, n_others } = *counts;
            let counts = [n_found, n_false, n_missed, n_others].map(|it| it as f64);
            let terms = counts.into_iter().chain(rates(counts).into_iter().flat_map(moments));
            let own = &mut all[index * N_TERMS_OF_ONE..][..N_TERMS_OF_ONE];
            own.iter_mut().zip(terms).for_each(|(it, term)| *it = term);
        }
        all
    }
}

/// The [`RATES`] of found, false, missed and other points.
fn rates([n_found, n_false, n_missed, n_others]: [f64; 4]) -> [Option<f64>; N_RATES] {
    [
        ratio(n_found, n_found + n_false),
        ratio(n_found, n_found + n_missed),
        ratio(2.0 * n_found, 2.0 * n_found + n_false + n_missed),
        ratio(n_found + n_others, n_found + n_false + n_missed + n_others),
    ]
}

/// Sums of one detector over scans.
pub(super) struct Ground {
    terms: ScanTerms<N_TERMS>,
}

impl Ground {
    /// Takes the rows of `scans`, which ascend.
    pub(super) fn new(scans: &[ScanName], rows: &BTreeMap<ScanName, ScoredGround>) -> Self {
        Self { terms: ScanTerms::new(scans, rows, ScoredGround::terms) }
    }
}

impl UnderProtocol for Ground {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        let total = self.terms.total();
        let of_definition = |(index, definition): (usize, GroundDefinition)| {
            let own = &total[index * N_TERMS_OF_ONE..][..N_TERMS_OF_ONE];
            let metric = |id: &str, direction, n: f64| {
                ProtocolMetric::new(definition.name(), (id, "ratio", direction), n as u64)
            };
            let n_points = own[..4].iter().sum();
            let of_points = RATES.into_iter().chain(["iou"]);
            let mut metrics: Vec<ProtocolMetric> =
                of_points.map(|id| metric(id, HigherIsBetter, n_points)).collect();
            for (index, id) in RATES.into_iter().enumerate() {
                let n_scans = own[4 + 3 * index];
                metrics.push(metric(&format!("{id}_per_scan"), HigherIsBetter, n_scans));
                metrics.push(metric(&format!("{id}_per_scan_deviation"), LowerIsBetter, n_scans));
            }
            metrics
        };
        GroundDefinition::ALL.into_iter().enumerate().flat_map(of_definition).collect()
    }

    fn values(&self, times: &[u16]) -> Vec<Option<f64>> {
        let sums = self.terms.sums(times);
        let of_definition = |own: &[f64]| {
            let [n_found, n_false, n_missed, n_others] = [own[0], own[1], own[2], own[3]];
            let mut values = rates([n_found, n_false, n_missed, n_others]).to_vec();
            values.push(ratio(n_found, n_found + n_false + n_missed));
            let moments = own[4..].as_chunks::<3>().0;
            values.extend(moments.iter().flat_map(|it| mean_and_deviation(*it)));
            values
        };
        sums.chunks_exact(N_TERMS_OF_ONE).flat_map(of_definition).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::label_score_row::tests::row;

    #[test]
    fn rates_are_of_all_points_and_means_over_scans() {
        let counts = [
            GroundCounts { n_found: 8, n_false: 2, n_missed: 0, n_others: 10 },
            GroundCounts { n_found: 1, n_false: 0, n_missed: 1, n_others: 0 },
            // Without ground and predicted ground: neither precision nor recall.
            GroundCounts { n_found: 0, n_false: 0, n_missed: 0, n_others: 5 },
        ];
        let (mut rows, mut names) = (BTreeMap::new(), Vec::new());
        for (scan, counts) in (0..).zip(counts) {
            let row = row(scan, LabelScore::Ground(GroundDefinition::GroundGrid, counts));
            let mut scored = ScoredGround::default();
            scored.add(&row.score);
            names.push(row.scan.clone());
            rows.insert(row.scan, scored);
        }
        let under = Ground::new(&names, &rows);
        let (metrics, values) = (under.metrics(), under.values(&[1, 1, 1]));
        assert_eq!(metrics.len(), values.len());
        let of = |id: &str| {
            let index = metrics.iter().position(|it| it.class == "groundgrid" && it.id == id).unwrap();
            (values[index], metrics[index].n)
        };
        assert_eq!(of("precision"), (Some(9.0 / 11.0), 27));
        assert_eq!(of("recall"), (Some(0.9), 27));
        assert_eq!(of("f1"), (Some(18.0 / 21.0), 27));
        assert_eq!(of("accuracy"), (Some(24.0 / 27.0), 27));
        assert_eq!(of("iou"), (Some(0.75), 27));
        assert_eq!(of("precision_per_scan"), (Some(0.9), 2));
        assert_eq!(of("recall_per_scan"), (Some(0.75), 2));
        assert_eq!(of("recall_per_scan_deviation"), (Some(0.25), 2));
        assert_eq!(of("accuracy_per_scan").1, 3);
        // Definitions without rows are undefined, not 0.
        assert_eq!(values[0], None);
    }
}
