//! A verdict of few lines.

use super::*;
use crate::tables::verdict::brief::{Brief, Purpose};

fn brief(verdict: &Verdict) -> String {
    let in_full = "scanbench gate runs/after --baseline runs/before --full";
    let sides = ["runs/after", "runs/before"];
    Terminal { width: Some(80) }.text(&Brief { verdict, sides, purpose: Purpose::Gate { in_full } })
}

#[test]
fn a_verdict_in_brief_names_losses_and_gains_with_their_intervals() {
    let run = SampleScans { tp_of: &|step| seven_or_five(step) - 1, ms_of: Some(&|_| 20.0), ..USUAL };
    let verdict = judge(&USUAL.archive(), &run.archive(), &Tolerances::built_in(&USUAL.archive())).unwrap();
    insta::assert_snapshot!(brief(&verdict), @r"
    FAILED: worse
    Judged: runs/after against runs/before, kd-tree, pca on 30 scans of main_road.
    18 numbers: 4 worse, 0 inconclusive, 0 missing. Results changed on 30 scans: 30
      objects that count otherwise.
    4 numbers changed; of these up to 0.1 are called worse by chance, on average.
    Tolerances: built in, because the baseline has no tolerances.toml. rates: 1.00
      points; entropies: 0.02 nats or 10 %; recall of slices: 2.00 points; time: 50
      %.

    All losses:
    - recall, pca, objects: 60.0 → 50.0 %, −10.00 (95 % −10.00 to −10.00, tolerated
      1.00): worse
    - f_rate, pca, objects: 66.7 → 58.8 %, −7.84 (95 % −8.21 to −7.50, tolerated
      1.00): worse
    - precision, pca, objects: 75.0 → 71.4 %, −3.57 (95 % −3.99 to −3.22, tolerated
      1.00): worse
    - time, pca: 20.00 → 40.00 times grid-write, 100 % slower (95 % 100 to 100 %,
      tolerated 50 %): worse
    Most results changed on main_road/0000/000000, pca, objects: 1 object.
    In full: scanbench gate runs/after --baseline runs/before --full
    ");
    assert_eq!((verdict.n_worse(), verdict.n_at_risk()), (4, 4));
    // The other way round all of it is gained.
    let before = run.archive();
    let better = judge(&before, &USUAL.archive(), &Tolerances::built_in(&before)).unwrap();
    let text = brief(&better);
    let (_, gains) = text.split_once("\nThe 3 largest of 4 gains, in tolerances:\n").unwrap();
    assert!(gains.starts_with("- recall, pca, objects: 50.0 → 60.0 %, +10.00 (95 % +10.00 to +10.00, tolerated\n  1.00): better\n"), "{gains}");
    assert!(!text.contains("losses:"), "{text}");
    assert!(Markdown.text(&better).contains("| better |"), "{}", Markdown.text(&better));
    let same = judged(&USUAL);
    assert_eq!((same.n_worse(), same.n_at_risk()), (0, 0), "what is the same is no matter of chance");
    insta::assert_snapshot!(brief(&same), @r"
    PASSED
    Judged: runs/after against runs/before, kd-tree, pca on 30 scans of main_road.
    4 numbers: 0 worse, 0 inconclusive, 0 missing. No result changed.
    Tolerances: tolerances.toml.

    In full: scanbench gate runs/after --baseline runs/before --full
    ");
}

/// However much is changed or missing.
#[test]
fn a_verdict_in_brief_has_thirty_lines_of_eighty_characters_at_most() {
    let run = SampleScans { tp_of: &|step| u64::from(step % 3), fo: None, ms_of: None, n_scans: 9 };
    let after = run.archive();
    let before = SampleScans { n_scans: 9, ..USUAL }.archive();
    let tolerances = Tolerances::built_in(&before);
    let verdict = judge(&before, &after, &tolerances).unwrap();
    let text = brief(&verdict);
    assert!(verdict.n(Finding::Incomparable) > 3, "{text}");
    assert!(text.lines().count() <= 30, "{}\n{text}", text.lines().count());
    assert!(text.lines().all(|it| it.chars().count() <= 80), "{text}");
    assert!(text.contains("more numbers are missing."), "{text}");
}

/// Without known times of the scans no loss is sure, however large it is.
#[test]
fn scans_that_may_be_neighbours_show_no_loss() {
    let without_times = |mut archive: RunArchive| {
        archive.scans.iter_mut().for_each(|it| it.time_s = None);
        archive
    };
    let run = SampleScans { tp_of: &|step| seven_or_five(step) - 4, ..USUAL };
    let [before, after] = [USUAL.archive(), run.archive()].map(without_times);
    let verdict = judge(&before, &after, &tolerances()).unwrap();
    assert_eq!((verdict.conclusion(), verdict.n_at_risk()), (Conclusion::Drift, 0));
    assert!(verdict.n(Finding::Inconclusive) > 0 && verdict.n_worse() == verdict.n(Finding::Inconclusive));
    let text = brief(&verdict);
    check_holds(&text, "These scans may be neighbours, because their times are not known");
    check_holds(&Markdown.text(&verdict), "inconclusive: scans may be neighbours");
    check_holds(&JUnit.text(&verdict), "inconclusive, scans may be neighbours: ");
    // With times they are the same scans, but their intervals would be others.
    let reasons = against_usual(&after).unwrap_err().to_string();
    check_holds(&reasons, "the time of scan 0000/000000 of main_road changed");
    let said = "No loss will be sure: scans without known times, which may be neighbours, are not enough to show one.";
    assert_eq!(least_losses(&before, &tolerances()).lines(), [said]);
}
