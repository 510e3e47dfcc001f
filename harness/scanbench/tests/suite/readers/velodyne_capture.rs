//! Captures of Velodyne's packets, drawn: there are no real ones here.

use scans::annotation::PointRegion;
use scans::dataset::source::DamagePolicy;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

use super::made::{calibration_of_64, packets, pcap, pcapng, steps_of, write};
use super::{check_damaged, open};
use crate::program::Workplace;

const VLP_16: [u8; 2] = [0x37, 0x22];
const HDL_32E: [u8; 2] = [0x37, 0x21];

/// Three turns from 90° on, so that two are whole: 0.4° a column, 900 of them a turn.
fn turns(n_banks: usize, last: [u8; 2]) -> Vec<Vec<u8>> {
    packets(9000, 2700, 40, n_banks, last)
}

/// Measurements of a whole turn that have a return.
fn n_returns(n_lasers: usize) -> usize {
    let azimuths = (0..900).map(|it| it * 40);
    azimuths.map(|azimuth| (0..n_lasers).filter(|laser| steps_of(*laser, azimuth) > 0).count()).sum()
}

#[test]
fn revolutions_are_cut_where_the_azimuth_is_0() {
    for (name, bytes) in [("a.pcap", pcap(&turns(1, HDL_32E))), ("a.pcapng", pcapng(&turns(1, HDL_32E)))] {
        let workplace = Workplace::new();
        workplace.write(name, &bytes);
        let dataset = open(&workplace.path(name));
        assert_eq!(
            (dataset.description().format.as_str(), dataset.description().sensor.as_str()),
            ("velodyne-pcap", "hdl-32e")
        );
        assert_eq!(dataset.scan_ids().len(), 2);
        assert_eq!(dataset.scan_ids()[1].to_string(), "a/000001");
        // 675 columns, 12 a packet, before the first whole turn.
        assert_eq!(dataset.scan_time_ns(0), Some(1_600_000_000_000_000_000 + 56 * 1_327_000));
        for scan_idx in 0..2 {
            let scan = dataset.read_scan(scan_idx).unwrap();
            assert_eq!(scan.cloud.len(), n_returns(32));
            assert!(scan.point_regions.iter().all(|it| *it == PointRegion::Outside));
            let [x, y, _] = scan.cloud.position_m(0);
            assert!(x > 3.0 && y.abs() < 0.05, "the first points are ahead: {x} {y}");
            let rings = scan.cloud.ring().unwrap();
            assert!((0..32).all(|it| rings.contains(&it)) && rings.len() == n_returns(32));
            // Their clocks stand still, as in captures that were made of something else.
            assert_eq!(scan.cloud.time_offset_s(), None);
        }
    }
}

#[test]
fn points_have_the_times_of_their_packets() {
    let workplace = Workplace::new();
    let mut packets = turns(1, HDL_32E);
    // The hour ends within the first turn.
    for (number, packet) in (0_u32..).zip(&mut packets) {
        let micros = (3_600_000_000_u64 - 60_000 + 553 * u64::from(number)) % 3_600_000_000;
        packet[1200..1204].copy_from_slice(&(micros as u32).to_le_bytes());
    }
    workplace.write("a.pcap", &pcap(&packets));
    let scan = open(&workplace.path("a.pcap")).read_scan(0).unwrap();
    let times_s = scan.cloud.time_offset_s().unwrap();
    assert!(times_s.windows(2).all(|it| it[0] < it[1]) && times_s[0] >= 0.0, "{:?}", &times_s[..40]);
    let n_packets = n_returns(32) as f32 / (12.0 * 32.0);
    let last_s = times_s[times_s.len() - 1];
    assert!((last_s - 553e-6 * n_packets).abs() < 0.1 * last_s, "{last_s}");

    // One clock that was set meanwhile.
    packets[100][1200..1204].copy_from_slice(&7_u32.to_le_bytes());
    workplace.write("b.pcap", &pcap(&packets));
    assert_eq!(open(&workplace.path("b.pcap")).read_scan(0).unwrap().cloud.time_offset_s(), None);
}

#[test]
fn sixteen_and_sixty_four_lasers_are_read_too() {
    let workplace = Workplace::new();
    workplace.write("vlp.pcap", &pcap(&turns(1, VLP_16)));
    let scan = open(&workplace.path("vlp.pcap")).read_scan(0).unwrap();
    assert_eq!(scan.cloud.len(), n_returns(32));
    let highest = scan.cloud.z_m().iter().copied().fold(f32::MIN, f32::max);
    assert!(highest > 3.0 && highest < 5.0, "{highest}");

    // Calibrated one by one: without a file nobody knows where the lasers point.
    workplace.write("hdl.pcap", &pcap(&turns(2, [0x48, 0x07])));
    check_damaged(&workplace.path("hdl.pcap"), &["db.xml", "does not exist"]);
    workplace.write("hdl.yaml", &calibration_of_64());
    let scan = open(&workplace.path("hdl.pcap")).read_scan(0).unwrap();
    assert_eq!(scan.cloud.len(), n_returns(64));
    workplace.write("hdl.yaml", calibration_of_64().split("- {laser_id: 63").next().unwrap());
    check_damaged(&workplace.path("hdl.pcap"), &["hdl.yaml", "has 63 lasers"]);
}

#[test]
fn verbs_take_captures_and_a_run_says_that_nothing_is_labelled() {
    let workplace = Workplace::new();
    workplace.write("a.pcap", &pcap(&turns(1, VLP_16)));
    workplace.succeed("data check a.pcap");
    workplace.succeed("detect a.pcap --scan 1");
    workplace.succeed("data convert a.pcap -o a.mcap");
    assert_eq!(
        open(&workplace.path("a.mcap")).read_scan(1).unwrap().cloud,
        open(&workplace.path("a.pcap")).read_scan(1).unwrap().cloud
    );
    workplace
        .succeed("run a.pcap -d pca --no-rrd -o run")
        .check_stderr(&["\"a\" has no labels: nothing is scored"]);
    assert!(workplace.path("run/agreement.csv").exists());
}

#[test]
fn damage_is_named_or_skipped() {
    let workplace = Workplace::new();
    let path = workplace.path("a.pcap");
    let skipping = || {
        let options = OpenOptions { damage: DamagePolicy::Skip, ..OpenOptions::default() };
        open_dataset(path.to_str().unwrap(), &options, &built_in_catalogue().unwrap()).unwrap()
    };
    let bytes = pcap(&turns(1, VLP_16));
    write(&path, &bytes[..bytes.len() - 100]);
    check_damaged(&path, &["is cut off at byte"]);
    assert_eq!(skipping().left_out().map(|it| it.contains("is cut off")), Some(true));
    assert_eq!(skipping().scan_ids().len(), 2);
    let mut bad = turns(1, VLP_16);
    bad[100][2..4].copy_from_slice(&40_000_u16.to_le_bytes());
    write(&path, pcap(&bad));
    check_damaged(&path, &["azimuth of 40000"]);
    assert!(skipping().left_out().unwrap().contains("azimuth of 40000"));
    write(&path, pcap(&turns(1, [0x37, 0x28])));
    check_damaged(&path, &["packets of an unknown sensor, 0x28"]);
    let mut huge = bytes;
    huge[24 + 8..24 + 12].fill(0xff);
    write(&path, huge);
    check_damaged(&path, &["a packet of more than 524288 bytes at byte 24"]);
    write(&path, pcap(&[vec![0; 500]]));
    check_damaged(&path, &["has no data packets"]);
}
