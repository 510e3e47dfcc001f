//! The page of a run, served to browsers of this machine.

use std::net::Ipv4Addr;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};
use reports::files::regular_file::RegularFile;
use reports::run_folder::run_directory::REPORT_HTML;
use tiny_http::{Header, Method, Request, Response, Server};

use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::standard_streams::print_diagnostic;

/// Characters of names that are written as numbers in links.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'.').remove(b'-').remove(b'_');

/// A viewer opens several files at once, and one that reads slowly holds up no other.
const N_THREADS: usize = 4;

/// Serves the files in `directory` at a port of this machine until the user ends it.
pub fn serve_until_interrupted(directory: &Path, port: u16, interrupted: &AtomicBool) -> Result<(), Failure> {
    let root = directory.canonicalize().map_err(|error| Failure::damaged_run(directory, error))?;
    let server = Server::http((Ipv4Addr::LOCALHOST, port)).map_err(|error| {
        Usage(format!(
            "cannot serve the page at port {port} of 127.0.0.1: {error}; choose another, --serve=PORT"
        ))
    })?;
    let address = server.server_addr();
    print_diagnostic(format_args!("Serving the page until Ctrl-C: http://{address}/{REPORT_HTML}"));
    let serve = || -> Result<(), Failure> {
        while !interrupted.load(Ordering::Relaxed) {
            let asked = server.recv_timeout(Duration::from_millis(50));
            let failed = |error| Failure::internal("the server of the page fails", error);
            if let Some(request) = asked.map_err(failed)? {
                answer(request, &root);
            }
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..N_THREADS).map(|_| scope.spawn(serve)).collect();
        let ended = serve();
        others.into_iter().map(|it| it.join().unwrap_or(Ok(()))).fold(ended, Result::and)
    })
}

/// Answers with the file or the names in the folder that is asked for. A browser that goes away is no failure.
fn answer(request: Request, root: &Path) {
    let is_read = matches!(request.method(), Method::Get | Method::Head);
    let path = if is_read && is_for_this_machine(&request) { asked_path(request.url(), root) } else { None };
    let _ = match path {
        None => request.respond(Response::empty(404)),
        // Links in it are relative to it.
        Some(path) if path.is_dir() && !request.url().ends_with('/') => {
            let location = Header::from_bytes("Location", format!("{}/", request.url()));
            let location = location.expect("it was in a header");
            request.respond(Response::empty(301).with_header(location))
        }
        Some(path) if path.is_dir() => {
            request.respond(Response::from_string(listing(&path)).with_header(content_type("html")))
        }
        Some(path) => match RegularFile::open(&path) {
            Ok(file) => {
                let n_bytes = usize::try_from(file.n_bytes()).ok();
                let ending = path.extension().and_then(|it| it.to_str()).unwrap_or_default();
                request.respond(Response::new(200.into(), vec![content_type(ending)], file, n_bytes, None))
            }
            Err(_) => request.respond(Response::empty(404)),
        },
    };
}

/// Whether the browser means this machine: pages of others can give it a name of their own.
fn is_for_this_machine(request: &Request) -> bool {
    let hosts = request.headers().iter().filter(|it| it.field.equiv("Host"));
    let names =
        hosts.map(|it| it.value.as_str().rsplit_once(':').map_or(it.value.as_str(), |(name, _)| name));
    names.clone().count() == 1 && names.clone().all(|it| ["127.0.0.1", "localhost"].contains(&it))
}

/// The file or folder below `root` that `url` names; hidden ones, and links that lead out of it, do not exist.
fn asked_path(url: &str, root: &Path) -> Option<PathBuf> {
    let path = url.split(['?', '#']).next()?;
    let path = percent_decode_str(path.trim_start_matches('/')).decode_utf8().ok()?.into_owned();
    let is_plain = |it: Component<'_>| match it {
        Component::Normal(name) => !name.to_string_lossy().starts_with('.'),
        _ => false,
    };
    if !Path::new(&path).components().all(is_plain) {
        return None;
    }
    let mut found = root.join(path).canonicalize().ok()?;
    if found == root && root.join(REPORT_HTML).is_file() {
        found.push(REPORT_HTML);
    }
    found.starts_with(root).then_some(found)
}

/// The names in a folder as links.
fn listing(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|it| it.file_name().into_string().ok()).collect();
    names.retain(|it| !it.starts_with('.'));
    names.sort();
    let link = |it: &String| {
        let encoded = utf8_percent_encode(it, ENCODED);
        format!("<p><a href=\"{encoded}\">{encoded}</a></p>\n")
    };
    names.iter().map(link).collect::<Vec<_>>().concat()
}

fn content_type(ending: &str) -> Header {
    let kind = match ending {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "wasm" => "application/wasm",
        "css" => "text/css; charset=utf-8",
        "svg" => "image/svg+xml",
        "json" => "application/json",
        "csv" | "md" | "tex" | "txt" => "text/plain; charset=utf-8",
        "pdf" => "application/pdf",
        _ => "application/octet-stream",
    };
    Header::from_bytes("Content-Type", kind).expect("it is ASCII")
}
