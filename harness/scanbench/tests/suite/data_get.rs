//! Data sets from elsewhere, fetched from a server of this machine.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use crate::drawn_dataset::DrawnDataset;
use crate::file_server::{Fault, FileServer};
use crate::program::{Ended, Workplace};

const GET: &str = "data get drives --catalogue mine.toml --accept-licence";

/// `n_bytes` that do not repeat soon.
fn bytes(n_bytes: u32) -> Vec<u8> {
    (0..n_bytes).map(|it| (it.wrapping_mul(2_654_435_761) >> 13) as u8).collect()
}

/// A catalogue whose data set `drives` is at `server`, and goes to the folder `data`.
fn workplace(server: &FileServer, lines: &str) -> Workplace {
    let workplace = Workplace::new();
    let catalogue = format!(
        "[recorded.drives]\nformat = \"scan-folder\"\nroot = \"data\"\nannotated_classes = \"every-object\"\n\
         sensor_height_m = 1.7\nlicence = \"Licence of the Moon\"\nlicence_url = \"https://example.org/moon\"\n\
         url = \"https://example.org/drives\"\n\n[recorded.drives.download]\nfrom = \"{}\"\n{lines}\n",
        server.url("public")
    );
    workplace.write("mine.toml", &catalogue);
    workplace
}

/// Sums up all files of a folder.
const SUM_UP: &str = "sha256sum $(find * -type f)";

/// What a command line gives in `folder`.
fn shell(line: &str, folder: &Path) -> Output {
    Command::new("sh").args(["-c", line]).current_dir(folder).output().unwrap()
}

/// The hidden files that hold what has arrived.
fn partials(workplace: &Workplace) -> Vec<PathBuf> {
    let is_partial = |it: &PathBuf| it.file_name().unwrap().to_string_lossy().contains(".partial-");
    workplace.names().into_iter().filter(is_partial).collect()
}

const ONE: &str = "files = [\"a/0.bin\"]";

/// A server with the file `a/0.bin` of `n_bytes`.
fn server_of_one(n_bytes: u32) -> FileServer {
    let server = FileServer::start();
    server.put("public/a/0.bin", &bytes(n_bytes));
    server
}

#[test]
fn nothing_is_fetched_before_the_licence_is_accepted() {
    let server = server_of_one(100);
    let workplace = workplace(&server, ONE);
    let parts = ["Licence of the Moon", "https://example.org/moon", "--accept-licence"];
    workplace.refuse("data get drives --catalogue mine.toml", 2, &parts);
    assert!(server.asked().is_empty());
}

#[test]
fn what_needs_a_login_says_where_to_go() {
    let workplace = Workplace::new();
    let page = "https://www.cvlibs.net/datasets/kitti/eval_tracking.php";
    workplace.refuse(
        "data get kitti-tracking",
        2,
        &["a login", page, "--link", "argoverse2-val, kitti-raw, semantic-kitti"],
    );
    workplace.refuse("data get kitti-traking", 2, &["did you mean \"kitti-tracking\""]);
    workplace.refuse("data get street-narrow", 2, &["is simulated", "scanbench run street-narrow"]);
    workplace.refuse("data get streets", 2, &["is a group"]);
    workplace.refuse(
        "data get kitti-raw --drive 9 --accept-licence",
        2,
        &["no drive \"9\"", "2011_09_26_drive_0001"],
    );
    workplace.refuse("data get argoverse2-val", 2, &["CC BY-NC-SA 4.0", "https://www.argoverse.org"]);
}

#[test]
fn drives_are_fetched_with_their_checksums_and_not_again() {
    let server = FileServer::start();
    for drive in ["a", "b", "c"] {
        server
            .put(&format!("public/{drive}/0.bin"), &bytes(1000))
            .put(&format!("public/{drive}/1.bin"), &bytes(2000));
    }
    let lines = "files = [\"{drive}/0.bin\", \"{drive}/1.bin\"]\ndrives = [\"a\", \"b\", \"c\"]";
    let workplace = workplace(&server, lines);
    let dry = workplace.succeed(&(GET, "--drive a,c --dry-run"));
    dry.check_stderr(&["Licence of the Moon", "6.0 kB in 4 files to fetch into data"]);
    assert!(!workplace.path("data").exists());
    let ended = workplace.succeed(&(GET, "--drive a,c"));
    ended.check_stdout(&["data  4 files  6.0 kB\n"]);
    assert_eq!(workplace.read_bytes("data/c/1.bin"), bytes(2000));
    assert!(!workplace.path("data/b").exists());
    let checked = shell("sha256sum -c --strict SHA256SUMS", &workplace.path("data"));
    assert!(checked.status.success(), "{checked:?}");
    assert_eq!(workplace.read("data/SHA256SUMS").lines().count(), 4);
    server.asked();
    workplace.succeed(&(GET, "--drive a,c"));
    assert!(server.asked().iter().all(|it| it.starts_with("HEAD ")));
    assert!(partials(&workplace).is_empty());
}

#[test]
fn broken_connections_and_busy_servers_cost_time_only() {
    let server = server_of_one(5000);
    for fault in [Fault::Breaks(1500), Fault::Busy(2), Fault::None] {
        let workplace = workplace(&server, ONE);
        server.fail(fault);
        workplace.succeed(GET);
        assert_eq!(workplace.read_bytes("data/a/0.bin"), bytes(5000));
        let asked = server.asked();
        let goes_on = asked.iter().any(|it| it.starts_with("GET /public/a/0.bin 1500-"));
        assert_eq!(goes_on, matches!(fault, Fault::Breaks(_)), "{asked:?}");
    }
}

#[test]
fn what_is_wrong_is_thrown_away_or_never_begun() {
    let server = server_of_one(5000);
    let workplace = workplace(&server, ONE);
    let wrong = format!("{}  a/0.bin\n", "1".repeat(64));
    workplace.write("data/SHA256SUMS", &wrong);
    workplace
        .run(GET)
        .check_refusal(3, &["wrong checksum", &"1".repeat(64), "SHA256SUMS", "/public/a/0.bin"]);
    assert_eq!(workplace.read("data/SHA256SUMS"), wrong);
    std::fs::remove_file(workplace.path("data/SHA256SUMS")).unwrap();
    server.fail(Fault::Boasts);
    workplace.run(GET).check_refusal(7, &["\"data\" has room for", "are missing", "--into"]);
    server.fail(Fault::Status(403));
    workplace.run(GET).check_refusal(3, &["/public/a/0.bin may not be read", "403"]);
    server.fail(Fault::Status(500));
    workplace.run(GET).check_refusal(3, &["cannot fetch", "500", "the same command goes on"]);
    server.fail(Fault::None);
    server.remove("public/a/0.bin");
    workplace.run(GET).check_refusal(3, &["nothing is at http://127.0.0.1", "/public/a/0.bin"]);
    let names: Vec<PathBuf> =
        workplace.names().into_iter().filter(|it| workplace.folder().join(it).is_file()).collect();
    assert_eq!(names, [PathBuf::from("mine.toml")]);
}

/// Ends the program by `signal` once 3,000 of 9,000 bytes have arrived.
#[cfg(unix)]
fn interrupted(server: &FileServer, workplace: &Workplace, signal: &str) -> Ended {
    server.fail(Fault::Stalls(3000));
    let child = workplace.start(GET);
    let started = Instant::now();
    let has_arrived = || {
        let sizes = partials(workplace)
            .into_iter()
            .map(|it| std::fs::metadata(workplace.folder().join(it)).unwrap().len());
        sizes.sum::<u64>() == 3000
    };
    while !has_arrived() {
        assert!(started.elapsed() < Duration::from_mins(1), "nothing arrives");
        std::thread::sleep(Duration::from_millis(5));
    }
    crate::program::send(&child, signal);
    let ended = Ended::from(child.wait_with_output().unwrap());
    server.fail(Fault::None);
    server.asked();
    ended
}

#[cfg(unix)]
#[test]
fn an_interruption_leaves_what_the_next_attempt_goes_on_with() {
    let server = server_of_one(9000);
    for (signal, exit_code) in [("-INT", Some(130)), ("-TERM", Some(143)), ("-KILL", None)] {
        let workplace = workplace(&server, ONE);
        let ended = interrupted(&server, &workplace, signal);
        assert_eq!(ended.exit_code, exit_code, "{ended:#?}");
        let [partial] = &partials(&workplace)[..] else { panic!("{:?}", workplace.names()) };
        assert!(partial.to_string_lossy().starts_with("data/a/.0.bin.partial-"), "{partial:?}");
        assert!(!workplace.path("data/a/0.bin").exists());
        workplace.succeed(GET);
        assert_eq!(workplace.read_bytes("data/a/0.bin"), bytes(9000));
        assert!(server.asked().contains(&"GET /public/a/0.bin 3000-".to_owned()));
        assert!(partials(&workplace).is_empty());
    }
}

#[cfg(unix)]
#[test]
fn another_object_and_a_server_without_ranges_begin_anew() {
    let server = server_of_one(9000);
    let workplace = workplace(&server, ONE);
    interrupted(&server, &workplace, "-INT");
    server.fail(Fault::WithoutRanges);
    workplace.succeed(GET);
    assert_eq!(workplace.read_bytes("data/a/0.bin"), bytes(9000));
    std::fs::remove_dir_all(workplace.path("data")).unwrap();
    interrupted(&server, &workplace, "-INT");
    let other: Vec<u8> = bytes(9000).into_iter().rev().collect();
    server.put("public/a/0.bin", &other);
    workplace.succeed(GET);
    assert_eq!(workplace.read_bytes("data/a/0.bin"), other);
    assert!(partials(&workplace).is_empty());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_what_has_arrived() {
    let server = server_of_one(9000);
    let workplace = workplace(&server, ONE);
    let limited = format!("trap '' XFSZ; ulimit -f 4; exec {} {GET}", env!("CARGO_BIN_EXE_scanbench"));
    let mut shell = Command::new("bash");
    let ended = Ended::from(shell.args(["-c", &limited]).current_dir(workplace.folder()).output().unwrap());
    ended.check_refusal(7, &["cannot write", "File too large", "the same command goes on"]);
    assert!(!workplace.path("data/a/0.bin").exists());
    let [partial] = &partials(&workplace)[..] else { panic!("{:?}", workplace.names()) };
    assert_eq!(workplace.n_bytes(partial.to_str().unwrap()), 4096);
    workplace.succeed(GET);
    // What arrives goes to no other file.
    let partial = workplace.path(partial.to_str().unwrap());
    std::fs::remove_file(workplace.path("data/a/0.bin")).unwrap();
    workplace.write("theirs", "theirs");
    std::os::unix::fs::symlink(workplace.path("theirs"), &partial).unwrap();
    workplace.run(GET).check_refusal(7, &["cannot write", ".0.bin.partial-"]);
    assert_eq!(workplace.read("theirs"), "theirs");
}

#[test]
fn a_server_that_brings_no_end_nearer_is_given_up() {
    let server = server_of_one(90_000);
    for (fault, patience_s, parts) in [
        (
            Fault::Cuts(30_000),
            "20",
            &["from its beginning alone, and never got beyond byte 30000 of 90000"][..],
        ),
        (Fault::Dribbles, "3", &["new bytes have come in 3 s", "more\n"]),
        (Fault::NeverAnswers, "3", &["no answer has come for 3 s", "waiting 3 s more\n"]),
    ] {
        let workplace = workplace(&server, ONE);
        server.fail(fault);
        let started = Instant::now();
        let ended = workplace.run_with(&[("SCANBENCH_PATIENCE_S", patience_s)], GET);
        ended.check_refusal(3, &["cannot fetch http://127.0.0.1"]);
        ended.check_refusal(3, parts);
        assert!(started.elapsed() < Duration::from_secs(30), "{fault:?} takes {:?}", started.elapsed());
    }
    let workplace = workplace(&server, ONE);
    workplace.write("unused", "");
    for seconds in ["0", "soon", "1e9"] {
        let ended = workplace.run_with(&[("SCANBENCH_PATIENCE_S", seconds)], GET);
        ended.check_refusal(2, &["SCANBENCH_PATIENCE_S", "is no number of seconds from 1 to 86400"]);
    }
    // One that is slow, and not too slow.
    server.fail(Fault::None);
    workplace.succeed(GET);
}

/// A zip file with these files.
fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn archives_are_unpacked_in_part_and_fetched_once() {
    let server = FileServer::start();
    let scan = bytes(1600);
    let archive = zipped(&[
        ("day/drive/points/0.bin", &scan),
        ("day/drive/image/0.png", b"large"),
        ("day/calib.txt", b"1"),
    ]);
    server.put("public/drive/drive.zip", &archive);
    let workplace = workplace(&server, "files = [\"drive/drive.zip\"]\nunpack = [\"/points/\", \"/calib\"]");
    workplace.succeed(GET);
    let names: Vec<String> =
        workplace.names().into_iter().map(|it| it.to_string_lossy().into_owned()).collect();
    let expected =
        ["data/SHA256SUMS", "data/day", "data/day/calib.txt", "data/day/drive", "data/day/drive/points"];
    for name in expected.into_iter().chain(["data/day/drive/points/0.bin", "data/drive.zip.unpacked"]) {
        assert!(names.iter().any(|it| it == name), "no {name} in {names:?}");
    }
    assert_eq!((names.len(), workplace.read_bytes("data/day/drive/points/0.bin")), (9, scan));
    let sums = workplace.read("data/SHA256SUMS");
    assert!(sums.contains("  day/calib.txt\n") && !sums.contains(".zip"), "{sums}");
    server.asked();
    workplace.succeed(GET);
    assert!(server.asked().iter().all(|it| it.starts_with("HEAD ")));
}

#[test]
fn archives_write_nothing_elsewhere() {
    let server = FileServer::start();
    server.put("public/drive.zip", &zipped(&[("good.bin", b"1"), ("../../evil.bin", b"1")]));
    let workplace = workplace(&server, "files = [\"drive.zip\"]");
    workplace.run(GET).check_refusal(3, &["cannot unpack", "leads out of it"]);
    server.put("public/drive.zip", b"no archive at all");
    std::fs::remove_dir_all(workplace.path("data")).unwrap();
    workplace.run(GET).check_refusal(3, &["cannot unpack", "drive.zip"]);
    assert!(!workplace.names().iter().any(|it| it.ends_with("evil.bin")));
}

/// The archive with the bytes of its last member in the place of the last but one, of which the directory says so.
fn overlapping(mut archive: Vec<u8>) -> Vec<u8> {
    const ENTRY: &[u8] = b"PK\x01\x02";
    let entries: Vec<usize> = (0..archive.len() - 4).filter(|it| archive[*it..].starts_with(ENTRY)).collect();
    let [.., one, other] = entries[..] else { panic!("it has too few members") };
    let offset: [u8; 4] = archive[other + 42..other + 46].try_into().unwrap();
    archive[one + 42..one + 46].copy_from_slice(&offset);
    archive
}

#[test]
fn archives_that_are_none_of_scans_are_not_unpacked() {
    let server = FileServer::start();
    let small: [(&str, &[u8]); 2] = [("a.bin", b"1"), ("b.bin", b"2")];
    let zeros = vec![0; 70_000_000];
    for (archive, parts) in [
        (overlapping(zipped(&small)), &["a.bin and b.bin overlap"][..]),
        (zipped(&[("a\nb.bin", b"1")]), &[r"the name a\nb.bin has a control character"]),
        (zipped(&[("a.bin", &zeros)]), &["would become 70 MB", "at most 67 MB", "--unpack-at-most 1"]),
    ] {
        server.put("public/drive.zip", &archive);
        let workplace = workplace(&server, "files = [\"drive.zip\"]");
        workplace.run(GET).check_refusal(3, parts);
        let left: Vec<PathBuf> = workplace.names().into_iter().filter(|it| it.ends_with(".bin")).collect();
        assert!(left.is_empty(), "{left:?}");
        if parts.len() > 1 {
            workplace.succeed(&(GET, "--unpack-at-most 1"));
            assert_eq!(workplace.n_bytes("data/a.bin"), 70_000_000);
        }
    }
}

#[test]
fn a_link_of_the_makers_is_fetched_and_not_shown() {
    let server = FileServer::start();
    server.put("signed/v1.0-mini.tgz", &bytes(3000));
    let link = format!("{}?Signature=secret", server.url("signed/v1.0-mini.tgz"));
    let workplace = Workplace::new();
    let ended =
        workplace.succeed(&("data get nuscenes --accept-licence --into here --link", [link.as_str()]));
    ended.check_stderr(&["CC BY-NC-SA 4.0", "Unpack it: tar -xf \"here/v1.0-mini.tgz\" -C \"here\""]);
    assert!(!ended.stderr.contains("secret") && !ended.stdout.contains("secret"), "{ended:#?}");
    assert_eq!(workplace.read_bytes("here/v1.0-mini.tgz"), bytes(3000));
    server.fail(Fault::Status(403));
    let ended = workplace.run(&("data get nuscenes --accept-licence --into there --link", [link.as_str()]));
    ended.check_refusal(3, &["a link may have expired"]);
    assert!(!ended.stderr.contains("secret"), "{ended:#?}");
    workplace.refuse(&["run", link.as_str()], 2, &["it has a query"]);
}

/// What it printed, but for where the data are.
fn without_path(ended: &Ended) -> String {
    ended.stdout.lines().filter(|it| !it.starts_with("path ")).collect::<Vec<_>>().join("\n")
}

/// A drawn drive at `server`, as a web server has it and in the bucket `bucket`, and the folder it is drawn in.
fn served_drive(server: &FileServer) -> Workplace {
    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), 3);
    let folder = workplace.path("street");
    server.put_folder("public/street", &folder).put_folder("bucket/drives/street", &folder);
    server.put("public/street/SHA256SUMS", &shell(SUM_UP, &folder).stdout);
    workplace
}

#[test]
fn data_sets_are_read_from_servers_and_buckets_as_from_disk() {
    let server = FileServer::start();
    let workplace = served_drive(&server);
    let from_disk = without_path(&workplace.succeed("data check street"));
    let web = server.url("public/street/");
    let endpoint = server.url("");
    let variables = [("AWS_ENDPOINT_URL", endpoint.trim_end_matches('/')), ("AWS_SKIP_SIGNATURE", "true")];
    for address in [web.as_str(), "s3://bucket/drives/street"] {
        let command = ["data", "check", address, "--cache", "cache"];
        let ended = workplace.run_with(&variables, &command);
        assert_eq!((ended.exit_code, without_path(&ended)), (Some(0), from_disk.clone()), "{ended:#?}");
        ended.check_stderr(&["fetched ", " files, ", "into cache/"]);
        server.asked();
        let again = workplace.run_with(&variables, &command);
        again.check_stderr(&["files as they are in cache/"]);
        assert_eq!(without_path(&again), from_disk);
        let fetched = server.asked().into_iter().filter(|it| it.starts_with("GET ") && it.contains(".bin "));
        assert_eq!(fetched.count(), 0);
    }
    let cache = workplace.path("of-environment");
    let variables = [variables[0], variables[1], ("XDG_CACHE_HOME", cache.to_str().unwrap())];
    let ended = workplace.run_with(&variables, "data hash s3://bucket/drives/street");
    assert_eq!(
        ended.stdout.split_whitespace().nth(1),
        workplace.succeed("data hash street").stdout.split_whitespace().nth(1)
    );
    assert!(cache.join("scanbench/s3/bucket/drives/street").is_dir());
}

#[test]
fn a_cache_follows_what_changes() {
    let server = FileServer::start();
    let workplace = served_drive(&server);
    let address = server.url("public/street/");
    let command = ["data", "check", address.as_str(), "--cache", "cache"];
    workplace.succeed(&command);
    // A label of the same size, and a scan less.
    let labels = workplace.read("street/training/label_02/0000.txt").replacen("Car", "Van", 1);
    workplace.write("street/training/label_02/0000.txt", &labels);
    let scans: Vec<PathBuf> = workplace
        .names()
        .into_iter()
        .filter(|it| it.starts_with("street") && it.extension().is_some_and(|it| it == "bin"))
        .collect();
    let last = scans.last().unwrap().strip_prefix("street").unwrap().to_str().unwrap().to_owned();
    std::fs::remove_file(workplace.path("street").join(&last)).unwrap();
    server.remove(&format!("public/street/{last}"));
    let sums = shell(SUM_UP, &workplace.path("street")).stdout;
    server
        .put("public/street/training/label_02/0000.txt", labels.as_bytes())
        .put("public/street/SHA256SUMS", &sums);
    server.age();
    let ended = workplace.succeed(&command);
    assert_eq!(without_path(&ended), without_path(&workplace.succeed("data check street")));
    server.put("public/street/training/label_02/0000.txt", &b"X".repeat(labels.len()));
    std::fs::remove_dir_all(workplace.path("cache")).unwrap();
    workplace.run(&command).check_refusal(3, &["wrong checksum", "SHA256SUMS of the server"]);
}

#[test]
fn addresses_without_data_are_named() {
    let server = FileServer::start();
    let workplace = Workplace::new();
    let address = server.url("nothing/");
    workplace
        .run(&["data", "check", &address, "--cache", "cache"])
        .check_refusal(3, &["nothing is at", "WebDAV", "SHA256SUMS"]);
    workplace.refuse(
        "data check s3://bucket/a",
        3,
        &["no credentials in the environment", "AWS_SKIP_SIGNATURE"],
    );
    workplace.refuse("data check ftp://host/a", 2, &["ftp is none of s3, gs, https and http"]);
}
