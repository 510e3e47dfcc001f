//! A server of files for this machine alone, which fails as it is told to: a web server, and a bucket of S3.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// How it fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Not at all.
    None,
    /// Connections break after so many bytes of a file.
    Breaks(usize),
    /// It sends so many bytes, and then so few that nobody waits for the end.
    Stalls(usize),
    /// It always sends files from their beginning.
    WithoutRanges,
    /// It does so, and connections always break after so many bytes.
    Cuts(usize),
    /// It sends a byte every tenth of a second.
    Dribbles,
    /// It sends headers without an end.
    NeverAnswers,
    /// It says that files are much larger than any disk.
    Boasts,
    /// It answers with this status and nothing else.
    Status(u16),
    /// The next answers, so many, say that it is busy.
    Busy(usize),
}

/// The server, until the test ends.
pub struct FileServer {
    address: SocketAddr,
    shelf: Arc<Mutex<Shelf>>,
}

struct Shelf {
    files: BTreeMap<String, Vec<u8>>,
    written: &'static str,
    fault: Fault,
    /// The requests: method, path and range.
    asked: Vec<String>,
}

const WRITTEN: &str = "Sat, 01 Nov 2025 10:00:00 GMT";
/// When files are written that are changed later.
const WRITTEN_LATER: &str = "Sun, 02 Nov 2025 10:00:00 GMT";

impl FileServer {
    /// Serves nothing yet.
    pub fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let shelf = Shelf { files: BTreeMap::new(), written: WRITTEN, fault: Fault::None, asked: Vec::new() };
        let shelf = Arc::new(Mutex::new(shelf));
        let of_server = Arc::clone(&shelf);
        std::thread::spawn(move || {
            for connection in listener.incoming().flatten() {
                let shelf = Arc::clone(&of_server);
                // Whoever hangs up has had enough.
                std::thread::spawn(move || drop(answer(connection, &shelf)));
            }
        });
        Self { address, shelf }
    }

    /// Puts a file at `path`, which has no leading `/`.
    pub fn put(&self, path: &str, content: &[u8]) -> &Self {
        self.shelf.lock().unwrap().files.insert(path.to_owned(), content.to_vec());
        self
    }

    /// Puts all files of `folder` below `path`.
    pub fn put_folder(&self, path: &str, folder: &Path) -> &Self {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let inner = format!("{path}/{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                self.put_folder(&inner, &entry.path());
            } else {
                self.put(&inner, &std::fs::read(entry.path()).unwrap());
            }
        }
        self
    }

    /// Takes the file at `path` away.
    pub fn remove(&self, path: &str) {
        self.shelf.lock().unwrap().files.remove(path).unwrap();
    }

    /// From now on files were written later.
    pub fn age(&self) {
        self.shelf.lock().unwrap().written = WRITTEN_LATER;
    }

    /// From now on it fails like this.
    pub fn fail(&self, fault: Fault) {
        self.shelf.lock().unwrap().fault = fault;
    }

    /// The requests since the last time this was asked.
    pub fn asked(&self) -> Vec<String> {
        std::mem::take(&mut self.shelf.lock().unwrap().asked)
    }

    /// The address of `path`.
    pub fn url(&self, path: &str) -> String {
        format!("http://{}/{path}", self.address)
    }
}

fn answer(connection: TcpStream, shelf: &Mutex<Shelf>) -> std::io::Result<()> {
    let mut lines = BufReader::new(connection.try_clone()?).lines();
    let request = lines.next().unwrap_or_else(|| Ok(String::new()))?;
    let mut range = None;
    for line in lines {
        let line = line?;
        if line.is_empty() {
            break;
        }
        if let Some(value) = line.to_ascii_lowercase().strip_prefix("range: bytes=") {
            range = Some(value.to_owned());
        }
    }
    let mut words = request.split(' ');
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let (files, written, fault) = {
        let mut shelf = shelf.lock().unwrap();
        shelf.asked.push(format!("{method} {target} {}", range.as_deref().unwrap_or("whole")));
        let fault = shelf.fault;
        if let Fault::Busy(n) = fault {
            shelf.fault = if n > 1 { Fault::Busy(n - 1) } else { Fault::None };
        }
        (shelf.files.clone(), shelf.written, fault)
    };
    let status = match fault {
        Fault::Status(status) => Some(status),
        Fault::Busy(_) => Some(503),
        _ if !["GET", "HEAD"].contains(&method) => Some(405),
        _ => None,
    };
    if fault == Fault::NeverAnswers {
        let mut connection = connection;
        connection.write_all(b"HTTP/1.1 200 OK\r\n")?;
        loop {
            connection.write_all(b"X-More: 1\r\n")?;
            std::thread::sleep(Duration::from_millis(100));
        }
    }
    if let Some(status) = status {
        return send(connection, &format!("HTTP/1.1 {status} x\r\nContent-Length: 0\r\n"), &[], usize::MAX);
    }
    let (path, query) =
        target.trim_start_matches('/').split_once('?').unwrap_or((target.trim_start_matches('/'), ""));
    if query.contains("list-type=2") {
        let listing = listing(&files, path, query);
        let head = format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\n", listing.len());
        return send(connection, &head, listing.as_bytes(), usize::MAX);
    }
    let Some(content) = files.get(path) else {
        return send(connection, "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n", &[], usize::MAX);
    };
    send_file(connection, (method, range.as_deref()), (content, written), fault)
}

fn send_file(
    connection: TcpStream,
    (method, range): (&str, Option<&str>),
    (content, written): (&[u8], &str),
    fault: Fault,
) -> std::io::Result<()> {
    let mut head = String::new();
    let part = if let Some(range) = range.filter(|_| !matches!(fault, Fault::WithoutRanges | Fault::Cuts(_)))
    {
        let (start, end) = range.split_once('-').unwrap();
        let start: usize = start.parse().unwrap();
        let end = end.parse().map_or(content.len(), |it: usize| (it + 1).min(content.len()));
        let (last, n) = (end - 1, content.len());
        write!(head, "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes {start}-{last}/{n}\r\n").unwrap();
        &content[start..end]
    } else {
        head.push_str("HTTP/1.1 200 OK\r\n");
        content
    };
    let n_bytes = if fault == Fault::Boasts { 1 << 62 } else { part.len() };
    let sum: u64 = content.iter().enumerate().map(|(index, it)| (index as u64 + 1) * u64::from(*it)).sum();
    write!(head, "Content-Length: {n_bytes}\r\nETag: \"{sum}\"\r\nLast-Modified: {written}\r\n").unwrap();
    let part = if method == "HEAD" { &[] } else { part };
    match fault {
        Fault::Dribbles => {
            let mut connection = connection;
            send(connection.try_clone()?, &head, &[], 0)?;
            for byte in part {
                connection.write_all(&[*byte])?;
                std::thread::sleep(Duration::from_millis(100));
            }
            Ok(())
        }
        Fault::Breaks(n_bytes) | Fault::Cuts(n_bytes) => send(connection, &head, part, n_bytes),
        Fault::Stalls(n_bytes) if n_bytes < part.len() => {
            send(connection.try_clone()?, &head, part, n_bytes)?;
            std::thread::sleep(Duration::from_mins(1));
            Ok(())
        }
        _ => send(connection, &head, part, usize::MAX),
    }
}

/// Sends an answer, and no more than `n_bytes` of its body.
fn send(mut connection: TcpStream, head: &str, body: &[u8], n_bytes: usize) -> std::io::Result<()> {
    connection.write_all(format!("{head}Connection: close\r\n\r\n").as_bytes())?;
    connection.write_all(&body[..n_bytes.min(body.len())])?;
    connection.flush()
}

/// What S3 says is in the bucket `bucket`.
fn listing(files: &BTreeMap<String, Vec<u8>>, bucket: &str, query: &str) -> String {
    let prefix = query.split('&').find_map(|it| it.strip_prefix("prefix=")).unwrap_or_default();
    let prefix = format!("{}/{}", bucket.trim_end_matches('/'), prefix.replace("%2F", "/"));
    let mut listing = "<ListBucketResult>".to_owned();
    for (path, content) in files.iter().filter(|(path, _)| path.starts_with(&prefix)) {
        let (key, n) = (path.split_once('/').unwrap().1, content.len());
        let written = "2025-11-01T10:00:00.000Z";
        write!(
            listing,
            "<Contents><Key>{key}</Key><Size>{n}</Size><LastModified>{written}</LastModified></Contents>"
        )
        .unwrap();
    }
    listing + "</ListBucketResult>"
}
