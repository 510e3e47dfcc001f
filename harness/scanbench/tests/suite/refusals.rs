//! What cannot be is said with file, position and values, with the exit code for its kind, and leaves nothing behind.
//!
//! `refusals.txt` has what is refused for what is asked for; what is refused of runs, shards or models stands with these.

use crate::program::{Words, Workplace};

/// A workplace with a drive `street` of three scans, and files and folders that are none of what is asked for.
fn workplace() -> Workplace {
    let workplace = Workplace::with_drive(3);
    for folder in ["empty", "folder.csv", "objects/training/label_2", "scenes"] {
        std::fs::create_dir_all(workplace.path(folder)).expect("a fresh folder");
    }
    let boxes = "center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad\n";
    for (name, content) in [
        ("file", ""),
        ("scan.xyz", ""),
        ("there.mcap", ""),
        ("mine/car/1.bin", "\0".repeat(64).as_str()),
        ("odd/cra/1.bin", "\0".repeat(16).as_str()),
        ("bad.txt", "1 2 3\n"),
        ("mine.toml", "# mine\n[hierarchical.grid]\ncel_size_m = 0.5\n"),
        ("classes.toml", "[classes]\nforklift = \"mics\"\n"),
        ("catalogue.toml", "\n[lidar.a]\nformat = \"kitti-object\"\n"),
        ("found/0000/000000.csv", boxes),
        ("above/pca/0000/000000.csv", boxes),
        ("above/pca/0000/000001.csv", boxes),
        ("above/pca/0000/000002.csv", boxes),
    ] {
        workplace.write(name, content);
    }
    workplace
}

/// It is refused, and each of these is said once.
#[track_caller]
fn check(
    workplace: &Workplace,
    variables: &[(&str, &str)],
    arguments: &(impl Words + ?Sized),
    (exit_code, parts): (i32, &[&str]),
) {
    let before = workplace.names();
    let ended = workplace.run_with(variables, arguments);
    let said = format!("{:?}: {ended:#?}", arguments.words());
    assert_eq!((ended.exit_code, ended.stdout.as_str()), (Some(exit_code), ""), "{said}");
    assert!(ended.stderr.starts_with("error: ") && !ended.stderr.contains("panicked"), "{said}");
    let in_one_line = ended.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in parts {
        assert_eq!(in_one_line.matches(part).count(), 1, "{part:?} in {said}");
    }
    assert_eq!(workplace.names(), before, "{said} leaves something behind");
}

/// Lines of the table: variables, a command, ` → `, the exit code, and what is said, in parts; some of these in lines of
/// their own.
#[test]
fn what_cannot_be() {
    let workplace = workplace();
    let table = include_str!("refusals.txt").replace("\n    ", " … ");
    let rows = table.lines().filter(|it| !it.is_empty() && !it.starts_with('#'));
    for row in rows {
        let (asked, refused) = row.split_once(" → ").unwrap_or_else(|| panic!("{row}"));
        let (exit_code, parts) = refused.split_at(1);
        let words: Vec<&str> = asked.split(' ').collect();
        let (variables, command) =
            words.split_at(words.iter().take_while(|it| it.contains("_ROOT=")).count());
        let variables: Vec<(&str, &str)> = variables.iter().filter_map(|it| it.split_once('=')).collect();
        let parts: Vec<&str> = parts.split(" … ").map(str::trim).filter(|it| !it.is_empty()).collect();
        check(&workplace, &variables, command, (exit_code.parse().expect("a code"), &parts));
    }
    let too_long = format!("run street -o {}", "x".repeat(300));
    check(&workplace, &[], &too_long, (2, &["cannot write \""]));
}

#[test]
fn options_that_say_nothing_about_objects() {
    let workplace = workplace();
    for verb in ["partial", "data objects"] {
        for name in ["objects-around", "mine"] {
            for (option, words) in [
                ("--seed 7", "--seed is for data sets, and none is given"),
                ("--sensor vlp-16", "--sensor is for data sets"),
                ("--sensor-height 1.7", "--sensor-height is for data sets"),
                ("--format kitti-tracking", "--format is for data sets"),
                ("--class boat=misc", "--class is for data sets"),
                ("--registered", "--registered is for data sets"),
            ] {
                check(&workplace, &[], &(verb, name, option, "-o x"), (2, &[words]));
            }
        }
        for (arguments, words) in [
            ("mine --part judging", "--part is for simulated objects"),
            ("mine --per-class 9", "--per-class is for simulated objects"),
            ("objects-nowhere", "there is no data set \"objects-nowhere\""),
        ] {
            check(&workplace, &[], &(verb, arguments, "-o x"), (2, &[words]));
        }
    }
}
