//! Runs that can be judged by each other.

use super::*;
use crate::run_folder::manifest::{DetectorEntry, ForeignEntry};
use crate::tables::verdict::brief::{Brief, Purpose};
use crate::tables::verdict::comparison::{ComparedSlices, compare_runs};
use crate::verdicts::classes_of_both::with_classes_of_both;

/// The usual run, whose only entry is a foreign `pca`.
fn with_foreign(foreign: ForeignEntry) -> RunArchive {
    let mut run = USUAL.archive();
    run.manifest.detectors = vec![DetectorEntry { foreign: Some(foreign), ..sample::detector("pca") }];
    run
}

#[test]
fn a_detector_that_was_not_run_everywhere_is_not_comparable() {
    let mut run = USUAL.archive();
    run.scans.retain(|it| it.detector == "kd-tree" || it.scan > 0);
    let error = against_usual(&run).unwrap_err().to_string();
    check_holds(&error, "pca was evaluated on 30 scans of main_road in the task objects, and now on 29");
    run.scans.retain(|it| it.detector == "kd-tree");
    assert_eq!(
        against_usual(&run).unwrap_err().to_string(),
        "the runs cannot be compared: the detector pca is only in the earlier run, not in the later one"
    );

    // A new detector has nothing to be judged by, and is named.
    let verdict = judge(&run, &USUAL.archive(), &tolerances()).unwrap();
    check_holds(&printed(&verdict), "Not judged, because only the later run has it: pca.");
    let comparison = compare_runs(&run, &USUAL.archive(), ComparedSlices::All, None).unwrap();
    check_holds(&printed(&comparison), "Not compared, because only the later run has it: pca.");
}

#[test]
fn a_changed_configuration_is_reported_with_both_values() {
    let with = |it: &str| with_foreign(ForeignEntry { vehicles: it.to_owned(), ..ForeignEntry::default() });
    let (before, after) = (with("size"), with("model"));
    let verdict = judge(&before, &after, &tolerances()).unwrap();
    let purpose = Purpose::Gate { in_full: "gate --full" };
    let brief = Brief { verdict: &verdict, sides: ["run", "baseline"], purpose };
    let comparison = compare_runs(&before, &after, ComparedSlices::All, None).unwrap();
    for text in [printed(&verdict), printed(&brief), printed(&comparison)] {
        check_holds(&text, "Configuration changed: pca: vehicles: size → model.");
    }
    check_holds(&Json.text(&verdict), "\"pca: vehicles: size → model\"");
    let same = judge(&before, &before, &tolerances()).unwrap();
    assert!(!printed(&same).contains("Configuration changed"));
}

/// Rules changed for detectors of others alone, and runs once had one version for all of their detectors.
#[test]
fn detectors_of_both_runs_have_one_scoring_version() {
    let run = |criterion: &str, is_foreign: bool, of_run: u32, own: Option<u32>| {
        let mut run = USUAL.archive();
        run.manifest.matching_criterion = criterion.to_owned();
        run.manifest.scoring_version = of_run;
        let foreign = is_foreign.then(ForeignEntry::default);
        run.manifest.detectors =
            vec![DetectorEntry { foreign, scoring_version: own, ..sample::detector("pca") }];
        run
    };
    let points = "points, IoU at least 0.5";
    let boxes = "points, IoU at least 0.5; car: boxes on the ground plan, IoU at least 0.7";
    for (criterion, is_foreign, before, after, changed) in [
        (points, false, (2, None), (2, Some(2)), None),
        (points, false, (2, None), (4, Some(2)), None),
        (points, false, (2, None), (4, None), None),
        (points, false, (4, None), (4, Some(2)), None),
        (points, false, (1, None), (4, None), Some("from 1 to 2")),
        (points, false, (4, Some(2)), (4, Some(4)), Some("from 2 to 4")),
        (boxes, false, (3, None), (4, None), None),
        (boxes, false, (2, None), (4, None), Some("from 2 to 3")),
        (points, true, (4, None), (4, Some(4)), None),
        (points, true, (2, None), (4, None), Some("from 2 to 4")),
        (points, true, (2, None), (4, Some(4)), Some("from 2 to 4")),
    ] {
        let [before, after] = [before, after].map(|(of_run, own)| run(criterion, is_foreign, of_run, own));
        let error = judge(&before, &after, &tolerances()).err().map(|it| it.to_string());
        let expected =
            changed.map(|it| format!("the runs cannot be compared: the scoring version of pca changed {it}"));
        assert_eq!(error, expected);
    }
}

#[test]
fn scans_of_which_points_or_labels_changed_are_not_gated() {
    let mut relabelled = USUAL.archive();
    numbers_of(&mut relabelled, |it| it.scan == 1).for_each(|it| it.checksum += 1);
    let error = against_usual(&relabelled).unwrap_err().to_string();
    let expected = "the runs cannot be compared: points or labels changed in 1 of ";
    assert!(error.starts_with(expected) && error.ends_with("their checksums differ"), "{error}");
}

/// The results are what is judged, as the parameters of a detector are.
#[test]
fn results_of_other_files_are_gated_and_the_files_counted() {
    let with = |checksum: &str| {
        let [results, results_checksum] = ["found", checksum].map(|it| Some(it.to_owned()));
        let files = [("road/1.txt", "a"), ("road/2.txt", checksum)];
        let result_files = files.map(|(name, sum)| (name.to_owned(), sum.to_owned())).into();
        with_foreign(ForeignEntry { results, results_checksum, result_files, ..ForeignEntry::default() })
    };
    let same = judge(&with("a"), &with("a"), &tolerances()).unwrap();
    assert_eq!((same.conclusion(), same.configuration_changes.len()), (Conclusion::Same, 0));
    assert!(against_usual(&with("a")).is_ok());
    let said = "Configuration changed: pca: results: 1 of 2 files changed.";
    let verdict = judge(&with("a"), &with("b"), &tolerances()).unwrap();
    check_holds(&printed(&verdict), said);
    check_holds(&Json.text(&verdict), "\"pca: results: 1 of 2 files changed\"");
    // Other results that are worse fail as those of any detector do.
    let mut worse = SampleScans { tp_of: &|step| seven_or_five(step) - 1, ..USUAL }.archive();
    worse.manifest = with("b").manifest;
    assert_eq!(judge(&with("a"), &worse, &tolerances()).unwrap().conclusion(), Conclusion::Regression);
    let comparison = compare_runs(&with("a"), &with("b"), ComparedSlices::All, None).unwrap();
    check_holds(&printed(&comparison), said);
}

#[test]
fn what_a_side_does_not_give_it_has_missed() {
    let tram = Task::Class(AnnotationClass::Tram);
    let plain = USUAL.archive();
    // `pca` gives trams falsely in every third scan, and misses one in every scan.
    let mut given = plain.clone();
    let of_pca = plain.scans.iter().filter(|it| it.detector == "pca");
    given.scans.extend(of_pca.map(|row| {
        let counts = Counts::new(1, 0, Some(u64::from(row.scan % 3 == 0))).unwrap();
        let outcome = ScanOutcome::Evaluated(ScanNumbers::of_counts(counts));
        ScanRow { task: tram, outcome, ..row.clone() }
    }));
    given.matches.extend((0..30).map(|scan| MatchRow { task: tram, ..missed("pca", scan, 9) }));
    let counts = |run: &RunArchive| -> Vec<[Option<u64>; 3]> {
        let of_trams = run.scans.iter().filter(|it| it.task == tram).filter_map(ScanRow::numbers);
        of_trams.map(|it| [Some(it.counts.no()), Some(it.counts.tp()), it.counts.fo()]).collect()
    };
    for (sides, filled) in [([&plain, &given], 0), ([&given, &plain], 1)] {
        let both = with_classes_of_both(sides.map(RunArchive::clone));
        assert_eq!(counts(&both[filled]), [[Some(1), Some(0), Some(0)]; 30]);
        assert_eq!(both[1 - filled].scans, given.scans);
        let reasons = both[filled].matches.iter().filter(|it| it.task == tram).map(|it| &it.outcome);
        let as_among_objects =
            |it: &MatchOutcome| matches!(it, MatchOutcome::Missed { reason: MissReason::Split, .. });
        assert!(reasons.clone().count() == 30 && reasons.into_iter().all(as_among_objects));
        assert!(judge(&both[0], &both[1], &tolerances()).is_ok());
    }
    let [same, _] = with_classes_of_both([plain.clone(), plain.clone()]);
    assert_eq!(same.scans, plain.scans);
    // A detector that only the other side has is not asked.
    let mut alone = plain;
    alone.scans.retain(|it| it.detector != "pca");
    assert_eq!(counts(&with_classes_of_both([alone, given])[0]), [[None; 3]; 0]);
}
