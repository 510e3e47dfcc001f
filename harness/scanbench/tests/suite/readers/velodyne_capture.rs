//! Captures of Velodyne's packets, drawn: there are no real ones here.

use proptest::prelude::*;
use scans::annotation::PointRegion;
use scans::dataset::source::{DamagePolicy, TopicChoice};
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

use super::made::{Captured, Head, calibration_of_64, packets, pcap, pcap_at, pcapng, steps_of, write};
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

/// Measurements with a return in the blocks of a packet whose returns are taken.
fn n_taken(bytes: &[u8], block: usize, head: &Head) -> usize {
    let is_dual = head.n_blocks_of_column == if head.last == [0, 0] { 4 } else { 2 };
    let is_taken = match (is_dual, head.last) {
        (false, _) => true,
        (true, [0, 0]) => block % 4 >= 2,
        (true, _) => block.is_multiple_of(2),
    };
    let measurements = bytes[100 * block + 4..100 * (block + 1)].chunks_exact(3);
    if is_taken { measurements.filter(|it| it[..2] != [0, 0]).count() } else { 0 }
}

/// The points of each turn that has any.
fn points_of_turns(packets: &[Captured], head: &Head) -> Vec<usize> {
    let mut n_by_turn = std::collections::BTreeMap::<u32, usize>::new();
    for packet in packets {
        for (block, turn) in packet.turns.iter().enumerate() {
            *n_by_turn.entry(*turn).or_default() += n_taken(&packet.bytes, block, head);
        }
    }
    n_by_turn.into_values().collect()
}

fn capture_of(packets: &[Captured]) -> Vec<u8> {
    pcap_at(&packets.iter().map(|it| (it.time_ns, it.bytes.clone(), 201)).collect::<Vec<_>>())
}

/// The points of each scan of a capture of these packets.
fn points_of_scans(packets: &[Captured]) -> Vec<usize> {
    let workplace = Workplace::new();
    write(&workplace.path("a.pcap"), capture_of(packets));
    write(&workplace.path("a.yaml"), calibration_of_64());
    // Only an HDL-64E needs its lasers named.
    if packets[0].bytes[1204..] != [0, 0] {
        std::fs::remove_file(workplace.path("a.yaml")).unwrap();
    }
    let dataset = open(&workplace.path("a.pcap"));
    (0..dataset.scan_ids().len()).map(|it| dataset.read_scan(it).unwrap().cloud.len()).collect()
}

#[test]
fn a_turn_of_a_limited_field_of_view_is_one_scan() {
    for (field, turns_per_s, first) in [([27_000, 9000], 10, 18_000), ([10_000, 25_000], 20, 0)] {
        let head = Head {
            field,
            first,
            turned: 36_000 * 5 + 15_000,
            turns_per_s,
            is_clockwise: true,
            n_blocks_of_column: 1,
            last: VLP_16,
        };
        let packets = head.packets();
        let found = points_of_scans(&packets);
        // The sixth turn is not whole.
        let expected = points_of_turns(&packets, &head);
        assert_eq!(expected.len(), 6);
        assert_eq!(found, expected[..5]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// No point is lost but those of turns that are not whole at both ends, and none is in another turn.
    #[test]
    fn scans_are_turns_whatever_is_seen(
        [from, width] in prop_oneof![
            Just([0, 0]), prop::array::uniform2(2000_u32..34_000), (0_u32..36_000).prop_map(|it| [it, 18_000]),
        ],
        first in 0_u32..36_000,
        n_turns in 3_u32..6,
        turns_per_s in prop::sample::select(vec![5_u32, 10, 20]),
        is_clockwise in any::<bool>(),
        sensor in prop::sample::select(vec![(1, VLP_16), (2, [0x39, 0x22]), (1, HDL_32E), (2, [0x39, 0x21]), (2, [0, 0]), (4, [0, 0])]),
        lost in prop::collection::vec((0_usize..2000, 1_usize..8), 0..4),
    ) {
        let head = Head {
            field: [from, (from + width) % 36_000],
            first,
            turned: 36_000 * n_turns + 7000,
            turns_per_s,
            is_clockwise,
            n_blocks_of_column: sensor.0,
            last: sensor.1,
        };
        let mut packets = head.packets();
        for (at, n) in lost {
            let at = at % packets.len();
            packets.drain(at..(at + n).min(packets.len()));
        }
        prop_assume!(!packets.is_empty());
        let (found, expected) = (points_of_scans(&packets), points_of_turns(&packets, &head));
        // Turns at the ends may be left out, if they are not whole.
        let is_part = (0..2).flat_map(|first| (0..2).map(move |last| (first, last))).any(|(first, last)| {
            expected.len() >= first + last && found == expected[first..expected.len() - last]
        });
        prop_assert!(is_part, "{:?} of {:?}: {:?}", found, expected, head);
        let n_left_out = expected.len() - found.len();
        let most = expected.iter().max().copied().unwrap_or_default();
        let left_out = expected.iter().sum::<usize>() - found.iter().sum::<usize>();
        prop_assert!(left_out <= n_left_out * most);
        // A field that begins and ends with whole turns loses none.
        prop_assert!(found.len() + 2 >= expected.len());
    }
}

#[test]
fn the_sensor_is_chosen_where_several_send() {
    let workplace = Workplace::new();
    let path = workplace.path("a.pcap");
    let own = turns(1, VLP_16);
    let at = |number: usize| 1_600_000_000_000_000_000 + 1_327_000 * number as u64;
    let both: Vec<(u64, Vec<u8>, u8)> = own
        .iter()
        .enumerate()
        .flat_map(|(number, it)| {
            [(at(number), it.clone(), 201), (at(number), own[own.len() - 1 - number].clone(), 202)]
        })
        .collect();
    write(&path, pcap_at(&both));
    let n = own.len();
    let several = format!(
        "has packets of several sensors to port 2368; choose one with --topic ADDRESS: 192.168.1.201 ({n} packets), \
         192.168.1.202 ({n} packets)"
    );
    workplace.refuse("detect a.pcap --scan 0", 2, &[&several]);
    workplace.succeed("detect a.pcap --scan 0 --topic 192.168.1.201");
    let options = |sender: &str| {
        let topics = TopicChoice { cloud: Some(sender.to_owned()), annotations: None };
        OpenOptions { topics, ..OpenOptions::default() }
    };
    let catalogue = built_in_catalogue().unwrap();
    let chosen = open_dataset(path.to_str().unwrap(), &options("192.168.1.201"), &catalogue).unwrap();
    assert_eq!(chosen.read_scan(0).unwrap().cloud.len(), n_returns(32));
    for (sender, part) in
        [("192.168.1.7", "has no packets from 192.168.1.7"), ("/top", "no address of a sender")]
    {
        let error =
            open_dataset(path.to_str().unwrap(), &options(sender), &catalogue).err().expect("another");
        assert!(error.is_usage_error() && error.to_string().contains(part), "{error}");
    }
}

#[test]
fn a_turn_without_returns_is_an_empty_scan() {
    let mut packets = turns(1, VLP_16);
    // The first whole turn.
    for column in 675..1575 {
        let block = column % 12;
        packets[column / 12][100 * block + 4..100 * (block + 1)].fill(0);
    }
    let workplace = Workplace::new();
    workplace.write("a.pcap", &pcap(&packets));
    let dataset = open(&workplace.path("a.pcap"));
    assert_eq!(dataset.read_scan(0).unwrap().cloud.len(), 0);
    assert_eq!(dataset.read_scan(1).unwrap().cloud.len(), n_returns(32));
}
