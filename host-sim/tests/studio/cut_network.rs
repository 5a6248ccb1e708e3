//! A network between page and studio that is cut while the motor is driven.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::net::{TcpListener, TcpStream};

use super::clock::breath;
use super::page::{Page, Studio, Visit, arm, run, studio};
use super::{LINK_TIMEOUT_S, SLACK_S, TICK_S, ticks_on_after};

/// A network between a page and the server, which can be cut: nothing gets through then, and no end
/// of the connection is seen.
async fn network(server: &Studio, is_cut: Arc<AtomicBool>) -> std::net::SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let (address, to) = (listener.local_addr().unwrap(), server.address());
    tokio::spawn(async move {
        let (near, _) = listener.accept().await.unwrap();
        let far = TcpStream::connect(to).await.unwrap();
        let ((mut from_near, mut to_near), (mut from_far, mut to_far)) =
            (near.into_split(), far.into_split());
        let cut = is_cut.clone();
        tokio::spawn(async move { carry(&mut from_far, &mut to_near, &cut).await });
        carry(&mut from_near, &mut to_far, &is_cut).await;
    });
    address
}

async fn carry(
    from: &mut tokio::net::tcp::OwnedReadHalf,
    to: &mut tokio::net::tcp::OwnedWriteHalf,
    is_cut: &AtomicBool,
) {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut buffer = [0; 4096];
    loop {
        let count = from.read(&mut buffer).await.unwrap_or(0);
        if count == 0 {
            return;
        }
        while is_cut.load(Ordering::SeqCst) {
            breath().await;
        }
        if to.write_all(&buffer[..count]).await.is_err() {
            return;
        }
    }
}

#[test]
fn a_network_that_is_cut_while_armed_turns_the_output_off_within_the_link_timeout() {
    run(async {
        let server = studio(&[]);
        let is_cut = Arc::new(AtomicBool::new(false));
        let address = network(&server, is_cut.clone()).await;
        let mut page = Visit { address, ..Visit::proper(&server) }.connect().await.unwrap();
        page.role = page.event("role").await;
        page.event("status").await;
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        page.done(arm()).await;
        page.watch(Duration::from_millis(1000)).await;
        let last = page.rows.last().unwrap().clock;
        is_cut.store(true, Ordering::SeqCst);
        let on_s = ticks_on_after(&mut reader, last).await as f64 * TICK_S;
        assert!((LINK_TIMEOUT_S - 0.15..LINK_TIMEOUT_S + SLACK_S).contains(&on_s), "{on_s} s");
        assert_eq!(reader.state("faulted").await["fault"]["code"], 22);
    });
}
