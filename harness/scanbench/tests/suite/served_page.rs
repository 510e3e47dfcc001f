//! The page of a run, served to browsers of this machine, and the viewer beside it.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;

use crate::program::{Workplace, send};

/// What the server at `address` answers to a request for `path` of `host`.
fn answer(address: &str, host: &str, path: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn only_the_files_of_the_run_are_served_and_only_to_this_machine() {
    let workplace = Workplace::with_drive(1);
    workplace.succeed("run street -d pca -o run --no-rrd");
    workplace.write("theirs.txt", "theirs");
    workplace.write("run/.hidden", "theirs");
    workplace.write("run/a name.txt", "ours");
    std::os::unix::fs::symlink("../theirs.txt", workplace.path("run/link.txt")).unwrap();
    let mut child = workplace.start("report run --serve=0");
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    let line = said.find_map(|it| it.ok().filter(|it| it.contains("Serving the page"))).unwrap();
    let address = line.split("http://").nth(1).unwrap().split('/').next().unwrap().to_owned();
    assert!(address.starts_with("127.0.0.1:"), "{line}");

    for path in ["/", "/report.html", "/report.html?a#b"] {
        let page = answer(&address, &address, path);
        assert!(page.contains("Content-Type: text/html") && page.contains("<h1"), "{path}: {page:.300}");
    }
    assert!(answer(&address, "localhost", "/figures/").contains("href=\"times.svg\""));
    let folder = answer(&address, &address, "/figures");
    assert!(folder.starts_with("HTTP/1.1 301") && folder.contains("Location: /figures/"), "{folder}");
    assert!(answer(&address, &address, "/a%20name.txt").ends_with("ours"));
    let hidden = ["/../theirs.txt", "/%2e%2e/theirs.txt", "/.hidden", "/link.txt", "/none", "//etc/passwd"];
    for path in hidden {
        let refused = answer(&address, &address, path);
        assert!(refused.starts_with("HTTP/1.1 404") && !refused.contains("theirs"), "{path}: {refused}");
    }
    assert!(answer(&address, "elsewhere.example", "/report.html").starts_with("HTTP/1.1 404"));
    let port = address.rsplit(':').next().unwrap();
    workplace.end_with(&format!("report run --serve={port}"), 2, &["cannot serve the page at port"]);
    send(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn a_viewer_needs_a_recording_and_is_that_of_its_publisher() {
    let workplace = Workplace::with_drive(1);
    workplace.succeed("run street -d pca -o without --no-rrd");
    workplace.end_with("report without --with-viewer", 2, &["--with-viewer: the run has no recording"]);
    workplace.write("viewer.crate", "theirs");
    if cfg!(feature = "viewer") {
        workplace.succeed("run street -d pca -o with");
        let other = "viewer.crate: its SHA-256 is ";
        workplace.end_with("report with --with-viewer=viewer.crate", 2, &[other]);
        assert!(
            !workplace.path("with/viewer").exists() && !workplace.path("with/recording/marks.rrd").exists()
        );
    }
}
