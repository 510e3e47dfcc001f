//! A run in one sentence: which detector leads, by how much, how surely, and how long it takes.

use crate::files::fixed_decimals::{fixed_decimals, three_digits};
use crate::verdicts::task_ranking::{Speeds, TaskRanking, end_points, points};
use crate::vocabulary::metric::Metric;

/// The sentence about the `rankings` of all tasks on the same data sets, and the `speeds` there. `None` where nothing can be
/// said of some task: a single detector, undefined rates, suspect labels.
pub fn run_sentence(rankings: &[&TaskRanking], speeds: Option<&Speeds>) -> Option<String> {
    let leads = rankings.iter().map(|it| Lead::of(it)).collect::<Option<Vec<_>>>()?;
    let (first, _) = leads.split_first()?;
    let times = times(&leads, speeds);
    if leads.iter().all(|it| it.is_sure() && it.first == first.first) {
        let by = leads.iter().map(Lead::by).collect::<Vec<_>>().join(", ");
        return Some(format!("{} leads {by}{times}.", first.first));
    }
    if leads.iter().all(|it| it.is_tie() && it.pair() == first.pair()) {
        let rates = leads.iter().map(|it| format!("in {} {}", it.ranking.task, it.rates(first.first)));
        let (rates, [a, b]) = (rates.collect::<Vec<_>>().join(", "), [first.first, first.second]);
        return Some(format!("{a} and {b} do not differ significantly: {rates}{times}."));
    }
    let parts: Vec<String> = leads.iter().map(Lead::text).collect();
    let mut sentence = parts.join("; ");
    sentence.replace_range(..1, &sentence[..1].to_uppercase());
    Some(format!("{sentence}{times}."))
}

/// The two best detectors of a task.
struct Lead<'a> {
    ranking: &'a TaskRanking,
    first: &'a str,
    second: &'a str,
}

impl<'a> Lead<'a> {
    fn of(ranking: &'a TaskRanking) -> Option<Self> {
        let mut defined = ranking.detectors.iter().filter(|it| it.value.is_some());
        let (first, second) = (defined.next()?, defined.next()?);
        ranking.suspect.is_empty().then_some(Self {
            ranking,
            first: &first.detector,
            second: &second.detector,
        })
    }

    fn is_sure(&self) -> bool {
        self.ranking.lead.as_ref().is_some_and(|it| !it.decides_nothing() && it.is_surely_larger())
    }

    /// Whether there are enough scans to tell the two apart, and these do not.
    fn is_tie(&self) -> bool {
        !self.is_sure() && self.ranking.lead.as_ref().is_some_and(|it| !it.decides_nothing())
    }

    /// The two in alphabetical order.
    fn pair(&self) -> [&'a str; 2] {
        let mut pair = [self.first, self.second];
        pair.sort_unstable();
        pair
    }

    fn rate(&self) -> &'static str {
        if self.ranking.metric == Metric::FRate { "F-rate" } else { "recall" }
    }

    /// The rates of both, that of `named_first` first.
    fn rates(&self, named_first: &str) -> String {
        let mut of_both: Vec<_> = self.ranking.detectors.iter().take(2).collect();
        of_both.sort_by_key(|it| it.detector != named_first);
        let percents = of_both.iter().filter_map(|it| Some(fixed_decimals(100.0 * it.value?, 1)));
        format!("{} {} %", self.rate(), percents.collect::<Vec<_>>().join(" and "))
    }

    /// How far the first is ahead, with the interval.
    fn by(&self) -> String {
        let rate = self.rate();
        let lead = self.ranking.lead.as_ref();
        let difference = lead.map_or_else(String::new, |it| points(it.difference()));
        let interval = lead.and_then(|it| it.interval).map_or_else(String::new, |it| {
            let [low, high] = end_points(it.ends);
            format!(" (95 %: {low} to {high})")
        });
        format!("in {} by {difference} points of {rate} over {}{interval}", self.ranking.task, self.second)
    }

    fn text(&self) -> String {
        let Self { ranking, first, second } = self;
        if self.is_sure() {
            return format!("{first} leads {}", self.by());
        }
        let task = &ranking.task;
        if !self.is_tie() {
            return format!("in {task} these scans are too few to tell {first} from {second}");
        }
        format!("in {task} {first} and {second} do not differ significantly ({})", self.rates(first))
    }
}

/// How long the leading detectors take, as the end of a sentence; empty where that is not known.
fn times(leads: &[Lead<'_>], speeds: Option<&Speeds>) -> String {
    let Some(speeds) = speeds.filter(|it| !it.is_doubted) else { return String::new() };
    let mut named: Vec<&str> = Vec::new();
    for lead in leads {
        let of_lead = if lead.is_tie() { &[lead.first, lead.second][..] } else { &[lead.first] };
        named.extend(of_lead.iter().filter(|it| !named.contains(it)).copied().collect::<Vec<_>>());
    }
    let mean_ms = |name: &str| speeds.means_ms.iter().find(|it| it.0 == name).map(|it| it.1);
    let texts = named.iter().map(|it| Some(format!("{it} takes {} ms a scan", three_digits(mean_ms(it)?))));
    let texts: Vec<String> = texts.flatten().collect();
    if texts.is_empty() { String::new() } else { format!("; {}", texts.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdicts::task_ranking::tests::ranking;
    use crate::vocabulary::task::Task;

    #[test]
    fn a_run_is_one_sentence() {
        let speeds = Speeds {
            on: None,
            means_ms: vec![("grid".to_owned(), 11.6), ("tree".to_owned(), 55.0)],
            is_doubted: false,
        };
        let sure = ranking(&[Some(0.7), Some(0.6)], Some([0.1, 0.05, 0.12]));
        let vehicles = TaskRanking { task: Task::Vehicles, ..sure.clone() };
        assert_eq!(
            run_sentence(&[&sure, &vehicles], Some(&speeds)).unwrap(),
            "grid leads in objects by 10.0 points of F-rate over tree (95 %: 5.0 to 12.0), in vehicles by 10.0 points of F-rate \
             over tree (95 %: 5.0 to 12.0); grid takes 11.6 ms a scan."
        );
        let mut unsure = ranking(&[Some(0.7), Some(0.69)], Some([0.01, -0.005, 0.02]));
        let doubted = Speeds { is_doubted: true, ..speeds.clone() };
        assert_eq!(
            run_sentence(&[&unsure, &vehicles], Some(&doubted)).unwrap(),
            "In objects grid and tree do not differ significantly (F-rate 70.0 and 69.0 %); grid leads in vehicles by 10.0 points of F-rate over tree \
             (95 %: 5.0 to 12.0)."
        );
        let other_order = ranking(&[Some(0.7), Some(0.69)], Some([0.01, -0.005, 0.02]));
        assert_eq!(
            run_sentence(&[&unsure, &TaskRanking { task: Task::Vehicles, ..other_order }], Some(&speeds))
                .unwrap(),
            "grid and tree do not differ significantly: in objects F-rate 70.0 and 69.0 %, in vehicles F-rate 70.0 and 69.0 %; \
             grid takes 11.6 ms a scan, tree takes 55.0 ms a scan."
        );
        unsure.lead = None;
        assert_eq!(
            run_sentence(&[&unsure], None).unwrap(),
            "In objects these scans are too few to tell grid from tree."
        );
        unsure.suspect.push("mine".to_owned());
        assert_eq!(run_sentence(&[&unsure], None), None);
        assert_eq!(run_sentence(&[&ranking(&[Some(0.7), None], None)], None), None);
    }
}
