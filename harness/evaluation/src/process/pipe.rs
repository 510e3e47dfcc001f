//! Messages through a pair of pipes, with a time limit.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::io::Errno;

use super::message::MOST_LINE_BYTES;

/// Most bytes that are read at once.
const CHUNK_BYTES: usize = 1 << 18;
/// Requested capacity of a pipe in bytes, so that an answer is not read in small pieces. The usual limit of unprivileged
/// users.
const PIPE_BYTES: usize = 1 << 20;

/// Our ends of the pipes to and from a detector.
#[derive(Debug)]
pub struct Pipe {
    to: Option<OwnedFd>,
    from: OwnedFd,
    // Bytes read from the pipe, but not returned yet.
    buffer: Vec<u8>,
    chunk: Vec<u8>,
}

/// Why a message did not get through.
#[derive(Debug)]
pub enum PipeError {
    /// The other end is closed.
    Closed,
    /// It took too long.
    TimedOut,
    /// A line is too long.
    EndlessLine,
    /// The operating system refuses.
    Io(io::Error),
}

impl Pipe {
    /// A pipe that writes to the end `to` and reads from the end `from`.
    ///
    /// # Errors
    ///
    /// If the operating system cannot make the ends non-blocking.
    pub fn new(to: OwnedFd, from: OwnedFd) -> io::Result<Self> {
        for end in [&to, &from] {
            let flags = rustix::fs::fcntl_getfl(end)?;
            rustix::fs::fcntl_setfl(end, flags | OFlags::NONBLOCK)?;
            // Smaller pipes work, too.
            let _ = rustix::pipe::fcntl_setpipe_size(end, PIPE_BYTES);
        }
        Ok(Self { to: Some(to), from, buffer: Vec::new(), chunk: vec![0; CHUNK_BYTES] })
    }

    /// Writes all of `bytes` before `deadline`.
    ///
    /// # Errors
    ///
    /// [`PipeError`] if it cannot.
    pub fn write(&mut self, mut bytes: &[u8], deadline: Instant) -> Result<(), PipeError> {
        let Some(to) = &self.to else { return Err(PipeError::Closed) };
        while !bytes.is_empty() {
            match rustix::io::write(to, bytes) {
                Ok(n_written) => bytes = &bytes[n_written..],
                Err(Errno::AGAIN) => wait_for(to, PollFlags::OUT, deadline)?,
                Err(Errno::INTR) => {}
                Err(Errno::PIPE) => return Err(PipeError::Closed),
                Err(error) => return Err(PipeError::Io(error.into())),
            }
        }
        Ok(())
    }

    /// Reads a line with its end.
    ///
    /// # Errors
    ///
    /// [`PipeError`] if there is none before `deadline`.
    pub fn read_line(&mut self, deadline: Instant) -> Result<Vec<u8>, PipeError> {
        let mut n_looked = 0;
        loop {
            let end = self.buffer[n_looked..].iter().position(|it| *it == b'\n');
            if let Some(end) = end.map(|it| n_looked + it + 1)
                && end <= MOST_LINE_BYTES
            {
                let rest = self.buffer.split_off(end);
                return Ok(std::mem::replace(&mut self.buffer, rest));
            }
            n_looked = self.buffer.len();
            if n_looked >= MOST_LINE_BYTES {
                return Err(PipeError::EndlessLine);
            }
            self.read_more(deadline)?;
        }
    }

    /// Reads `n_bytes` to the end of `payload`.
    ///
    /// # Errors
    ///
    /// [`PipeError`] if they are not there before `deadline`.
    pub fn read_payload(
        &mut self,
        n_bytes: usize,
        payload: &mut Vec<u8>,
        deadline: Instant,
    ) -> Result<(), PipeError> {
        let n_taken = n_bytes.min(self.buffer.len());
        payload.extend(self.buffer.drain(..n_taken));
        let mut n_there = payload.len();
        payload.resize(n_there + n_bytes - n_taken, 0);
        // Read directly into `payload`: the clock runs.
        while n_there < payload.len() {
            n_there += read_some(&self.from, &mut payload[n_there..], deadline)?;
        }
        Ok(())
    }

    /// Whether there are bytes to read that answer no question, or the other end is closed.
    pub fn has_more(&self) -> bool {
        let mut ends = [PollFd::new(&self.from, PollFlags::IN)];
        let is_ready = poll(&mut ends, Some(&Timespec::default())).is_ok_and(|n_ready| n_ready > 0);
        is_ready || !self.buffer.is_empty()
    }

    /// Whether the other end is closed, and all that came from it has been read.
    pub fn is_closed(&mut self) -> bool {
        self.buffer.is_empty() && matches!(self.read_more(Instant::now()), Err(PipeError::Closed))
    }

    /// Closes the end that is written to.
    pub fn close(&mut self) {
        self.to = None;
    }

    fn read_more(&mut self, deadline: Instant) -> Result<(), PipeError> {
        let n_read = read_some(&self.from, &mut self.chunk, deadline)?;
        self.buffer.extend_from_slice(&self.chunk[..n_read]);
        Ok(())
    }
}

/// Reads at least a byte to the beginning of `buffer`. Returns the number of bytes.
fn read_some(from: &OwnedFd, buffer: &mut [u8], deadline: Instant) -> Result<usize, PipeError> {
    loop {
        match rustix::io::read(from, &mut *buffer) {
            Ok(0) => return Err(PipeError::Closed),
            Ok(n_read) => return Ok(n_read),
            Err(Errno::AGAIN) => wait_for(from, PollFlags::IN, deadline)?,
            Err(Errno::INTR) => {}
            Err(error) => return Err(PipeError::Io(error.into())),
        }
    }
}

/// Waits until `end` can be used.
fn wait_for(end: &impl AsFd, flags: PollFlags, deadline: Instant) -> Result<(), PipeError> {
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        if left == Duration::ZERO {
            return Err(PipeError::TimedOut);
        }
        let left = Timespec::try_from(left).map_err(|_| PipeError::TimedOut)?;
        match poll(&mut [PollFd::new(end, flags)], Some(&left)) {
            Ok(0) | Err(Errno::INTR) => {}
            Ok(_) => return Ok(()),
            Err(error) => return Err(PipeError::Io(error.into())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    /// Our ends, and the other ends: a file to write to, and a descriptor to read from.
    fn pipe() -> (Pipe, std::fs::File, OwnedFd) {
        let (theirs, to) = rustix::pipe::pipe().unwrap();
        let (from, written) = rustix::pipe::pipe().unwrap();
        (Pipe::new(to, from).unwrap(), std::fs::File::from(written), theirs)
    }

    fn soon() -> Instant {
        Instant::now() + Duration::from_millis(50)
    }

    #[test]
    fn lines_and_payloads_come_one_after_the_other() {
        let (mut pipe, mut written, _theirs) = pipe();
        written.write_all(b"{\"a\":1}\n12345{}\nx").unwrap();
        let mut payload = Vec::new();
        assert_eq!(pipe.read_line(soon()).unwrap(), b"{\"a\":1}\n");
        pipe.read_payload(5, &mut payload, soon()).unwrap();
        assert_eq!(
            (payload.as_slice(), pipe.read_line(soon()).unwrap().as_slice()),
            (&b"12345"[..], &b"{}\n"[..])
        );
        assert!(pipe.has_more() && !pipe.is_closed());
        let half = pipe.read_payload(2, &mut payload, soon());
        assert!(matches!(half, Err(PipeError::TimedOut)), "{half:?}");
        drop(written);
        assert!(matches!(pipe.read_payload(2, &mut payload, soon()), Err(PipeError::Closed)));
        assert!(pipe.is_closed());
    }

    #[test]
    fn a_line_has_to_end_and_whoever_does_not_read_is_not_waited_for() {
        let (mut pipe, mut written, _theirs) = pipe();
        let writer = std::thread::spawn(move || written.write_all(&vec![b'x'; MOST_LINE_BYTES + 1]));
        let endless = pipe.read_line(Instant::now() + Duration::from_secs(20));
        assert!(matches!(endless, Err(PipeError::EndlessLine)), "{endless:?}");
        let deaf = pipe.write(&vec![0; 4 * PIPE_BYTES], soon());
        assert!(matches!(deaf, Err(PipeError::TimedOut)), "{deaf:?}");
        drop(pipe);
        // It may fail or not: the last byte may have been read or not.
        let _ = writer.join().unwrap();
    }
}
