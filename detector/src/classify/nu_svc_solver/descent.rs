//! Sequential minimal optimisation of the dual problem.

use super::super::kernel_rows::KernelRows;
use super::{NuSvcError, NuSvcParams, NuSvcSolution, Tolerance};

/// The dual problem, and how far it is solved.
pub(super) struct Problem<'a, const D: usize> {
    kernel: KernelRows<'a, D>,
    n_first: usize,
    multipliers: Vec<f64>,
    /// Qα, where Q holds kernels times the signs of both classes.
    gradient: Vec<f64>,
}

/// A multiplier to raise and one to lower by as much.
struct Pair {
    raised: usize,
    lowered: usize,
    /// Difference of their gradients.
    slope: f64,
    curvature: f64,
}

/// State of one class before a step.
struct ClassState {
    /// Least gradient of the multipliers that can be raised, greatest of those that can be lowered.
    ends: [f64; 2],
    best: Option<Pair>,
}

impl<'a, const D: usize> Problem<'a, D> {
    /// Starts with the first vectors of either class as support vectors.
    pub(super) fn new(kernel: KernelRows<'a, D>, n_first: usize, nu: f64) -> Self {
        let n = kernel.len();
        let mut problem = Self { kernel, n_first, multipliers: vec![0.0; n], gradient: vec![0.0; n] };
        for class in problem.classes() {
            let mut left = nu * n as f64 / 2.0;
            for vector_idx in class {
                let multiplier = left.min(1.0);
                if multiplier > 0.0 {
                    problem.multipliers[vector_idx] = multiplier;
                    problem.add_to_gradient(vector_idx, multiplier);
                    left -= multiplier;
                }
            }
        }
        problem
    }

    fn classes(&self) -> [std::ops::Range<usize>; 2] {
        [0..self.n_first, self.n_first..self.multipliers.len()]
    }

    fn add_to_gradient(&mut self, vector_idx: usize, change: f64) {
        self.kernel.prepare([vector_idx]);
        let row = self.kernel.row(vector_idx);
        let is_first = vector_idx < self.n_first;
        let (first, second) = self.gradient.split_at_mut(self.n_first);
        let [to_first, to_second] = if is_first { [change, -change] } else { [-change, change] };
        for (gradient, &kernel) in first.iter_mut().zip(row) {
            *gradient += to_first * f64::from(kernel);
        }
        for (gradient, &kernel) in second.iter_mut().zip(&row[self.n_first..]) {
            *gradient += to_second * f64::from(kernel);
        }
    }

    /// Takes steps until no decision value is farther off than the tolerance, and returns how many.
    pub(super) fn descend(&mut self, params: &NuSvcParams) -> Result<usize, NuSvcError> {
        for n_steps in 0..=params.max_steps {
            let [first, second] = self.classes().map(|class| self.class_state(class));
            let margin = 0.25 * (first.ends.iter().sum::<f64>() + second.ends.iter().sum::<f64>());
            let violation = (first.ends[1] - first.ends[0]).max(second.ends[1] - second.ends[0]);
            let allowed = match params.tolerance {
                Tolerance::OfMargin(share) => share * margin,
                Tolerance::OfGradients(difference) => difference,
            };
            if margin > 0.0 && violation <= allowed {
                return Ok(n_steps);
            }
            let gain = |pair: &Pair| pair.slope * pair.slope / pair.curvature;
            let best = match (first.best, second.best) {
                (Some(a), Some(b)) => Some(if gain(&b) > gain(&a) { b } else { a }),
                (a, b) => a.or(b),
            };
            let Some(pair) = best else { return Err(NuSvcError::NoMargin { n_steps }) };
            if n_steps == params.max_steps {
                let deviation = violation / margin.max(f64::MIN_POSITIVE);
                return Err(NuSvcError::NotConverged { n_steps, deviation });
            }
            self.step(&pair);
        }
        unreachable!("the last round returns")
    }

    fn class_state(&mut self, class: std::ops::Range<usize>) -> ClassState {
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        let mut raised = None;
        for vector_idx in class.clone() {
            let gradient = self.gradient[vector_idx];
            if self.multipliers[vector_idx] < 1.0 && gradient < ends[0] {
                ends[0] = gradient;
                raised = Some(vector_idx);
            }
        }
        let Some(raised) = raised else {
            // All are at their bound: no multiplier of the class can be raised, and its end is the greatest gradient.
            let top = class.map(|it| self.gradient[it]).fold(f64::NEG_INFINITY, f64::max);
            return ClassState { ends: [top, top], best: None };
        };
        self.kernel.prepare([raised]);
        let row = &self.kernel.row(raised)[class.clone()];
        let mut best: Option<(Pair, f64)> = None;
        for (lowered, &kernel) in class.zip(row) {
            if self.multipliers[lowered] <= 0.0 {
                continue;
            }
            let gradient = self.gradient[lowered];
            ends[1] = ends[1].max(gradient);
            let slope = gradient - ends[0];
            if slope > 0.0 {
                let curvature = (2.0 - 2.0 * f64::from(kernel)).max(1e-12);
                let gain = slope * slope / curvature;
                if best.as_ref().is_none_or(|&(_, most)| gain > most) {
                    best = Some((Pair { raised, lowered, slope, curvature }, gain));
                }
            }
        }
        ClassState { ends, best: best.map(|(pair, _)| pair) }
    }

    fn step(&mut self, pair: &Pair) {
        let room = 1.0 - self.multipliers[pair.raised];
        let stock = self.multipliers[pair.lowered];
        let wanted = pair.slope / pair.curvature;
        let change = wanted.min(room).min(stock);
        // At a bound exactly, or a rounding error would keep it among those that can move.
        self.multipliers[pair.raised] = if change == room { 1.0 } else { 1.0 - room + change };
        self.multipliers[pair.lowered] = if change == stock { 0.0 } else { stock - change };
        self.kernel.prepare([pair.raised, pair.lowered]);
        let rows = self.kernel.row(pair.raised).iter().zip(self.kernel.row(pair.lowered));
        let sign = if pair.raised < self.n_first { 1.0 } else { -1.0 };
        for (vector_idx, (gradient, (&up, &down))) in self.gradient.iter_mut().zip(rows).enumerate() {
            let signed = if vector_idx < self.n_first { sign * change } else { -sign * change };
            *gradient += signed * f64::from(up - down);
        }
    }

    /// The gradient at the margin of a class: the mean over free support vectors, else the middle of the possible range.
    fn level(&self, class: std::ops::Range<usize>) -> f64 {
        let (mut sum, mut n_free) = (0.0, 0);
        let mut bounds = [f64::NEG_INFINITY, f64::INFINITY];
        for (&multiplier, &gradient) in self.multipliers[class.clone()].iter().zip(&self.gradient[class]) {
            if multiplier >= 1.0 {
                bounds[0] = bounds[0].max(gradient);
            } else if multiplier <= 0.0 {
                bounds[1] = bounds[1].min(gradient);
            } else {
                sum += gradient;
                n_free += 1;
            }
        }
        match bounds {
            _ if n_free > 0 => sum / f64::from(n_free),
            [low, high] if low.is_finite() && high.is_finite() => 0.5 * (low + high),
            [low, high] => {
                if low.is_finite() {
                    low
                } else {
                    high
                }
            }
        }
    }

    /// The classifier of the multipliers, for vectors that were brought into this `order`.
    pub(super) fn solution(&self, order: &[usize], n_steps: usize) -> NuSvcSolution {
        let [first, second] = self.classes().map(|class| self.level(class));
        let margin = 0.5 * (first + second);
        let mut coefficients = vec![0.0; order.len()];
        for (index, &vector_idx) in order.iter().enumerate() {
            let sign = if index < self.n_first { 1.0 } else { -1.0 };
            coefficients[vector_idx] = sign * self.multipliers[index] / margin;
        }
        let products = self.multipliers.iter().zip(&self.gradient).map(|(a, b)| a * b);
        NuSvcSolution {
            coefficients,
            rho: 0.5 * (first - second) / margin,
            objective: 0.5 * products.sum::<f64>(),
            n_steps,
        }
    }
}
