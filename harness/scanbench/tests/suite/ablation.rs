//! `scanbench ablation`: what each part of the method is worth, as one table of a run.

use crate::program::Workplace;
use crate::shard_folders::{check_same_but_times, check_same_table, check_study};

/// The rows of `ablation.csv`, each as its cells.
fn rows(workplace: &Workplace, folder: &str) -> Vec<Vec<String>> {
    cells(workplace, &format!("{folder}/ablation.csv"))
}

fn cells(workplace: &Workplace, path: &str) -> Vec<Vec<String>> {
    let text = workplace.read(path);
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn every_variant_has_a_row_for_each_data_set_and_for_all_simulated_ones() {
    let workplace = Workplace::with_drive(2);
    let command = "ablation street street-narrow street-main-road --simulated-scans 2 --sensor vlp-16";
    let ended = check_study(&workplace, command, &[2], |workplace, whole, merged| {
        check_same_but_times(workplace, whole, merged);
        check_same_table(workplace, whole, merged, "ablation.csv");
    });
    assert!(
        ended.stderr.ends_with("--seed 9001\nAblation: in-one\nPage: in-one/report.html\n"),
        "{}",
        ended.stderr
    );

    let rows = rows(&workplace, "in-one");
    let (head, rows) = rows.split_first().expect("a head");
    let column = |name: &str| head.iter().position(|it| it == name).expect("a column");
    let (dataset, origin, variant) = (column("dataset"), column("origin"), column("variant"));
    let variants_of = |id: &str| -> Vec<&str> {
        rows.iter().filter(|row| row[dataset] == id).map(|row| row[variant].as_str()).collect()
    };
    let variants = variants_of("street");
    assert_eq!(
        (variants.first(), variants.last()),
        (Some(&"whole method"), Some(&"and the best cut of groups"))
    );
    let papers = variants.iter().position(|it| *it == "the papers").expect("a row");
    assert_eq!(variants[papers - 1], "without all of these");
    assert!(variants.contains(&"without terrain") && variants.contains(&"without walls"));
    for id in ["street-narrow", "street-main-road", "overall-simulated"] {
        assert_eq!(variants_of(id), variants, "{id}");
    }
    // Recorded and simulated ones are never put together.
    assert_eq!(rows.len(), 4 * variants.len());
    for row in rows {
        let expected = if row[dataset] == "street" { "recorded" } else { "simulated" };
        assert_eq!(row[origin], expected, "{row:?}");
        // KITTI does not label every kind of object.
        assert_eq!(row[column("f_rate")].is_empty(), expected != "simulated", "{row:?}");
        assert!(!row[column("recall")].is_empty() && !row[column("latency_p50_ms")].is_empty(), "{row:?}");
    }
    for text in [&ended.stdout, &workplace.read("in-one/ablation.md")] {
        assert!(text.contains("street-narrow (simulated)") || text.contains("street-narrow (*simulated*)"));
        // A table that is folded names its lines again.
        assert_eq!(text.matches("without terrain").count() % 4, 0, "{text}");
        assert!(text.contains("without terrain"), "{text}");
    }
    let manifest = workplace.read("in-one/manifest.json");
    // Whole, and with two rounds and one, there is nothing missing.
    assert_eq!(manifest.matches("\"name\": \"without ").count(), papers - 3, "{manifest}");
}

#[test]
fn variants_are_detectors_of_a_run() {
    let workplace = Workplace::new();
    let data = "street-narrow --simulated-scans 2 --sensor vlp-16";
    workplace.succeed(&("ablation -o before", data));
    workplace.succeed(&("run -d hierarchical -o whole", data));
    // The whole method is what `run` runs: no, tp, mo, fo.
    let report = workplace.read("whole/table_objects.csv");
    let of_run: Vec<&str> = report.lines().nth(1).expect("a row").split(',').collect();
    let parts = rows(&workplace, "before");
    assert_eq!(of_run[6..10], parts[1][5..9], "{report}");
    assert!(parts[1..].iter().any(|row| row[5..9] != parts[1][5..9]), "no part makes a difference");
    workplace.succeed(&("ablation -o after -P hierarchical.grid.xi=2", data));
    workplace
        .succeed("compare before before")
        .check_stdout(&["without terrain", "No result of a scan changed."]);
    let of_two = workplace.succeed("compare before after");
    assert!(!of_two.stdout.contains("No result of a scan changed."), "{of_two:#?}");
    let pair = ["compare", "before", "--detectors", "whole method,without terrain"];
    let of_pair = workplace.succeed(&pair);
    of_pair.check_stdout(&["without terrain − whole method"]);

    let written = workplace.succeed(&(&pair, "-o pair"));
    assert_eq!(written.stdout, of_pair.stdout);
    for (folder, stem) in [("pair", "comparison"), ("before", "ablation")] {
        for ending in ["csv", "md", "tex", "svg", "pdf"] {
            let path = workplace.path(&format!("{folder}/{stem}.{ending}"));
            assert!(std::fs::metadata(&path).is_ok_and(|it| it.len() > 200), "{path:?}");
        }
    }
    let differences = cells(&workplace, "pair/comparison.csv");
    let f_rate = differences.iter().find(|it| it[0] == "objects" && it[3] == "f_rate").expect("a row");
    let [before, after, difference] = [4, 5, 6].map(|it| f_rate[it].parse::<f64>().expect("a number"));
    assert!((after - before - difference).abs() < 2e-6, "{f_rate:?}");
    workplace.succeed(&(&pair, "-o pair --overwrite"));

    let page = workplace.read("before/report.html");
    workplace.succeed("report before");
    assert_eq!(workplace.read("before/report.html"), page);
    // Each interval of the table is one of the report.
    let rows = rows(&workplace, "before");
    let low = rows[0].iter().position(|it| it == "f_rate_low").expect("a column");
    let table = workplace.read("before/table_objects.csv");
    for row in &rows[1..] {
        let expected = format!(",{},{},", row[low], row[low + 1]);
        assert!(!row[low].is_empty() && table.contains(&expected), "{row:?}");
    }
}
