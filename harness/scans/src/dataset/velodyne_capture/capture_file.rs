//! Captures of network packets, pcap and pcapng: where the payloads of UDP lie that go to a port.
//!
//! Walked from record to record, so that a capture may be larger than memory; a record may be no larger than a packet.

use std::io::{BufReader, Read, Seek as _, SeekFrom};
use std::path::Path;

use crate::dataset::DatasetError;

/// No packet of a network is larger.
const MAX_PACKET_BYTES: u32 = 1 << 18;

/// A payload within the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Payload {
    /// Where it begins.
    pub offset: u64,
    /// When it was captured, in nanoseconds since 1970.
    pub time_ns: u64,
}

/// Whether `path` is a file that begins as a capture does.
pub fn is_capture(path: &Path) -> bool {
    let mut magic = [0; 4];
    path.is_file()
        && std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok()
        && CaptureKind::of(magic).is_some()
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum CaptureKind {
    /// Fractions of a second are of so many nanoseconds; numbers may be big-endian.
    Classic {
        ns_per_fraction: u64,
        is_big_endian: bool,
    },
    NextGeneration,
}

impl CaptureKind {
    fn of(magic: [u8; 4]) -> Option<Self> {
        let classic = |ns_per_fraction, is_big_endian| Some(Self::Classic { ns_per_fraction, is_big_endian });
        match magic {
            [0xd4, 0xc3, 0xb2, 0xa1] => classic(1000, false),
            [0xa1, 0xb2, 0xc3, 0xd4] => classic(1000, true),
            [0x4d, 0x3c, 0xb2, 0xa1] => classic(1, false),
            [0xa1, 0xb2, 0x3c, 0x4d] => classic(1, true),
            [0x0a, 0x0d, 0x0d, 0x0a] => Some(Self::NextGeneration),
            _ => None,
        }
    }
}

/// The kinds of links whose packets are understood.
#[derive(Clone, Copy)]
enum Link {
    Ethernet,
    /// Linux's own, of captures from any interface.
    Cooked,
    /// Nothing before the internet's own header.
    Raw,
    /// Four bytes before it.
    Loopback,
    Unknown,
}

impl Link {
    fn of(number: u16) -> Self {
        match number {
            1 => Self::Ethernet,
            113 => Self::Cooked,
            101 => Self::Raw,
            0 => Self::Loopback,
            _ => Self::Unknown,
        }
    }

    /// Where the internet's header begins.
    fn internet_header(self, packet: &[u8]) -> Option<usize> {
        const INTERNET: [u8; 2] = [8, 0];
        const TAGGED: [u8; 2] = [0x81, 0];
        let kind = |at: usize| packet.get(at..at + 2).map(|it| [it[0], it[1]]);
        match self {
            Self::Ethernet if kind(12)? == TAGGED => (kind(16)? == INTERNET).then_some(18),
            Self::Ethernet => (kind(12)? == INTERNET).then_some(14),
            Self::Cooked => (kind(14)? == INTERNET).then_some(16),
            Self::Raw => Some(0),
            Self::Loopback => Some(4),
            Self::Unknown => None,
        }
    }
}

/// The payloads of `length` bytes in the capture at `path` that go to `port`, from the first sender there is, in the order of the
/// file. `take` is shown each and may refuse the file; its errors are the rest of a sentence about it.
///
/// Returns the rest of a sentence about the end of the file if it is cut off.
///
/// # Errors
///
/// [`DatasetError::Io`]; [`DatasetError::Damaged`] if it is no capture, or breaks off in a record that cannot be.
pub fn walk_payloads(
    path: &Path,
    port: u16,
    length: usize,
    mut take: impl FnMut(Payload, &[u8]) -> Result<(), String>,
) -> Result<Option<String>, DatasetError> {
    let io_error = |source| DatasetError::Io { path: path.to_path_buf(), source };
    let file = std::fs::File::open(path).map_err(io_error)?;
    let mut walker = Walker { reader: BufReader::with_capacity(1 << 18, file), offset: 0 };
    let mut sender = None;
    let mut on_packet = |link: Link, begin: u64, time_ns: u64, packet: &[u8]| -> Result<(), String> {
        let Some((from, payload_at)) = datagram(link, packet, port, length) else { return Ok(()) };
        if *sender.get_or_insert(from) == from {
            let payload = Payload { offset: begin + payload_at as u64, time_ns };
            take(payload, &packet[payload_at..payload_at + length])?;
        }
        Ok(())
    };
    let walked = match walker.read::<4>().map_err(io_error)?.and_then(CaptureKind::of) {
        Some(CaptureKind::Classic { ns_per_fraction, is_big_endian }) => {
            walker.walk_classic(ns_per_fraction, is_big_endian, &mut on_packet)
        }
        Some(CaptureKind::NextGeneration) => walker.walk_next_generation(&mut on_packet),
        None => Err(Stop::Damage("is not a capture of packets".to_owned())),
    };
    match walked {
        Ok(()) => Ok(None),
        Err(Stop::CutOff(offset)) => Ok(Some(format!("is cut off at byte {offset}"))),
        Err(Stop::Io(source)) => Err(io_error(source)),
        Err(Stop::Damage(problem)) => Err(DatasetError::Damaged { path: path.to_path_buf(), problem }),
    }
}

/// The sender and the place of the payload, if `packet` is a whole datagram of that length to `port`.
fn datagram(link: Link, packet: &[u8], port: u16, length: usize) -> Option<([u8; 4], usize)> {
    const UDP: u8 = 17;
    const UDP_HEADER: usize = 8;
    let at = link.internet_header(packet)?;
    let header = packet.get(at..at + 20)?;
    let header_length = 4 * usize::from(header[0] & 15);
    // Fragments have no header of their own, but the first.
    let is_fragment = u16::from_be_bytes([header[6], header[7]]) & 0x3fff != 0;
    if header[0] >> 4 != 4 || header_length < 20 || header[9] != UDP || is_fragment {
        return None;
    }
    let udp = packet.get(at + header_length..)?;
    let head = udp.get(..UDP_HEADER)?;
    let is_meant = u16::from_be_bytes([head[2], head[3]]) == port
        && usize::from(u16::from_be_bytes([head[4], head[5]])) == UDP_HEADER + length
        && udp.len() >= UDP_HEADER + length;
    is_meant.then_some(([header[12], header[13], header[14], header[15]], at + header_length + UDP_HEADER))
}

enum Stop {
    Io(std::io::Error),
    /// Where the record begins that is not whole.
    CutOff(u64),
    Damage(String),
}

struct Walker {
    reader: BufReader<std::fs::File>,
    offset: u64,
}

type OnPacket<'a> = dyn FnMut(Link, u64, u64, &[u8]) -> Result<(), String> + 'a;

impl Walker {
    /// The next bytes; `None` at the end of the file, be it before or within them.
    fn read<const N: usize>(&mut self) -> Result<Option<[u8; N]>, std::io::Error> {
        let mut bytes = [0; N];
        match self.reader.read_exact(&mut bytes) {
            Ok(()) => {
                self.offset += N as u64;
                Ok(Some(bytes))
            }
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Fills `buffer`; false if the file ends before.
    fn fill(&mut self, buffer: &mut [u8]) -> Result<bool, Stop> {
        match self.reader.read_exact(buffer) {
            Ok(()) => {
                self.offset += buffer.len() as u64;
                Ok(true)
            }
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Ok(false),
            Err(error) => Err(Stop::Io(error)),
        }
    }

    fn walk_classic(
        &mut self,
        ns_per_fraction: u64,
        is_big_endian: bool,
        on_packet: &mut OnPacket<'_>,
    ) -> Result<(), Stop> {
        let number =
            |it: [u8; 4]| if is_big_endian { u32::from_be_bytes(it) } else { u32::from_le_bytes(it) };
        let Some(head) = self.read::<20>().map_err(Stop::Io)? else { return Err(Stop::CutOff(0)) };
        let link = Link::of(number([head[16], head[17], head[18], head[19]]) as u16);
        let mut packet = Vec::new();
        loop {
            let begin = self.offset;
            let Some(head) = self.read::<16>().map_err(Stop::Io)? else {
                // Nothing, or a part of a head.
                let is_at_end = self.reader.get_ref().metadata().is_ok_and(|it| it.len() == begin);
                return if is_at_end { Ok(()) } else { Err(Stop::CutOff(begin)) };
            };
            let (words, _) = head.as_chunks::<4>();
            let [seconds, fraction, n_captured, _] = std::array::from_fn(|place| number(words[place]));
            if n_captured > MAX_PACKET_BYTES {
                let problem = format!("claims to hold a packet of {n_captured} bytes at byte {begin}");
                return Err(Stop::Damage(problem));
            }
            packet.resize(n_captured as usize, 0);
            let at = self.offset;
            if !self.fill(&mut packet)? {
                return Err(Stop::CutOff(begin));
            }
            let time_ns = u64::from(seconds) * 1_000_000_000 + u64::from(fraction) * ns_per_fraction;
            on_packet(link, at, time_ns, &packet).map_err(Stop::Damage)?;
        }
    }

    fn walk_next_generation(&mut self, on_packet: &mut OnPacket<'_>) -> Result<(), Stop> {
        const SECTION: u32 = 0x0a0d_0d0a;
        const INTERFACE: u32 = 1;
        const PACKET: u32 = 6;
        self.reader.seek(SeekFrom::Start(0)).map_err(Stop::Io)?;
        self.offset = 0;
        let mut is_big_endian = false;
        let mut interfaces: Vec<(Link, u64)> = Vec::new();
        let mut body = Vec::new();
        loop {
            let begin = self.offset;
            let Some(head) = self.read::<12>().map_err(Stop::Io)? else {
                let is_at_end = self.reader.get_ref().metadata().is_ok_and(|it| it.len() == begin);
                return if is_at_end { Ok(()) } else { Err(Stop::CutOff(begin)) };
            };
            let (words, _) = head.as_chunks::<4>();
            if words[0] == SECTION.to_be_bytes() {
                is_big_endian = words[2] == [0x1a, 0x2b, 0x3c, 0x4d];
                interfaces.clear();
            }
            let number =
                |it: [u8; 4]| if is_big_endian { u32::from_be_bytes(it) } else { u32::from_le_bytes(it) };
            let (kind, length) = (number(words[0]), number(words[1]));
            if length < 12 || !length.is_multiple_of(4) || length > 2 * MAX_PACKET_BYTES {
                return Err(Stop::Damage(format!(
                    "claims to hold a block of {length} bytes at byte {begin}"
                )));
            }
            // What is behind the first word of the body, up to and with the length that is said again.
            body.clear();
            body.extend_from_slice(&words[2]);
            body.resize(length as usize - 8, 0);
            let at = self.offset - 4;
            if !self.fill(&mut body[4..])? {
                return Err(Stop::CutOff(begin));
            }
            let word = |at: usize| body.get(at..at + 4).map(|it| number([it[0], it[1], it[2], it[3]]));
            if kind == INTERFACE {
                let half = if is_big_endian { [body[0], body[1]] } else { [body[1], body[0]] };
                let link = Link::of(u16::from_be_bytes(half));
                interfaces.push((link, ns_per_tick(&body, is_big_endian)));
            }
            if kind == PACKET
                && let (Some(interface), Some(high), Some(low), Some(n_captured)) =
                    (word(0), word(4), word(8), word(12))
            {
                let Some(&(link, ns_per_tick)) = interfaces.get(interface as usize) else {
                    return Err(Stop::Damage(format!("has a packet of no interface at byte {begin}")));
                };
                let Some(packet) = body.get(20..20_usize.saturating_add(n_captured as usize)) else {
                    let problem = format!("claims to hold a packet of {n_captured} bytes at byte {begin}");
                    return Err(Stop::Damage(problem));
                };
                let ticks = (u64::from(high) << 32) | u64::from(low);
                let time_ns = ticks.saturating_mul(ns_per_tick);
                on_packet(link, at + 20, time_ns, packet).map_err(Stop::Damage)?;
            }
        }
    }
}

/// Nanoseconds of a tick of the interface that `body` describes: a millionth of a second unless an option says otherwise.
fn ns_per_tick(body: &[u8], is_big_endian: bool) -> u64 {
    const RESOLUTION: u16 = 9;
    let half = |at: usize| {
        let half = body.get(at..at + 2).map(|it| [it[0], it[1]])?;
        Some(if is_big_endian { u16::from_be_bytes(half) } else { u16::from_le_bytes(half) })
    };
    let mut at = 8;
    while let (Some(option), Some(length)) = (half(at), half(at + 2)) {
        if option == 0 {
            break;
        }
        if option == RESOLUTION {
            return match body.get(at + 4) {
                Some(9) => 1,
                Some(8) => 10,
                Some(7) => 100,
                Some(3) => 1_000_000,
                _ => 1000,
            };
        }
        at += 4 + usize::from(length).next_multiple_of(4);
    }
    1000
}
