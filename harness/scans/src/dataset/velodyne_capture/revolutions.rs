//! Captures of packets as scans, one a revolution, which begins where the azimuth is 0.
//!
//! ```text
//! NAME.pcap, NAME.pcapng               the packets
//! NAME.xml, .yaml or .yml, or db.xml   beside it: the calibration, which an HDL-64E needs
//! ```
//!
//! The packets are read once when a capture is opened; what stays in memory is where they lie.

use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use reports::files::regular_file::RegularFile;

use super::calibration_file::parse_calibration_file;
use super::capture_file::{Payload, walk_payloads};
use super::data_packet::{DATA_PORT, DataPacket, FULL_TURN, N_BLOCKS, N_PACKET_BYTES};
use super::laser_table::{Laser, VelodyneModel, lasers_of};
use crate::annotation::{LabeledArea, LabeledScan, PointRegion, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::on_disk::stem_of;
use crate::dataset::positioned_points::PositionedPoints;
use crate::dataset::source::{DamagePolicy, DatasetSource, StatedBy};
use crate::dataset::text_file::read_text_file;
use crate::dataset::{Dataset, DatasetError, Listing};

/// Longer than this without a packet, in nanoseconds, and nobody knows how often the head has turned.
const MAX_GAP_NS: u64 = 40_000_000;

/// A revolution that begins and ends this near to azimuth 0 is whole, in hundredths of a degree.
const WHOLE_WITHIN: u16 = 500;

/// After so many microseconds the clock of a packet begins again.
const MICROS_OF_HOUR: u32 = 3_600_000_000;

/// Packets of a sensor follow each other sooner than this; otherwise their clock was set meanwhile, or there is none.
const MAX_MICROS_BETWEEN_PACKETS: u64 = 1_000_000;

/// An open capture.
#[derive(Debug)]
struct VelodyneCapture {
    listing: Listing,
    path: PathBuf,
    lasers: Vec<Laser>,
    // Invariant: `scan_ids` and `revolutions` have the same length and order.
    revolutions: Vec<Revolution>,
    payloads: Vec<Payload>,
    left_out: Option<String>,
}

/// The packets of a revolution, of which the first and the last may belong to it in part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Revolution {
    first_packet: usize,
    first_block: usize,
    last_packet: usize,
    end_block: usize,
    first_azimuth: u16,
    last_azimuth: u16,
}

impl Revolution {
    fn is_whole(&self) -> bool {
        self.first_azimuth <= WHOLE_WITHIN && self.last_azimuth >= FULL_TURN - WHOLE_WITHIN
    }
}

/// Opens the capture of `source`.
///
/// What is not a whole revolution at its beginning or end is left out, unless there is nothing else. If damage is to be
/// skipped, so are packets that are none, and the end of a capture that is cut off is left out.
pub fn open_velodyne_capture(source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let path = source.path.clone();
    let mut finder = RevolutionFinder::default();
    let mut first_bad = None;
    let cut_off = walk_payloads(&path, DATA_PORT, N_PACKET_BYTES, |payload, bytes| {
        let bytes: &[u8; N_PACKET_BYTES] = bytes.try_into().map_err(|_| "has a packet of another length")?;
        match DataPacket::parse(bytes).and_then(|packet| finder.add(payload, &packet)) {
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
    let Some(model) = finder.model else {
        let problem = format!("has no data packets of a Velodyne sensor to port {DATA_PORT}");
        return Err(DatasetError::Damaged { path, problem: first_bad.unwrap_or(problem) });
    };
    let (revolutions, payloads) = finder.finish();
    let mut checksum = DatasetChecksum::default();
    checksum.add_file("capture", &path)?;
    let lasers = lasers_beside(&path, model, &mut checksum)?;
    let sequence = stem_of(&path);
    let scan_ids =
        (0..revolutions.len() as u32).map(|index| ScanId { sequence: sequence.clone(), index }).collect();
    let mut source = source;
    if source.stated_by == StatedBy::Nobody {
        model.sensor().clone_into(&mut source.sensor);
    }
    let description = source.describe(DatasetFormat::VelodynePcap, checksum.finish());
    let left_out = cut_off.or(first_bad);
    let listing = Listing { description, scan_ids };
    Ok(Box::new(VelodyneCapture { listing, path, lasers, revolutions, payloads, left_out }))
}

impl Dataset for VelodyneCapture {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let (cloud, points_left_out) = self.read_points(&self.revolutions[scan_idx])?.into_parts();
        let point_regions = vec![PointRegion::Outside; cloud.len()];
        let (id, labeled_area) = (self.listing.scan_ids[scan_idx].clone(), LabeledArea::AsPoints);
        let annotations = Vec::new();
        Ok(LabeledScan { id, cloud, annotations, point_regions, labeled_area, points_left_out })
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        Some(self.payloads[self.revolutions[scan_idx].first_packet].time_ns)
    }

    fn left_out(&self) -> Option<&str> {
        self.left_out.as_deref()
    }
}

impl VelodyneCapture {
    fn read_points(&self, revolution: &Revolution) -> Result<PositionedPoints, DatasetError> {
        let io_error = DatasetError::io(&self.path);
        let damaged = |problem| DatasetError::Damaged { path: self.path.clone(), problem };
        let mut file = RegularFile::open(&self.path).map_err(io_error)?;
        let mut points = PositionedPoints::default();
        let (mut rings, mut offsets_s) = (Vec::new(), Vec::new());
        let (mut firings, mut clock) = (Vec::new(), PacketClock::default());
        let mut bytes = [0; N_PACKET_BYTES];
        for packet_idx in revolution.first_packet..=revolution.last_packet {
            file.seek(SeekFrom::Start(self.payloads[packet_idx].offset)).map_err(io_error)?;
            file.read_exact(&mut bytes).map_err(io_error)?;
            let first = if packet_idx == revolution.first_packet { revolution.first_block } else { 0 };
            let end = if packet_idx == revolution.last_packet { revolution.end_block } else { N_BLOCKS };
            // Read before, unless the file has changed since.
            let packet = DataPacket::parse(&bytes).map_err(damaged)?;
            firings.clear();
            packet.append_points(first..end, &self.lasers, &mut points, &mut firings).map_err(damaged)?;
            let packet_s = clock.seconds_since_first(packet.micros_of_hour());
            rings.extend(firings.iter().map(|it| it.laser_idx as f64));
            offsets_s.extend(firings.iter().map(|it| packet_s + 1e-6 * f64::from(it.micros)));
        }
        points.take_rings(&rings);
        points.take_time_offsets_s(&offsets_s);
        points.not_empty(&self.path)
    }
}

/// The clocks of the packets of one revolution.
#[derive(Default)]
struct PacketClock {
    first_and_last_micros: Option<[u32; 2]>,
}

impl PacketClock {
    /// Seconds from the first packet to this one; not a number where the clock does not go on, as in captures without one.
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

/// Cuts packets into revolutions.
#[derive(Default)]
struct RevolutionFinder {
    model: Option<VelodyneModel>,
    payloads: Vec<Payload>,
    revolutions: Vec<Revolution>,
    last_azimuth: u16,
}

impl RevolutionFinder {
    fn add(&mut self, payload: Payload, packet: &DataPacket<'_>) -> Result<(), String> {
        let model = *self.model.get_or_insert(packet.model());
        if model != packet.model() {
            let (one, other) = (model.sensor(), packet.model().sensor());
            return Err(format!("has packets of two sensors, {one} and {other}"));
        }
        let gap_ns = self.payloads.last().map_or(0, |it| payload.time_ns.saturating_sub(it.time_ns));
        let packet_idx = self.payloads.len();
        self.payloads.push(payload);
        for block in 0..N_BLOCKS {
            let azimuth = packet.azimuth(block);
            let has_wrapped = self.last_azimuth > azimuth && self.last_azimuth - azimuth > FULL_TURN / 2;
            let is_after_gap = block == 0 && gap_ns > MAX_GAP_NS;
            if has_wrapped || is_after_gap || self.revolutions.is_empty() {
                self.revolutions.push(Revolution {
                    first_packet: packet_idx,
                    first_block: block,
                    last_packet: packet_idx,
                    end_block: block,
                    first_azimuth: azimuth,
                    last_azimuth: azimuth,
                });
            }
            if let Some(revolution) = self.revolutions.last_mut() {
                (revolution.last_packet, revolution.end_block) = (packet_idx, block + 1);
                revolution.last_azimuth = azimuth;
            }
            self.last_azimuth = azimuth;
        }
        Ok(())
    }

    fn finish(self) -> (Vec<Revolution>, Vec<Payload>) {
        let Self { mut revolutions, payloads, .. } = self;
        if revolutions.iter().any(Revolution::is_whole) {
            if revolutions.first().is_some_and(|it| !it.is_whole()) {
                revolutions.remove(0);
            }
            if revolutions.last().is_some_and(|it| !it.is_whole()) {
                revolutions.pop();
            }
        }
        (revolutions, payloads)
    }
}

/// The lasers of the sensor: as a calibration beside the capture says, or else the manual.
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
