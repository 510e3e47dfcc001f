//! Captures of packets as scans, one for each [turn](super::turns) of the head.
//!
//! ```text
//! NAME.pcap, NAME.pcapng               the packets
//! NAME.xml, .yaml or .yml, or db.xml   beside it: the calibration, which an HDL-64E needs
//! ```
//!
//! The packets are read once when a capture is opened; only their positions stay in memory.

use std::collections::BTreeMap;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};

use reports::files::regular_file::RegularFile;

use super::calibration_file::parse_calibration_file;
use super::capture_file::{Payload, Walked, Wanted, walk_payloads};
use super::data_packet::{DATA_PORT, DataPacket, Firing, N_BLOCKS, N_PACKET_BYTES, Rotation};
use super::laser_table::{Laser, VelodyneModel, lasers_of};
use super::turns::{PacketAzimuths, Turn, turns_of};
use crate::annotation::{LabeledArea, LabeledScan, PointRegion, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::on_disk::stem_of;
use crate::dataset::positioned_points::PositionedPoints;
use crate::dataset::source::{DamagePolicy, DatasetSource, StatedBy};
use crate::dataset::text_file::read_text_file;
use crate::dataset::unpaired_files::few_of;
use crate::dataset::{Dataset, DatasetError, Listing};

/// The clock of a packet starts again after this many microseconds.
const MICROS_OF_HOUR: u32 = 3_600_000_000;

/// Packets of a sensor follow each other sooner than this; otherwise their clock was set in between, or there is none.
const MAX_MICROS_BETWEEN_PACKETS: u64 = 1_000_000;

/// An open capture.
#[derive(Debug)]
struct VelodyneCapture {
    listing: Listing,
    path: PathBuf,
    lasers: Vec<Laser>,
    rotation: Rotation,
    // Invariant: `scan_ids` and `turns` have the same length and order.
    turns: Vec<Turn>,
    payloads: Vec<Payload>,
    left_out: Option<String>,
}

/// Opens the capture of `source`.
///
/// If several sensors send to one port, the user chooses one by its address, in place of a topic. If damage is skipped,
/// invalid packets are skipped too, and so is the end of a capture that is cut off.
pub fn open_velodyne_capture(source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let path = source.path.clone();
    let sender = source.parts.topics.cloud.as_deref().map(|it| address(&path, it)).transpose()?;
    let mut packets = Packets::default();
    let mut first_bad = None;
    let wanted = Wanted { port: DATA_PORT, length: N_PACKET_BYTES, sender };
    let Walked { n_by_sender, cut_off } = walk_payloads(&path, wanted, |payload, bytes| {
        let bytes: &[u8; N_PACKET_BYTES] = bytes.try_into().map_err(|_| "has a packet of another length")?;
        match DataPacket::parse(bytes).and_then(|packet| packets.add(payload, &packet)) {
            Err(problem) if source.damage == DamagePolicy::Skip => {
                first_bad.get_or_insert(problem);
                Ok(())
            }
            added => added,
        }
    })?;
    if let (Some(problem), DamagePolicy::Refuse) = (&cut_off, source.damage) {
        return Err(DatasetError::Damaged { path, problem: problem.clone() });
    }
    refuse_several(&path, sender, &n_by_sender)?;
    let Packets { model: Some(model), payloads, azimuths } = packets else {
        let problem = format!("has no data packets of a Velodyne sensor to port {DATA_PORT}");
        return Err(DatasetError::Damaged { path, problem: first_bad.unwrap_or(problem) });
    };
    let (turns, rotation) = turns_of(&azimuths);
    let mut checksum = DatasetChecksum::default();
    checksum.add_file("capture", &path)?;
    let lasers = lasers_beside(&path, model, &mut checksum)?;
    let sequence = stem_of(&path);
    let scan_ids =
        (0..turns.len() as u32).map(|index| ScanId { sequence: sequence.clone(), index }).collect();
    let mut source = source;
    if source.stated_by == StatedBy::Nobody {
        model.sensor().clone_into(&mut source.sensor);
    }
    let description = source.describe(DatasetFormat::VelodynePcap, checksum.finish());
    let left_out = cut_off.or(first_bad);
    let listing = Listing { description, scan_ids };
    Ok(Box::new(VelodyneCapture { listing, path, lasers, rotation, turns, payloads, left_out }))
}

impl Dataset for VelodyneCapture {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let (cloud, points_left_out) = self.read_points(&self.turns[scan_idx])?.into_parts();
        let point_regions = vec![PointRegion::Outside; cloud.len()];
        let (id, labeled_area) = (self.listing.scan_ids[scan_idx].clone(), LabeledArea::AsPoints);
        let annotations = Vec::new();
        Ok(LabeledScan { id, cloud, annotations, point_regions, labeled_area, points_left_out })
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        Some(self.payloads[self.turns[scan_idx].first_packet].time_ns)
    }

    fn left_out(&self) -> Option<&str> {
        self.left_out.as_deref()
    }
}

impl VelodyneCapture {
    fn read_points(&self, turn: &Turn) -> Result<PositionedPoints, DatasetError> {
        let io_error = DatasetError::io(&self.path);
        let damaged = |problem| DatasetError::Damaged { path: self.path.clone(), problem };
        let mut file = RegularFile::open(&self.path).map_err(io_error)?;
        let mut points = PositionedPoints::default();
        let (mut rings, mut offsets_s) = (Vec::new(), Vec::new());
        let (mut firings, mut clock) = (Vec::new(), PacketClock::default());
        let mut bytes = [0; N_PACKET_BYTES];
        let mut is_after_gap = false;
        for packet_idx in turn.first_packet..=turn.last_packet {
            file.seek(SeekFrom::Start(self.payloads[packet_idx].offset)).map_err(io_error)?;
            file.read_exact(&mut bytes).map_err(io_error)?;
            let first = if packet_idx == turn.first_packet { turn.first_block } else { 0 };
            let end = if packet_idx == turn.last_packet { turn.end_block } else { N_BLOCKS };
            // Parsed before, unless the file has changed since.
            let packet = DataPacket::parse(&bytes).map_err(damaged)?.turning(self.rotation);
            firings.clear();
            packet.append_points(first..end, &self.lasers, &mut points, &mut firings).map_err(damaged)?;
            let firing_s = |it: &Firing| 1e-6 * f64::from(it.micros);
            if packet_idx == turn.first_packet && first > 0 && packet.block_after_gap() == Some(first) {
                // Its clock is that of the blocks before the gap, so the clock of the next packet is used.
                let packet_s = -1e-6 * f64::from(packet.duration_micros());
                offsets_s.extend(firings.iter().map(|it| packet_s + firing_s(it)));
                is_after_gap = true;
            } else {
                let packet_s = clock.seconds_since_first(packet.micros_of_hour());
                offsets_s.extend(firings.iter().map(|it| packet_s + firing_s(it)));
            }
            rings.extend(firings.iter().map(|it| it.laser_idx as f64));
        }
        points.take_rings(&rings);
        if is_after_gap {
            shift_to_first(&mut offsets_s);
        }
        points.take_time_offsets_s(&offsets_s);
        Ok(points)
    }
}

/// The address of a sensor, from the text that the user chose.
fn address(path: &Path, chosen: &str) -> Result<Ipv4Addr, DatasetError> {
    let problem = || {
        format!(
            "{path:?} is a capture of packets: {chosen:?} is no address of a sender, such as 192.168.1.201"
        )
    };
    chosen.parse().map_err(|_| DatasetError::Usage(problem()))
}

/// Fails if there are several senders and none was chosen, or if the chosen one is missing.
fn refuse_several(
    path: &Path,
    chosen: Option<Ipv4Addr>,
    n_by_sender: &BTreeMap<Ipv4Addr, usize>,
) -> Result<(), DatasetError> {
    let sender = |(address, n): (&Ipv4Addr, &usize)| format!("{address} ({n} packets)");
    let senders = || few_of(&n_by_sender.iter().map(sender).collect::<Vec<String>>());
    match chosen {
        None if n_by_sender.len() > 1 => Err(DatasetError::Usage(format!(
            "{path:?} has packets of several sensors to port {DATA_PORT}; choose one with --topic ADDRESS: {}",
            senders()
        ))),
        Some(chosen) if !n_by_sender.is_empty() && !n_by_sender.contains_key(&chosen) => {
            Err(DatasetError::Usage(format!(
                "{path:?} has no packets from {chosen} to port {DATA_PORT}: {}",
                senders()
            )))
        }
        _ => Ok(()),
    }
}

/// Shifts times so that the first one is 0.
fn shift_to_first(times_s: &mut [f64]) {
    let first_s = times_s.first().copied().unwrap_or(0.0);
    for time_s in times_s {
        *time_s -= first_s;
    }
}

/// The clocks of the packets of one turn.
#[derive(Default)]
struct PacketClock {
    first_and_last_micros: Option<[u32; 2]>,
}

impl PacketClock {
    /// Seconds from the first packet to this one; NaN if the clock does not go on, as in captures without one.
    fn seconds_since_first(&mut self, micros_of_hour: u32) -> f64 {
        let [first, last] = self.first_and_last_micros.unwrap_or([micros_of_hour; 2]);
        let is_first = self.first_and_last_micros.is_none();
        self.first_and_last_micros = Some([first, micros_of_hour]);
        if [first, last, micros_of_hour].iter().any(|it| *it >= MICROS_OF_HOUR) {
            return f64::NAN;
        }
        // The hour may end between two packets.
        let hour = u64::from(MICROS_OF_HOUR);
        let since = |earlier: u32| (u64::from(micros_of_hour) + hour - u64::from(earlier)) % hour;
        let goes_on = is_first || (1..MAX_MICROS_BETWEEN_PACKETS).contains(&since(last));
        if goes_on { 1e-6 * since(first) as f64 } else { f64::NAN }
    }
}

/// The data packets of a sensor.
#[derive(Default)]
struct Packets {
    model: Option<VelodyneModel>,
    payloads: Vec<Payload>,
    azimuths: Vec<PacketAzimuths>,
}

impl Packets {
    fn add(&mut self, payload: Payload, packet: &DataPacket<'_>) -> Result<(), String> {
        let model = *self.model.get_or_insert(packet.model());
        if model != packet.model() {
            let (one, other) = (model.sensor(), packet.model().sensor());
            return Err(format!("has packets of two sensors, {one} and {other}"));
        }
        self.azimuths.push(PacketAzimuths { azimuths: packet.azimuths(), time_ns: payload.time_ns });
        self.payloads.push(payload);
        Ok(())
    }
}

/// The lasers of the sensor: from a calibration beside the capture, or else from the manual.
fn lasers_beside(
    path: &Path,
    model: VelodyneModel,
    checksum: &mut DatasetChecksum,
) -> Result<Vec<Laser>, DatasetError> {
    let of_capture = ["xml", "yaml", "yml"].map(|extension| path.with_extension(extension));
    let of_folder = path.with_file_name("db.xml");
    let mut candidates = of_capture.to_vec();
    if model == VelodyneModel::Hdl64e {
        candidates.push(of_folder.clone());
    }
    let Some(file) = candidates.iter().find(|it| it.is_file()) else {
        return match model {
            VelodyneModel::Hdl64e => Err(DatasetError::without_calibration(path, &of_folder)),
            _ => Ok(lasers_of(model)),
        };
    };
    let text = read_text_file(file)?;
    checksum.add_text("calibration", &text);
    let damaged = |problem| DatasetError::Damaged { path: file.clone(), problem };
    let lasers = parse_calibration_file(&text).map_err(damaged)?;
    let n_needed = match model {
        VelodyneModel::Vlp16 => 16,
        VelodyneModel::Hdl32e => 32,
        VelodyneModel::Hdl64e => 64,
    };
    if lasers.len() == n_needed {
        return Ok(lasers);
    }
    Err(damaged(format!("has {} lasers, but the sensor of the packets has {n_needed}", lasers.len())))
}
