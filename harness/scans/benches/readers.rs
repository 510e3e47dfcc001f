//! How fast scans are read: the same simulated scans in every format, one core, files in the page cache. Packets are drawn.
//!
//! `cargo bench -p scans` prints the most of several passes, in megabytes of the files and in scans a second.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark prints and may panic")]

use std::path::Path;
use std::time::Instant;

use scans::conversion::ConversionError;
use scans::conversion::convert::{Output, convert};
use scans::conversion::mcap_writer::ChunkCompression;
use scans::conversion::output_format::OutputFormat;
use scans::dataset::Dataset;
use scans::dataset::point_columns::PointColumns;
use scans::dataset::scan_columns::ScanColumns;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

#[path = "../../scanbench/tests/suite/readers/made/mod.rs"]
#[allow(dead_code, unused_imports, reason = "the tests make more of it")]
mod made;

const N_SCANS: u32 = 10;
const N_PASSES: usize = 9;

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let catalogue = built_in_catalogue().unwrap();
    let options = OpenOptions { n_simulated_scans: Some(N_SCANS), ..OpenOptions::default() };
    let street = open_dataset("street-main-road", &options, &catalogue).unwrap();
    let all: Vec<usize> = (0..N_SCANS as usize).collect();
    println!("{N_SCANS} simulated scans of an HDL-64E; the most of {N_PASSES} passes");
    for (name, format, compression) in [
        ("KITTI tracking", OutputFormat::KittiTracking, ChunkCompression::None),
        ("SemanticKITTI", OutputFormat::SemanticKitti, ChunkCompression::None),
        ("MCAP", OutputFormat::Mcap, ChunkCompression::None),
        ("MCAP, LZ4", OutputFormat::Mcap, ChunkCompression::Lz4),
        ("MCAP, Zstandard", OutputFormat::Mcap, ChunkCompression::Zstd),
    ] {
        let path = folder.path().join(name);
        let output = Output { path: &path, format, compression };
        convert(&*street, &all, output, |_, error| Err(error), || Ok::<(), ConversionError>(())).unwrap();
        let dataset = open_dataset(path.to_str().unwrap(), &OpenOptions::default(), &catalogue).unwrap();
        time(name, n_bytes(&path), || {
            for scan_idx in 0..all.len() {
                std::hint::black_box(dataset.read_scan(scan_idx).unwrap());
            }
        });
        if format == OutputFormat::KittiTracking {
            let mut files = Vec::new();
            list(&path.join("training/velodyne"), &mut files);
            let n_bytes = files.iter().map(|it| std::fs::metadata(it).unwrap().len()).sum();
            let columns = ScanColumns::new(None, PointColumns::of_kitti(), &files);
            time("Velodyne .bin", n_bytes, || {
                for file in &files {
                    std::hint::black_box(columns.read(file).unwrap());
                }
            });
        }
    }
    time_made(&*street, folder.path());
}

/// Data sets in layouts that are only read.
fn time_made(street: &dyn Dataset, folder: &Path) {
    made::kitti_raw(&folder.join("raw"), street);
    made::nuscenes(&folder.join("nuscenes"), street);
    for (number, scan) in made::scans(street).iter().enumerate() {
        let points: Vec<[i32; 3]> =
            scan.cloud.positions_m().map(|it| it.map(|value| (value * 100.0) as i32)).collect();
        for (name, is_compressed) in [("las", false), ("laz", true)] {
            let bytes = made::las_file(&points, [0.0; 3], 0, is_compressed);
            made::write(&folder.join(format!("{name}/{number}.{name}")), bytes);
        }
    }
    // Packets of 32 lasers, 1800 columns a turn, and one more turn than is asked for, which is not whole.
    let packets = made::packets(18_000, 1800 * (N_SCANS as usize + 1), 20, 1, [0x37, 0x21]);
    made::write(&folder.join("capture/drawn.pcap"), made::pcap(&packets));
    for (name, of) in [
        ("KITTI raw", "raw"),
        ("nuScenes", "nuscenes"),
        ("LAS", "las"),
        ("LAZ", "laz"),
        ("Velodyne pcap", "capture"),
    ] {
        let path = folder.join(of);
        let catalogue = built_in_catalogue().unwrap();
        let dataset = open_dataset(path.to_str().unwrap(), &OpenOptions::default(), &catalogue).unwrap();
        assert_eq!(dataset.scan_ids().len(), N_SCANS as usize);
        time(name, n_bytes(&path), || {
            for scan_idx in 0..N_SCANS as usize {
                std::hint::black_box(dataset.read_scan(scan_idx).unwrap());
            }
        });
    }
}

fn time(name: &str, n_bytes: u64, read: impl Fn()) {
    let passes = (0..N_PASSES).map(|_| {
        let started = Instant::now();
        read();
        started.elapsed().as_secs_f64()
    });
    let least_s = passes.fold(f64::INFINITY, f64::min);
    let (megabytes, scans) = (n_bytes as f64 / 1e6 / least_s, f64::from(N_SCANS) / least_s);
    println!("{name:<16} {megabytes:>6.0} MB/s {scans:>6.0} scans/s");
}

fn list(folder: &Path, files: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { list(&path, files) } else { files.push(path) }
    }
}

fn n_bytes(path: &Path) -> u64 {
    if path.is_file() {
        return std::fs::metadata(path).unwrap().len();
    }
    let mut files = Vec::new();
    list(path, &mut files);
    files.iter().map(|it| std::fs::metadata(it).unwrap().len()).sum()
}
