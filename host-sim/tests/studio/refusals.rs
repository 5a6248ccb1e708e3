//! Reports of refused connections at the terminal.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use futures_util::SinkExt;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;

use super::clock::breath;
use super::page::{PATIENCE, Page, Visit, run, studio_with_reports};

/// Waits for a number of reports, and takes them.
async fn reported(all: &Mutex<Vec<String>>, count: usize) -> Vec<String> {
    let begin = Instant::now();
    while all.lock().unwrap().len() < count {
        assert!(begin.elapsed() < PATIENCE, "they are not reported");
        breath().await;
    }
    std::mem::take(&mut *all.lock().unwrap())
}

#[test]
fn a_wrong_token_and_a_foreign_origin_are_reported_and_a_proper_page_is_not() {
    run(async {
        let (server, all) = studio_with_reports();
        Page::open(&server).await;
        let proper = || Visit::proper(&server);
        assert!(Visit { token: "0", ..proper() }.connect().await.is_err());
        let origin = Some("http://evil.example".into());
        assert!(Visit { origin, ..proper() }.connect().await.is_err());
        let lines = reported(&all, 2).await;
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!(lines[0].starts_with("a connection was refused: the token is wrong"), "{lines:?}");
        assert!(!lines[0].contains(server.token().text()), "{lines:?}");
        assert_eq!(lines[1], "a connection was refused: the page is of another origin");
    });
}

#[test]
fn a_message_that_is_too_large_is_reported_with_the_number_of_its_page() {
    run(async {
        let (server, all) = studio_with_reports();
        let mut page = Page::open(&server).await;
        let large = "x".repeat(65 * 1024);
        let _ = page.socket.send(Message::Text(large.into())).await;
        while page.next().await.is_some() {}
        let lines = reported(&all, 1).await;
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].starts_with("page 0: the connection ends: "), "{lines:?}");
        assert!(lines[0].contains("too long") || lines[0].contains("too large"), "{lines:?}");
    });
}

#[test]
fn connections_beyond_the_limit_are_reported_and_then_counted_like_other_refusals() {
    run(async {
        let (server, all) = studio_with_reports();
        let mut idle = Vec::new();
        for _ in 0..64 + 40 {
            idle.push(TcpStream::connect(server.address()).await.unwrap());
        }
        let lines = reported(&all, 8).await;
        assert_eq!(lines, vec!["a connection was closed: 64 are open already"; 8]);
        // The last one was closed after all others.
        let _ = idle.last_mut().unwrap().read(&mut [0; 8]).await;
        // The next period starts with the number of refusals that were not reported.
        drop(idle);
        server.clock.jump(Duration::from_secs(11));
        assert!(Visit { token: "0", ..Visit::proper(&server) }.connect().await.is_err());
        let lines = reported(&all, 1).await;
        assert!(lines[0].ends_with(" (32 refusals before it were not reported)"), "{lines:?}");
    });
}
