//! Choice of the parameters of a support vector machine that are best on drives that it has not seen.

use std::collections::BTreeSet;
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

use crate::plumbing::failure::Failure;
use crate::plumbing::progress::progress_over_results;
use crate::verbs::train::data::nothing;

/// Largest number of parts that the drives are divided into.
const MOST_FOLDS: usize = 5;

/// The user asked for an end.
#[derive(Debug, thiserror::Error)]
#[error("interrupted during cross-validation")]
struct Interrupted;

/// Candidates to learn from, and how many of them are used.
pub struct FoldedCandidates<'a> {
    /// Candidates of training drives.
    pub taught: &'a [&'a Candidate],
    /// The data set of each.
    pub datasets: &'a [&'a str],
    pub most_vehicles: usize,
    /// Most others for each vehicle.
    pub others_per_vehicle: f64,
    /// Seed of the choice of examples.
    pub seed: u64,
}

/// Objects that one fold learns from, and those that it is judged by.
type Fold<const D: usize> = [Vec<DescribedObject<D>>; 2];

impl FoldedCandidates<'_> {
    /// The one of `pairs` with the greatest mean area below the precision-recall curve over five parts of the drives, or
    /// fewer of fewer drives, each judged by a classifier that learned from the others, and a table of all in words.
    /// `describer_of` makes the describer of objects from the candidates that are learned from.
    pub fn best<const D: usize, S: ObjectDescriber<D>>(
        &self,
        pairs: &[NuSvcParams],
        describer_of: impl Fn(&[&Candidate]) -> Result<S, Failure>,
        interrupted: &AtomicBool,
    ) -> Result<(NuSvcParams, String), Failure> {
        let drive_of_candidate: Vec<(&str, &str)> =
            self.datasets.iter().zip(self.taught).map(|(dataset, it)| (*dataset, &*it.sequence)).collect();
        let drives: Vec<(&str, &str)> =
            drive_of_candidate.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
        let n_folds = drives.len().min(MOST_FOLDS);
        if n_folds < 2 {
            return Err(nothing(&"one training drive cannot be parted; give one --nu and one --gamma").into());
        }
        let fold_of = |drive: &(&str, &str)| drives.binary_search(drive).map_or(0, |it| it % n_folds);
        let folds_of_candidates: Vec<usize> = drive_of_candidate.iter().map(fold_of).collect();
        let folds: Vec<Fold<D>> = (0..n_folds)
            .map(|it| self.fold(&folds_of_candidates, it, &describer_of))
            .collect::<Result<_, _>>()?;
        let progress = progress_over_results(pairs.len() * n_folds, 0, "cross-validation");
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
        let means: Vec<[f64; 2]> = areas.chunks(n_folds).map(|it| [mean(it, 0), mean(it, 1)]).collect();
        // The first of equals.
        let best = (0..pairs.len()).rev().max_by(|&a, &b| means[a][1].total_cmp(&means[b][1]));
        let mut text = format!("Areas below the curves, mean of {n_folds} parts of the training drives:\n");
        for (params, [roc, precision_recall]) in pairs.iter().zip(&means) {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "  nu {}, gamma {}: ROC {roc:.4}, precision-recall {precision_recall:.4}",
                params.nu, params.gamma
            );
        }
        let best = pairs[best.expect("there is a pair")];
        let _ = writeln!(text, "Chosen: nu {}, gamma {}\n", best.nu, best.gamma);
        Ok((best, text))
    }

    fn fold<const D: usize, S: ObjectDescriber<D>>(
        &self,
        folds_of_candidates: &[usize],
        fold_idx: usize,
        describer_of: impl Fn(&[&Candidate]) -> Result<S, Failure>,
    ) -> Result<Fold<D>, Failure> {
        let of = |is_judged: bool| -> Vec<&Candidate> {
            let of_fold = folds_of_candidates.iter().zip(self.taught);
            of_fold.filter(|it| (*it.0 == fold_idx) == is_judged).map(|it| *it.1).collect()
        };
        let [learned, judged] = [false, true].map(of);
        let mut describer = describer_of(&learned)?;
        let mut described = |candidates: &[&Candidate]| -> Vec<DescribedObject<D>> {
            candidates.iter().filter_map(|it| DescribedObject::of(it, &mut describer)).collect()
        };
        let selected = select(&learned, self.most_vehicles, self.others_per_vehicle, self.seed);
        Ok([described(&selected), described(&judged)])
    }
}

/// Areas below the ROC curve and below the precision-recall curve.
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
