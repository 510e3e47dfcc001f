//! Recommendations of a sweep, and how far they can be trusted.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::sweep_curve::{CurvePoint, SweepCurve};
use crate::numbers::sweep_score::{SweepScore, SweepScores};

/// The 95 % interval of the rate of the first score minus that of the second, both of the same draws of the same scans;
/// `None` where there is none.
pub type Paired<'a> = &'a dyn Fn([&SweepScore; 2]) -> Option<[f64; 2]>;

/// The rate of the scores of one curve where each block of scans is judged at the value that the others choose; `None` where
/// there is none.
pub type HeldOut<'a> = &'a dyn Fn(&[&SweepScore]) -> Option<f64>;

/// The caveat of every sweep that has a best value.
const OPTIMISTIC: &str = "The best value of a sweep looks better on the scans that chose it than it is: run it on other scans before you \
                          rely on its rate.";

/// A text for every detector and task: the best value over all data sets of one origin with its rate, and the values that
/// cannot be distinguished from it. Then what holds for all of them.
pub fn recommendations(sweep: &SweepScores, paired: Paired<'_>, held_out: HeldOut<'_>) -> Vec<String> {
    let curves = sweep.curves();
    let is_widest = |it: &&SweepCurve<'_>| {
        let ours = &it.first().subject;
        let is_wider = |other: &SweepCurve<'_>| {
            let subject = &other.first().subject;
            subject.extent.is_overall() && subject.origin == ours.origin
        };
        ours.extent.is_overall() || !curves.iter().any(is_wider)
    };
    let mut texts: Vec<String> = curves
        .iter()
        .filter(is_widest)
        .filter_map(|it| recommendation(sweep, it, paired, held_out))
        .collect();
    if !texts.is_empty() {
        texts.push(OPTIMISTIC.to_owned());
    }
    texts
}

fn recommendation(
    sweep: &SweepScores,
    curve: &SweepCurve<'_>,
    paired: Paired<'_>,
    held_out: HeldOut<'_>,
) -> Option<String> {
    let first = curve.first();
    let best = curve.best()?;
    let percent = |it: f64| fixed_decimals(100.0 * it, 1);
    let within = best.reached.rate_within().map_or_else(String::new, |[low, high]| {
        let caveat = first.blocks.caveat_of_conclusions().map_or_else(String::new, |it| format!(", {it}"));
        format!(" ({} to {}{caveat})", percent(low), percent(high))
    });
    let scores: Vec<&SweepScore> = curve.points.iter().map(|it| it.reached).collect();
    let elsewhere = held_out(&scores).map_or_else(String::new, |it| {
        format!("; {} % if each block of scans is judged at the value that the others choose", percent(it))
    });
    let detector = curve.named(&first.subject.detector);
    let is_best =
        |it: &&String| *it == best.x_text || it.parse::<f64>().is_ok_and(|it| (it - best.x).abs() < 1e-9);
    let configured = sweep.configured.as_ref().filter(|it| !is_best(it));
    let configured = configured.map_or_else(String::new, |it| format!(" (configured: {it})"));
    Some(format!(
        "Best for {detector}, {}, {}: {} = {}{configured}, {} {} %{within}{elsewhere}. {}",
        first.task,
        first.subject.extent.name(),
        sweep.parameters[0],
        best.x_text,
        first.rate_name(),
        percent(best.reached.rate()?),
        about_others(curve, best, paired)
    ))
}

/// The values that the scans cannot distinguish from the best one.
fn about_others(curve: &SweepCurve<'_>, best: &CurvePoint<'_, SweepScore>, paired: Paired<'_>) -> String {
    if let Some(shortfall) = best.reached.blocks.shortfall() {
        let (head, rest) = shortfall.split_at(shortfall.chars().next().map_or(0, char::len_utf8));
        return format!("{}{rest} to distinguish any other value from it.", head.to_uppercase());
    }
    let others = || curve.points.iter().filter(|it| it.x_text != best.x_text && it.reached.rate().is_some());
    let is_like = |it: &&CurvePoint<'_, SweepScore>| {
        paired([best.reached, it.reached]).is_none_or(|[low, high]| low <= 0.0 && high >= 0.0)
    };
    let like: Vec<&str> = others().filter(is_like).map(|it| it.x_text).collect();
    match (like.len(), others().count()) {
        (_, 0) => "No other value has a rate.".to_owned(),
        (0, _) => "All other values are significantly worse on these scans.".to_owned(),
        (n, all) if n == all => "These scans cannot distinguish any of the other values from it.".to_owned(),
        _ => format!("These scans cannot distinguish from it: {}.", like.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind};
    use crate::numbers::sweep_score::tests::cell_sizes;

    fn sweep(n_blocks: u64) -> SweepScores {
        let mut sweep =
            cell_sizes(&[(4, Some(6), None, 0.1), (8, Some(2), None, 0.3), (7, Some(3), None, 0.4)]);
        for it in &mut sweep.scores {
            it.blocks = BlockCount::of_dataset(n_blocks, BlockKind::Drives);
        }
        sweep
    }

    fn said_of(n_blocks: u64, paired: Paired<'_>) -> String {
        recommendations(&sweep(n_blocks), paired, &|_| None).remove(0)
    }

    #[test]
    fn values_that_the_scans_cannot_tell_from_the_best_are_named() {
        let rate = |it: &SweepScore| it.rate().unwrap_or_default();
        let within = |width: f64| {
            move |[best, other]: [&SweepScore; 2]| {
                let difference = rate(best) - rate(other);
                Some([difference - width, difference + width])
            }
        };
        assert_eq!(
            said_of(12, &within(0.2)),
            "Best for hierarchical, objects, street: hierarchical.grid.cell_size_m = 0.4, F-rate 80.0 % (10.0 to 90.0). \
             These scans cannot distinguish from it: 0.6."
        );
        assert!(
            said_of(12, &within(0.01)).ends_with("All other values are significantly worse on these scans.")
        );
        assert!(
            said_of(12, &within(0.9))
                .ends_with("These scans cannot distinguish any of the other values from it.")
        );
        assert!(
            said_of(12, &|_| None)
                .ends_with("These scans cannot distinguish any of the other values from it.")
        );
    }

    #[test]
    fn few_blocks_tell_nothing_and_the_optimism_is_said_once() {
        assert!(
            said_of(4, &|_| Some([0.1, 0.2]))
                .ends_with("4 blocks of scans are too few to distinguish any other value from it.")
        );
        let all = recommendations(&sweep(12), &|_| None, &|scores| (scores.len() == 3).then_some(0.7));
        assert!(all[0].contains("(10.0 to 90.0); 70.0 % if each block of scans is judged at"), "{all:?}");
        assert_eq!(all.iter().filter(|it| *it == OPTIMISTIC).count(), 1);
    }
}
