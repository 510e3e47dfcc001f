//! A search for the best joint setting of open values: from the best setting of a Latin hypercube, one value after another.

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;

use super::open_values::{OpenRange, OpenValue};
use super::settings::Shares;

/// Initial step, as a share of a range.
const FIRST_STEP: f64 = 0.25;

/// The search ends when the step is below this share of a range.
const LEAST_STEP: f64 = 0.01;

/// A search from one setting, in rounds: each round tries the best setting with one value changed, and the setting with all
/// changes that helped in the round before.
#[derive(Debug, Clone)]
pub struct CoordinateSearch<'a> {
    values: &'a [OpenValue],
    best: Shares,
    best_rate: f64,
    step: f64,
    // All changes of the latest round that helped.
    together: Option<Shares>,
    rng: ChaCha8Rng,
}

impl<'a> CoordinateSearch<'a> {
    /// A search over `values` from the setting `best`, whose mean rate is `best_rate`. If a round may not try all changes,
    /// `seed` decides which ones it tries.
    pub fn from(values: &'a [OpenValue], best: Shares, best_rate: f64, seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { values, best, best_rate, step: FIRST_STEP, together: None, rng }
    }

    /// The best setting so far, and its mean rate.
    pub fn best(&self) -> (&Shares, f64) {
        (&self.best, self.best_rate)
    }

    /// The settings of the next round, at most `most`; empty once the step is too small to matter.
    pub fn round(&mut self, most: usize) -> Vec<Shares> {
        if self.step < LEAST_STEP {
            return Vec::new();
        }
        let mut settings: Vec<Shares> = Vec::new();
        for (value_idx, value) in self.values.iter().enumerate() {
            for share in moved(value.range, self.best[value_idx], self.step) {
                let mut setting = self.best.clone();
                setting[value_idx] = share;
                settings.push(setting);
            }
        }
        settings.shuffle(&mut self.rng);
        settings.splice(0..0, self.together.take());
        settings.truncate(most);
        settings
    }

    /// Continues from the best tried setting of a round, each with its mean rate; halves the step if none was better.
    pub fn take(&mut self, tried: &[(Shares, f64)]) {
        let before = self.best.clone();
        let better: Vec<&(Shares, f64)> = tried.iter().filter(|(_, rate)| *rate > self.best_rate).collect();
        let Some((setting, rate)) = better.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a })
        else {
            self.step /= 2.0;
            return;
        };
        // Worse changes first, so that of two changes of one value the better one stays.
        let mut ascending = better.clone();
        ascending.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut together = before.clone();
        for (changed, _) in ascending {
            for (share, (old, new)) in together.iter_mut().zip(before.iter().zip(changed)) {
                *share = if old == new { *share } else { *new };
            }
        }
        self.together = Some(together).filter(|it| it != setting);
        (self.best, self.best_rate) = (setting.clone(), *rate);
    }
}

/// Shares that a value can move to from a share of its range: each other word, or up and down by `step`.
fn moved(range: OpenRange, share: f64, step: f64) -> Vec<f64> {
    let now = range.at(share);
    let shares: Vec<f64> = match range {
        OpenRange::Words(words) => {
            (0..words.len()).map(|idx| (idx as f64 + 0.5) / words.len() as f64).collect()
        }
        OpenRange::Numbers { .. } => [share - step, share + step].map(|it| it.clamp(0.0, 0.999)).to_vec(),
    };
    // A short step may not change a whole number.
    shares.into_iter().filter(|it| range.at(*it) != now).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn number(parameter: &'static str) -> OpenValue {
        let range = OpenRange::Numbers { low: 0.0, high: 1.0, is_whole: false, is_log: false };
        OpenValue { parameter, said: "", range }
    }

    const VALUES: [OpenValue; 4] = [
        number("a"),
        number("b"),
        number("c"),
        OpenValue { parameter: "word", said: "", range: OpenRange::Words(&["x", "y", "z"]) },
    ];

    /// Greatest, 1, at a = 0.3, b = 0.3 + (a − 0.3), c = 0.9 and the word z: a and b only go together.
    fn rate(shares: &Shares) -> f64 {
        let [a, b, c, word] = shares[..] else { panic!("{shares:?}") };
        let word = if VALUES[3].range.at(word) == "z" { 0.0 } else { 0.2 };
        1.0 - word - (a - b).powi(2) - 0.2 * (a - 0.3).powi(2) - (c - 0.9).powi(2)
    }

    /// The best setting after `n_rounds` of at most `most` settings.
    fn searched(most: usize, n_rounds: usize) -> (Shares, f64) {
        let start = vec![0.9, 0.1, 0.2, 0.1];
        let start_rate = rate(&start);
        let mut search = CoordinateSearch::from(&VALUES, start, start_rate, 1);
        for _ in 0..n_rounds {
            let settings = search.round(most);
            let tried: Vec<(Shares, f64)> = settings.into_iter().map(|it| (it.clone(), rate(&it))).collect();
            search.take(&tried);
        }
        let (best, best_rate) = search.best();
        (best.clone(), best_rate)
    }

    #[test]
    fn values_and_words_come_to_their_best_also_where_they_depend_on_each_other() {
        let (best, best_rate) = searched(usize::MAX, 40);
        assert!(best_rate > 0.99, "{best_rate} at {best:?}");
        assert_eq!(VALUES[3].range.at(best[3]), "z");
    }

    #[test]
    fn no_round_makes_the_best_worse_and_the_same_seed_gives_the_same() {
        let rates: Vec<f64> = (0..20).map(|n_rounds| searched(5, n_rounds).1).collect();
        assert!(rates.is_sorted(), "{rates:?}");
        assert!(rates[19] > rates[0]);
        assert_eq!(searched(5, 19), searched(5, 19));
    }

    #[test]
    fn a_search_ends_where_nothing_is_better() {
        let start = vec![0.3, 0.3, 0.9, 0.9];
        let start_rate = rate(&start);
        let mut search = CoordinateSearch::from(&VALUES, start.clone(), start_rate, 1);
        let mut n_rounds = 0;
        loop {
            let settings = search.round(usize::MAX);
            if settings.is_empty() {
                break;
            }
            n_rounds += 1;
            search.take(&settings.iter().map(|it| (it.clone(), rate(it))).collect::<Vec<_>>());
        }
        assert!(n_rounds < 10);
        assert_eq!(search.best().0, &start);
    }

    #[test]
    fn a_step_that_changes_no_whole_number_is_not_tried() {
        let range = OpenRange::Numbers { low: 4.0, high: 8.0, is_whole: true, is_log: false };
        assert_eq!(moved(range, 0.5, 0.05), Vec::<f64>::new());
        assert_eq!(moved(range, 0.5, 0.2).len(), 2);
        assert_eq!(moved(range, 0.0, 0.2), [0.2]);
    }
}
