//! Sound files, changed at random from a fixed seed: readers give scans or an error, soon and with little memory.
//!
//! A few seconds in all; `SCANBENCH_MUTATION_SECONDS` sets how long each kind of data set is tried. With `--nocapture` every
//! reader says how many cases there were of which kind of file, and how many it refused.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use rand::{Rng as _, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use scans::dataset::catalogue::parse_catalogue;
use scans::dataset::mcap::mcap_dataset::is_mcap;
use scans::dataset::source::DamagePolicy;
use simulator::catalogue::Catalogue;
use simulator::open::{OpenOptions, open_dataset};

use crate::drawn_dataset::DrawnDataset;
use crate::program::{Workplace, copy_folder};

/// How long one changed data set may take to be read, on a busy machine.
const MAX_TIME: Duration = Duration::from_secs(10);

/// How much memory may be in use at once: so many bytes, and so many for each byte on disk.
const MAX_BYTES: u64 = 256 << 20;
const MAX_BYTES_FOR_EACH: u64 = 100;

fn seconds_for_each() -> f64 {
    std::env::var("SCANBENCH_MUTATION_SECONDS").ok().and_then(|it| it.parse().ok()).unwrap_or(0.25)
}

/// All files below `folder`, in order, with what is in them.
fn files_below(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    if folder.is_file() {
        return vec![(folder.to_owned(), std::fs::read(folder).unwrap())];
    }
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|it| it.unwrap().path()).collect();
    entries.sort();
    entries.iter().flat_map(|it| files_below(it)).collect()
}

/// Changes `bytes` in one to four positions.
fn mutate(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    for _ in 0..random.random_range(1..5) {
        if bytes.is_empty() {
            return;
        }
        let at = random.random_range(0..bytes.len());
        let end = (at + random.random_range(1..9)).min(bytes.len());
        match random.random_range(0..10) {
            0 => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes[at] = random.next_u32() as u8,
            2 => bytes[at..end].fill(0xff),
            3 => bytes[at..end].fill(0),
            4 => bytes.truncate(at),
            5 => drop(bytes.drain(at..end)),
            6 => {
                let copied = bytes[at..end].to_vec();
                let to = random.random_range(0..=bytes.len());
                bytes.splice(to..to, copied);
            }
            // A number that is written out, such as that of the points in a header.
            8 | 9 => change_number(bytes, at, random),
            // A length or number that claims to be large.
            _ => {
                let claim = [u32::MAX, i32::MAX as u32, 1 << 24, 1 << 16][random.random_range(0..4)];
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&claim.to_le_bytes()[..end - at]);
            }
        }
    }
}

/// Gives the first number that is written out from `at` on another value: none, one too large, or the largest there is.
fn change_number(bytes: &mut Vec<u8>, at: usize, random: &mut ChaCha8Rng) {
    let is_digit = |it: &u8| it.is_ascii_digit();
    let Some(begin) = bytes[at..].iter().position(is_digit).map(|it| at + it) else { return };
    let n_digits = bytes[begin..].iter().take_while(|it| is_digit(it)).count();
    let values = ["0", "0", "1", "-1", "4294967295", "18446744073709551615", "1e300", "nan"];
    let value = values[random.random_range(0..values.len())];
    bytes.splice(begin..begin + n_digits, value.bytes());
}

/// How long reading may take, and how much memory may be in use at once.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    pub time: Duration,
    pub memory_bytes: u64,
}

/// Opens the data set at `path` and reads all of it, or says why that cannot be done.
fn read_all(path: &Path, damage: DamagePolicy) -> Result<(), String> {
    let options = OpenOptions { damage, ..OpenOptions::default() };
    let dataset =
        open_dataset(path.to_str().unwrap(), &options, &no_catalogue()).map_err(|error| error.to_string())?;
    for scan_idx in 0..dataset.scan_ids().len() {
        let scan = dataset.read_scan(scan_idx).map_err(|error| error.to_string())?;
        assert_eq!(scan.point_regions.len(), scan.cloud.len(), "{}", path.display());
        let n_points = scan.cloud.len() as u32;
        let points = scan.annotations.iter().flat_map(|it| &it.point_indices);
        assert!(points.copied().all(|it| it < n_points), "{}", path.display());
        assert!(scan.cloud.positions_m().flatten().all(|it| it.abs() <= 10_000.0), "{}", path.display());
        dataset.world_from_sensor(scan_idx).map_err(|error| error.to_string())?;
    }
    dataset.oddities().map(drop).map_err(|error| error.to_string())
}

fn no_catalogue() -> Catalogue {
    parse_catalogue("datasets.toml", "").unwrap()
}

/// Reads the data set at `path`, see [`within`].
#[track_caller]
pub fn read_within(path: &Path, damage: DamagePolicy, limits: Limits, name: &str) -> Result<(), String> {
    let owned = path.to_owned();
    within(limits, name, move || read_all(&owned, damage))
}

/// How many times the limit is waited for: other processes may use the processors, too.
const LONGEST_WAIT: u32 = 20;

/// Time on processors of this thread.
#[cfg(unix)]
fn time_of_thread() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Time, where that of a thread is not asked for.
#[cfg(not(unix))]
fn time_of_thread() -> Duration {
    std::time::UNIX_EPOCH.elapsed().unwrap()
}

/// Lets `read` work in a thread of its own, so that what never ends fails and does not hang.
///
/// Panics if it panics, takes more of a processor's time or more memory than `limits`; `name` is what it is called then.
#[track_caller]
pub fn within(
    limits: Limits,
    name: &str,
    work: impl FnOnce() -> Result<(), String> + Send + 'static,
) -> Result<(), String> {
    let (send, receive) = mpsc::channel();
    let reader = std::thread::spawn(move || {
        let mut read = Ok(());
        let begun = time_of_thread();
        let used = allocation_counter::measure(|| read = work());
        // Nobody listens any more where it took too long.
        let _ = send.send((read, used.bytes_max, time_of_thread().saturating_sub(begun)));
    });
    match receive.recv_timeout(limits.time * LONGEST_WAIT) {
        Ok((read, bytes_max, time)) => {
            assert!(bytes_max < limits.memory_bytes, "{name} used {bytes_max} bytes");
            assert!(time < limits.time, "{name} took {time:?}");
            read
        }
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("{name} does not end"),
        Err(mpsc::RecvTimeoutError::Disconnected) => {
            drop(reader.join());
            panic!("{name} panicked");
        }
    }
}

/// Changes the files of the sound data set at `path` again and again. `reader` is what is printed beside the counts.
#[track_caller]
fn check(reader: &str, path: &Path, seed: u64) {
    check_with(reader, path, seed, |damage, limits, name| read_within(path, damage, limits, name));
}

/// Changes the files at `path`, which `read` reads, again and again.
#[track_caller]
pub fn check_with(
    reader: &str,
    path: &Path,
    seed: u64,
    read: impl Fn(DamagePolicy, Limits, &str) -> Result<(), String>,
) {
    let files = files_below(path);
    let n_bytes: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    let limits = Limits { time: MAX_TIME, memory_bytes: MAX_BYTES + MAX_BYTES_FOR_EACH * n_bytes as u64 };
    read(DamagePolicy::Refuse, limits, "what is sound").expect("sound before it is changed");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let begun = Instant::now();
    let (mut n_cases, mut n_refused) = (0, 0);
    let mut n_by_kind: BTreeMap<String, u32> = BTreeMap::new();
    while begun.elapsed().as_secs_f64() < seconds_for_each() || n_cases < 50 {
        let (file, sound) = &files[random.random_range(0..files.len())];
        let mut bytes = sound.clone();
        mutate(&mut bytes, &mut random);
        std::fs::write(file, &bytes).unwrap();
        let damage = [DamagePolicy::Refuse, DamagePolicy::Skip][n_cases % 2];
        let name = format!("case {n_cases} of seed {seed}, {}", file.display());
        let read = read(damage, limits, &name);
        n_cases += 1;
        n_refused += usize::from(read.is_err());
        let kind = file.extension().map(|it| it.to_string_lossy().into_owned()).unwrap_or_default();
        *n_by_kind.entry(kind).or_default() += 1;
        std::fs::write(file, sound).unwrap();
    }
    let kinds: Vec<String> = n_by_kind.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
    eprintln!("mutations: {reader}: {n_cases} cases ({}), {n_refused} refused", kinds.join(", "));
    assert!(n_refused > n_cases / 20, "only {n_refused} of {n_cases} were noticed");
}

#[test]
fn kitti_tracking() {
    let workplace = Workplace::new();
    let tracking = DrawnDataset::tracking(workplace.folder(), 2);
    check("kitti-tracking", &tracking.root, 1);
}

#[test]
fn kitti_object() {
    let workplace = Workplace::new();
    let objects = DrawnDataset::objects(workplace.folder(), 2);
    // An image, of which the size is read.
    let png =
        [&b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], &1242_u32.to_be_bytes(), &375_u32.to_be_bytes()].concat();
    objects.write("training/image_2/000000.png", png);
    check("kitti-object", &objects.root, 90);
}

/// With a sheet, and a file that says point by point what is labelled.
#[test]
fn kitti_layouts_written() {
    let workplace = Workplace::new();
    let street =
        ["data", "simulate", "street-main-road-ahead", "--sensor", "vlp-16", "--simulated-scans", "2"];
    for (seed, format) in [(91, "kitti-tracking"), (92, "kitti-object")] {
        workplace.succeed(&(&street, ["--to", format, "-o", format]));
        assert!(workplace.names().iter().any(|it| it.extension().is_some_and(|it| it == "u8")), "{format}");
        check(&format!("{format}, written by scanbench"), &workplace.path(format), seed);
    }
}

#[test]
fn semantic_kitti() {
    let workplace = Workplace::new();
    let street = ["data", "simulate", "street-narrow", "--sensor", "vlp-16", "--simulated-scans", "2"];
    workplace.succeed(&(&street, "--to semantic-kitti -o drive"));
    check("semantic-kitti", &workplace.path("drive"), 2);
}

#[test]
fn recordings_of_foxglove() {
    let workplace = Workplace::with_drive(2);
    for (seed, compression) in [(3, "none"), (4, "lz4"), (5, "zstd")] {
        let name = format!("{compression}.mcap");
        workplace.succeed(&["data", "convert", "street", "-o", &name, "--compression", compression]);
        assert!(is_mcap(&workplace.path(&name)));
        check(&format!("mcap, Foxglove in protobuf, {compression}"), &workplace.path(&name), seed);
    }
}

#[test]
fn recordings_of_foxglove_in_json() {
    use super::recordings::{SECOND, category, foxglove_messages, write};
    let workplace = Workplace::new();
    let messages: Vec<_> =
        (1..4).flat_map(|second| foxglove_messages(second * SECOND, &category("car"))).collect();
    let options = mcap::WriteOptions::new().compression(None);
    check("mcap, Foxglove in JSON", &write(&workplace, options, &messages), 12);
}

#[test]
fn recordings_of_ros() {
    for (seed, options) in super::recordings::write_options().into_iter().enumerate() {
        let workplace = Workplace::new();
        let path = super::recordings::write_drive(&workplace, options);
        check(&format!("mcap, ROS 2, way of writing {seed}"), &path, 6 + seed as u64);
    }
}

#[test]
fn argoverse2() {
    let workplace = Workplace::new();
    copy_folder(&super::argoverse2::drawn(), &workplace.path("log"));
    check("argoverse2", &workplace.path("log"), 20);
}

#[test]
fn scan_folders() {
    let workplace = super::scan_folder::drawn();
    std::fs::remove_file(workplace.path("drive/readme.txt")).unwrap();
    check("scan-folder: .bin, .npy, PCD and PLY as text, JSON", &workplace.path("drive"), 30);
}

/// PCD and PLY as bytes, and arrays column by column.
#[test]
fn scan_folders_of_packed_points() {
    let workplace = Workplace::new();
    let rows: Vec<u8> = [5.0_f32, 1.0, -1.0, 20.0, 0.0, 0.0].iter().flat_map(|it| it.to_le_bytes()).collect();
    let columns: Vec<u8> =
        [5.0_f32, 20.0, 1.0, 0.0, -1.0, 0.0].iter().flat_map(|it| it.to_le_bytes()).collect();
    let write = |name: &str, header: &str, points: &[u8]| {
        workplace.write(name, &[header.as_bytes(), points].concat());
    };
    let pcd = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ";
    write("a.pcd", &format!("{pcd}binary\n"), &rows);
    // Compressed to bytes as they are.
    let lzf = [&[columns.len() as u8 - 1], &columns[..]].concat();
    let sizes = [lzf.len() as u32, columns.len() as u32].map(u32::to_le_bytes).concat();
    write("b.pcd", &format!("{pcd}binary_compressed\n"), &[sizes, lzf].concat());
    for (name, format) in [("c.ply", "binary_little_endian"), ("d.ply", "binary_big_endian")] {
        let points: Vec<u8> = if format == "binary_big_endian" {
            rows.chunks_exact(4).flat_map(|it| it.iter().rev().copied()).collect()
        } else {
            rows.clone()
        };
        let properties = "property float x\nproperty float y\nproperty float z\n";
        write(
            name,
            &format!("ply\nformat {format} 1.0\nelement vertex 2\n{properties}end_header\n"),
            &points,
        );
    }
    let header = "{'descr': '<f4', 'fortran_order': True, 'shape': (2, 3), }";
    let npy = [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &columns]
        .concat();
    workplace.write("e.npy", &npy);
    check("scan-folder: PCD and PLY as bytes, .npy by columns", workplace.folder(), 31);
}

/// Labels in KITTI's lines beside scans, with a calibration.
#[test]
fn scan_folders_with_labels_of_kitti() {
    let workplace = Workplace::new();
    std::fs::create_dir_all(workplace.path("of")).unwrap();
    let objects = DrawnDataset::objects(&workplace.path("of"), 2);
    for (from, to) in [("velodyne", "lidar"), ("label_2", "label_2"), ("calib", "calib")] {
        std::fs::create_dir_all(workplace.path("drive")).unwrap();
        std::fs::rename(objects.path(&format!("training/{from}")), workplace.path(&format!("drive/{to}")))
            .unwrap();
    }
    // Not those of a benchmark: one calibration for all.
    std::fs::rename(workplace.path("drive/calib/000000.txt"), workplace.path("drive/calib.txt")).unwrap();
    std::fs::remove_dir_all(workplace.path("drive/calib")).unwrap();
    let parts = workplace.path("drive/labels");
    std::fs::rename(workplace.path("drive/label_2"), parts).unwrap();
    check("scan-folder: labels of KITTI", &workplace.path("drive"), 32);
}

#[test]
fn kitti_raw() {
    let workplace = Workplace::new();
    super::made::kitti_raw(workplace.folder(), &*super::made::street(2));
    check("kitti-raw", workplace.folder(), 40);
}

#[test]
fn nuscenes() {
    let workplace = Workplace::new();
    super::made::nuscenes(workplace.folder(), &*super::made::street(2));
    check("nuscenes", workplace.folder(), 50);
}

#[test]
fn captures_of_packets() {
    use super::made::{calibration_of_64, packets, pcap, pcapng};
    let workplace = Workplace::new();
    let turns = packets(9000, 1200, 72, 2, [0, 0]);
    workplace.write("classic/a.pcap", &pcap(&turns));
    workplace.write("classic/a.yaml", &calibration_of_64());
    check("velodyne-pcap: pcap, calibration in YAML", &workplace.path("classic"), 60);
    workplace.write("next/a.pcapng", &pcapng(&packets(9000, 1200, 72, 1, [0x39, 0x22])));
    check("velodyne-pcap: pcapng", &workplace.path("next"), 61);
    workplace.write("xml/a.pcap", &pcap(&turns));
    workplace.write("xml/db.xml", &calibration_in_xml());
    check("velodyne-pcap: calibration in XML", &workplace.path("xml"), 62);
}

/// Lasers a third of a degree apart, as the maker lists them.
fn calibration_in_xml() -> String {
    let laser = |id: u32| {
        let vertical = 2.0 - f64::from(id) / 3.0;
        format!(
            "<item><px><id_>{id}</id_><vertCorrection_>{vertical}</vertCorrection_><distCorrection_>120</distCorrection_></px></item>"
        )
    };
    let lasers: String = (0..64).map(laser).collect();
    format!(
        "<?xml version=\"1.0\"?><boost_serialization><DB><distLSB_>0.2</distLSB_><points_>{lasers}</points_></DB></boost_serialization>"
    )
}

#[test]
fn las_and_laz() {
    check("scan-folder: LAS and LAZ", &super::las::drawn().path("drive"), 70);
}

#[test]
fn projects_of_annotation_tools() {
    let workplace = Workplace::new();
    for (seed, tool) in [(80, "labelcloud"), (81, "sustechpoints"), (82, "kitti")] {
        let street = ["data", "prelabel", "street-main-road", "--sensor", "vlp-16", "--simulated-scans", "2"];
        workplace.succeed(&(&street, ["--to", tool, "-o", tool]));
        check(&format!("project of {tool}"), &workplace.path(tool), seed);
    }
}
