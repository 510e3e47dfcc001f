//! Numbers of protocols of a sweep as curves over its first parameter.

use super::protocol_number::ProtocolNumber;
use super::swept_numbers::{SweptNumber, SweptNumbers};
use crate::numbers::sweep_curve::{Curve, curves, highest};
use crate::vocabulary::extent::Extent;
use crate::vocabulary::metric::Direction;
use crate::vocabulary::protocol::Protocol;

/// One number of one detector.
pub type NumberCurve<'a> = Curve<'a, &'a SweptNumber>;

impl SweptNumbers {
    /// The curves of those principal numbers that are defined somewhere, in the order of their first points.
    pub fn principal_curves(&self) -> Vec<NumberCurve<'_>> {
        let principal = self.numbers.iter().filter(|it| it.number.is_principal()).map(|it| {
            let ProtocolNumber { protocol, dataset, detector, metric, .. } = &it.number;
            (&it.subject.values[..], (protocol, dataset, detector, &metric.class, &metric.id), it)
        });
        let mut curves = curves(&self.parameters, self.n_swept, principal);
        curves.retain(|it| it.points.iter().any(|it| it.reached.number.value.is_some()));
        curves
    }

    /// The protocols, each with what it was evaluated on, in the order of the numbers.
    pub fn extents(&self) -> Vec<(Protocol, &Extent)> {
        let mut extents: Vec<(Protocol, &Extent)> = Vec::new();
        for it in &self.numbers {
            let extent = (it.number.protocol, &it.subject.extent);
            if !extents.contains(&extent) {
                extents.push(extent);
            }
        }
        extents
    }
}

impl NumberCurve<'_> {
    /// Index of the point with the best value, the first of several; `None` without a value, or where neither way is better.
    pub fn best(&self) -> Option<usize> {
        self.extreme(1.0)
    }

    /// Index of the point with the worst value.
    pub fn worst(&self) -> Option<usize> {
        self.extreme(-1.0)
    }

    fn extreme(&self, sign: f64) -> Option<usize> {
        let sign = match self.first().number.metric.direction {
            Direction::HigherIsBetter => sign,
            Direction::LowerIsBetter => -sign,
            Direction::Neither => return None,
        };
        let value = |it: &ProtocolNumber| it.value.map(|it| sign * it);
        highest(self.points.iter().map(|it| value(&it.reached.number)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocols::swept_numbers::tests::swept;

    #[test]
    fn a_curve_is_of_a_principal_number_that_is_known() {
        let numbers = swept(&[Some(0.25), None, Some(0.5), Some(0.5)]);
        let curves = numbers.principal_curves();
        assert_eq!(curves.len(), 1);
        let xs: Vec<f64> = curves[0].points.iter().map(|it| it.x).collect();
        assert_eq!(xs, [0.1, 0.2, 0.3, 0.4]);
        assert_eq!((curves[0].best(), curves[0].worst()), (Some(2), Some(0)));
        assert_eq!(swept(&[None, None]).principal_curves(), []);
        let street = Extent::Dataset("street".to_owned());
        assert_eq!(numbers.extents(), [(Protocol::Nuscenes, &street)]);
    }

    #[test]
    fn of_errors_the_least_is_best() {
        let mut numbers = swept(&[Some(0.25), Some(0.5)]);
        numbers.numbers.retain(|it| it.number.is_principal());
        for it in &mut numbers.numbers {
            it.number.metric.direction = Direction::LowerIsBetter;
        }
        let best = |numbers: &SweptNumbers| numbers.principal_curves()[0].best();
        assert_eq!(best(&numbers), Some(0));
        for it in &mut numbers.numbers {
            it.number.metric.direction = Direction::Neither;
        }
        assert_eq!(best(&numbers), None);
    }

    #[test]
    fn other_parameters_make_other_curves() {
        let mut numbers = swept(&[Some(0.25), Some(0.5)]);
        numbers.parameters.push("a.xi".to_owned());
        numbers.n_swept = 2;
        for (index, it) in numbers.numbers.iter_mut().enumerate() {
            it.subject.values = vec!["word".to_owned(), (index / 2 + 2).to_string()];
        }
        let curves = numbers.principal_curves();
        let others: Vec<String> = curves.iter().map(|it| it.others.join(", ")).collect();
        assert_eq!(others, ["xi = 2", "xi = 3"]);
        assert_eq!((curves[1].points[0].x, curves[1].points[0].x_text), (0.0, "word"));
    }
}
