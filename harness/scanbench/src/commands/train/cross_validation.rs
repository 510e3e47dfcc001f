//! Which parameters of a support vector machine are best on drives that it has not seen.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

use detector::classify::nu_svc_solver::NuSvcParams;
use detector::classify::nu_svm::NuSvm;
use detector::classify::svm_training::train_svm;
use detector::describe::object_describer::ObjectDescriber;
use evaluation::training::candidates::Candidate;
use evaluation::training::described_object::DescribedObject;
use evaluation::training::operating_curves::OperatingCurves;
use evaluation::training::selection::select;
use rayon::prelude::*;

use crate::commands::failure::Failure;
use crate::commands::progress::progress_over_results;
use crate::commands::train::data::nothing;

/// The drives are parted into so many parts.
const N_FOLDS: usize = 5;

/// Somebody asked for an end.
#[derive(Debug, thiserror::Error)]
#[error("interrupted during cross-validation")]
struct Interrupted;

/// What is learned from, and how much of it.
pub struct FoldedCandidates<'a> {
    /// Candidates of training drives.
    pub taught: &'a [&'a Candidate],
    /// Most vehicles, and most others for each.
    pub numbers: (usize, f64),
    /// Seed of the choice of examples.
    pub seed: u64,
}

/// Objects that one fold learns from, and those that it is judged by.
type Fold<const D: usize> = [Vec<DescribedObject<D>>; 2];

impl FoldedCandidates<'_> {
    /// The one of `pairs` with the greatest mean area below the precision-recall curve over five parts of the drives, each judged by a
    /// classifier that learned from the other four, and a table of all in words. `describer_of` makes what sees of an object what the
    /// classifier looks at, of the candidates that are learned from.
    pub fn best<const D: usize, S: ObjectDescriber<D>>(
        &self,
        pairs: &[NuSvcParams],
        describer_of: impl Fn(&[&Candidate]) -> Result<S, Failure>,
        interrupted: &AtomicBool,
    ) -> Result<(NuSvcParams, String), Failure> {
        let folds: Vec<Fold<D>> =
            (0..N_FOLDS).map(|it| self.fold(it, &describer_of)).collect::<Result<_, _>>()?;
        let progress = progress_over_results(pairs.len() * N_FOLDS, 0, "cross-validation");
        let jobs: Vec<(&NuSvcParams, &Fold<D>)> =
            pairs.iter().flat_map(|pair| folds.iter().map(move |fold| (pair, fold))).collect();
        let areas: Vec<Result<[f64; 2], Failure>> = jobs
            .into_par_iter()
            .with_max_len(1)
            .map(|(params, [learned, judged])| {
                if interrupted.load(Ordering::Relaxed) {
                    return Err(Failure::Interrupted(Interrupted.into()));
                }
                let areas = areas(params, learned, judged, S::NAMES);
                progress.inc(1);
                areas
            })
            .collect();
        progress.finish_and_clear();
        let areas: Vec<[f64; 2]> = areas.into_iter().collect::<Result<_, _>>()?;
        let mean = |of: &[[f64; 2]], idx: usize| of.iter().map(|it| it[idx]).sum::<f64>() / of.len() as f64;
        let means: Vec<[f64; 2]> = areas.chunks(N_FOLDS).map(|it| [mean(it, 0), mean(it, 1)]).collect();
        // The first of equals.
        let best = (0..pairs.len()).rev().max_by(|&a, &b| means[a][1].total_cmp(&means[b][1]));
        let mut text = format!("Areas below the curves, mean of {N_FOLDS} parts of the training drives:\n");
        for (params, [roc, precision_recall]) in pairs.iter().zip(&means) {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "  nu {}, gamma {}: ROC {roc:.4}, precision-recall {precision_recall:.4}",
                params.nu, params.gamma
            );
        }
        let best = pairs[best.expect("there is a pair")];
        let _ = writeln!(text, "Taken: nu {}, gamma {}\n", best.nu, best.gamma);
        Ok((best, text))
    }

    fn fold<const D: usize, S: ObjectDescriber<D>>(
        &self,
        fold_idx: usize,
        describer_of: impl Fn(&[&Candidate]) -> Result<S, Failure>,
    ) -> Result<Fold<D>, Failure> {
        let mut drives: Vec<&str> = self.taught.iter().map(|it| it.sequence.as_str()).collect();
        drives.sort_unstable();
        drives.dedup();
        if drives.len() < N_FOLDS {
            let problem = format!("{} drives cannot be parted into {N_FOLDS}", drives.len());
            return Err(nothing(&problem).into());
        }
        let is_judged = |it: &&&Candidate| {
            drives.binary_search(&it.sequence.as_str()).is_ok_and(|idx| idx % N_FOLDS == fold_idx)
        };
        let (judged, learned): (Vec<&Candidate>, Vec<&Candidate>) =
            self.taught.iter().copied().partition(|it| is_judged(&it));
        let mut describer = describer_of(&learned)?;
        let mut described = |candidates: &[&Candidate]| -> Vec<DescribedObject<D>> {
            candidates.iter().filter_map(|it| DescribedObject::of(it, &mut describer)).collect()
        };
        let selected = select(&learned, self.numbers, self.seed);
        Ok([described(&selected), described(&judged)])
    }
}

/// Below the ROC curve and below the precision-recall curve.
fn areas<const D: usize>(
    params: &NuSvcParams,
    learned: &[DescribedObject<D>],
    judged: &[DescribedObject<D>],
    names: [&'static str; D],
) -> Result<[f64; 2], Failure> {
    let vectors: Vec<[f32; D]> = learned.iter().map(|it| it.features).collect();
    let are_vehicles: Vec<bool> = learned.iter().map(|it| it.is_vehicle).collect();
    let model = train_svm(&vectors, &are_vehicles, names, params).map_err(|error| nothing(&error))?;
    let svm = NuSvm::new(&model);
    let curves = OperatingCurves::of(judged.iter().map(|it| (svm.decision(&it.features), it.is_vehicle)));
    let missing = || nothing(&"a part of the drives has no vehicle, or nothing else");
    Ok([curves.roc_area().ok_or_else(missing)?, curves.precision_recall_area().ok_or_else(missing)?])
}
