//! Sound files, changed at random from a fixed seed: readers give scans or an error, soon and with little memory.
//!
//! A few seconds in all; `SCANBENCH_MUTATION_SECONDS` sets how long each kind of data set is tried.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use harness::dataset::catalogue::{Catalogue, built_in_catalogue};
use harness::dataset::mcap::recording::is_mcap;
use harness::dataset::open::{OpenOptions, open_dataset};
use harness::dataset::source::DamagePolicy;
use rand::{Rng as _, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;

/// How long one changed data set may take to be read, on a busy machine.
const MAX_TIME: Duration = Duration::from_secs(10);

/// How much memory may be in use at once: so many bytes, and so many for each byte on disk.
const MAX_BYTES: u64 = 256 << 20;
const MAX_BYTES_FOR_EACH: u64 = 100;

fn seconds_for_each() -> f64 {
    std::env::var("SCANBENCH_MUTATION_SECONDS").ok().and_then(|it| it.parse().ok()).unwrap_or(1.0)
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

/// Changes `bytes` in one to four places.
fn mutate(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    for _ in 0..random.random_range(1..5) {
        if bytes.is_empty() {
            return;
        }
        let at = random.random_range(0..bytes.len());
        let end = (at + random.random_range(1..9)).min(bytes.len());
        match random.random_range(0..9) {
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
            // A number in text that becomes nothing, or large.
            7 => {
                let is_digit = |byte: &u8| byte.is_ascii_digit();
                let Some(begin) = bytes[at..].iter().position(is_digit).map(|it| at + it) else { continue };
                let n_digits = bytes[begin..].iter().take_while(|it| is_digit(it)).count();
                let claim = ["0", "99999999999", "18446744073709551615"][random.random_range(0..3)];
                bytes.splice(begin..begin + n_digits, claim.bytes());
            }
            // A length or number that claims to be large.
            _ => {
                let claim = [u32::MAX, i32::MAX as u32, 1 << 24, 1 << 16][random.random_range(0..4)];
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&claim.to_le_bytes()[..end - at]);
            }
        }
    }
}

fn read_all(path: &Path, catalogue: &Catalogue, damage: DamagePolicy) -> bool {
    let options = OpenOptions { damage, ..OpenOptions::default() };
    let Ok(dataset) = open_dataset(path.to_str().unwrap(), &options, catalogue) else { return false };
    (0..dataset.scan_ids().len()).all(|scan_idx| {
        let is_sound = dataset.read_scan(scan_idx).is_ok();
        is_sound && dataset.world_from_sensor(scan_idx).is_ok()
    })
}

#[track_caller]
fn check(path: &Path, seed: u64) {
    let catalogue = built_in_catalogue().unwrap();
    assert!(read_all(path, &catalogue, DamagePolicy::Refuse), "the data are damaged before they are changed");
    let files = files_below(path);
    let n_bytes: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let begun = Instant::now();
    let (mut n_cases, mut n_refused) = (0, 0);
    while begun.elapsed().as_secs_f64() < seconds_for_each() || n_cases < 50 {
        let (file, sound) = &files[random.random_range(0..files.len())];
        let mut bytes = sound.clone();
        mutate(&mut bytes, &mut random);
        std::fs::write(file, &bytes).unwrap();
        let damage = [DamagePolicy::Refuse, DamagePolicy::Skip][n_cases % 2];
        let started = Instant::now();
        let mut is_sound = false;
        let used = allocation_counter::measure(|| is_sound = read_all(path, &catalogue, damage));
        let name = format!("case {n_cases} of seed {seed}, {}", file.display());
        assert!(started.elapsed() < MAX_TIME, "{name} took {:?}", started.elapsed());
        let max_bytes = MAX_BYTES + MAX_BYTES_FOR_EACH * n_bytes as u64;
        assert!(used.bytes_max < max_bytes, "{name} used {} bytes", used.bytes_max);
        n_cases += 1;
        n_refused += usize::from(!is_sound);
        std::fs::write(file, sound).unwrap();
    }
    eprintln!("{}: {n_cases} cases, {n_refused} refused", path.display());
    assert!(n_refused > n_cases / 20, "only {n_refused} of {n_cases} were noticed");
}

#[test]
fn kitti() {
    let workplace = Workplace::new();
    let tracking = DrawnDataset::tracking(workplace.folder(), 2);
    check(&tracking.root, 1);
}

#[test]
fn semantic_kitti() {
    let workplace = Workplace::new();
    let street = ["data", "simulate", "street-narrow", "--sensor", "vlp-16", "--simulated-scans", "2"];
    workplace.succeed(&[&street[..], &["--to", "semantic-kitti", "-o", "drive"]].concat());
    check(&workplace.path("drive"), 2);
}

#[test]
fn recordings_of_foxglove() {
    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), 2);
    for (seed, compression) in [(3, "none"), (4, "lz4"), (5, "zstd")] {
        let name = format!("{compression}.mcap");
        workplace.succeed(&["data", "convert", "street", "-o", &name, "--compression", compression]);
        assert!(is_mcap(&workplace.path(&name)));
        check(&workplace.path(&name), seed);
    }
}

#[test]
fn recordings_of_ros() {
    for (seed, options) in super::mcap::write_options().into_iter().enumerate() {
        let workplace = Workplace::new();
        check(&super::mcap::write_drive(&workplace, options), 6 + seed as u64);
    }
}

#[test]
fn argoverse2() {
    let workplace = Workplace::new();
    let log = super::argoverse2::drawn();
    for (file, bytes) in files_below(&log) {
        let copy = workplace.path("log").join(file.strip_prefix(&log).unwrap());
        std::fs::create_dir_all(copy.parent().unwrap()).unwrap();
        std::fs::write(copy, bytes).unwrap();
    }
    check(&workplace.path("log"), 20);
}

#[test]
fn scan_folders() {
    let workplace = super::scan_folder::drawn();
    check(&workplace.path("drive"), 30);
    let workplace = Workplace::new();
    std::fs::create_dir(workplace.path("drive")).unwrap();
    std::fs::write(workplace.path("drive/a.pcd"), super::scan_folder::compressed_pcd()).unwrap();
    check(&workplace.path("drive"), 31);
}

#[test]
fn kitti_raw() {
    let workplace = Workplace::new();
    super::made::kitti_raw(workplace.folder(), &*super::made::street(2));
    check(workplace.folder(), 40);
}

#[test]
fn nuscenes() {
    let workplace = Workplace::new();
    super::made::nuscenes(workplace.folder(), &*super::made::street(2));
    check(workplace.folder(), 50);
}

#[test]
fn captures_of_packets() {
    use super::made::{calibration_of_64, packets, pcap, pcapng, write};
    let workplace = Workplace::new();
    let turns = packets(9000, 1200, 72, 2, [0, 0]);
    write(&workplace.path("classic/a.pcap"), pcap(&turns));
    write(&workplace.path("classic/a.yaml"), calibration_of_64());
    check(&workplace.path("classic"), 60);
    write(&workplace.path("next/a.pcapng"), pcapng(&packets(9000, 1200, 72, 1, [0x39, 0x22])));
    check(&workplace.path("next"), 61);
}

#[test]
fn las_and_laz() {
    check(&super::las::drawn().path("drive"), 70);
}

#[test]
fn projects_of_annotation_tools() {
    let workplace = Workplace::new();
    for (seed, tool) in [(80, "labelcloud"), (81, "sustechpoints"), (82, "kitti")] {
        let street = ["data", "prelabel", "street-main-road", "--sensor", "vlp-16", "--simulated-scans", "2"];
        workplace.succeed(&[&street[..], &["--to", tool, "-o", tool]].concat());
        check(&workplace.path(tool), seed);
    }
}
