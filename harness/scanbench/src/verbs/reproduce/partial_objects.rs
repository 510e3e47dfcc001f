//! The method of BG on objects of which it sees more and more.

use std::sync::atomic::{AtomicBool, Ordering};

use evaluation::partial::experiment::{Knowledge, ObjectsOf, PartialExperiment, TrainedOn, run};
use evaluation::partial::methods::Method;
use evaluation::partial::object_parts::PartsSeen;
use reports::partial_study::partial_claims::{MeasuredClaim, PartialClaim};
use reports::partial_study::partial_curves::PartialCurve;
use reports::reproduction::judged_claim::Seen;
use reports::reproduction::steps::Basis;
use reports::rows::partial_row::PartialRow;
use reports::vocabulary::partial_class::PartialClass;
use simulator::object_clouds::simulated_objects::{ObjectPart, SimulatedObjects, open_simulated_objects};

use crate::plumbing::failure::Failure;
use crate::plumbing::progress::progress_over_results;
use crate::verbs::partial::shared_objects::Interrupted;

/// Objects that are scanned from all round, as `scanbench partial` has them by default.
const OBJECTS: &str = "objects-around";

/// Answers of the method about objects, by what it learned from and the end that they are seen from.
pub struct PartialObjects {
    n_per_class: u32,
    curves: Vec<PartialCurve>,
}

impl PartialObjects {
    /// Has the method as printed learn from `n_per_class` simulated objects of each class, whole ones as in the paper and
    /// their parts, and judge as many others.
    pub fn judge(n_per_class: u32, interrupted: &AtomicBool) -> Result<Self, Failure> {
        let open = |part: ObjectPart| open_simulated_objects(OBJECTS, part, n_per_class);
        let (training, judged): (SimulatedObjects, SimulatedObjects) =
            (open(ObjectPart::Training)?, open(ObjectPart::Judging)?);
        let object_indices: Vec<usize> = (0..PartialClass::ALL.len() * n_per_class as usize).collect();
        let experiment = PartialExperiment {
            knowledge: Knowledge::Learned {
                training: ObjectsOf { set: &training, object_indices: &object_indices },
                trained_on: &[TrainedOn::Whole, TrainedOn::Parts],
                methods: &[Method::of_paper()],
            },
            judged: ObjectsOf { set: &judged, object_indices: &object_indices },
            judged_parts: PartsSeen::Uncovered,
            classes: &PartialClass::LEARNT,
        };
        let mut rows: Vec<PartialRow> = Vec::new();
        let progress = progress_over_results(experiment.n_answered_objects(), 0, OBJECTS);
        let ended = run(
            &experiment,
            |_, _| false,
            false,
            |it| {
                rows.extend(it.rows);
                progress.inc(1);
                if interrupted.load(Ordering::Relaxed) {
                    let (object_idx, set) = (it.object_idx, OBJECTS.to_owned());
                    return Err(Failure::from(Interrupted { object_idx, set }));
                }
                Ok(())
            },
        );
        progress.finish_and_clear();
        ended?;
        Ok(Self { n_per_class, curves: PartialCurve::all(&rows) })
    }

    /// Readings of `claim`: learned from whole objects first, as in the paper.
    pub fn seen(&self, claim: PartialClaim) -> Vec<Seen> {
        let seen = |(idx, curve): (usize, &PartialCurve)| {
            let MeasuredClaim { holds, number } = claim.measured(curve);
            let reading = format!("learned from {}, seen from {}", curve.trained_on, curve.direction);
            // The paper learns from whole objects; that comes first.
            let basis = if idx == 0 { Basis::Text } else { Basis::Open };
            Seen { reading, basis, numbers: number, difference: String::new(), holds }
        };
        self.curves.iter().enumerate().map(seen).collect()
    }

    /// A note on how the claims were judged.
    pub fn note(&self) -> String {
        let n = self.n_per_class;
        format!(
            "BG: the bag of graphs as printed. It learned from {n} simulated objects of each class, scanned from all round ({OBJECTS}), from whole \
             objects as in the paper or from their parts; {n} others of each class judge it (scanbench partial)."
        )
    }
}
