//! A viewer that is streamed to.
//!
//! It must never cost the recording its file: a viewer that is not there, that stops taking data or that is closed
//! half-way is given up, and the file goes on without it.

use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream, ToSocketAddrs as _};
use std::str::FromStr;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use evaluation::run::scan_recorder::Served;
use rerun::ServerOptions;
use rerun::external::re_log_types::LogMsg;
use rerun::external::re_uri::{ProxyUri, RedapUri};
use rerun::grpc_server::GrpcServerSink;
use rerun::sink::{GrpcSink, GrpcSinkConnectionState, LogSink, SinkFlushError};

use super::error::StreamError;

/// Time for which a viewer may take nothing before it is given up.
const PATIENCE: Duration = Duration::from_secs(3);
/// Time that a viewer that was just started may take until it listens.
const STARTUP_PATIENCE: Duration = Duration::from_secs(10);
/// Time that a viewer may take for the data that are still on their way at the end.
const ENDING_PATIENCE: Duration = Duration::from_secs(5);
const POLL_INTERVAL: Duration = Duration::from_millis(5);
/// Messages that may wait for the viewer; with more, logging waits.
const QUEUE_LENGTH: usize = 64;

/// Which viewer to stream to, beside the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ViewerChoice {
    /// None.
    None,
    /// One that runs already.
    Connect(ViewerUrl),
    /// A new one, started from the program `rerun` in `PATH`.
    Spawn,
    /// Any that connect to this port of this machine.
    Serve {
        /// The port.
        port: u16,
    },
}

/// The address of a running viewer, such as `rerun+http://127.0.0.1:9876/proxy`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ViewerUrl(ProxyUri);

impl FromStr for ViewerUrl {
    type Err = StreamError;

    /// Reads the address.
    ///
    /// # Errors
    ///
    /// [`StreamError::BadUrl`] if it is none, or that of something else than a viewer.
    fn from_str(url: &str) -> Result<Self, StreamError> {
        let bad_url = |reason: String| StreamError::BadUrl { url: url.to_owned(), reason };
        match url.parse::<RedapUri>() {
            Ok(RedapUri::Proxy(uri)) => Ok(Self(uri)),
            Ok(_) => Err(bad_url("the path must be /proxy".to_owned())),
            Err(error) => Err(bad_url(error.to_string())),
        }
    }
}

/// State of the viewer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ViewerState {
    /// None was asked for.
    None,
    /// It takes the messages.
    Connected,
    /// It was given up; the file goes on without it.
    Lost {
        /// The reason.
        reason: String,
    },
}

/// A handle on the connection; clones share it, so that one can be given to Rerun to write to.
#[derive(Clone)]
pub struct ViewerLink {
    shared: Arc<Mutex<Shared>>,
    served_at: Option<String>,
}

struct Shared {
    state: ViewerState,
    queue: Option<SyncSender<Parcel>>,
    sender: Option<JoinHandle<()>>,
}

/// A recording that is complete and that viewers can still connect to, until this is dropped.
#[derive(Debug)]
pub struct ServedRecording {
    /// Its address.
    pub url: String,
    _queue: SyncSender<Parcel>,
}

impl Served for ServedRecording {
    fn url(&self) -> &str {
        &self.url
    }
}

/// Receiver of the messages.
enum Connection {
    /// To one viewer.
    Viewer(GrpcSink),
    /// To all that connect.
    Server(GrpcServerSink),
}

impl Connection {
    fn is_lost(&self) -> bool {
        match self {
            Self::Viewer(viewer) => matches!(viewer.status(), GrpcSinkConnectionState::Disconnected(_)),
            Self::Server(_) => false,
        }
    }

    fn sink(&self) -> &dyn LogSink {
        match self {
            Self::Viewer(viewer) => viewer,
            Self::Server(server) => server,
        }
    }
}

#[derive(Debug)]
enum Parcel {
    Message(Box<LogMsg>),
    Flush { reply: SyncSender<Result<(), String>> },
}

impl ViewerLink {
    /// Connects to, or starts, the viewer of `choice`.
    ///
    /// One that does not answer is no error: its state is [`ViewerState::Lost`].
    ///
    /// # Errors
    ///
    /// [`StreamError::ViewerNotInstalled`] or [`StreamError::ViewerFailed`] if a viewer has to be started and cannot be,
    /// [`StreamError::Serve`] if the port is taken.
    pub fn open(choice: &ViewerChoice) -> Result<Self, StreamError> {
        match choice {
            ViewerChoice::None => Ok(Self::without_viewer(ViewerState::None)),
            ViewerChoice::Connect(ViewerUrl(uri)) => Ok(Self::connect(uri, Duration::ZERO)),
            ViewerChoice::Spawn => {
                let port = spawn_viewer()?;
                let url = format!("rerun+http://127.0.0.1:{port}/proxy");
                let ViewerUrl(uri) = url.parse()?;
                Ok(Self::connect(&uri, STARTUP_PATIENCE))
            }
            ViewerChoice::Serve { port } => Self::serve(*port),
        }
    }

    /// Where viewers can connect to, if the recording is served.
    pub fn served_at(&self) -> Option<&str> {
        self.served_at.as_deref()
    }

    /// State of the viewer.
    pub fn state(&self) -> ViewerState {
        self.with(|shared| shared.state.clone())
    }

    /// Waits until the viewer has everything, but not for a viewer that takes nothing any more, and disconnects. A server
    /// goes on with what it has.
    pub fn finish(&self) -> (ViewerState, Option<ServedRecording>) {
        let Some(queue) = self.with(|shared| shared.queue.clone()) else {
            return (self.state(), None);
        };
        let (reply, answer) = mpsc::sync_channel(1);
        self.deliver(&queue, Parcel::Flush { reply });
        match answer.recv_timeout(ENDING_PATIENCE) {
            Ok(Ok(())) => {
                let sender = self.with(|shared| {
                    shared.queue = None;
                    shared.sender.take()
                });
                if let Some(url) = &self.served_at {
                    return (self.state(), Some(ServedRecording { url: url.clone(), _queue: queue }));
                }
                drop(queue);
                // Everything has arrived, so nothing keeps the thread from ending.
                if sender.is_some_and(|thread| thread.join().is_err()) {
                    self.give_up("the thread that sends to it panicked");
                }
            }
            Ok(Err(reason)) => self.give_up(&reason),
            Err(_) => self.give_up("it does not accept the last messages"),
        }
        (self.state(), None)
    }

    fn without_viewer(state: ViewerState) -> Self {
        let shared = Shared { state, queue: None, sender: None };
        Self { shared: Arc::new(Mutex::new(shared)), served_at: None }
    }

    fn connect(uri: &ProxyUri, startup_patience: Duration) -> Self {
        if let Err(reason) = wait_until_listening(uri, startup_patience) {
            return Self::without_viewer(ViewerState::Lost { reason });
        }
        let uri = uri.clone();
        Self::sending_to(move || Connection::Viewer(GrpcSink::new(uri)), None)
    }

    fn serve(port: u16) -> Result<Self, StreamError> {
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        // The server itself says nothing if the port is taken.
        let port = TcpListener::bind(address)
            .and_then(|listener| listener.local_addr())
            .map_err(|source| StreamError::Serve { port, source })?
            .port();
        let server = GrpcServerSink::new(&address.ip().to_string(), port, ServerOptions::default())
            .map_err(|error| StreamError::Serve { port, source: std::io::Error::other(error) })?;
        let url = server.uri().to_string();
        Ok(Self::sending_to(move || Connection::Server(server), Some(url)))
    }

    /// Sends in a thread of its own, in which the connection is made.
    fn sending_to(connect: impl FnOnce() -> Connection + Send + 'static, served_at: Option<String>) -> Self {
        let (queue, parcels) = mpsc::sync_channel(QUEUE_LENGTH);
        let sender = std::thread::Builder::new()
            .name("viewer_link".to_owned())
            .spawn(move || send_parcels(&connect(), &parcels));
        match sender {
            Ok(sender) => {
                let shared =
                    Shared { state: ViewerState::Connected, queue: Some(queue), sender: Some(sender) };
                Self { shared: Arc::new(Mutex::new(shared)), served_at }
            }
            Err(error) => Self::without_viewer(ViewerState::Lost { reason: error.to_string() }),
        }
    }

    /// Puts `parcel` into the queue, waiting for room as long as patience lasts.
    fn deliver(&self, queue: &SyncSender<Parcel>, mut parcel: Parcel) {
        let started = Instant::now();
        loop {
            match queue.try_send(parcel) {
                Ok(()) => return,
                Err(TrySendError::Disconnected(_)) => return self.give_up("it was closed"),
                Err(TrySendError::Full(_)) if started.elapsed() > PATIENCE => {
                    return self.give_up(&format!("it accepted nothing for {} s", PATIENCE.as_secs()));
                }
                Err(TrySendError::Full(returned)) => parcel = returned,
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Sends nothing more. The thread that may be stuck in the connection is left to the end of the program.
    fn give_up(&self, reason: &str) {
        self.with(|shared| {
            shared.state = ViewerState::Lost { reason: reason.to_owned() };
            shared.queue = None;
            shared.sender = None;
        });
    }

    fn with<T>(&self, use_shared: impl FnOnce(&mut Shared) -> T) -> T {
        use_shared(&mut self.shared.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl LogSink for ViewerLink {
    fn send(&self, message: LogMsg) {
        // The lock is not held while waiting for room, so that `state` always answers.
        if let Some(queue) = self.with(|shared| shared.queue.clone()) {
            self.deliver(&queue, Parcel::Message(Box::new(message)));
        }
    }

    /// Does not wait: only the end of the recording waits for the viewer, see [`ViewerLink::finish`].
    fn flush_blocking(&self, _timeout: Duration) -> Result<(), SinkFlushError> {
        Ok(())
    }
}

/// Runs in a thread of its own, because the connection blocks while the viewer takes nothing.
fn send_parcels(connection: &Connection, parcels: &Receiver<Parcel>) {
    while let Ok(parcel) = parcels.recv() {
        if connection.is_lost() {
            return;
        }
        match parcel {
            Parcel::Message(message) => connection.sink().send(*message),
            Parcel::Flush { reply } => {
                let flushed =
                    connection.sink().flush_blocking(ENDING_PATIENCE).map_err(|error| error.to_string());
                // The recording may have stopped waiting for the reply.
                let _ = reply.try_send(flushed);
            }
        }
    }
}

fn spawn_viewer() -> Result<u16, StreamError> {
    let options = rerun::SpawnOptions {
        // Everyone on the network could connect to it otherwise.
        extra_args: vec!["--bind=127.0.0.1".to_owned()],
        headless: false,
        ..rerun::SpawnOptions::default()
    };
    rerun::spawn(&options).map(|spawned| spawned.port).map_err(|error| match error {
        rerun::SpawnError::Io(source) => StreamError::ViewerFailed { source },
        rerun::SpawnError::ExecutableNotFoundInPath { .. } | rerun::SpawnError::ExecutableNotFound { .. } => {
            StreamError::ViewerNotInstalled { version: super::rerun_version() }
        }
    })
}

/// Tries to reach the viewer for `startup_patience`, but at least once.
fn wait_until_listening(uri: &ProxyUri, startup_patience: Duration) -> Result<(), String> {
    let started = Instant::now();
    loop {
        let Err(reason) = reach(uri) else {
            return Ok(());
        };
        if started.elapsed() >= startup_patience {
            return Err(format!("no viewer at {uri}: {reason}"));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

fn reach(uri: &ProxyUri) -> Result<(), String> {
    let origin = &uri.origin;
    let host = origin.host.to_string();
    let addresses = (host.as_str(), origin.port).to_socket_addrs().map_err(|error| error.to_string())?;
    let mut reason = "the name has no address".to_owned();
    for address in addresses {
        match TcpStream::connect_timeout(&address, PATIENCE / 2) {
            Ok(_) => return Ok(()),
            Err(error) => reason = error.to_string(),
        }
    }
    Err(reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_refused(url: &str) {
        let refused = url.parse::<ViewerUrl>().unwrap_err();
        assert!(matches!(refused, StreamError::BadUrl { .. }), "{refused}");
        assert!(refused.to_string().contains(&format!("{url:?}")), "{refused}");
    }

    #[test]
    fn what_is_not_the_address_of_a_viewer_is_refused() {
        check_refused("");
        check_refused("viewer");
        check_refused("rerun+http://127.0.0.1:port/proxy");
        check_refused("rerun+http://127.0.0.1:9876/catalog");
        check_refused("ftp://127.0.0.1:9876/proxy");
    }

    #[test]
    fn the_address_of_a_viewer_is_understood() {
        let ViewerUrl(uri) = "rerun+http://127.0.0.1:9877/proxy".parse().unwrap();
        assert_eq!(uri.origin.port, 9877);
    }
}
