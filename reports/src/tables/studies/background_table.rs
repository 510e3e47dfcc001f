//! How a classifier of vehicles fares against each kind of background.

use crate::files::fixed_decimals::percent;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Sheet, Tabular};

/// Objects that were classified.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Classified {
    /// Number of objects.
    pub n: u64,
    /// Number of these that are classified as vehicles.
    pub n_vehicle: u64,
}

impl Classified {
    /// The share that is classified as vehicles; `None` of none.
    pub fn share(self) -> Option<f64> {
        (self.n > 0).then(|| self.n_vehicle as f64 / self.n as f64)
    }
}

/// Clusters of vehicles, and each kind of background.
#[derive(Debug, Clone, PartialEq)]
pub struct BackgroundTable {
    /// Clusters that show a vehicle.
    pub vehicles: Classified,
    /// Each kind of background, with its name.
    pub backgrounds: Vec<(String, Classified)>,
}

impl BackgroundTable {
    /// The F-rate of the classifier on all vehicles and as many objects of a background: with r and f the shares of vehicles
    /// and of background that are classified as vehicles, 2 r / (1 + r + f).
    fn f_rate_of_equal_numbers(&self, background: Classified) -> Option<f64> {
        let (found, taken) = (self.vehicles.share()?, background.share()?);
        Some(2.0 * found / (1.0 + found + taken))
    }

    /// The F-rate on all vehicles and all of a background, as many as there are.
    fn f_rate(&self, background: Classified) -> Option<f64> {
        let n = self.vehicles.n + self.vehicles.n_vehicle + background.n_vehicle;
        (self.vehicles.n > 0).then(|| 2.0 * self.vehicles.n_vehicle as f64 / n as f64)
    }
}

impl Tabular for BackgroundTable {
    fn sheet(&self) -> Sheet {
        let cell = |it: Option<f64>| Cell::new(it.map_or_else(|| "–".to_owned(), percent));
        let line = |(name, it): &(String, Classified)| {
            let rates = [it.share(), self.f_rate_of_equal_numbers(*it), self.f_rate(*it)].map(cell);
            let head = [name.clone(), it.n.to_string()].map(Cell::new);
            Line { kind: LineKind::Dataset, cells: head.into_iter().chain(rates).collect() }
        };
        let columns = vec![
            Column::left("background"),
            Column::number("objects"),
            Column::number("classified as vehicles %"),
            Column::number("F-rate %, as many as vehicles"),
            Column::number("F-rate %, all of them"),
        ];
        let lines = self.backgrounds.iter().map(line).collect();
        let notes = vec![format!(
            "The good-faith classifier on clusters of paper: it classifies {} % of {} vehicles as vehicles. cut region: background cut out at \
             random, as in the training set of VM 6; other cluster: what else the detector finds; fragment: parts of vehicles. Vehicles that \
             segmentation misses do not count here.",
            self.vehicles.share().map_or_else(|| "–".to_owned(), percent),
            self.vehicles.n,
        )];
        Sheet::of(
            "The background that the classifier is judged by".to_owned(),
            Grid { columns, lines },
            notes,
        )
        .labelled("backgrounds")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;

    #[test]
    fn easy_background_gives_a_better_rate_than_the_same_number_of_hard_ones() {
        let of = |n, n_vehicle| Classified { n, n_vehicle };
        let table = BackgroundTable {
            vehicles: of(10, 8),
            backgrounds: vec![("cut region".to_owned(), of(20, 0)), ("other cluster".to_owned(), of(30, 6))],
        };
        // 2 * 0.8 / 1.8 and 2 * 0.8 / 2; 16 / 18 and 16 / 24.
        let text = Markdown.text(&table);
        assert!(text.contains("| cut region | 20 | 0.0 | 88.9 | 88.9 |"), "{text}");
        assert!(text.contains("| other cluster | 30 | 20.0 | 80.0 | 66.7 |"), "{text}");
        let empty = BackgroundTable { vehicles: of(0, 0), ..table };
        assert!(Markdown.text(&empty).contains("| cut region | 20 | 0.0 | – | – |"));
    }
}
