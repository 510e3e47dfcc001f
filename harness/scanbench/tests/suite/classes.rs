//! Classes that detectors give: in rows, tables, gates, and classes of the user.

use crate::program::Workplace;

const HEADER: &str = "class,score,center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad";
const N_SCANS: u32 = 12;

/// Writes the boxes of the two cars of each scan of the drawn drive, called by these words, into `folder`.
fn write_results(workplace: &Workplace, folder: &str, words: [&str; 2]) {
    for number in 0..N_SCANS {
        let ahead_m = 12.0 + 0.5 * f64::from(number);
        let boxes = [[ahead_m, -1.5], [18.0, 4.5]].into_iter().zip(words).zip([0.9, 0.8]);
        let line = |(([x_m, y_m], word), score): (([f64; 2], &str), f64)| {
            format!("{word},{score},{x_m},{y_m},-0.98,4.2,1.8,1.5,0\n")
        };
        let lines: String = boxes.map(line).collect();
        workplace.write(&format!("{folder}/0000/{number:06}.csv"), &format!("{HEADER}\n{lines}"));
    }
}

fn run(workplace: &Workplace, results: &str, output: &str) {
    let results = format!("net={results}");
    let run = ["run", "street", "-d", "pca", "--criterion", "centre", "--detections", results.as_str()];
    workplace.succeed(&(&run, "--no-rrd -o", output));
}

#[test]
fn each_class_is_judged_by_itself_and_a_changed_class_does_not_pass() {
    let workplace = Workplace::with_drive(N_SCANS);
    write_results(&workplace, "right", ["Car", "REGULAR_VEHICLE"]);
    write_results(&workplace, "swapped", ["Car", "Truck"]);
    run(&workplace, "right", "right-run");
    run(&workplace, "swapped", "swapped-run");
    let found = |run: &str, task: &str| -> [u64; 3] {
        let rows = workplace.table(&format!("{run}/scans.csv"));
        let of_task = rows.iter().filter(|it| it["detector"] == "net" && it["task"] == task);
        let sum = |column: &str| of_task.clone().filter_map(|it| it[column].parse::<u64>().ok()).sum();
        ["no", "tp", "fo"].map(sum)
    };
    let n = u64::from(N_SCANS);
    assert_eq!(found("right-run", "car"), [2 * n, 2 * n, 0]);
    assert_eq!(found("swapped-run", "car"), [2 * n, n, 0]);
    assert_eq!(found("swapped-run", "truck"), [0, 0, n]);
    assert_eq!(found("swapped-run", "vehicles"), [2 * n, 2 * n, 0]);
    // Who gives no class is not asked for any.
    let rows = workplace.table("swapped-run/scans.csv");
    assert!(rows.iter().all(|it| it["detector"] == "net" || it["task"] != "car"));

    let confusion = workplace.read("swapped-run/confusion.csv");
    assert_eq!(
        confusion,
        "dataset,detector,annotated,detected,n\nstreet,net,car,car,12\nstreet,net,car,truck,12\n"
    );
    workplace.check_file(
        "swapped-run/table_classes_street.md",
        &["Of 24 objects of the class car that net found, it calls 12 truck.", "| truck |"],
    );
    workplace.check_file(
        "swapped-run/report.html",
        &["Each class by itself", "that net found, it calls 12 truck"],
    );
    let rows = workplace.table("swapped-run/matches.csv");
    let trucks = rows.iter().filter(|it| it["task"] == "objects" && it["detection_class"] == "truck");
    assert_eq!(trucks.count(), N_SCANS as usize);

    let gate =
        workplace.end_with("gate swapped-run --baseline right-run --full", 101, &["FAILED: results changed"]);
    gate.check_stdout(&["net, car", "24 objects with another class"]);
    assert!(words(&gate.stdout).contains("found before as car, now as truck"), "{}", gate.stdout);
    let same = workplace.succeed("gate right-run --baseline right-run");
    same.check_stdout(&["PASSED"]);
    let compared = workplace.succeed("compare right-run swapped-run");
    assert!(
        compared.stdout.lines().any(|it| it.starts_with("car ") && it.contains("recall")),
        "{}",
        compared.stdout
    );
    let one = workplace.succeed("compare right-run swapped-run -d net");
    assert!(!one.stdout.contains("pca"), "{}", one.stdout);
    workplace.refuse("compare right-run swapped-run -d nett", 2, &["no detector \"nett\""]);
}

#[test]
fn a_class_that_one_side_does_not_give_is_one_of_which_it_has_found_nothing() {
    let workplace = Workplace::with_drive(N_SCANS);
    write_results(&workplace, "right", ["Car", "REGULAR_VEHICLE"]);
    write_results(&workplace, "swapped", ["Car", "Truck"]);
    write_results(&workplace, "unnamed", ["object", "object"]);
    for results in ["right", "swapped", "unnamed"] {
        run(&workplace, results, &format!("{results}-run"));
    }
    let changed = &["FAILED: results changed"];
    let gate = workplace.end_with("gate swapped-run --baseline right-run --full", 101, changed);
    let gone =
        workplace.end_with("gate right-run --baseline swapped-run --full", 101, &["FAILED: results changed"]);
    assert!(words(&gone.stdout).contains("found before as truck, now as car"), "{}", gone.stdout);
    assert!(rates(&gone.stdout, "all  , fo  ").contains("all fo 12 0 −12"), "{}", gone.stdout);
    let new = rates(&gate.stdout, "No rule is about the class truck");
    assert!(new.is_empty(), "the built-in rules are about it: {}", gate.stdout);
    assert!(rates(&gate.stdout, "all  , fo  ").contains("all fo 0 12 +12"), "{}", gate.stdout);
    let gate =
        workplace.end_with("gate unnamed-run --baseline right-run --full", 5, &["numbers are missing"]);
    assert!(
        rates(&gate.stdout, "class/car  , recall").contains("recall [%] 100.0 0.0 −100.00"),
        "{}",
        gate.stdout
    );
    assert!(words(&gate.stdout).contains("found before, now missed (wrong class)"), "{}", gate.stdout);
    // Rules of a file are about the classes that they name.
    let rule = "[[quality]]\nmetrics = [\"recall\"]\nslices = [\"all\"]\ntasks = [\"car\"]\ndetectors = [\"net\"]\nabsolute = 0.01\nrelative = 0.0\n";
    workplace.write("named.toml", rule);
    let named = workplace.end_with("gate swapped-run --baseline right-run -t named.toml", 101, &["FAILED"]);
    let about_none = "No rule is about the class truck, which net gives falsely 12 times, and gave 0 times.";
    assert!(words(&named.stdout).contains(about_none), "{}", named.stdout);
}

/// The line of `text` with the words of `what`, its spaces as one.
fn rates(text: &str, what: &str) -> String {
    let has_all = |line: &&str| what.split(", ").all(|it| line.contains(it));
    words(text.lines().find(has_all).unwrap_or_default())
}

fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn a_class_of_the_user_goes_from_labels_and_results_to_tables_and_exports() {
    let workplace = Workplace::with_drive(N_SCANS);
    let labels = workplace.read("street/training/label_02/0000.txt");
    let second = |line: &str| line.split(' ').nth(1) == Some("1");
    let labels: String = labels
        .lines()
        .map(|it| if second(it) { it.replace("Car", "Fork_Lift") } else { it.to_owned() } + "\n")
        .collect();
    workplace.write("street/training/label_02/0000.txt", &labels);
    write_results(&workplace, "found", ["Car", "fork lift"]);
    let run = ["run", "street", "-d", "pca", "--criterion", "centre", "--detections", "net=found"];
    let refused = workplace.end_with(&(&run, "--no-rrd -o out"), 2, &["unknown class", "Fork_Lift"]);
    assert!(refused.stderr.contains("[class.fork-lift]"), "{}", refused.stderr);
    workplace.write("scanbench.toml", "[class.fork-lift]\nnames = [\"stacker\"]\n");
    let ended = workplace.succeed(&(&run, "--no-rrd -o out --detections-out written --as csv"));
    ended.check_stdout(&["fork-lift"]);
    let rows = workplace.table("out/matches.csv");
    let is_matched = |it: &&crate::program::Row| it["task"] == "fork-lift" && it["outcome"] == "matched";
    assert_eq!(rows.iter().filter(is_matched).count(), N_SCANS as usize);
    let vehicles = workplace.table("out/scans.csv");
    let vehicles = vehicles.iter().filter(|it| it["task"] == "vehicles" && it["detector"] == "net");
    assert!(vehicles.clone().all(|it| it["no"] == "1" && it["fo"] == "0"), "it is in no group");
    workplace.check_file("written/net/0000/000003.csv", &["fork-lift", "car"]);
    // Its own page is made without the configuration.
    std::fs::remove_file(workplace.path("scanbench.toml")).expect("it is there");
    workplace.succeed("report out");
    workplace.check_file("out/report.html", &["fork-lift"]);
    workplace.write("scanbench.toml", "[class.fork-lift]\ngroup = \"vehicles\"\n");
    workplace.end_with(&(&run, "--no-rrd -o other"), 2, &["scanbench.toml", "class.fork-lift", "vehicles"]);
    workplace.write("scanbench.toml", "[class.fork-lift]\ngroup = \"vehicle\"\nnames = [\"stacker\"]\n");
    workplace.succeed(&(&run, "--no-rrd -o grouped"));
    let vehicles = workplace.table("grouped/scans.csv");
    let mut vehicles = vehicles.iter().filter(|it| it["task"] == "vehicles" && it["detector"] == "net");
    assert!(vehicles.all(|it| it["no"] == "2" && it["tp"] == "2"), "it is a vehicle");
}

#[test]
fn a_class_of_a_whole_group_is_found_where_any_of_the_group_is_annotated() {
    let workplace = Workplace::with_drive(N_SCANS);
    let labels = workplace.read("street/training/label_02/0000.txt");
    let is_second = |line: &str| line.split(' ').nth(1) == Some("1");
    let labels = labels
        .lines()
        .map(|it| if is_second(it) { it.replace("Car", "Truck") } else { it.to_owned() } + "\n");
    workplace.write("street/training/label_02/0000.txt", &labels.collect::<String>());
    write_results(&workplace, "found", ["any vehicle", "any vehicle"]);
    workplace.write("scanbench.toml", "[class.any-vehicle]\ngroup = \"vehicle\"\nwhole_group = true\n");
    run(&workplace, "found", "out");
    let rows = workplace.table("out/scans.csv");
    let sums = |task: &str| -> [u64; 3] {
        let of_task = rows.iter().filter(|it| it["detector"] == "net" && it["task"] == task);
        ["no", "tp", "fo"].map(|column| of_task.clone().filter_map(|it| it[column].parse::<u64>().ok()).sum())
    };
    let n = u64::from(N_SCANS);
    assert_eq!(sums("any-vehicle"), [2 * n, 2 * n, 0]);
    assert_eq!(sums("car"), [n, 0, 0]);
    assert_eq!(sums("vehicles"), [2 * n, 2 * n, 0]);
    workplace.write("scanbench.toml", "[class.anything]\nwhole_group = true\n");
    let refused = "run street -d pca --no-rrd -o other";
    workplace.refuse(refused, 2, &["class.anything: whole_group needs a group"]);
}
