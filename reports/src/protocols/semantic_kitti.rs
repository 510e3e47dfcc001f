//! Scores of SemanticKITTI's instances: association, unknown quality, panoptic quality of things, entropies.
//!
//! Nunes et al.: Unsupervised Class-Agnostic Instance Segmentation of 3D LiDAR Data for Autonomous Vehicles, 2022, for the
//! association. Wong et al.: Identifying Unknown Instances for Autonomous Driving, 2019, for unknown quality. Kirillov et
//! al.: Panoptic Segmentation, CVPR 2019, as semantic-kitti-api has it. Oh et al.: TRAVEL, RA-L 2022, as
//! `continuous_clustering` has it, for entropies.

use std::collections::BTreeMap;

use super::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolMetric};
use super::scan_terms::{ScanTerms, mean_and_deviation, moments, ratio};
use super::under_protocol::UnderProtocol;
use crate::rows::label_score_row::{InstanceScore, LabelScore, SegmentationEntropies, ThingCounts};
use crate::rows::scan_name::ScanName;
use crate::vocabulary::metric::Direction::{self, HigherIsBetter, LowerIsBetter};
use crate::vocabulary::thing_class::ThingClass;

/// The association is published of all instances, and of those with more points than this.
const FEW_POINTS: u64 = 50;

const N_CLASSES: usize = ThingClass::ALL.len();
/// Number, association, matched ones and their overlaps: of all instances, and of those with more than [`FEW_POINTS`].
const N_INSTANCE_TERMS: usize = 8;
/// Matched, missed, false, overlaps of each class.
const N_THING_TERMS: usize = 4 * N_CLASSES;
/// Moments of OSE and USE of a scan.
const N_ENTROPY_TERMS: usize = 6;
const N_TERMS: usize = N_INSTANCE_TERMS + N_THING_TERMS + N_ENTROPY_TERMS;

const OF_INSTANCES: [(&str, Direction); 6] = [
    ("s_assoc", HigherIsBetter),
    ("s_assoc_over_50_points", HigherIsBetter),
    ("unknown_quality", HigherIsBetter),
    ("unknown_quality_over_50_points", HigherIsBetter),
    ("unknown_recall", HigherIsBetter),
    ("unknown_recall_over_50_points", HigherIsBetter),
];

const OF_SCANS: [&str; 4] =
    ["ose_per_scan_nats", "ose_per_scan_deviation_nats", "use_per_scan_nats", "use_per_scan_deviation_nats"];

const OF_THINGS: [&str; 3] = ["pq", "sq", "rq"];

/// Scores of the labels of one scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct ScoredLabels {
    // By label, so that the order of rows does not show.
    instances: BTreeMap<u32, InstanceScore>,
    things: BTreeMap<ThingClass, ThingCounts>,
    entropies: Option<SegmentationEntropies>,
}

impl ScoredLabels {
    /// Adds a score; those of other protocols change nothing.
    pub(super) fn add(&mut self, score: &LabelScore) {
        match score {
            LabelScore::Instance(it) => {
                self.instances.insert(it.label, *it);
            }
            LabelScore::Things(class, it) => {
                self.things.insert(*class, *it);
            }
            LabelScore::Entropies(it) => self.entropies = Some(*it),
            LabelScore::Ground(..) => {}
        }
    }

    fn terms(&self) -> [f64; N_TERMS] {
        let mut of_instances = [0.0; N_INSTANCE_TERMS];
        for it in self.instances.values() {
            let terms = [
                1.0,
                it.association,
                f64::from(it.matched_iou.is_some()),
                it.matched_iou.unwrap_or_default(),
            ];
            for (index, term) in terms.into_iter().enumerate() {
                of_instances[index] += term;
                of_instances[4 + index] += if it.n_points > FEW_POINTS { term } else { 0.0 };
            }
        }
        let of_class = |class: ThingClass| {
            let ThingCounts { n_matched, n_missed, n_false, iou_sum } =
                self.things.get(&class).copied().unwrap_or_default();
            [n_matched as f64, n_missed as f64, n_false as f64, iou_sum]
        };
        let entropies = self.entropies.map(|it| [it.over_nats, it.under_nats]);
        let of_scan = [0, 1].map(|it| moments(entropies.map(|nats| nats[it])));
        let terms = of_instances
            .into_iter()
            .chain(ThingClass::ALL.into_iter().flat_map(of_class))
            .chain(of_scan.into_iter().flatten());
        let mut all = [0.0; N_TERMS];
        all.iter_mut().zip(terms).for_each(|(it, term)| *it = term);
        all
    }
}

/// Sums of one detector over scans.
pub(super) struct SemanticKitti {
    terms: ScanTerms<N_TERMS>,
    has_classes: bool,
}

impl SemanticKitti {
    /// Takes the rows of `scans`, which ascend.
    pub(super) fn new(scans: &[ScanName], rows: &BTreeMap<ScanName, ScoredLabels>) -> Self {
        Self {
            terms: ScanTerms::new(scans, rows, ScoredLabels::terms),
            has_classes: rows.values().any(|it| !it.things.is_empty()),
        }
    }
}

/// Counts of one class, summed.
#[derive(Debug, Clone, Copy)]
struct ClassSums {
    n_matched: f64,
    n_missed: f64,
    n_false: f64,
    iou_sum: f64,
}

impl ClassSums {
    fn all(terms: &[f64; N_TERMS]) -> [Self; N_CLASSES] {
        std::array::from_fn(|class| {
            let index = N_INSTANCE_TERMS + 4 * class;
            let [n_matched, n_missed, n_false, iou_sum] = std::array::from_fn(|it| terms[index + it]);
            Self { n_matched, n_missed, n_false, iou_sum }
        })
    }

    fn is_present(&self) -> bool {
        self.n_matched + self.n_missed > 0.0
    }

    /// PQ, SQ and RQ; `None` for a class without labelled or found segments.
    fn qualities(&self) -> Option<[f64; 3]> {
        let recognition = ratio(self.n_matched, self.n_matched + 0.5 * (self.n_false + self.n_missed))?;
        let segmentation = ratio(self.iou_sum, self.n_matched).unwrap_or_default();
        Some([segmentation * recognition, segmentation, recognition])
    }
}

/// Mean qualities of `classes`; a class without segments has 0, as the makers take it.
fn mean_qualities(classes: &[ClassSums]) -> [Option<f64>; 3] {
    std::array::from_fn(|index| {
        let qualities = classes.iter().map(|it| it.qualities().unwrap_or_default()[index]);
        ratio(qualities.sum(), classes.len() as f64)
    })
}

impl UnderProtocol for SemanticKitti {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        let metric = |class: &str, id: &str, unit, direction, n: f64| {
            ProtocolMetric::new(class, (id, unit, direction), n as u64)
        };
        let total = self.terms.total();
        let n_instances = [total[0], total[4]];
        let n_scans = total[N_INSTANCE_TERMS + N_THING_TERMS];
        let mut metrics: Vec<ProtocolMetric> = OF_INSTANCES
            .iter()
            .enumerate()
            .map(|(index, (id, direction))| {
                metric(ALL_CLASSES, id, "ratio", *direction, n_instances[index % 2])
            })
            .collect();
        metrics.extend(OF_SCANS.map(|id| metric(ALL_CLASSES, id, "nats", LowerIsBetter, n_scans)));
        if self.has_classes {
            let classes = ClassSums::all(&total);
            let n_of = |it: &ClassSums| it.n_matched + it.n_missed;
            let n_all = classes.iter().map(n_of).sum();
            let of_several = [ALL_CLASSES, PRESENT_CLASSES].map(|name| (name, n_all));
            let of_one = ThingClass::ALL.into_iter().zip(&classes).filter(|(_, it)| it.is_present());
            let named = of_several.into_iter().chain(of_one.map(|(class, it)| (class.name(), n_of(it))));
            metrics
                .extend(named.flat_map(|(class, n)| {
                    OF_THINGS.map(|id| metric(class, id, "ratio", HigherIsBetter, n))
                }));
        }
        metrics
    }

    fn values(&self, times: &[u16]) -> Vec<Option<f64>> {
        let sums = self.terms.sums(times);
        let of_instances = |index: usize| [0, 4].map(|first| ratio(sums[first + index], sums[first]));
        // Association; overlaps of matched instances, over all: recall times their mean overlap; recall.
        let mut values: Vec<Option<f64>> = [1, 3, 2].into_iter().flat_map(of_instances).collect();
        for index in [0, 3] {
            let first = N_INSTANCE_TERMS + N_THING_TERMS + index;
            values.extend(mean_and_deviation([sums[first], sums[first + 1], sums[first + 2]]));
        }
        if self.has_classes {
            let classes = ClassSums::all(&sums);
            // Classes present in all scans, so that each draw has the same numbers.
            let has_any = ClassSums::all(&self.terms.total()).map(|it| it.is_present());
            let present: Vec<ClassSums> =
                classes.iter().zip(has_any).filter(|(_, has_any)| *has_any).map(|(it, _)| *it).collect();
            let there: Vec<ClassSums> = present.iter().copied().filter(ClassSums::is_present).collect();
            values.extend(mean_qualities(&classes));
            values.extend(mean_qualities(&there));
            for class in &present {
                let qualities = class.qualities();
                values.extend((0..OF_THINGS.len()).map(|index| qualities.map(|it| it[index])));
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::label_score_row::tests::row;
    use proptest::prelude::*;

    /// The numbers of scans, each with its scores, by class and name.
    fn numbers(scans: &[&[LabelScore]], times: &[u16]) -> BTreeMap<(String, String), (Option<f64>, u64)> {
        let mut rows: BTreeMap<ScanName, ScoredLabels> = BTreeMap::new();
        let mut names = Vec::new();
        for (scan, scores) in (0..).zip(scans) {
            names.push(row(scan, LabelScore::Entropies(SegmentationEntropies::default())).scan);
            for score in *scores {
                rows.entry(row(scan, *score).scan).or_default().add(score);
            }
        }
        let under = SemanticKitti::new(&names, &rows);
        let (metrics, values) = (under.metrics(), under.values(times));
        assert_eq!(metrics.len(), values.len());
        metrics.into_iter().zip(values).map(|(it, value)| ((it.class, it.id), (value, it.n))).collect()
    }

    /// Instances of one scan have different numbers of points here, and these for labels.
    fn instance(n_points: u64, association: f64, matched_iou: Option<f64>) -> LabelScore {
        let label = 10 + ((n_points as u32) << 16);
        LabelScore::Instance(InstanceScore { label, n_points, association, matched_iou })
    }

    fn entropies(over_nats: f64, under_nats: f64) -> LabelScore {
        LabelScore::Entropies(SegmentationEntropies { n_objects: 1, over_nats, n_segments: 1, under_nats })
    }

    fn things(class: ThingClass, [n_matched, n_missed, n_false]: [u64; 3], iou_sum: f64) -> LabelScore {
        LabelScore::Things(class, ThingCounts { n_matched, n_missed, n_false, iou_sum })
    }

    #[test]
    fn association_is_the_mean_over_instances_of_all_scans() {
        let scans: [&[LabelScore]; 2] = [
            &[instance(51, 0.9, Some(0.8)), instance(50, 0.3, None), entropies(1.0, 4.0)],
            &[instance(99, 0.5, None), entropies(3.0, 4.0)],
        ];
        let of = |times: &[u16], id: &str| numbers(&scans, times)[&("all".to_owned(), id.to_owned())];
        let third = |sum: f64| (Some(sum / 3.0), 3);
        assert_eq!(of(&[1, 1], "s_assoc"), third(0.9 + 0.3 + 0.5));
        assert_eq!(of(&[1, 1], "s_assoc_over_50_points"), (Some(0.7), 2));
        assert_eq!(of(&[1, 1], "unknown_quality"), third(0.8));
        assert_eq!(of(&[1, 1], "unknown_recall_over_50_points"), (Some(0.5), 2));
        assert_eq!(of(&[1, 1], "ose_per_scan_nats"), (Some(2.0), 2));
        assert_eq!(of(&[1, 1], "ose_per_scan_deviation_nats"), (Some(1.0), 2));
        assert_eq!(of(&[1, 1], "use_per_scan_deviation_nats"), (Some(0.0), 2));
        // The second scan three times.
        assert_eq!(of(&[0, 3], "s_assoc").0, Some(0.5));
        assert_eq!(of(&[0, 0], "s_assoc").0, None);
        assert!(!numbers(&scans, &[1, 1]).contains_key(&("all".to_owned(), "pq".to_owned())));
    }

    proptest! {
        #[test]
        fn the_order_of_rows_changes_nothing(
            scores in prop::collection::btree_map((0_u32..4, 1_u64..200), 0.0_f64..1.0, 0..40),
            seed in any::<u64>(),
        ) {
            let rows: Vec<_> =
                scores.iter().map(|((scan, n), it)| row(*scan, instance(*n, *it, (*it > 0.5).then_some(*it)))).collect();
            let mut shuffled = rows.clone();
            shuffled.sort_by_key(|it| match it.score {
                LabelScore::Instance(score) => (u64::from(score.label) << 8 | u64::from(it.scan.scan)) ^ seed,
                _ => seed,
            });
            let values = |rows: &[crate::rows::label_score_row::LabelScoreRow]| {
                let mut by_scan: BTreeMap<ScanName, ScoredLabels> = BTreeMap::new();
                for it in rows {
                    by_scan.entry(it.scan.clone()).or_default().add(&it.score);
                }
                let names: Vec<ScanName> = by_scan.keys().cloned().collect();
                SemanticKitti::new(&names, &by_scan).values(&vec![1; names.len()])
            };
            prop_assert_eq!(values(&shuffled), values(&rows));
        }
    }

    #[test]
    fn classes_of_which_nothing_is_labelled_are_0_of_all_and_not_among_the_present() {
        // Of cars 3 of 4 with an overlap of 0.8 each, and one false; a false person.
        let scan = [things(ThingClass::Car, [3, 1, 1], 2.4), things(ThingClass::Person, [0, 0, 1], 0.0)];
        let of =
            |class: &str, id: &str| numbers(&[&scan], &[1]).get(&(class.to_owned(), id.to_owned())).copied();
        let close = |found: Option<(Option<f64>, u64)>, value: f64| {
            assert!((found.unwrap().0.unwrap() - value).abs() < 1e-12, "{found:?} {value}");
        };
        close(of("car", "rq"), 0.75);
        close(of("car", "sq"), 0.8);
        close(of("car", "pq"), 0.6);
        close(of("present", "pq"), 0.6);
        close(of("all", "pq"), 0.6 / 8.0);
        assert_eq!(of("person", "pq"), None);
    }
}
