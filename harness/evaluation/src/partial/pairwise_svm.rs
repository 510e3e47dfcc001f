//! Support vector machines for several classes: one for each pair.

use detector::classify::nu_svc_solver::{NuSvcError, NuSvcParams, Tolerance};
use detector::classify::nu_svm::NuSvm;
use detector::classify::svm_training::train_svm;
use detector::partial::decision::to_probabilities;
use detector::partial::sharpness::{HeldOutScores, learn_sharpness};

/// Width of the kernel, times the number of values, which are standardised.
const GAMMA: f32 = 1.0;
/// The ν of each machine, unless the smaller class requires a lower one.
const NU: f64 = 0.1;
/// Greatest ν, as a share of the largest possible one.
const MOST_NU: f64 = 0.9;
/// Every third group is held out to learn how sure decisions are.
const HOLD_OUT_EVERY: usize = 3;

/// A classifier of `D` values.
#[derive(Debug, Clone, PartialEq)]
pub struct PairwiseSvm<const D: usize> {
    n_classes: usize,
    machines: Vec<(usize, usize, NuSvm<D>)>,
    sharpness: f32,
}

impl<const D: usize> PairwiseSvm<D> {
    /// Trains on vectors and their classes; vectors of one of the `groups` are held out together.
    ///
    /// # Errors
    ///
    /// [`NuSvcError`] if two classes cannot be separated.
    pub fn learned(
        vectors: &[[f32; D]],
        classes: &[usize],
        groups: &[usize],
        n_classes: usize,
    ) -> Result<Self, NuSvcError> {
        let all: Vec<usize> = (0..vectors.len()).collect();
        let (held_out, others): (Vec<usize>, Vec<usize>) =
            all.iter().partition(|&&it| groups[it].is_multiple_of(HOLD_OUT_EVERY));
        let of_others =
            Self { n_classes, machines: machines(vectors, classes, &others, n_classes)?, sharpness: 1.0 };
        let scores =
            |&it: &usize| HeldOutScores { scores: of_others.scores(&vectors[it]), class_idx: classes[it] };
        let sharpness = learn_sharpness(&held_out.iter().map(scores).collect::<Vec<_>>());
        Ok(Self { n_classes, machines: machines(vectors, classes, &all, n_classes)?, sharpness })
    }

    /// The class with most votes, and the probabilities of all classes.
    pub fn judge(&self, vector: &[f32; D]) -> (usize, Vec<f32>) {
        let mut chances = self.scores(vector);
        let best =
            (1..self.n_classes).fold(0, |best, it| if chances[it] > chances[best] { it } else { best });
        to_probabilities(&mut chances, self.sharpness);
        (best, chances)
    }

    /// For each class the votes of its machines, changed by less than one in total by how clear the votes are.
    fn scores(&self, vector: &[f32; D]) -> Vec<f32> {
        let mut scores = vec![0.0; self.n_classes];
        for (first, second, machine) in &self.machines {
            let decision = machine.decision(vector);
            let clear = 0.4 * (decision.abs() / (1.0 + decision.abs())) / self.n_classes as f32;
            let (winner, loser) = if decision > 0.0 { (*first, *second) } else { (*second, *first) };
            scores[winner] += 1.0 + clear;
            scores[loser] -= clear;
        }
        scores
    }
}

fn machines<const D: usize>(
    vectors: &[[f32; D]],
    classes: &[usize],
    taken: &[usize],
    n_classes: usize,
) -> Result<Vec<(usize, usize, NuSvm<D>)>, NuSvcError> {
    let mut machines = Vec::new();
    for second in 0..n_classes {
        for first in 0..second {
            let of_pair = || taken.iter().filter(|&&it| classes[it] == first || classes[it] == second);
            let vectors: Vec<[f32; D]> = of_pair().map(|&it| vectors[it]).collect();
            let is_first: Vec<bool> = of_pair().map(|&it| classes[it] == first).collect();
            machines.push((first, second, machine(&vectors, &is_first)?));
        }
    }
    Ok(machines)
}

fn machine<const D: usize>(vectors: &[[f32; D]], is_first: &[bool]) -> Result<NuSvm<D>, NuSvcError> {
    let n_first = is_first.iter().filter(|&&it| it).count();
    let smaller = n_first.min(is_first.len() - n_first) as f64;
    let most = MOST_NU * 2.0 * smaller / is_first.len().max(1) as f64;
    let params = NuSvcParams {
        gamma: GAMMA / D as f32,
        nu: NU.min(most),
        tolerance: Tolerance::OfGradients(1e-3),
        max_steps: 2_000_000,
    };
    Ok(NuSvm::new(&train_svm(vectors, is_first, [""; D], &params)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_clouds_of_points_are_distinguished_and_middles_are_less_sure() {
        let middles = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]];
        let around = |it: usize| [(it * 7 % 10) as f32 / 10.0, (it * 3 % 10) as f32 / 10.0];
        let vectors: Vec<[f32; 2]> =
            (0..60).map(|it| [0, 1].map(|axis| middles[it % 3][axis] + around(it)[axis])).collect();
        let classes: Vec<usize> = (0..60).map(|it| it % 3).collect();
        let groups: Vec<usize> = (0..60).map(|it| it / 3).collect();
        let svm = PairwiseSvm::learned(&vectors, &classes, &groups, 3).unwrap();
        for (class, middle) in middles.into_iter().enumerate() {
            let (predicted, chances) = svm.judge(&middle.map(|it| it + 0.45));
            assert!(predicted == class && chances[class] > 0.9, "{chances:?}");
        }
        assert!(PairwiseSvm::learned(&vectors[..1], &classes[..1], &groups[..1], 3).is_err());
    }
}
