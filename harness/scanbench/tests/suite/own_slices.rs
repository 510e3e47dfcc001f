//! Slices of the user: beside all others, alone, and in the gate.

use crate::program::Workplace;

const SLICES: &str = "[slice.corridor]\npolygon_m = [[0, -6], [60, -6], [60, 6], [0, 6]]\n\n[slice.small]\nlength_m = [0, 3]\n";

#[test]
fn a_slice_has_numbers_and_judged_alone_it_has_the_same() {
    let workplace = Workplace::new();
    workplace.write("scanbench.toml", SLICES);
    let run = "run streets --scans 0..20:10 -d pca,simple-grid --no-rrd -o";
    workplace.succeed(&format!("{run} all"));
    workplace.succeed(&format!("{run} alone --only corridor"));
    let lines = |run: &str| -> Vec<String> {
        let table = workplace.read(&format!("{run}/table_slices_overall.md"));
        let of_corridor = table.lines().filter(|it| it.starts_with("| corridor"));
        of_corridor.map(str::to_owned).collect()
    };
    // Two tasks of two detectors, and the two classes that one of these gives.
    assert_eq!(lines("all").len(), 6);
    assert_eq!(lines("all"), lines("alone"));
    let no = |run: &str| -> u64 {
        let rows = workplace.table(&format!("{run}/scans.csv"));
        let of_task = rows.iter().filter(|it| it["task"] == "objects" && it["detector"] == "pca");
        of_task.map(|it| it["no"].parse::<u64>().unwrap()).sum()
    };
    assert!(lines("all")[0].contains(&format!("| {} |", no("alone"))) && no("alone") < no("all"));
    workplace.check_file("alone/table_objects.md", &["judged in the slice corridor only"]);
    workplace.check_file("alone/matches.csv", &["outside slice"]);
    workplace.check_file("all/report.html", &["Slices of your own", "corridor"]);
    // The page, made again from the rows, has the same slices.
    let before = workplace.read("all/report.json");
    workplace.succeed("report all");
    assert_eq!(workplace.read("all/report.json"), before);

    // A slice is gated by its name; under other bounds it is another.
    let rule =
        "[[quality]]\nmetrics = [\"recall\"]\nslices = [\"own/corridor\"]\nabsolute = 0.01\nrelative = 0.0\n";
    workplace.write("tolerances.toml", rule);
    workplace.succeed("gate all --baseline all --tolerances tolerances.toml");
    workplace.refuse("gate alone --baseline all", 5, &["the matching criterion changed", "corridor only"]);
    workplace.write("scanbench.toml", &SLICES.replace("60", "30"));
    workplace.succeed(&format!("{run} shorter"));
    workplace.refuse("gate shorter --baseline all", 5, &["the slice corridor changed from {\"polygon_m\""]);
}

#[test]
fn a_slice_that_is_none_is_refused() {
    let workplace = Workplace::new();
    let none = "there is no slice \"corridor\"; slices of the configuration: there are none";
    workplace.refuse("run streets -d pca --only corridor", 2, &[none]);
    for (text, problem) in [
        ("[slice.a]\nrange_m = [9, 3]", "line 1: slice.a: range_m = [9, 3] holds nothing"),
        ("\n[slice.a]\n", "line 2: slice.a: bounds nothing"),
        ("[slice.a]\nrange = [3, 9]", "slice.a: unknown field `range`"),
        ("[slice.A]\nrange_m = [3, 9]", "\"A\" is no name of a slice"),
        ("[matching]\npreset = \"coco\"", "unknown variant `coco`"),
        ("[matching]\nonly = \"b\"", "there is no slice \"b\""),
    ] {
        workplace.write("scanbench.toml", text);
        workplace.refuse("run streets -d pca", 2, &[problem]);
    }
}

#[test]
fn criteria_of_a_benchmark_are_named_in_tables() {
    let workplace = Workplace::new();
    workplace.write("scanbench.toml", "[matching]\npreset = \"nuscenes\"\n");
    workplace.succeed("run streets --scans 0..20:20 -d pca --no-rrd -o run");
    workplace.check_file(
        "run/table_objects.md",
        &["each class: centre, closer than 2 m (criteria of classes as in nuScenes)"],
    );
}
