//! Captures of network packets, pcap and pcapng: positions of the UDP payloads that go to a port.
//!
//! The file is walked from record to record, so a capture may be larger than memory; a record must fit into the buffer.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::net::Ipv4Addr;
use std::path::Path;

use etherparse::{LaxNetSlice, LaxSlicedPacket, TransportSlice};
use pcap_parser::data::{PacketData, get_packetdata};
use pcap_parser::traits::PcapNGPacketBlock as _;
use pcap_parser::{Block, Linktype, PcapBlockOwned, PcapError, create_reader};
use reports::files::regular_file::RegularFile;

use crate::dataset::DatasetError;

/// No packet of a network is this large.
const BUFFER_BYTES: usize = 1 << 19;

/// A payload within the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Payload {
    /// Its start in the file.
    pub offset: u64,
    /// When it was captured, in nanoseconds since 1970.
    pub time_ns: u64,
}

/// Whether `path` is a file that begins like a capture.
pub fn is_capture(path: &Path) -> bool {
    let mut magic = [0; 4];
    path.is_file()
        && RegularFile::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok()
        && matches!(
            magic,
            [0xd4, 0xc3, 0xb2, 0xa1]
                | [0xa1, 0xb2, 0xc3, 0xd4]
                | [0x4d, 0x3c, 0xb2, 0xa1]
                | [0xa1, 0xb2, 0x3c, 0x4d]
                | [0x0a, 0x0d, 0x0d, 0x0a]
        )
}

/// The wanted payloads: those of one length to one port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted {
    /// The port of UDP that they go to.
    pub port: u16,
    /// Their length in bytes.
    pub length: usize,
    /// Their sender; the first one if `None`.
    pub sender: Option<Ipv4Addr>,
}

/// Result of a walk through a capture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Walked {
    /// The number of packets to the port from each sender.
    pub n_by_sender: BTreeMap<Ipv4Addr, usize>,
    /// The rest of a sentence about the end of the file, if it is cut off.
    pub cut_off: Option<String>,
}

/// Passes the `wanted` payloads in the capture at `path` to `take`, in the order of the file. `take` may refuse the file;
/// its errors are the rest of a sentence about it.
pub fn walk_payloads(
    path: &Path,
    wanted: Wanted,
    mut take: impl FnMut(Payload, &[u8]) -> Result<(), String>,
) -> Result<Walked, DatasetError> {
    let Wanted { port, length, mut sender } = wanted;
    let io_error = DatasetError::io(path);
    let damaged = |problem| DatasetError::Damaged { path: path.to_path_buf(), problem };
    let file = RegularFile::open(path).map_err(io_error)?;
    let mut reader = create_reader(BUFFER_BYTES, file)
        .map_err(|_| damaged("is not a capture of packets, or is cut off at its beginning".to_owned()))?;
    let (mut interfaces, mut n_by_sender, mut offset) = (Interfaces::default(), BTreeMap::new(), 0);
    loop {
        match reader.next() {
            Ok((n_bytes, block)) => {
                if let Some(packet) = interfaces.packet(&block).map_err(damaged)?
                    && let Some((from, at)) = datagram(packet.link, packet.bytes, port, length)
                {
                    *n_by_sender.entry(from).or_default() += 1;
                    if *sender.get_or_insert(from) == from {
                        let payload = Payload {
                            offset: offset + (packet.offset_in_block + at) as u64,
                            time_ns: packet.time_ns,
                        };
                        take(payload, &packet.bytes[at..at + length]).map_err(damaged)?;
                    }
                }
                offset += n_bytes as u64;
                reader.consume(n_bytes);
            }
            Err(PcapError::Eof) => return Ok(Walked { n_by_sender, cut_off: None }),
            Err(PcapError::Incomplete(_) | PcapError::UnexpectedEof) => {
                if reader.reader_exhausted() {
                    let cut_off = Some(format!("is cut off at byte {offset}"));
                    return Ok(Walked { n_by_sender, cut_off });
                }
                reader.refill().map_err(|_| io_error(std::io::Error::other("reading failed")))?;
            }
            Err(PcapError::BufferTooSmall) => {
                return Err(damaged(format!(
                    "claims to hold a packet of more than {BUFFER_BYTES} bytes at byte {offset}"
                )));
            }
            Err(_) => return Err(damaged(format!("has a damaged record at byte {offset}"))),
        }
    }
}

/// A packet of the network, with the position of its first byte.
struct Packet<'a> {
    link: Linktype,
    time_ns: u64,
    offset_in_block: usize,
    bytes: &'a [u8],
}

/// The interfaces of the capture: kind of the link, and ticks in a second.
#[derive(Default)]
struct Interfaces(Vec<(Linktype, u64)>);

impl Interfaces {
    /// The packet in `block`, if it is one; notes the interfaces that other blocks describe.
    fn packet<'a>(&mut self, block: &'a PcapBlockOwned<'a>) -> Result<Option<Packet<'a>>, String> {
        match block {
            PcapBlockOwned::LegacyHeader(it) => {
                let ticks_per_s = if it.is_nanosecond_precision() { 1_000_000_000 } else { 1_000_000 };
                self.0 = vec![(it.network, ticks_per_s)];
            }
            PcapBlockOwned::NG(Block::SectionHeader(_)) => self.0.clear(),
            PcapBlockOwned::NG(Block::InterfaceDescription(it)) => {
                self.0.push((it.linktype, it.ts_resolution().unwrap_or(1_000_000)));
            }
            PcapBlockOwned::Legacy(it) => {
                let (link, ticks_per_s) = self.0[0];
                let time_ns = u64::from(it.ts_sec) * 1_000_000_000 + ns_of(it.ts_usec.into(), ticks_per_s);
                return Ok(Some(Packet { link, time_ns, offset_in_block: 16, bytes: it.data }));
            }
            PcapBlockOwned::NG(Block::EnhancedPacket(it)) => {
                let &(link, ticks_per_s) =
                    self.0.get(it.if_id as usize).ok_or("has a packet of no interface".to_owned())?;
                let time_ns = ns_of(u64::from(it.ts_high) << 32 | u64::from(it.ts_low), ticks_per_s);
                return Ok(Some(Packet { link, time_ns, offset_in_block: 28, bytes: it.packet_data() }));
            }
            PcapBlockOwned::NG(_) => {}
        }
        Ok(None)
    }
}

/// At most what 64 bits hold.
fn ns_of(ticks: u64, ticks_per_s: u64) -> u64 {
    u64::try_from(u128::from(ticks) * 1_000_000_000 / u128::from(ticks_per_s.max(1))).unwrap_or(u64::MAX)
}

/// The sender and the position of the payload, if `packet` is a whole datagram of this length to `port`.
fn datagram(link: Linktype, packet: &[u8], port: u16, length: usize) -> Option<(Ipv4Addr, usize)> {
    let sliced = match get_packetdata(packet, link, packet.len())? {
        PacketData::L2(frame) => LaxSlicedPacket::from_ethernet(frame).ok()?,
        PacketData::L3(_, bytes) => LaxSlicedPacket::from_ip(bytes).ok()?,
        _ => return None,
    };
    let (Some(LaxNetSlice::Ipv4(internet)), Some(TransportSlice::Udp(udp))) =
        (&sliced.net, &sliced.transport)
    else {
        return None;
    };
    let payload = udp.payload();
    let is_meant = udp.destination_port() == port && payload.len() == length;
    // The payload is a part of the packet.
    is_meant.then_some((internet.header().source_addr(), payload.as_ptr().addr() - packet.as_ptr().addr()))
}
